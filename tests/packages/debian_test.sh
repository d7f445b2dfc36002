#!/usr/bin/env bash
# Debian's package in clean Debian roots: built in one of the release it is for, and in another,
# which has nothing but what a bare Debian has, installed by apt, started as its unit says, given a
# mesh and asked, upgraded over a package of an older version with mesh and settings kept, removed,
# and purged, after which nothing of it is left. A root has no systemd that runs, so that the unit is
# checked by systemd-analyze, and its user, variables and command by starting them.
#
# usage: tests/packages/debian_test.sh [--suite bookworm|trixie]... [--package FILE]
#                                      [--folder DIR] [--ccache]
#
#     --package FILE   not built but taken, for the only suite that is named
#     --folder DIR     where roots are built and kept (default: a new one, removed at the end)
#     --ccache         lend the roots in which packages are built this machine's ccache folder
#
# Needs root and debootstrap. Not part of `make test`. GEODESICD_SEED sets what is random.
set -euo pipefail
repository=$(cd "$(dirname "$0")/../.." && pwd)
# shellcheck source=tests/packages/in_roots.sh
. "$repository/tests/packages/in_roots.sh"
[ -z "$package" ] || [ ${#suites[@]} -eq 1 ] || { echo "packages: --package is for one --suite" >&2; exit 2; }

build_package() {
  local builder=$folder/$suite.builder commit
  step "build"
  make_base "$suite" || failed "no root to build in"
  commit=$(git -C "$repository" rev-parse HEAD)
  [ -d "$builder" ] || cp -a --reflink=auto "$folder/$suite.base" "$builder"
  if [ "$(git -C "$builder/src" rev-parse HEAD 2>/dev/null)" != "$commit" ]; then
    rm -rf "$builder/src"
    git clone --quiet "file://$repository" "$builder/src"
  fi
  inside "$builder" env GEODESICD_NO_BROWSER=1 make deb >"$folder/$suite.build.log" 2>&1 ||
    { tail -n 40 "$folder/$suite.build.log"; failed "make deb"; }
  package=$(echo "$builder"/src/build/dist/*.deb)
}

# The same package with a number that is older.
repack_as_older() {
  dpkg-deb --raw-extract "$package" "$folder/older"
  sed -i 's/^Version: .*/Version: 0.0.1-1/' "$folder/older/DEBIAN/control"
  dpkg-deb --root-owner-group --build "$folder/older" "$root/src/older.deb" >/dev/null
  rm -rf "$folder/older"
}

expect_version() {
  local found
  # shellcheck disable=SC2016  # dpkg's
  found=$(inside "$root" dpkg-query --show --showformat '${Version}' geodesicd)
  [ "$found" = "$1" ] || failed "its version is $found, not $1"
}
start_service() { start "http://127.0.0.1:$admin_port/readyz" sh as_the_unit_does.sh; }

install_and_ask() {
  step "install 0.0.1-1"
  apt update
  apt install ./older.deb
  expect_version 0.0.1-1
  [ "$(inside "$root" stat -c '%U %a' /var/lib/geodesicd)" = "geodesicd 700" ] ||
    failed "/var/lib/geodesicd is not the user's own"
  zcat "$root/usr/share/man/man8/geodesicd.8.gz" | grep -cF '\-\-max\-vertices' >/dev/null ||
    failed "the man page does not have the flags"
  [ -s "$root/usr/share/doc/geodesicd/copyright" ] || failed "it has no copyright"
  # As an operator would.
  port=$(free_port) admin_port=$(free_port)
  sed -i "s/:8080$/:$port/; s/:8081$/:$admin_port/" "$root/etc/default/geodesicd"

  step "start, upload, ask"
  start_service
  upload_triangle "http://127.0.0.1:$port"
  check_answer
  curl --silent --fail "http://127.0.0.1:$port/" | grep -c '<script' >/dev/null || failed "no viewer at /"
  curl --silent --fail --output /dev/null "http://127.0.0.1:$port/docs/start/operator/" ||
    failed "no documentation at /docs/"
  stop
}

upgrade_and_ask() {
  step "upgrade"
  apt install ./newer.deb
  expect_version "$(dpkg-deb --field "$package" Version)"
  start_service
  check_answer
  stop

  step "systemd-analyze verify"
  local said
  apt install systemd
  said=$(inside "$root" env SYSTEMD_LOG_LEVEL=warning systemd-analyze verify --man=no geodesicd.service 2>&1) || true
  [ -z "$said" ] || failed "$said"
}

remove_and_purge() {
  step "remove, and install again"
  apt remove geodesicd
  [ ! -e "$root/usr/bin/geodesicd" ] || failed "the program is left"
  apt install ./newer.deb
  start_service
  check_answer
  stop

  step "purge"
  local left
  apt purge geodesicd
  left=$(inside "$root" find / -xdev -path /src -prune -o -name '*geodesicd*' -print)
  [ -z "$left" ] || failed "it leaves $left"
  ! grep -q geodesicd "$root/etc/passwd" "$root/etc/group" || failed "it leaves its user"
}

for suite in "${suites[@]}"; do
  [ -n "$package" ] || build_package
  new_root clean
  cp "$package" "$root/src/newer.deb"
  cp "$repository/tests/packages/as_the_unit_does.sh" "$root/src/"
  repack_as_older
  step "$(basename "$package"): $(($(stat -c %s "$package") / 1024)) KiB," \
    "$(dpkg-deb --field "$package" Installed-Size) KiB installed"
  install_and_ask
  upgrade_and_ask
  remove_and_purge
  rm -rf --one-file-system "$root"
  package=""
done
echo "packages: installed, asked, upgraded and purged: ${suites[*]}"
