#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# figure_accumulate.sh BUILD OUT.png [--context auto|osmesa|egl]: the picture of figure_accumulate (of
# BUILD) with its rows and columns named, by gnuplot; its tables on stdout. Makes
# docs/accumulation-cube.png.
set -eu
build=$1 out=$2
shift 2
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
"$build/figure_accumulate" "$@" "$tmp/cells.png" >"$tmp/tables"
cat "$tmp/tables"
# Rows and columns as the first table has them.
awk -F' *[|] *' '
    /^identical/ { on = 1 } /^noise/ { on = 0 }
    on && /^\| N / { columns = NF - 3; for (i = 1; i <= columns; i++) head[i] = $(i + 2) }
    on && /^\|/ && !/^\| N / && !/^\|---/ { row[++rows] = $2 }
    END {
        split("equal frames, averaged;their errors, 16 times, on grey;errors of frames of noise, 16 times", title, ";")
        pitch = 80; left = 215; top = 48; panel = columns * pitch + 8; w = 3 * panel; h = rows * pitch + 4
        W = left + w + 10; H = top + h + 10
        printf "set terminal pngcairo size %d,%d font \"sans,11\"\n", W, H
        printf "set lmargin at screen %.8f\nset rmargin at screen %.8f\n", left / W, (left + w) / W
        printf "set bmargin at screen %.8f\nset tmargin at screen %.8f\n", 10 / H, (10 + h) / H
        printf "set xrange [-0.5:%d-0.5]\nset yrange [-0.5:%d-0.5]\n", w, h
        print "unset border\nunset tics\nunset key"
        for (r = 1; r <= rows; r++)
            printf "set label \"%s\" at screen %.6f,%.6f right\n", row[r], (left - 8) / W,
                (10 + h - (r - 0.5) * pitch) / H
        for (c = 1; c <= columns; c++)
            for (p = 0; p < 3; p++)
                printf "set label \"%s\" at screen %.6f,%.6f center\n", head[c],
                    (left + (c - 0.5) * pitch + p * panel) / W, (10 + h + 10) / H
        for (p = 0; p < 3; p++)
            printf "set label \"%s\" at screen %.6f,%.6f left\n",
                title[p + 1], (left + 4 + p * panel) / W,
                (10 + h + 34) / H
        printf "plot \"%s\" binary filetype=png with rgbimage\n", cells
    }' cells="$tmp/cells.png" "$tmp/tables" >"$tmp/script"
sed -i "1s|^|set output '$tmp/out.png'\n|" "$tmp/script"
gnuplot "$tmp/script"
mv "$tmp/out.png" "$out"
