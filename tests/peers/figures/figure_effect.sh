#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# figure_effect.sh BUILD OUT.png [options of figure_effect]: the curves of figure_effect (of BUILD) as a
# chart, by gnuplot; their slopes on stdout. Makes docs/effect_convergence.png.
set -eu
build=$1 out=$2
shift 2
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
"$build/figure_effect" "$@" >"$tmp/curves"
grep '^"' "$tmp/curves"
# The first six blocks are anti-aliasing by sets of samples, the others effects.
awk '
    /^"/ { slope = $NF; sub(/ [^ ]*$/, ""); name[n++] = $0 " (" sprintf("%.2f", slope) ")"
           gsub(/"/, "", name[n - 1]) }
    NF == 3 && /^[0-9]/ { if ($2 > high) high = $2; if (!low || $2 < low) low = $2
                          if ($1 > most) most = $1 }
    function panel(first, end, left, title, i) {
        printf "set lmargin at screen %g\nset rmargin at screen %g\nset title \"%s\"\nplot ",
            left, left + 0.4, title
        for (i = first; i < end; i++)
            printf "curves index %d using 1:2 with linespoints lw 1.6 pt %d ps 0.9 title \"%s\", ",
                i, i - first + 4, name[i]
        print "0.3*x**-0.5 dt 2 lc \"#909090\" title \"N^{-1/2}\"," \
              "0.3*x**-0.75 dt 3 lc \"#909090\" title \"N^{-3/4}\"," \
              "0.3*x**-1 dt 4 lc \"#909090\" title \"N^{-1}\"" }
    END {
        print "set terminal pngcairo size 1000,520 font \"sans,10\" noenhanced"
        print "set output out"
        print "curves = data"
        print "set multiplot\nset logscale xy 2\nset logscale y 10\nset grid lc \"#d0d0d0\""
        print "set bmargin at screen 0.1\nset tmargin at screen 0.92"
        printf "set xrange [1:%g]\nset yrange [%g:%g]\n", most, low / 4, high * 1.5
        print "set key bottom left Left reverse samplen 2\nset xlabel \"frames\""
        print "set format y \"10^{%T}\"\nset termoption enhanced"
        print "set ylabel \"RMS error of the picture\""
        panel(0, 6, 0.07, "anti-aliasing, by set of samples (slope)")
        print "unset ylabel"
        panel(6, n, 0.57, "effects (slope)")
        print "unset multiplot"
    }' out="$tmp/out.png" data="$tmp/curves" "$tmp/curves" |
    sed "s|set output out|set output '$tmp/out.png'|; s|curves = data|curves = '$tmp/curves'|" >"$tmp/script"
gnuplot "$tmp/script"
mv "$tmp/out.png" "$out"
