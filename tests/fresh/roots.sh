# shellcheck shell=bash
# Bare Debian roots, for tests that need root and debootstrap: to be sourced, with `folder` (where
# roots are built) and `ccache` (a folder to lend them, or nothing) set before the functions are
# called. The mirror, apt's proxy settings and local CA certificates are this machine's own.

for tool in debootstrap unshare git curl jq sha256sum; do
  command -v "$tool" >/dev/null || { echo "fresh: needs $tool" >&2; exit 2; }
done
[ "$(id -u)" -eq 0 ] || { echo "fresh: needs root, for chroot and mounts" >&2; exit 2; }
mirror=$("$(dirname "${BASH_SOURCE[0]}")/../../scripts/debian_mirror")
[ -n "$mirror" ] || { echo "fresh: apt knows no Debian mirror (apt-get update?)" >&2; exit 2; }

# The way out that apt on this machine uses, for debootstrap and the roots.
if [ -z "${http_proxy:-}" ]; then
  proxy=""
  eval "$(apt-config shell proxy Acquire::http::Proxy)"
  [ -z "$proxy" ] || export http_proxy=$proxy
fi

# make_base SUITE [PACKAGES]: a bare root in $folder/SUITE.base, never changed after, with this machine's
# network.
make_base() {
  local suite=$1 base=$folder/$1.base
  [ ! -d "$base" ] || return 0
  debootstrap --variant=minbase --include="${2:-git,make,ca-certificates}" \
    "$suite" "$base.new" "$mirror" >"$base.log" || { tail -n 20 "$base.log"; return 1; }
  cp --dereference /etc/resolv.conf "$base.new/etc/resolv.conf"
  apt-config dump |
    { grep -E '^Acquire::(http|https|Retries|ForceIPv[46]|Check-(Date|Valid-Until))\b' || true; } |
    { grep -v -i auto-detect || true; } >"$base.new/etc/apt/apt.conf.d/90from-the-host"
  local certificate
  for certificate in /usr/local/share/ca-certificates/*.crt; do
    [ -f "$certificate" ] || continue
    cp "$certificate" "$base.new/usr/local/share/ca-certificates/"
  done
  chroot "$base.new" update-ca-certificates >/dev/null 2>&1
  mv "$base.new" "$base"
}

# inside ROOT COMMAND...: runs it in ROOT's /src with a clean environment. Whatever
# it leaves running or mounted ends with it.
inside() {
  # shellcheck disable=SC2016  # for the inner shell
  unshare --mount --pid --fork --kill-child bash -euc '
    root=$1 ccache=$2
    shift 2
    mount -t proc proc "$root/proc"
    mount --rbind /sys "$root/sys"
    mount --rbind /dev "$root/dev"
    variables=(HOME=/root LANG=C.UTF-8 PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin)
    for name in http_proxy https_proxy no_proxy PORT; do
      [ -z "${!name:-}" ] || variables+=("$name=${!name}")
    done
    if [ -n "$ccache" ]; then
      mkdir -p "$ccache" "$root/ccache"
      mount --bind "$ccache" "$root/ccache"
      variables+=(CCACHE_DIR=/ccache)
    fi
    status=0
    chroot "$root" env -i "${variables[@]}" sh -c "cd /src && exec \"\$@\"" inside "$@" || status=$?
    exit $status' inside "$1" "$ccache" "${@:2}"
}

free_port() {
  python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'
}
