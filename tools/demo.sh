#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# sh tools/demo.sh [VOLUME.vdb]: from a fresh clone to a tri-cubic slice with its error measured.
# Installs Debian packages if any are missing (as root, or with sudo), builds into build/demo, and
# leaves demo/slice.exr and demo/slice.png. Without a volume it makes one (Marschner-Lobb, 128^3).
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/tools/setup.sh"

volume=${1:-}
if [ -n "$volume" ] && [ ! -r "$volume" ]; then
    echo "cannot read $volume" >&2
    exit 3
fi

weft_install_packages
mkdir -p "$root/build" "$root/demo"
weft_build build/demo -DCMAKE_BUILD_TYPE=Release -DWEFT_TESTS=OFF
weft="$root/build/demo/weft"

if [ -z "$volume" ]; then
    volume="$root/demo/marschner-lobb.vdb"
    echo "== making $volume"
    "$weft" make marschner-lobb -o "$volume"
fi

echo "== slicing $volume with the Catmull-Rom kernel"
"$weft" info "$volume"
"$weft" slice "$volume" -o "$root/demo/slice.exr" --preview "$root/demo/slice.png" --verify -v
echo "== done:"
echo "$root/demo/slice.exr"
echo "$root/demo/slice.png"
