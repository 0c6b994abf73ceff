#!/bin/sh
# Opens the real window on a display that nobody sees: it must stay open, without a word, until it is told to close.
set -eu
cd "$(dirname "$0")/.."
cargo build --locked --quiet
folder=$(mktemp -d)
Xvfb -displayfd 3 -screen 0 1400x900x24 3>"$folder/display" 2>/dev/null &
server=$!
trap 'kill $server 2>/dev/null; rm -rf "$folder"' EXIT
for _ in 1 2 3 4 5 6 7 8 9 10; do
    [ -s "$folder/display" ] && break
    sleep 0.5
done
DISPLAY=":$(cat "$folder/display")"
export DISPLAY HOME="$folder" XDG_RUNTIME_DIR="$folder"
unset WAYLAND_DISPLAY WAYLAND_SOCKET
code=0
timeout -s TERM 40 ./target/debug/raystep scenes/cornell-box.gltf --size 128x128 >"$folder/said" 2>&1 || code=$?
cat "$folder/said"
# 124: it was still open when its time was over.
if [ "$code" != 124 ] || [ -s "$folder/said" ]; then
    echo "the window did not stay open: exit code $code" >&2
    exit 1
fi
# What it keeps every ten seconds says what it showed: the scene, traced to its end.
kept=$(find "$folder" -name inspector.ron)
if ! grep -q 'cornell-box.gltf.*pass=73' "$kept"; then
    echo "the window did not trace the scene:" >&2
    cat "$kept" >&2
    exit 1
fi
