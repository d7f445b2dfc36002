#!/usr/bin/env bash
# The image of what is committed, built twice on a bare Debian 12: both have the same file system to the
# last byte, are less than 120 MB larger than their base, and name all their packages in the SBOM.
#
# usage: tests/packages/image_test.sh [--folder DIR] [--ccache]
#
#     --folder DIR   where roots and images are built and kept (default: a new one, removed at the end)
#     --ccache       lend the builds this machine's ccache folder
#
# Needs root, debootstrap and buildah. Not part of `make test`. tests/fresh/run.sh asks the image's server.
set -euo pipefail
repository=$(cd "$(dirname "$0")/../.." && pwd)
# shellcheck source=tests/packages/in_roots.sh
. "$repository/tests/packages/in_roots.sh"
command -v buildah >/dev/null || { echo "packages: needs buildah" >&2; exit 2; }
suite=bookworm most=120000000
export IMAGE_STORE=$folder/images
images() { buildah --root "$IMAGE_STORE" --runroot "$IMAGE_STORE.run" --storage-driver vfs "$@"; }
bytes_of() { du --summarize --apparent-size --block-size=1 "$1" | cut -f 1; }

# The bare root as an image, without what apt can fetch again, which the build removes; sets `base_bytes`.
import_base() {
  local container
  make_base "$suite" ca-certificates || failed "no base"
  container=$(images from scratch)
  tar -C "$folder/$suite.base" --exclude './dev/*' --exclude './var/lib/apt/lists/*' --exclude './var/cache/apt/*' \
    -cf "$folder/base.tar" .
  images add --quiet "$container" "$folder/base.tar" / >/dev/null
  rm "$folder/base.tar"
  base_bytes=$(bytes_of "$(images mount "$container")")
  images commit --quiet --rm "$container" "localhost/base:$suite" >/dev/null
}

# build NUMBER: sets `digest` and `bytes`, and looks at the SBOM.
build() {
  local container mounted sbom
  step "build $1"
  rm -rf "$folder/source"
  git clone --quiet "file://$repository" "$folder/source"
  BUILD_FLAGS=${ccache:+--volume $ccache:/root/.cache/ccache} "$folder/source/scripts/build_image" \
    "localhost/base:$suite" >"$folder/image.$1.log" 2>&1 || { tail -n 40 "$folder/image.$1.log"; failed "build"; }
  digest=$(sed -n 's/^image: .* file system //p' "$folder/image.$1.log")
  [ ${#digest} -eq 64 ] || failed "it says no digest"
  container=$(images from --pull-never "$(sed -nE 's/^image: (.*), file system .*/\1/p' "$folder/image.$1.log")")
  mounted=$(images mount "$container")
  bytes=$(bytes_of "$mounted")
  sbom=$mounted/usr/local/share/doc/geodesicd/sbom.cdx.json
  diff <(dpkg-query --admindir "$mounted/var/lib/dpkg" --show --showformat '${Package} ${Version}\n' | sort) \
    <(jq -r '.components[] | select(.purl | endswith("arch=source") | not) | "\(.name) \(.version)"' "$sbom" | sort) ||
    failed "the SBOM is not what dpkg has"
  images rm "$container" >/dev/null
  step "file system $digest, $((bytes - base_bytes)) bytes over its base"
}

import_base
build 1
first=$digest
build 2
[ "$digest" = "$first" ] || failed "the second is another"
[ $((bytes - base_bytes)) -lt $most ] || failed "that is more than $most"
echo "packages: the image is the same twice, and small"
