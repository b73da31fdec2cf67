#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# figure_kernels.sh BUILD OUT.png [--size WxH]: the picture of figure_kernels (of BUILD) with its cells
# named, by gnuplot; the names and errors on stdout. Makes docs/kernels-side-by-side.png.
set -eu
build=$1 out=$2
shift 2
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
"$build/figure_kernels" "$@" "$tmp/cells.png" >"$tmp/table"
cat "$tmp/table"

# Where a cell stands, as figure_kernels puts them: three in a row, 4 pixels apart.
bytes() { od -An -tu1 -j"$1" -N4 "$tmp/cells.png" | awk '{ print (($1 * 256 + $2) * 256 + $3) * 256 + $4 }'; }
awk -F'|' '
    { label[n++] = $1; rms[n - 1] = $2 }
    END {
        columns = 3; rows = int((n + columns - 1) / columns)
        cell = (w + 4) / columns - 4; high = (h + 4) / rows - 4
        head = 30; W = w + 16; H = h + rows * head + 10
        printf "set terminal pngcairo size %d,%d font \"sans,13\" noenhanced\n", W, H
        print "unset border\nunset tics\nunset key\nset multiplot"
        for (i = 0; i < n; i++) {
            x = 8 + (i % columns) * (cell + 4)
            y = (H - (int(i / columns) * (high + head + 4) + 15)) / H
            printf "set label \"%s\" at screen %.6f,%.6f left font \"sans:Bold,14\"\n", label[i], (x + 4) / W, y
            printf "set label \"%s\" at screen %.6f,%.6f right font \"sans,11\" textcolor rgb \"#505050\"\n",
                rms[i] + 0 ? "rms error " rms[i] : "red: off by 0.1 of the range", (x + cell - 4) / W, y
        }
        for (row = 0; row < rows; row++) { # a strip of the picture at a time
            top = row * (high + head + 4) + head
            printf "set lmargin at screen %.8f\nset rmargin at screen %.8f\n", 8 / W, (8 + w) / W
            printf "set bmargin at screen %.8f\nset tmargin at screen %.8f\n", (H - top - high) / H, (H - top) / H
            from = h - row * (high + 4) - high
            printf "set xrange [-0.5:%d-0.5]\nset yrange [%g-0.5:%g-0.5]\n", w, from, from + high
            printf "plot \"%s\" binary filetype=png with rgbimage\nunset label\n", cells
        }
        print "unset multiplot"
    }' cells="$tmp/cells.png" w="$(bytes 16)" h="$(bytes 20)" "$tmp/table" >"$tmp/script"
sed -i "1s|^|set output '$tmp/out.png'\n|" "$tmp/script"
gnuplot "$tmp/script"
mv "$tmp/out.png" "$out"
