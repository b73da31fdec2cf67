#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# figure_antialias.sh BUILD OUT.png [options of figure_antialias]: ways of anti-aliasing side by side with
# POV-Ray's on the same triangles, camera and colours (left out, with a line, where POV-Ray 3.7 is not
# installed), by gnuplot; times, memory and errors against exact coverage as a table on stdout. Makes
# docs/antialias-crops.png. RUNS: of POV-Ray, in turns (default 3).
set -eu
build=$1 out=$2
shift 2
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
size=256x256 columns=5
previous=
for argument in "$@"; do
    case $previous in --size) size=$argument ;; --columns) columns=$argument ;; esac
    previous=$argument
done
width=${size%x*} height=${size#*x}

# Each line: a label, and what POV-Ray is told. +A takes another sample where neighbours differ by more;
# +AM1 a fixed grid in such a pixel, +AM2 goes on where its corners differ, +R times; -J: not at random.
cat >"$tmp/settings" <<'SETTINGS'
POV-Ray +AM1|+AM1 +A0.1 +R4 -J
POV-Ray +AM2|+AM2 +A0.1 +R3 -J
SETTINGS

# Seconds of tracing, without the start of the program, which takes a second, and reading the scene.
trace() {
    # shellcheck disable=SC2086 # settings are several words
    povray "+I$tmp/scene.pov" "+O$1" "+W$width" "+H$height" $2 +FN16 File_Gamma=1 -D -P +WT"$(nproc)" \
        >"$tmp/log" 2>&1 || { tail -5 "$tmp/log" >&2; return 1; }
    sed -n 's/.*Trace Time:.*(\([0-9.]*\) seconds).*/\1/p' "$tmp/log"
}

if command -v povray >/dev/null; then
    "$build/figure_antialias" "$@" --pov "$tmp/scene.pov"
    n=0
    while [ "$n" -lt "${RUNS:-3}" ]; do
        n=$((n + 1)) k=0
        while IFS='|' read -r label settings; do
            k=$((k + 1))
            trace "$tmp/$k.png" "$settings" >>"$tmp/$k.times"
        done <"$tmp/settings"
    done
    k=0
    while IFS='|' read -r label settings; do
        k=$((k + 1))
        seconds=$(sort -n "$tmp/$k.times" | awk '{ t[NR] = $1 } END { print (t[int((NR + 1) / 2)] + t[int(NR / 2) + 1]) / 2 }')
        set -- "$@" --peer "$label|$seconds|$tmp/$k.png"
    done <"$tmp/settings"
else
    echo "figure_antialias.sh: POV-Ray is not installed, and left out" >&2
fi

"$build/figure_antialias" "$@" "$tmp/cells.png" >"$tmp/table"
echo '| way | ms | MiB | largest error | RMS error |'
echo '|---|---:|---:|---:|---:|'
awk -F'|' 'NR > 1 { printf "| %s | %s | %s | %s | %s |\n", $1, $2, $3, $4, $5 }' "$tmp/table"

# Labels above the cells, which are as large as the image and the number of columns say.
awk -F'|' '
    { label[n++] = $1; rms[n - 1] = $5 }
    END {
        if (columns > n) columns = n
        rows = int((n + columns - 1) / columns)
        cell = (w + 4) / columns - 4; high = (h + 4) / rows - 4
        head = 34; W = w + 20; H = h + rows * head + 14
        printf "set terminal pngcairo size %d,%d font \"sans,10\" noenhanced\n", W, H
        print "unset border\nunset tics\nunset key\nset multiplot"
        for (i = 0; i < n; i++) {
            x = 10 + (i % columns) * (cell + 4); row = int(i / columns)
            y = H - 6 - (row + 1) * (high + 4 + head) + 4 + high
            printf "set label \"%s\" at screen %.6f,%.6f left\n", label[i], x / W, (y + 22) / H
            if (i)
                printf "set label \"rms %s\" at screen %.6f,%.6f left font \"sans,9\" textcolor rgb \"#606060\"\n",
                    rms[i], x / W, (y + 8) / H
        }
        for (row = 0; row < rows; row++) { # a strip of the image at a time
            low = H - 6 - (row + 1) * (high + 4 + head) + 4
            printf "set lmargin at screen %.8f\nset rmargin at screen %.8f\n", 10 / W, (10 + w) / W
            printf "set bmargin at screen %.8f\nset tmargin at screen %.8f\n", low / H, (low + high) / H
            from = h - row * (high + 4) - high
            printf "set xrange [-0.5:%d-0.5]\nset yrange [%g-0.5:%g-0.5]\n", w, from, from + high
            printf "plot \"%s\" binary filetype=png with rgbimage\nunset label\n", cells
        }
        print "unset multiplot"
    }' columns="$columns" cells="$tmp/cells.png" \
    w="$(od -An -tu1 -j16 -N4 "$tmp/cells.png" | awk '{ print (($1 * 256 + $2) * 256 + $3) * 256 + $4 }')" \
    h="$(od -An -tu1 -j20 -N4 "$tmp/cells.png" | awk '{ print (($1 * 256 + $2) * 256 + $3) * 256 + $4 }')" \
    "$tmp/table" >"$tmp/script"
sed -i "1s|^|set output '$tmp/out.png'\n|" "$tmp/script"
gnuplot "$tmp/script"
mv "$tmp/out.png" "$out"
