#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# house.sh NM SOURCE_DIR BUILD_DIR: the source tree keeps its shape. Includes and calls run only to
# the same room or to one that stands before it below, files do not call each other in circles, no
# folder has more than 28 entries, and every public header says about as much as it declares.
# Prints what breaks these rules, one line each, and then the figures.
set -eu
nm=$1 source=$2 build=$3
most_entries=28 least_comment=0.9

# Each room may use those before it.
rooms='filter filter/kernels filter/analysis tiles/output tiles/process tiles/kernel tiles/volume
tiles/image tiles/image/exr tiles/image/codes tiles/image/files tiles/mesh tiles/readers/mesh tiles/readers/dense tiles/readers/tiff tiles/readers passes/cpu passes/gl/native passes/gl passes/gl/textures passes/accumulate/sums passes/accumulate/tree
passes/accumulate/blend passes/accumulate passes/jitter passes/separable passes/positions passes/plan
passes/fused/lines
passes/fused passes/points passes/hardware passes/multipass passes/slice passes/verify passes/choose passes/simple passes/resample passes/warp passes/lattice
passes/antialias/pattern passes/antialias/drawing passes/antialias/marks passes/antialias passes/stability
passes/distribute/schedule passes/distribute passes/params passes/distribute/mpi weft tools/common tools/framing tools/options tools/volumes tools/draw tools/ranks tools/methods tools/plan_json tools/scene
tools/render/gl tools/render tools/resample tools/accumulate tools/effect/lights tools/effect tools/antialias tools/curve tools/slice tools/probe tools/lattice tools/table tools/chart tools/kernel tools/verbs tools/program'
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
cd "$source"

# "user used kind" for every include and for every call from one source file to another.
find filter tiles passes tools weft.h -name '*.[ch]' -o -name '*.cc' | sort >"$tmp/files"
xargs grep -H '^#include "' <"$tmp/files" | awk -F'[:"]' '
    # The path as written from the source root, or relative to the file.
    function known(path, line) { if (!(path in cache)) {
            cache[path] = (getline line <path) >= 0; close(path) } return cache[path] }
    function join(file, path, parts) {
        sub(/[^\/]*$/, "", file)
        while (path ~ /^\.\.\//) { path = substr(path, 4); sub(/[^\/]*\/$/, "", file) }
        return file path }
    { near = join($1, $3); print $1, (known(near) ? near : $3), "include" }' >"$tmp/includes"
find "$build"/CMakeFiles/weft_objects.dir "$build"/CMakeFiles/weft_tools.dir \
    "$build"/CMakeFiles/weft.dir -name '*.o' >"$tmp/objects"
# With an MPI, where there is one; either will do.
for name in openmpi mpich; do
    [ ! -d "$build/CMakeFiles/weft-$name.dir" ] || [ -s "$tmp/mpi" ] ||
        find "$build/CMakeFiles/weft_$name.dir" "$build/CMakeFiles/weft-$name.dir" -name '*.o' |
        tee "$tmp/mpi" >>"$tmp/objects"
done
xargs "$nm" -A <"$tmp/objects" | awk -v sources="$tmp/files" -v build="$build/CMakeFiles/" '
    BEGIN { while ((getline file <sources) > 0) source[file] = 1 }
    # "BUILD/CMakeFiles/weft_objects.dir/FILE.o:..." is of FILE.
    { split($1, part, ":"); file = substr(part[1], length(build) + 1)
      sub(/^weft[^\/]*\.dir\//, "", file); sub(/\.o$/, "", file)
      if (file in source) print file, $0 }' | awk '
    $NF ~ /^(weft_|[a-z])/ && $(NF - 1) ~ /^[TDBRC]$/ { defined[$NF] = $1 }
    $(NF - 1) == "U" { count++; user[count] = $1; used[count] = $NF }
    END { for (i = 1; i <= count; i++) if (used[i] in defined && defined[used[i]] != user[i])
              print user[i], defined[used[i]], "call", used[i] }' | sort -u >"$tmp/calls"

cat "$tmp/includes" "$tmp/calls" | awk -v rooms="$rooms" '
    function room(file) {
        if (file == "weft.h") return "weft"
        sub(/\/[^\/]*$/, "", file); return file }
    BEGIN { count = split(rooms, name, /[ \n]+/); for (i = 1; i <= count; i++) rank[name[i]] = i }
    $2 ~ /\// || $2 == "weft.h" {
        from = room($1); to = room($2)
        if (!(from in rank)) print "no room of the house: " from
        else if (rank[to] > rank[from]) print "runs upwards: " $1 " to " $2 " (" $3 " " $4 ")" }
    ' | sort -u >"$tmp/faults"
awk '{ print $1, $2 }' "$tmp/calls" | sort -u | tsort >/dev/null 2>"$tmp/loops" ||
    sed -n "s/^tsort: \\([^ ]*\\.c\\)$/in a circle of calls: \\1/p" "$tmp/loops" | sort -u >>"$tmp/faults"
awk '$1 ~ /\.h$/ { print $1, $2 }' "$tmp/includes" | sort -u | tsort >/dev/null 2>"$tmp/loops" ||
    sed -n "s/^tsort: \\([^ ]*\\.h\\)$/in a circle of includes: \\1/p" "$tmp/loops" | sort -u >>"$tmp/faults"

find filter tiles passes tools tests -type d | sort | while read -r folder; do
    echo "$(find "$folder" -mindepth 1 -maxdepth 1 | wc -l) $folder"
done >"$tmp/folders"
awk -v most=$most_entries '$1 > most { print "more than " most " entries: " $2 " has " $1 }' \
    "$tmp/folders" >>"$tmp/faults"

# Comment lines to lines of code, what every header has aside.
for header in weft.h $(sed -n 's/^#include "\(.*\)"$/\1/p' weft.h); do
    [ "$header" = weft.h ] || awk -v header="$header" '
        /^[[:space:]]*$|SPDX|^#(ifndef|endif|include)|^#define WEFT_.*_H$|^WEFT_(BEGIN|END)_DECLS/ { next }
        /\/\// { comment++ } !/^[[:space:]]*\/\// { code++ }
        END { print comment, code, header }' "$header"
done >"$tmp/headers"
awk -v least=$least_comment '$1 < least * $2 {
    printf "says too little: %s has %d lines of comment for %d of code\n", $3, $1, $2 }' \
    "$tmp/headers" >>"$tmp/faults"

cat "$tmp/faults"
echo "$(wc -l <"$tmp/files") files, $(wc -l <"$tmp/includes") includes, $(wc -l <"$tmp/calls") calls"
awk '{ print $1 " entries: " $2 }' "$tmp/folders"
awk '{ c += $1; k += $2 } END { printf "public headers: %.2f comment to code\n", c / k }' "$tmp/headers"
[ ! -s "$tmp/faults" ]
