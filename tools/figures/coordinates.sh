#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# coordinates.sh OUT.svg: pixels, voxels and a slice among them, for docs/coordinates.md.
set -eu
awk '
    function line(x1, y1, x2, y2, class) {
        printf "<line class=\"%s\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>\n", class, x1, y1, x2, y2
    }
    function arrow(x1, y1, x2, y2, class) {
        printf "<line class=\"%s\" marker-end=\"url(#%s)\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>\n", \
            class, class, x1, y1, x2, y2
    }
    function dot(x, y, r, class) { printf "<circle class=\"%s\" cx=\"%.1f\" cy=\"%.1f\" r=\"%g\"/>\n", class, x, y, r }
    function say(x, y, text, class, anchor) {
        printf "<text class=\"%s\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">%s</text>\n", class, x, y, \
            anchor ? anchor : "start", text
    }
    # A point of index space, of the third panel, on the paper: x to the right, y into it, z up.
    function px(x, y, z) { return 745 + 25 * x + 15 * y }
    function py(x, y, z) { return 345 - 25 * z - 11 * y + 4 * x }
    function edge(a, b, c, d, e, f, class) { line(px(a, b, c), py(a, b, c), px(d, e, f), py(d, e, f), class) }

    function pixels(  x, y, left, top, side) {
        left = 40; top = 92; side = 58
        say(20, 28, "An image of 4 x 3 pixels", "head")
        for (x = 0; x <= 4; x++) line(left + x * side, top, left + x * side, top + 3 * side, "cell")
        for (y = 0; y <= 3; y++) line(left, top + y * side, left + 4 * side, top + y * side, "cell")
        for (y = 0; y < 3; y++)
            for (x = 0; x < 4; x++) dot(left + (x + 0.5) * side, top + (y + 0.5) * side, 4, "pixel")
        for (x = 0; x <= 4; x++) say(left + x * side, top - 10, x, "small", "middle")
        for (y = 0; y <= 3; y++) say(left - 12, top + y * side + 4, y, "small", "middle")
        say(left + 4 * side + 8, top + side / 2 + 4, "row 0", "note")
        say(left + 4 * side + 8, top + 2.5 * side + 4, "row 2", "note")
        say(left + 1.5 * side + 7, top + side * 1.5 - 6, "(1, 1)", "small")
        arrow(left, top - 30, left + 62, top - 30, "axis")
        say(left + 70, top - 26, "x", "axis-name")
        arrow(left - 28, top, left - 28, top + 62, "axis")
        say(left - 32, top + 80, "y", "axis-name")
        say(20, 305, "Pixel (x, y) is centred at (x + 0.5, y + 0.5).", "note")
        say(20, 325, "Row 0 is on top. Pixel (1, 1) is at (1.5, 1.5).", "note")
        say(20, 345, "Edges of the picture are at 0 and 4, 0 and 3.", "note")
    }

    function voxels(  i, j, left, bottom, side) {
        left = 405; bottom = 252; side = 46
        say(370, 28, "A volume of 5 x 4 x n voxels", "head")
        printf "<rect class=\"box\" x=\"%g\" y=\"%g\" width=\"%g\" height=\"%g\"/>\n", \
            left - side / 2, bottom - 3.5 * side, 5 * side, 4 * side
        for (i = 0; i < 5; i++) line(left + i * side, bottom, left + i * side, bottom - 3 * side, "cell")
        for (j = 0; j < 4; j++) line(left, bottom - j * side, left + 4 * side, bottom - j * side, "cell")
        for (j = 0; j < 4; j++)
            for (i = 0; i < 5; i++) dot(left + i * side, bottom - j * side, 5, "voxel")
        for (i = 0; i < 5; i++) say(left + i * side, bottom + 40, i, "small", "middle")
        for (j = 0; j < 4; j++) say(left - 33, bottom - j * side + 4, j, "small", "middle")
        say(left + 2 * side + 7, bottom - side + 17, "(2, 1, k)", "small")
        say(left - side / 2, bottom - 3.5 * side - 8, "-0.5", "small", "middle")
        say(left + 4.5 * side, bottom - 3.5 * side - 8, "4.5", "small", "middle")
        say(370, 325, "Voxel (i, j, k) is the point (i, j, k). The box", "note")
        say(370, 345, "reaches half a voxel further (dashed).", "note")
        say(370, 365, "world = A (i, j, k) + b, by the grid itself.", "note")
    }

    function slice(  t) {
        say(715, 28, "A slice of W x H pixels in the volume", "head")
        edge(0, 0, 0, 8, 0, 0, "solid"); edge(0, 0, 0, 0, 0, 8, "solid"); edge(8, 0, 0, 8, 0, 8, "solid")
        edge(0, 0, 8, 8, 0, 8, "solid"); edge(8, 0, 0, 8, 6, 0, "solid"); edge(8, 0, 8, 8, 6, 8, "solid")
        edge(0, 0, 8, 0, 6, 8, "solid"); edge(0, 6, 8, 8, 6, 8, "solid"); edge(8, 6, 0, 8, 6, 8, "solid")
        edge(0, 0, 0, 0, 6, 0, "hidden"); edge(0, 6, 0, 8, 6, 0, "hidden"); edge(0, 6, 0, 0, 6, 8, "hidden")
        # Origin (0, 2, 7), u = (8, 2, 0), v = (0, 1, -6).
        printf "<polygon class=\"plane\" points=\"%.1f,%.1f %.1f,%.1f %.1f,%.1f %.1f,%.1f\"/>\n", \
            px(0, 2, 7), py(0, 2, 7), px(8, 4, 7), py(8, 4, 7), px(8, 5, 1), py(8, 5, 1), px(0, 3, 1), py(0, 3, 1)
        for (t = 1; t < 4; t++) {
            edge(8 * t / 4, 2 + 2 * t / 4, 7, 8 * t / 4, 3 + 2 * t / 4, 1, "faint")
            if (t < 3) edge(0, 2 + t / 3, 7 - 2 * t, 8, 4 + t / 3, 7 - 2 * t, "faint")
        }
        dot(px(1, 2.25 + 1 / 6, 6), py(1, 2.25 + 1 / 6, 6), 4, "pixel")
        arrow(px(0, 2, 7), py(0, 2, 7), px(7.7, 3.925, 7), py(7.7, 3.925, 7), "vector")
        arrow(px(0, 2, 7), py(0, 2, 7), px(0, 2.95, 1.3), py(0, 2.95, 1.3), "vector")
        dot(px(0, 2, 7), py(0, 2, 7), 5, "origin")
        say(px(0, 2, 7) - 8, py(0, 2, 7) - 10, "origin", "mark", "end")
        say(px(5, 3.25, 7), py(5, 3.25, 7) - 10, "u", "mark", "middle")
        say(px(0, 2.7, 3) - 10, py(0, 2.7, 3), "v", "mark", "end")
        say(px(1, 2.42, 6) + 8, py(1, 2.42, 6) + 4, "(0, 0)", "small")
        arrow(745, 345, 785, 351.4, "axis"); arrow(745, 345, 745, 305, "axis")
        say(778, 366, "i", "axis-name"); say(730, 312, "k", "axis-name")
        arrow(745, 345, 769, 327.4, "axis"); say(774, 332, "j", "axis-name")
        say(820, 395, "Pixel (x, y) samples the volume at", "note")
        say(820, 415, "origin + (x + 0.5)/W u + (y + 0.5)/H v.", "note")
    }

    BEGIN {
        print "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"1100\" height=\"430\" viewBox=\"0 0 1100 430\">"
        print "<style>text{font-family:sans-serif;fill:#202020}.head{font-size:16px;font-weight:bold}"
        print ".note{font-size:13px}.small{font-size:12px;fill:#606060}.axis-name{font-size:14px;font-style:italic}"
        print ".mark{font-size:15px;font-weight:bold;fill:#b03000}.cell{stroke:#c0c0c0}.solid{stroke:#707070}"
        print ".hidden{stroke:#b0b0b0;stroke-dasharray:4 3}.box{fill:none;stroke:#808080;stroke-dasharray:5 4}"
        print ".plane{fill:#f0a060;fill-opacity:.35;stroke:#b03000}.faint{stroke:#b03000;stroke-opacity:.4}"
        print ".pixel{fill:#b03000}.voxel{fill:#0060a8}.origin{fill:#b03000}"
        print ".axis{stroke:#202020;stroke-width:1.3}.vector{stroke:#b03000;stroke-width:2}</style>"
        print "<defs><marker id=\"axis\" markerWidth=\"9\" markerHeight=\"8\" refX=\"6\" refY=\"4\" orient=\"auto\">" \
              "<path d=\"M0,0L8,4L0,8z\" fill=\"#202020\"/></marker><marker id=\"vector\" markerWidth=\"7\" " \
              "markerHeight=\"6\" refX=\"5\" refY=\"3\" orient=\"auto\"><path d=\"M0,0L6,3L0,6z\" fill=\"#b03000\"/>" \
              "</marker></defs>"
        print "<rect width=\"1100\" height=\"430\" fill=\"white\"/>"
        pixels(); voxels(); slice()
        print "</svg>"
    }' >"$1.new"
mv "$1.new" "$1"
