#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
# bench_resample.sh WEFT [RUNS [IMAGE.exr]]: `weft resample` on both engines and `oiiotool --resize`,
# end to end: a 1240 x 846 RGBA half image, packed with PIZ, to 4096 x 4096 and to 25 %, Catmull-Rom,
# half and PIZ again. Ways in turns; medians of wall clock and of processor time, which other
# programs on the machine disturb less, and how much of oiiotool's both are. The image is made by
# oiiotool (Debian's openimageio-tools) from another, with a little noise so that it packs like a
# photo; without oiiotool one of 1240 x 846 is to be given, and weft is measured alone.
set -eu
weft=$1 runs=${2:-5}
image=${3:-$(dirname "$0")/../../../shared/data/SquaresSwirls.exr}
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
TIMEFORMAT='%R %U %S'

if command -v oiiotool >/dev/null; then
    ways="oiiotool gl cpu double"
    oiiotool "$image" --resize 1240x846 --ch R,G,B,A=1 --noise:type=gaussian:stddev=0.004:seed=7 \
        -d half --compression piz -o "$tmp/in.exr"
else
    ways="gl cpu double"
    cp "$image" "$tmp/in.exr"
    echo "oiiotool is not here: left out"
fi

once() { # WAY SIZE
    case $1 in
    oiiotool) oiiotool "$tmp/in.exr" --resize:filter=catmull-rom "$2" -d half --compression piz \
        -o "$tmp/out.exr" ;;
    double) "$weft" resample "$tmp/in.exr" -q --size "$2" --sums double -o "$tmp/out.exr" ;;
    *) "$weft" resample "$tmp/in.exr" -q --size "$2" --engine "$1" -o "$tmp/out.exr" ;;
    esac
}

median() { sort -n | awk '{ v[NR] = $1 } END { print v[int((NR + 1) / 2)] }'; }

for size in 4096x4096 310x212; do
    for way in $ways; do once "$way" $size; done # files in memory, programs too
    for ((run = 0; run < runs; run++)); do
        for way in $ways; do
            { time once "$way" $size 2>/dev/null; } 2>>"$tmp/$way.$size"
        done
    done
    echo "to $size, medians of $runs turns:"
    for way in $ways; do
        wall=$(awk '{ print $1 }' "$tmp/$way.$size" | median)
        work=$(awk '{ print $2 + $3 }' "$tmp/$way.$size" | median)
        [ "$way" != oiiotool ] || { all=$wall; own=$work; }
        echo "$way $wall $work ${all:-0} ${own:-0}" | awk '{
            printf "  %-9s %7.3f s, %7.3f s of processors", $1, $2, $3
            if ($4 > 0) printf "; %.2f and %.2f of oiiotool", $2 / $4, $3 / $5
            printf "\n" }'
    done
done
