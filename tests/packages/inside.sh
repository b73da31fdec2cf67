#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# inside.sh: in a bare Debian, as its root: installs the packages that lie beside it, uses each as a
# user would, and removes them again. Ends with 0 where all did as they should.
set -eu
export LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive
here=/weft work=/home/weft
install() {
    echo "-- $*"
    apt-get install -qq -y "$@" >/dev/null
}
packages() { for name in "$@"; do echo "$here/${name}"_*.deb; done; }
user() {
    echo "\$ $*"
    setpriv --reuid weft --regid weft --clear-groups env HOME=$work "$@"
}
# What is read there should not be.
none() {
    if grep "$@"; then
        exit 1
    fi
}
useradd -m -d $work weft
cd $work

# ---- the command --------------------------------------------------------------------------------
# With what it recommends, as Debian's apt has it by default: OSMesa.
install -o APT::Install-Recommends=true $(packages weft libweft0)
ldd /usr/bin/weft /usr/libexec/weft/* | none 'not found'
user weft --version
user weft make marschner-lobb --size 40 -q -o ml.vdb
user weft info ml.vdb
user weft slice ml.vdb --context osmesa --size 64x64 --verify -v -o slice.exr --preview slice.png
user weft slice ml.vdb --engine cpu --size 64x64 -q -o cpu.exr
user weft convert ml.vdb ml.nrrd
user weft slice ml.nrrd --size 64x64 -q -o nrrd.exr
user weft resample slice.exr --size x2 -q -o large.tif
user weft resample large.tif --size 50% -q -o small.png
user weft resample small.png --size x2 -q -o again.exr
test -s again.exr
# No gnuplot: one line, and the exit code of what failed.
code=0
user weft kernel catmull-rom --plot plot.svg 2>plot.err || code=$?
cat plot.err
test $code = 1
test "$(wc -l <plot.err)" = 1

# ---- texts ----------------------------------------------------------------------------------------
install $(packages weft-doc) man-db bash-completion
for page in /usr/share/man/man1/weft*.1.gz; do
    name=$(basename "$page" .1.gz)
    man --warnings=w -E UTF-8 -Tutf8 "$name" 2>warnings | head -4
    none . warnings
done
# What bash offers behind "weft sl" and "weft slice -k catm".
cat >complete.bash <<'END'
. /usr/share/bash-completion/bash_completion
_completion_loader weft
offer() {
    COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)) COMP_LINE="$*" COMP_POINT=${#COMP_LINE}
    _weft
    echo "${COMPREPLY[@]}"
}
offer weft sl
offer weft slice -k catm
END
test "$(user bash complete.bash | tail -n 2 | tr '\n' ' ')" = "slice catmull-rom "
(cd /usr/share/doc/weft && grep -o '](docs/[^)#]*' README.md | sort -u | while read -r link; do
    test -s "${link#](}"
done)
zcat /usr/share/doc/weft/changelog.Debian.gz | head -1

# ---- programs -------------------------------------------------------------------------------------
install $(packages libweft-dev) g++ make cmake pkg-config
user weft make ramp --size 8 -q -o ramp.vdb
for module in weft weft-static; do
    cc $here/consumer/consumer.c -o $module $(pkg-config --cflags --libs $module) -lm
    user ./$module ramp.vdb
done
ldd ./weft-static | none libweft

# ---- ranks ----------------------------------------------------------------------------------------
install $(packages weft-openmpi weft-mpich libweft-openmpi-dev libweft-mpich-dev)
mkdir empty
cmake -S $here/consumer -B consumer -D WEFT_HOSTILE=$work/empty -D "WEFT_MPIS=openmpi;mpich" >/dev/null
cmake --build consumer >/dev/null
for kind in weft weft_static cxx; do
    user consumer/consumer_$kind ramp.vdb
done
for mpi in openmpi mpich; do
    user mpirun.$mpi $([ $mpi = mpich ] || echo --oversubscribe) -n 2 \
        weft slice ramp.vdb --size 8x8 -q -o $mpi.exr
    cmp $mpi.exr openmpi.exr
done

# ---- removed --------------------------------------------------------------------------------------
echo "-- removed"
apt-get purge -qq -y $(dpkg-query -W -f '${Package}\n' | grep weft) >/dev/null
find / -xdev \( -path $here -o -path $work -o -path /proc \) -prune -o -name '*weft*' -print |
    none -v '^/var/\(log\|mail\)/'
