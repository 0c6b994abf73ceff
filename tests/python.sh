#!/bin/sh
# Builds the Python wheel, and tries it in an environment that has nothing else: the command, the module, its types.
# `sh tests/python.sh WHEEL` tries one that was built before.
set -eu
cd "$(dirname "$0")/.."

step() { printf '\n== %s\n' "$1"; }

target="${CARGO_TARGET_DIR:-$PWD/target}/python"
mkdir -p "$target"
target=$(cd "$target" && pwd)

step "the wheel"
rm -rf "$target/wheels"
if [ $# = 0 ]; then
    sh app/python/build.sh "$target/wheels"
else
    mkdir "$target/wheels"
    cp "$1" "$target/wheels/"
fi

step "from Python and nothing else to a picture"
rm -rf "$target/clean" "$target/cornell-box.png"
begin=$(date +%s)
python3 -m venv "$target/clean"
"$target/clean/bin/pip" install --quiet --no-cache-dir "$target"/wheels/raystep-*.whl
"$target/clean/bin/raystep" render scenes/cornell-box.gltf -o "$target/cornell-box.png" --device cpu
seconds=$(($(date +%s) - begin))
echo "$seconds s"
[ "$seconds" -lt 60 ] || { echo "a picture took $seconds s, of at most 60" >&2; exit 1; }
"$target/clean/bin/raystep" render missing.gltf -o "$target/missing.png" 2>/dev/null && exit 1

step "the module"
"$target/clean/bin/python" app/python/tests/test_cast.py

step "types"
"$target/clean/bin/pip" install --quiet mypy==2.4.1
"$target/clean/bin/mypy" --strict --no-error-summary app/python/tests
"$target/clean/bin/python" -m mypy.stubtest raystep --ignore-missing-stub

step "the wheel is right"
