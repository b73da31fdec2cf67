#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# bench_warp_peers.sh WEFT IMAGE.exr [RUNS]: a turn by 15 degrees from file to file, in turns with
# oiiotool --rotate and ImageMagick -distort SRT (which reads a TIFF copy of the same floats);
# medians of wall and processor seconds. Each writes what it writes fastest of the same type:
# uncompressed half EXR, or float TIFF. What is not installed is left out.
set -eu
weft=$1 image=$2 runs=${3:-5}
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
oiiotool "$image" --compression none -o "$tmp/in.exr"
oiiotool "$image" -d float --compression none -o "$tmp/in.tif"

# A name, the command, and where its times go.
one() {
    name=$1
    shift
    python3 - "$tmp/$name.times" "$@" <<'PY'
import resource, subprocess, sys, time
start = time.monotonic()
subprocess.run(sys.argv[2:], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
wall = time.monotonic() - start
used = resource.getrusage(resource.RUSAGE_CHILDREN)
print(wall, used.ru_utime + used.ru_stime, file=open(sys.argv[1], 'a'))
PY
}
i=0
while [ $i -lt "$runs" ]; do
    one weft-cpu "$weft" resample "$tmp/in.exr" -o "$tmp/out.exr" --rotate 15 --boundary border:0 -q
    one weft-gl "$weft" resample "$tmp/in.exr" -o "$tmp/out.exr" --rotate 15 --boundary border:0 \
        --engine gl -q
    one oiiotool oiiotool "$tmp/in.exr" --rotate:filter=catmull-rom -15 -o "$tmp/out.exr"
    ! command -v convert >/dev/null || one imagemagick convert "$tmp/in.tif" -virtual-pixel black \
        -filter Catrom -interpolate Catrom -distort SRT -15 "$tmp/out.tif"
    i=$((i + 1))
done
for f in "$tmp"/*.times; do
    sort -n "$f" | awk -v name="$(basename "$f" .times)" '{ wall[NR] = $1; cpu[NR] = $2 }
        END { m = int((NR + 1) / 2); printf "%-12s %.3f s wall, %.3f s of processors\n", name,
              wall[m], cpu[m] }'
done
