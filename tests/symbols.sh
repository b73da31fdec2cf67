#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# symbols.sh NM LIBRARY.so LIBRARY.a: every global symbol that either defines starts with weft_.
set -eu
nm=$1 shared=$2 static=$3
{
    "$nm" -D --defined-only "$shared"
    "$nm" -g --defined-only "$static"
} | awk 'NF == 3 { count++; if ($3 !~ /^weft_/) { print "not weft_: " $3; bad = 1 } }
         END { print count + 0 " symbols"; exit bad || count < 100 }'
