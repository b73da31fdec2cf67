# SPDX-License-Identifier: BSD-3-Clause
# Sourced by tools/demo.sh and tests/run.sh, with $root set to the repository: installs what is missing.

weft_missing_packages() {
    sed -e 's/#.*//' -e '/^[[:space:]]*$/d' "$root/tools/packages.txt" | while read -r package; do
        dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' ||
            printf '%s ' "$package"
    done
}

weft_as_root() {
    if [ "$(id -u)" -eq 0 ]; then
        env DEBIAN_FRONTEND=noninteractive "$@"
    elif command -v sudo >/dev/null 2>&1; then
        sudo env DEBIAN_FRONTEND=noninteractive "$@"
    else
        echo "these packages are missing, and neither root nor sudo is at hand: $missing" >&2
        exit 1
    fi
}

weft_install_packages() {
    if ! command -v dpkg-query >/dev/null 2>&1; then
        echo "== not a Debian system: the packages of tools/packages.txt are taken as installed"
        return
    fi
    missing=$(weft_missing_packages)
    if [ -z "$missing" ]; then
        echo "== all packages of tools/packages.txt are installed"
        return
    fi
    echo "== installing with apt-get: $missing"
    weft_as_root apt-get update -qq
    # shellcheck disable=SC2086
    weft_as_root apt-get install -y -qq --no-install-recommends $missing
}

# Configures and builds into $root/$1; the rest are options for cmake.
weft_build() {
    build="$root/$1"
    shift
    echo "== building in $build"
    cmake -S "$root" -B "$build" -G Ninja "$@" >"$build.log" 2>&1 &&
        cmake --build "$build" >>"$build.log" 2>&1 || {
        cat "$build.log" >&2
        echo "the build failed; the log above is $build.log" >&2
        exit 1
    }
}
