#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# run.sh BUILD_DIR LIBDIR CC MPI...: installs the build tree to a temporary prefix, builds the
# consumer against it by CMake and by pkg-config, shared and static, and runs each; likewise one that
# uses MPI, by pkg-config and by CMake, for each of those that weft was built for (openmpi, mpich).
# Then removes what was installed.
set -eu
build=$1 libdir=$2 cc=$3
shift 3
source=$(cd "$(dirname "$0")" && pwd)
tmp=$(mktemp -d)
prefix="$tmp/a prefix"
# The build tree's manifest stays that of what the user installed.
manifest=$build/install_manifest.txt
[ ! -f "$manifest" ] || cp -p "$manifest" "$tmp/manifest"
tidy() {
    rm -f "$manifest"
    [ ! -f "$tmp/manifest" ] || mv "$tmp/manifest" "$manifest"
    rm -rf "$tmp"
}
trap tidy EXIT

cmake --install "$build" --prefix "$prefix" >/dev/null
"$prefix/bin/weft" --version
# The tree has been moved from its configured prefix: the readers must be found all the same.
ramp=$tmp/ramp.vdb
"$prefix/bin/weft" make ramp --size 8 -q -o "$ramp"
"$prefix/bin/weft" info "$ramp" >/dev/null
for reader in weft-read-dwa weft-read-exr weft-read-mesh weft-read-nifti weft-read-nrrd \
        weft-read-png weft-read-tiff weft-read-vdb weft-write-tiff weft-write-vdb; do
    test -x "$prefix/libexec/weft/$reader"
done
for text in "$source"/../../docs/*.md README.md CHANGELOG.md LICENSE; do
    test -s "$prefix/share/doc/weft/${text#"$source/../../"}"
done
man=$(echo "$prefix"/share/man/man1/weft-slice.1*)
test "$(ls "$prefix/share/man/man1" | wc -l)" = "$(($(ls "$source"/../../tools/verbs/*.c | wc -l) + 1))"
case $man in *.gz) gzip -dc "$man" ;; *) cat "$man" ;; esac | grep -q '^weft.*-slice '
for script in bash-completion/completions/weft zsh/site-functions/_weft \
        fish/vendor_completions.d/weft.fish; do
    grep -q catmull-rom "$prefix/share/$script"
done

# Consumers have headers of the same names as weft's, which come first and do not compile.
hostile=$tmp/hostile
(cd "$prefix/include/weft" && find . -name '*.h' ! -path './weft*.h') | while read -r header; do
    mkdir -p "$hostile/$(dirname "$header")"
    echo "#error not weft's $header" >"$hostile/$header"
done
test -f "$hostile/filter/base.h"

cmake -S "$source" -B "$tmp/cmake" -G Ninja -D CMAKE_C_COMPILER="$cc" \
    -D CMAKE_PREFIX_PATH="$prefix" -D WEFT_HOSTILE="$hostile" -D WEFT_MPIS="$(echo "$*" | tr ' ' ';')" >/dev/null
cmake --build "$tmp/cmake" || exit 1
# A program that the library is part of knows no moved tree.
libexec=$prefix/libexec/weft
echo "-- CMake, shared"
"$tmp/cmake/consumer_weft" "$ramp"
"$tmp/cmake/consumer_cxx"
echo "-- CMake, static"
WEFT_LIBEXEC=$libexec "$tmp/cmake/consumer_weft_static" "$ramp"

# compile OUT SOURCE MODULE...: pkg-config writes what is to be quoted for a shell.
export PKG_CONFIG_PATH="$prefix/$libdir/pkgconfig"
compile() {
    out=$1 program=$2
    shift 2
    flags=$(pkg-config --cflags --libs "$@")
    eval "\"\$cc\" \"\$source/\$program\" -o \"\$out\" -I\"\$hostile\" $flags -lm"
}
echo "-- pkg-config, shared"
compile "$tmp/shared" consumer.c weft
LD_LIBRARY_PATH="$prefix/$libdir" "$tmp/shared" "$ramp"
echo "-- pkg-config, static"
compile "$tmp/static" consumer.c weft-static
if ldd "$tmp/static" | grep libweft; then
    exit 1
fi
WEFT_LIBEXEC=$libexec "$tmp/static" "$ramp"

export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
for mpi in "$@"; do
    [ -x "/usr/bin/mpirun.$mpi" ] || { echo "-- $mpi: no launcher, skipped" && continue; }
    run="mpirun.$mpi -n 3"
    [ "$mpi" != openmpi ] || run="$run --oversubscribe --bind-to none"
    echo "-- $mpi, pkg-config"
    compile "$tmp/ranks_$mpi" ranks.c "weft-$mpi"
    LD_LIBRARY_PATH="$prefix/$libdir" $run "$tmp/ranks_$mpi"
    echo "-- $mpi, CMake"
    $run "$tmp/cmake/ranks_$mpi"
    echo "-- $mpi, the command"
    $run "$prefix/bin/weft" slice "$ramp" --size 8x8 -q -o "$tmp/slice.exr"
    test -s "$tmp/slice.exr"
    rm "$tmp/slice.exr"
done

echo "-- removed"
cmake -D MANIFEST="$manifest" -P "$source/../../cmake/uninstall.cmake"
test -z "$(ls -A "$prefix")"
