#!/bin/sh
# Builds the Python wheel, and tries it in an environment that has nothing else: the command, the module, its types, the
# notebooks, sweeps on a Ray cluster of this machine, and the source distribution.
#
#     sh tests/python.sh [--quick] [WHEEL]
#
# tries a wheel that was built before, if one is named. With --quick, a wheel that is optimised less, without what takes
# minutes: one notebook, and neither pandas, Ray nor the source distribution.
set -eu
cd "$(dirname "$0")/.."

step() { printf '\n== %s\n' "$1"; }

quick=""
[ "${1-}" != --quick ] || { quick=--quick; shift; }

# Debian has it as a package of its own.
if ! python3 -c 'import ensurepip, venv' 2>/dev/null && command -v apt-get >/dev/null; then
    step "virtual environments for Python"
    as_root=""
    [ "$(id -u)" = 0 ] || as_root=sudo
    $as_root apt-get update -qq
    DEBIAN_FRONTEND=noninteractive $as_root apt-get install -y -qq python3-venv >/dev/null
fi

target="${CARGO_TARGET_DIR:-$PWD/target}/python"
mkdir -p "$target"
target=$(cd "$target" && pwd)

step "the wheel"
rm -rf "$target/wheels"
# The page that its own tests have built, if they have.
page=$(dirname "$target")/web/served
[ -n "$quick" ] && [ -f "$page/index.html" ] || page=""
packaged=$PWD/app/python/python/raystep/page
if [ $# = 0 ]; then
    sh app/python/build.sh ${page:+--page "$page"} $quick "$target/wheels"
else
    mkdir "$target/wheels"
    cp "$1" "$target/wheels/"
    # The same page as in the wheel, for the source distribution.
    rm -rf "$packaged"
    mkdir -p "$packaged"
    python3 -m zipfile -e "$1" "$target/wheels/unpacked"
    cp -R "$target/wheels/unpacked/raystep/page/." "$packaged"
fi

step "from Python and nothing else to a picture"
rm -rf "$target/clean" "$target/cornell-box.png"
begin=$(date +%s)
python3 -m venv "$target/clean"
"$target/clean/bin/pip" install --quiet --no-cache-dir "$target"/wheels/raystep-*.whl
"$target/clean/bin/raystep" render cornell-box -o "$target/cornell-box.png" --device cpu
seconds=$(($(date +%s) - begin))
echo "$seconds s"
[ "$seconds" -lt 60 ] || { echo "a picture took $seconds s, of at most 60" >&2; exit 1; }
"$target/clean/bin/raystep" render missing.gltf -o "$target/missing.png" 2>/dev/null && exit 1

step "the module"
for test in cast renderer view; do
    "$target/clean/bin/python" "app/python/tests/test_$test.py"
done

step "notebooks"
"$target/clean/bin/pip" install --quiet ipykernel==7.4.0 matplotlib==3.11.2 nbclient==0.11.0
"$target/clean/bin/python" app/python/tests/test_notebooks.py ${quick:+costly-voxels}

step "types"
"$target/clean/bin/pip" install --quiet mypy==2.4.1
rm -rf "$target/notebooks"
mkdir "$target/notebooks"
"$target/clean/bin/python" app/python/tests/test_notebooks.py --code "$target/notebooks"
"$target/clean/bin/mypy" --strict --no-error-summary "$target"/notebooks/*.py
"$target/clean/bin/mypy" --strict --no-error-summary app/python/tests
"$target/clean/bin/mypy" --strict --no-error-summary -p raystep
"$target/clean/bin/python" -m mypy.stubtest raystep --ignore-missing-stub

if [ -z "$quick" ]; then
    step "the module, with pandas"
    "$target/clean/bin/pip" install --quiet pandas==3.1.1
    "$target/clean/bin/python" app/python/tests/test_renderer.py

    step "sweeps, on a Ray cluster of this machine"
    "$target/clean/bin/pip" install --quiet ray==2.60.0
    "$target/clean/bin/python" app/python/tests/test_sweep.py scenes

    step "a wheel from the source distribution"
    rm -rf "$target/sdist"
    sh app/python/build.sh --sdist --page "$packaged" "$target/sdist"
    tar -xf "$target"/sdist/raystep-*.tar.gz -C "$target/sdist"
    (
        cd "$target"/sdist/raystep-*/
        PATH="$target/tools/bin:$PATH" CARGO_TARGET_DIR="$target/build" maturin build --quiet --release --locked --zig \
            --compatibility manylinux_2_28 --out "$target/sdist"
    )
    "$target/clean/bin/pip" install --quiet --force-reinstall --no-deps "$target"/sdist/raystep-*.whl
    "$target/clean/bin/raystep" render textures -o "$target/textures.png" --device cpu
fi

step "the wheel is right"
