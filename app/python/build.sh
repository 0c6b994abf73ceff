#!/bin/sh
# Builds the wheel into a folder: sh app/python/build.sh DIR; with --sdist before DIR, the source distribution. Needs Rust
# and Python 3.11 or later; maturin, and zig as a linker for an old glibc, are installed into target/python.
set -eu
what=wheel
[ "${1-}" != --sdist ] || { what=sdist; shift; }
[ $# = 1 ] || { echo "usage: sh app/python/build.sh [--sdist] DIR" >&2; exit 2; }
mkdir -p "$1"
out=$(cd "$1" && pwd)
cd "$(dirname "$0")"
target="${CARGO_TARGET_DIR:-$PWD/../../target}/python"
mkdir -p "$target"
target=$(cd "$target" && pwd)
MATURIN=1.16.0
ZIG=0.17.1

[ -x "$target/tools/bin/maturin" ] || {
    python3 -m venv "$target/tools"
    "$target/tools/bin/pip" install --quiet "maturin==$MATURIN" "ziglang==$ZIG"
}

# The scenes that open by name, with the files that they refer to. Those that only tests read stay behind.
scenes=python/raystep/scenes
rm -rf "$scenes"
mkdir "$scenes"
for name in cornell-box flat instances lights primitives single-triangle skin-and-morph textures; do
    cp "../../scenes/$name.gltf" "$scenes"
done
for name in quantized sphere-flake teapot terrain; do
    cp "../../scenes/$name.glb" "$scenes"
done
cp ../../scenes/textures-*.bin ../../scenes/*.png "$scenes"

PATH="$target/tools/bin:$PATH"
export PATH CARGO_TARGET_DIR="$target/build"
case $what in
wheel) maturin build --quiet --release --locked --zig --compatibility manylinux_2_28 --out "$out" ;;
sdist) maturin sdist --quiet --out "$out" ;;
esac
for file in "$out"/raystep-*; do
    echo "$file: $(wc -c <"$file") bytes"
done
