#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# run.sh [-v] WEFT TABLE: what newcomers type, a line of TABLE each:
#
#   EXIT CODE | COMMAND | what must hold, separated by semicolons
#
# Where the exit code is not 0, stderr is one line, an error's; it has each of the texts, and no
# file out.* or z_* was left. Where it is 0 there is no error line, and what was printed has them;
# "file NAME" is a file that is not empty, "no TEXT:" must not be printed. `-` stands for any code:
# programs that a signal may end. Commands are the shell's, in a folder of their own, with $weft's
# folder first in PATH and $source for the source tree. Prints the lines that do not hold with what
# the command said, -v all of them, and how many hold; ends with 1 unless all do.
set -u
verbose=
[ "$1" != -v ] || { verbose=1 && shift; }
weft=$(realpath "$1") table=$(realpath "$2") source=$(realpath "$(dirname "$0")/../..")
folder=$(mktemp -d) || exit 1
trap 'rm -rf "$folder"' EXIT
PATH=$(dirname "$weft"):$PATH XDG_CACHE_HOME=$folder/cache LC_ALL=C.UTF-8
export PATH XDG_CACHE_HOME LC_ALL weft source

# What the commands find there: a volume of a name that it has not, images, frames, damaged files.
set_up() {
    mkdir folder said &&
    weft make marschner-lobb -o smoke.vdb --size 16 &&
    weft slice smoke.vdb -o photo.exr --preview photo.png --size 16x12 --engine cpu &&
    weft resample photo.png -o photo.tif --size 100% --engine cpu || return 1
    for n in 1 2 3; do
        cp smoke.vdb "puff_000$n.vdb"
        cp photo.exr "render_000$n.exr"
    done
    head -c 512 /dev/zero >ct.raw
    head -c 2000 smoke.vdb >cut.vdb
    head -c 700 photo.exr >cut.exr
    echo 'this is no volume' | tee text.vdb >text.png
    echo 'support two' >weights.txt
    printf 'x,y,z\n1,2,3\n4,5,6\n' >track.csv
    echo '{}' >scene.gltf
    : >empty.vdb
}

is_there() { # NAME...: the first one, where it is
    [ -s "$1" ]
}

# The words of $1, by semicolons, that do not hold of $text, in $missing.
check_words() {
    missing= words="$1;"
    while [ -n "$words" ]; do
        word=${words%%;*} words=${words#*;}
        word=${word# } word=${word% }
        case $word in
        '') ;;
        'file '*) [ -s "${word#file }" ] || missing="$missing ($word)" ;;
        'no '*:) case $text in *"${word#no }"*) missing="$missing ($word)" ;; esac ;;
        *) case $text in *"$word"*) ;; *) missing="$missing ($word)" ;; esac ;;
        esac
    done
}

check() { # CODE COMMAND WORDS
    rm -f out.* z_*
    (eval "$2") >said/out 2>said/err
    code=$?
    read -r error <said/err || :
    text=$(cat said/err)
    if [ "$1" = 0 ]; then
        text="$text $(tr -d '\0' <said/out)"
        case $error in 'weft: error: '*) missing=' (no error)' && return 1 ;; esac
    fi
    check_words "$3"
    [ "$1" = - ] || [ "$1" = "$code" ] || missing="$missing (exit code $1, not $code)"
    [ "$1" = 0 ] || [ "$1" = - ] || {
        [ "$text" = "$error" ] || missing="$missing (one line)"
        case $error in 'weft: error: '*) ;; *) missing="$missing (an error line)" ;; esac
        ! is_there out.* && ! is_there z_* || missing="$missing (no output)"
    }
    [ -z "$missing" ]
}

show() {
    head -n 4 said/err | cut -c 1-300 | sed 's/^/        /'
}

cd "$folder" && set_up >set_up 2>&1 || { cat set_up && exit 1; }
all=0 held=0
while IFS= read -r line; do
    case $line in '' | '#'*) continue ;; esac
    rest=${line#* | }
    all=$((all + 1))
    if check "${line%% | *}" "${rest% | *}" "${rest##* | }"; then
        held=$((held + 1))
        [ -z "$verbose" ] || { echo "ok      ${rest% | *}" && show; }
    else
        echo "not so  ${rest% | *}"
        echo "        wanted$missing"
        show
    fi
done <"$table"
echo "$held of $all hold"
[ "$held" = "$all" ]
