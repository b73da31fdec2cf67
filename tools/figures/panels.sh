#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# panels.sh OUT.png COLUMNS LABEL=FILE.png...: pictures of one size side by side, COLUMNS in a row,
# each with its label above, by gnuplot. A label's second line, after a "|", is smaller.
set -eu
out=$1 columns=$2
shift 2
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
for panel; do
    file=${panel#*=}
    # Sides, as the header of a PNG file has them.
    od -An -tu1 -j16 -N8 "$file" | awk -v label="${panel%%=*}" -v file="$file" '
        { print label "\t" file "\t" ($1 * 256 + $2) * 65536 + $3 * 256 + $4 "\t" \
              ($5 * 256 + $6) * 65536 + $7 * 256 + $8 }'
done >"$tmp/panels"
awk -F'\t' -v columns="$columns" '
    { label[n++] = $1; file[n - 1] = $2; if ($3 > w) w = $3; if ($4 > h) h = $4
      width[n - 1] = $3; height[n - 1] = $4; if ($1 ~ /[|]/) small = 17 }
    END {
        if (columns > n) columns = n
        rows = int((n + columns - 1) / columns); gap = 6; head = 26 + small
        W = columns * (w + gap) + gap; H = rows * (h + head + gap) + gap
        printf "set terminal pngcairo size %d,%d font \"sans,12\" noenhanced\n", W, H
        print "unset border\nunset tics\nunset key\nset multiplot"
        for (i = 0; i < n; i++) {
            x = gap + (i % columns) * (w + gap); top = int(i / columns) * (h + head + gap) + head
            split(label[i], line, "|")
            printf "set label 1 \"%s\" at screen %.6f,%.6f left font \"sans:Bold,12\"\n", line[1], x / W, (H - top + 12 + small) / H
            printf "set label 2 \"%s\" at screen %.6f,%.6f left font \"sans,10\" textcolor rgb \"#505050\"\n", line[2], x / W, (H - top + 10) / H
            printf "set lmargin at screen %.8f\nset rmargin at screen %.8f\n", x / W, (x + width[i]) / W
            printf "set tmargin at screen %.8f\nset bmargin at screen %.8f\n", (H - top) / H, (H - top - height[i]) / H
            printf "set xrange [-0.5:%d-0.5]\nset yrange [-0.5:%d-0.5]\n", width[i], height[i]
            printf "plot \"%s\" binary filetype=png with rgbimage\n", file[i]
        }
        print "unset multiplot"
    }' "$tmp/panels" >"$tmp/script"
sed -i "1s|^|set output '$tmp/out.png'\n|" "$tmp/script"
gnuplot "$tmp/script"
mv "$tmp/out.png" "$out"
