#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# letter.py OUT.raw: an F of 28^3 bytes that is of no symmetry: it stands in the plane of y (to the
# right) and z (up), and its arms are thinner along x than its stem.
import sys

LETTER = ["#####", "#....", "####.", "#....", "#...."]
SIZE, SCALE, MARGIN = 28, 4, 4

def value(x, y, z):
    column, row = (y - MARGIN) // SCALE, (SIZE - 1 - MARGIN - z) // SCALE
    if not (0 <= column < 5 and 0 <= row < 5 and LETTER[row][column] == "#"):
        return 0
    return 255 if 8 <= x < (20 if column == 0 else 14) else 0

with open(sys.argv[1], "wb") as out:
    out.write(bytes(value(x, y, z) for z in range(SIZE) for y in range(SIZE) for x in range(SIZE)))
