#!/bin/sh
# How long the window takes to respond to clicks and keys, in a real window of 1280x800 under a window manager on a
# virtual display: a table for each device, for the Cornell box and a scene of 60,000 triangles. Nothing else should run
# meanwhile. Progress goes to standard error, a line every few seconds. `sh tests/run.sh` installs what it needs.
set -eu
cd "$(dirname "$0")/.."
binary=${1:-}
if [ -z "$binary" ]; then
    cargo build --release --locked --quiet
    binary=${CARGO_TARGET_DIR:-./target}/release/raystep
fi
folder=$(mktemp -d)
Xvfb -displayfd 3 -screen 0 1400x900x24 3>"$folder/display" 2>/dev/null &
server=$!
trap 'kill $window_manager $server 2>/dev/null; rm -rf "$folder"' EXIT
trap 'exit 130' INT
trap 'exit 143' TERM
window_manager=""
until [ -s "$folder/display" ]; do kill -0 "$server" && sleep 0.1; done
DISPLAY=":$(cat "$folder/display")"
export DISPLAY HOME="$folder" XDG_RUNTIME_DIR="$folder"
unset WAYLAND_DISPLAY WAYLAND_SOCKET XDG_DATA_HOME
openbox >/dev/null 2>&1 &
window_manager=$!
until wmctrl -m >/dev/null 2>&1; do kill -0 "$window_manager" && sleep 0.1; done
"$binary" scene terrain --triangles 60000 --seed 1 -o "$folder/terrain.glb" >/dev/null
for scene in scenes/cornell-box.gltf "$folder/terrain.glb"; do
    for device in cpu gpu; do
        echo "$(basename "$scene"), $device" >&2
        "$binary" inspect "$scene" --device "$device" --latency
        echo
    done
done
