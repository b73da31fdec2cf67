#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# sh tests/run.sh: builds weft with warnings as errors into build/check and runs every test.
# Installs Debian packages if any are missing (as root, or with sudo).
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/tools/setup.sh"

weft_install_packages
mkdir -p "$root/build"
start=$(date +%s)
# Functions and lines are all that is asked of debug information: a sixth of compiling is the rest.
weft_build build/check -DCMAKE_BUILD_TYPE=RelWithDebInfo -DWEFT_WERROR=ON \
    "-DCMAKE_C_FLAGS_RELWITHDEBINFO=-O2 -g1 -DNDEBUG"
built=$(date +%s)
echo "== testing"
status=0
# One more than there are processors: some tests wait for what they start.
ctest --test-dir "$root/build/check" --output-on-failure -j "$(($(nproc) + 1))" || status=$?
tested=$(date +%s)
verdict=passed
[ "$status" -eq 0 ] || verdict=FAILED
echo "== weft tests $verdict: built in $((built - start)) s, tested in $((tested - built)) s"
exit "$status"
