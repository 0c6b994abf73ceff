#!/bin/sh
# Reads folders of scene files from elsewhere, and holds what raystep says of each against two independent readers: the
# Python package trimesh and the library assimp.
#
#     sh tests/corpus.sh [--binary RAYSTEP] [--table F.md] DIR…
#
# For every glTF, GLB, OBJ, PLY and STL file below the folders, `info` and `render` must end with exit code 0 or 1 within
# a minute, and triangles, bounds and area must be those of a reader. tests/corpus/known.csv lists files for which they
# need not be, each with the reason. Exit code 1 if anything else differs.
set -eu
cd "$(dirname "$0")/.."

binary=""
table=""
while :; do
    case "${1:-}" in
    --binary) binary=$2 && shift 2 ;;
    --table) table=$2 && shift 2 ;;
    *) break ;;
    esac
done
if [ $# = 0 ]; then
    echo "usage: sh tests/corpus.sh [--binary RAYSTEP] [--table F.md] DIR…" >&2
    exit 2
fi
if [ -z "$binary" ]; then
    cargo build --release --locked --quiet
    binary=${CARGO_TARGET_DIR:-./target}/release/raystep
fi
if ! command -v assimp >/dev/null && command -v apt-get >/dev/null; then
    as_root=""
    [ "$(id -u)" = 0 ] || as_root=sudo
    $as_root apt-get update -qq
    DEBIAN_FRONTEND=noninteractive $as_root apt-get install -y -qq assimp-utils >/dev/null
fi
venv=${CARGO_TARGET_DIR:-./target}/corpus-venv
if [ ! -x "$venv/bin/python" ]; then
    python3 -m venv "$venv"
    "$venv/bin/pip" install --quiet numpy trimesh networkx pillow DracoPy
fi
"$venv/bin/python" tests/corpus/compare.py --binary "$binary" ${table:+--table "$table"} "$@"
