#!/bin/sh
# Opens the real window under a window manager, on a display that nobody sees, with each device: it must open every
# time, bear being resized and moved while it traces, trace to the end, and close without a word.
# RAYSTEP_THOROUGH, as tests/full.sh sets it, opens it more often.
set -eu
cd "$(dirname "$0")/.."
binary=${1:-}
if [ -z "$binary" ]; then
    cargo build --locked --quiet
    binary=${CARGO_TARGET_DIR:-./target}/debug/raystep
fi
# A start that fails once in ten is found by run after run; what every start does wrong, by the first.
starts=3
[ -z "${RAYSTEP_THOROUGH:-}" ] || starts=10

# Does something up to so many times, until it succeeds, with 0.1 s between.
until_it_does() {
    tries=$1
    shift
    while ! "$@" >/dev/null 2>&1; do
        tries=$((tries - 1))
        [ "$tries" -gt 0 ] || return 1
        sleep 0.1
    done
}

# A display, a window manager and a home for one device, in a shell of its own.
begin() {
    folder=$(mktemp -d)
    window_manager=""
    Xvfb -displayfd 3 -screen 0 1400x900x24 3>"$folder/display" 2>/dev/null &
    server=$!
    trap 'kill $window_manager $server 2>/dev/null; rm -rf "$folder"' EXIT
    until_it_does 100 test -s "$folder/display"
    DISPLAY=":$(cat "$folder/display")"
    export DISPLAY HOME="$folder" XDG_RUNTIME_DIR="$folder"
    unset WAYLAND_DISPLAY WAYLAND_SOCKET XDG_DATA_HOME
    openbox >/dev/null 2>&1 &
    window_manager=$!
    until_it_does 100 wmctrl -m
}

fail() {
    echo "$1" >&2
    touch "$folder/said" "$folder/kept"
    cat "$folder/said" "$folder/kept" >&2
    exit 1
}

# Starts it in a fresh home, with these options, and waits until it shows the scene.
open() {
    rm -rf "$folder/.local" "$folder/said"
    until_it_does 100 no_window || fail "$*: there is a window already"
    # Its exit code is the last line of what it said.
    ("$binary" scenes/cornell-box.gltf "$@" 2>&1; echo "exit code $?") >"$folder/said" &
    opened=$!
    until_it_does 300 shows_the_scene && [ ! -s "$folder/said" ] || fail "$*: the window did not show the scene"
}

no_window() {
    [ "$(wmctrl -l | grep -c raystep)" = 0 ]
}

shows_the_scene() {
    # One that has ended never will.
    [ -s "$folder/said" ] || wmctrl -l | grep -q cornell-box
}

# Closes it as its user would.
close() {
    wmctrl -c cornell-box || fail "$*: the window is gone"
    until_it_does 300 test -s "$folder/said" || fail "$*: the window does not close"
    wait "$opened"
    [ "$(cat "$folder/said")" = "exit code 0" ] || fail "$*: the window did not stay open and silent"
}

# What it keeps every ten seconds says what it showed.
is_traced() {
    find "$folder/.local" -name inspector.json -exec cat {} + >"$folder/kept"
    [ -s "$folder/said" ] || grep -q 'cornell-box.gltf.*pass=73' "$folder/kept"
}

test_with() {
    device=$1
    begin
    start=1
    while [ "$start" -le "$starts" ]; do
        open --device "$device"
        # The first passes, while window manager and window agree about the size.
        sleep 1
        close "--device $device, start $start"
        start=$((start + 1))
    done
    open --device "$device" --size 1024x1024
    for turn in 1 2 3 4 5 6 7 8 9 10; do
        wmctrl -r cornell-box -e "0,$((20 * turn)),$((10 * turn)),$((500 + 80 * turn)),$((300 + 50 * turn))"
        sleep 0.2
        wmctrl -r cornell-box -e "0,0,0,$((1380 - 80 * turn)),500"
        sleep 0.2
    done
    until_it_does 600 is_traced && [ ! -s "$folder/said" ] || fail "--device $device: the window did not trace the scene"
    close "--device $device, after twenty resizes"
}

# What auto takes is one of these. They mostly wait, so both at once.
(test_with gpu) &
gpu=$!
(test_with cpu) &
cpu=$!
failed=0
wait "$gpu" || failed=1
wait "$cpu" || failed=1
exit "$failed"
