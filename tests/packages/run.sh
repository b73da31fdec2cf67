#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# run.sh [BUILD_DIR]: makes the Debian packages in BUILD_DIR (build/deb by default) and tries them in
# a bare Debian 12, which mmdebstrap makes in a temporary folder: inside.sh says what. As root, or
# where users may have namespaces of their own. Takes minutes and a mirror of Debian; ctest runs it
# with WEFT_PACKAGES=full alone.
set -eu
source=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$source/build/deb}
if [ -n "${1:-}" ] && [ "${WEFT_PACKAGES:-}" != full ]; then
    echo "skipped: WEFT_PACKAGES=full runs it"
    exit 77
fi
for program in mmdebstrap dpkg-shlibdeps; do
    command -v $program >/dev/null || { echo "skipped: no $program" && exit 77; }
done

cmake -S "$source" --preset deb -B "$build" >/dev/null
cmake --build "$build"
rm -f "$build"/*.deb
(cd "$build" && cpack -G DEB)
# What lintian calls an error; nobody's mail is the maintainer's unless DEBEMAIL tells, and it takes
# the "libdeflate 1.14" of weft --version for a copy of zlib.
if command -v lintian >/dev/null; then
    lintian --fail-on error --suppress-tags \
        bogus-mail-host,bogus-mail-host-in-debian-changelog,embedded-library "$build"/*.deb
fi

tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
mkdir "$tmp/weft"
cp "$build"/*.deb "$source/tests/packages/inside.sh" "$tmp/weft"
cp -r "$source/tests/consumer" "$tmp/weft"
mmdebstrap --quiet --variant=apt --format=null \
    --customize-hook="copy-in '$tmp/weft' /" \
    --customize-hook='chroot "$1" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin sh /weft/inside.sh' \
    bookworm -
