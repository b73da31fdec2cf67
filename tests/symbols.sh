#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# symbols.sh NM LIBRARY.so LIBRARY.a SOURCE_DIR: every global symbol that either library defines
# starts with weft_, and so does what the public headers define: macros (WEFT_, too) and include
# guards, tags of structs, enums and unions, types, inline functions, and the constants of enums
# (WEFT_).
set -eu
nm=$1 shared=$2 static=$3 source=$4
{
    "$nm" -D --defined-only "$shared"
    "$nm" -g --defined-only "$static"
} | awk 'NF == 3 { count++; if ($3 !~ /^weft_/) { print "not weft_: " $3; bad = 1 } }
         END { print count + 0 " symbols"; exit bad || count < 100 }'

cd "$source"
headers="weft.h weft_mpi.h $(sed -n 's/^#include "\(.*\)"$/\1/p' weft.h weft_mpi.h)"
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
# Without comments and continued lines; macros apart, the rest on one line.
cat $headers | sed -e 's|//.*||' -e ':again' -e '/\\$/{N;s/\\\n/ /;b again' -e '}' >"$tmp/text"
sed -n 's/^[[:space:]]*#[[:space:]]*define[[:space:]]*\([A-Za-z0-9_]*\).*/macro \1/p' \
    "$tmp/text" >"$tmp/names"
sed '/^[[:space:]]*#/d' "$tmp/text" | tr '\n' ' ' >"$tmp/line"
grep -oE '\b(struct|enum|union) [A-Za-z0-9_]+ *[{;]' "$tmp/line" |
    sed 's/^[a-z]* \([A-Za-z0-9_]*\).*/tag \1/' >>"$tmp/names"
grep -oE '\btypedef [^;{]*;' "$tmp/line" |
    sed -e 's/.*(\*\([A-Za-z0-9_]*\)).*/type \1/' -e 's/^typedef.*[ *]\([A-Za-z0-9_]*\) *;/type \1/' \
        >>"$tmp/names"
grep -oE '\benum( [A-Za-z0-9_]+)? *\{[^}]*\}' "$tmp/line" | sed 's/^[^{]*{//; s/}$//' | tr ',' '\n' |
    sed -n 's/^[[:space:]]*\([A-Za-z_][A-Za-z0-9_]*\).*/constant \1/p' >>"$tmp/names"
grep -oE '\bstatic inline [^({;]*\(' "$tmp/line" |
    sed 's/.*[ *]\([A-Za-z0-9_]*\)(/function \1/' >>"$tmp/names"
awk '{ count[$1]++ }
     $1 == "macro" ? $2 !~ /^(WEFT|weft)_/ : $1 == "constant" ? $2 !~ /^WEFT_/ : $2 !~ /^weft_/ {
         print "a " $1 " of a public header is not weft_: " $2; bad = 1 }
     END { for (kind in count) print count[kind] " " kind "s"
           exit bad || count["macro"] < 200 || count["tag"] < 200 || count["type"] < 20 ||
                count["constant"] < 100 }' "$tmp/names"
