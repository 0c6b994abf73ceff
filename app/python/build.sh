#!/bin/sh
# Builds the wheel into a folder: sh app/python/build.sh DIR. Needs Rust and Python 3.11 or later; maturin, and zig as a
# linker for an old glibc, are installed into target/python.
set -eu
[ $# = 1 ] || { echo "usage: sh app/python/build.sh DIR" >&2; exit 2; }
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
PATH="$target/tools/bin:$PATH" CARGO_TARGET_DIR="$target/build" maturin build --quiet --release --locked --zig \
    --compatibility manylinux_2_28 --out "$out"
for wheel in "$out"/raystep-*.whl; do
    echo "$wheel: $(wc -c <"$wheel") bytes"
done
