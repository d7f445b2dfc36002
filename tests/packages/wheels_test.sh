#!/usr/bin/env bash
# The wheels of build/dist, built by `make wheels`, in clean Debian roots that have Python, no compiler
# and none of the server's libraries: `pip install 'geodesicd[server]'`, and as a user without rights
# `geodesic serve`, which is given a mesh, asked and stopped, and `geodesicd.local`.
#
# usage: tests/packages/wheels_test.sh [--suite bookworm|trixie]... [--folder DIR]
#
#     --folder DIR   where roots are built and kept (default: a new one, removed at the end)
#
# Needs root and debootstrap. Not part of `make test`. GEODESICD_SEED sets what is random.
set -euo pipefail
repository=$(cd "$(dirname "$0")/../.." && pwd)
# shellcheck source=tests/packages/in_roots.sh
. "$repository/tests/packages/in_roots.sh"
client=$(find "$repository/build/dist" -name 'geodesicd-*.whl')
server=$(find "$repository/build/dist" -name 'geodesicd_server-*-manylinux_*.whl')
if [ -z "$client" ] || [ -z "$server" ]; then
  echo "packages: no wheels in build/dist: make wheels" >&2
  exit 2
fi

# Into the root's /src/wheels, with what the client needs of others for the root's Python.
gather_wheels() {
  local python needed
  # shellcheck disable=SC2016  # Python's
  python=$(inside "$root" python3 -c 'import sys; print("%d.%d" % sys.version_info[:2])')
  mapfile -t needed < <(python3 - "$client" <<'END'
import email, sys, zipfile
with zipfile.ZipFile(sys.argv[1]) as wheel:
    (metadata,) = (name for name in wheel.namelist() if name.endswith(".dist-info/METADATA"))
    for need in email.message_from_bytes(wheel.read(metadata)).get_all("Requires-Dist"):
        if "extra ==" not in need:
            print(need)
END
  )
  python3 -m pip download --quiet --no-input --disable-pip-version-check --only-binary=:all: \
    --python-version "$python" --dest "$root/src/wheels" "${needed[@]}" || failed "PyPI has no ${needed[*]}"
  cp "$client" "$server" "$root/src/wheels"
}

as_nobody=(setpriv --reuid=65534 --regid=65534 --clear-groups --no-new-privs env HOME=/tmp)

for suite in "${suites[@]}"; do
  new_root wheels
  apt update
  apt install python3-venv
  gather_wheels
  step "pip install of $(basename "$server"), $(($(stat -c %s "$server") / 1024)) KiB"
  inside "$root" python3 -m venv /venv
  inside "$root" /venv/bin/pip install --quiet --no-index --find-links wheels 'geodesicd[server]' ||
    failed "pip"
  ! inside "$root" sh -c 'command -v cc || command -v geodesicd' || failed "the root is not clean"

  step "geodesic serve"
  url=http://127.0.0.1:$(free_port)
  # shellcheck disable=SC2016  # for the root's shell
  start "$url/readyz" sh -c '
    "$@" & serving=$!
    until [ -e /src/stop ]; do kill -0 $serving || exit; sleep 0.2; done
    kill -TERM $serving
    status=0
    wait $serving || status=$?
    [ $status -eq 130 ] || echo "geodesic serve ended with $status"
    ! ls -l /proc/[0-9]*/exe 2>/dev/null | grep geodesicd' sh \
    "${as_nobody[@]}" /venv/bin/geodesic serve --samples --listen "${url#http://}" -- --compute-threads 1
  upload_triangle "$url"
  check_answer
  curl --silent --fail "$url/" | grep -c '<script' >/dev/null || failed "no viewer at /"
  curl --silent --fail "$url/v1/meshes" | jq --exit-status '.meshes | length > 1' >/dev/null ||
    failed "it has no samples"
  touch "$root/src/stop"
  wait "$started" || true
  started=""
  ! grep -E 'ended with|geodesicd_server' "$folder/server.log" || failed "it does not stop in order"

  step "geodesicd.local"
  length=$(inside "$root" "${as_nobody[@]}" /venv/bin/python -c \
    'import geodesicd; print(geodesicd.local([[0, 0, 0], [3, 0, 0], [0, 4, 0]], [[0, 1, 2]]).distance(1)[2])')
  [ "$length" = 5.0 ] || failed "the hypotenuse of 3 and 4 is $length"
  rm -rf --one-file-system "$root"
done
echo "packages: installed by pip, served and asked: ${suites[*]}"
