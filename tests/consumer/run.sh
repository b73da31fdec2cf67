#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# run.sh BUILD_DIR LIBDIR CC MPI...: installs the build tree to a temporary prefix, builds the
# consumer against it by CMake and by pkg-config, shared and static, and runs each. Likewise one that
# uses MPI, by pkg-config and by CMake, for each of those that weft was built for (openmpi, mpich).
set -eu
build=$1 libdir=$2 cc=$3
shift 3
source=$(dirname "$0")
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
prefix=$tmp/prefix

cmake --install "$build" --prefix "$prefix" >/dev/null
"$prefix/bin/weft" --version
# The tree has been moved from its configured prefix: the readers must be found all the same.
"$prefix/bin/weft" make ramp --size 8 -q -o "$tmp/ramp.vdb"
"$prefix/bin/weft" info "$tmp/ramp.vdb" >/dev/null
for reader in weft-read-dwa weft-read-exr weft-read-mesh weft-read-png weft-read-vdb \
        weft-write-vdb; do
    test -x "$prefix/libexec/weft/$reader"
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
for kind in weft weft_static cxx; do
    echo "-- CMake, $kind"
    "$tmp/cmake/consumer_$kind"
done

export PKG_CONFIG_PATH="$prefix/$libdir/pkgconfig"
echo "-- pkg-config, shared"
flags=$(pkg-config --cflags --libs weft)
"$cc" "$source/consumer.c" -o "$tmp/shared" -I"$hostile" $flags -lm
LD_LIBRARY_PATH="$prefix/$libdir" "$tmp/shared"
echo "-- pkg-config, static"
# The linker would take the shared library where it finds both.
flags=$(pkg-config --static --cflags --libs weft | sed 's/-lweft/-l:libweft.a/')
"$cc" "$source/consumer.c" -o "$tmp/static" -I"$hostile" $flags
"$tmp/static"

export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
for mpi in "$@"; do
    [ -x "/usr/bin/mpirun.$mpi" ] || { echo "-- $mpi: no launcher, skipped" && continue; }
    run="mpirun.$mpi -n 3"
    [ "$mpi" != openmpi ] || run="$run --oversubscribe --bind-to none"
    echo "-- $mpi, pkg-config"
    "$cc" "$source/ranks.c" -o "$tmp/ranks_$mpi" -I"$hostile" \
        $(pkg-config --cflags --libs "weft-$mpi")
    LD_LIBRARY_PATH="$prefix/$libdir" $run "$tmp/ranks_$mpi"
    echo "-- $mpi, CMake"
    $run "$tmp/cmake/ranks_$mpi"
    echo "-- $mpi, the command"
    $run "$prefix/bin/weft" slice "$tmp/ramp.vdb" --size 8x8 -q -o "$tmp/slice.exr"
    test -s "$tmp/slice.exr"
    rm "$tmp/slice.exr"
done
