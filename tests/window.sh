#!/bin/sh
# Opens the real window under a window manager, on a virtual display, with each device. It must open every time, survive
# being resized and moved while it traces, trace to the end, and close without messages, also in the middle of its work; it
# must live with texels that are no numbers, and with a home that cannot be written to.
# With RAYSTEP_THOROUGH, which tests/full.sh sets, it is opened more often.
set -eu
cd "$(dirname "$0")/.."
binary=${1:-}
if [ -z "$binary" ]; then
    cargo build --locked --quiet
    binary=${CARGO_TARGET_DIR:-./target}/debug/raystep
fi
# Repeated starts find intermittent failures; the first start finds the others.
starts=3
# Times that it is closed in the middle of each kind of work.
interruptions=2
if [ -n "${RAYSTEP_THOROUGH:-}" ]; then
    starts=10
    interruptions=20
fi

# Repeats a command until it succeeds, up to this many times, every 0.1 s.
until_it_does() {
    tries=$1
    shift
    while ! "$@" >/dev/null 2>&1; do
        tries=$((tries - 1))
        [ "$tries" -gt 0 ] || return 1
        sleep 0.1
    done
}

# Starts a display and a window manager and creates a home folder, for one device in a separate shell.
begin() {
    folder=$(mktemp -d)
    window_manager=""
    Xvfb -displayfd 3 -screen 0 1400x900x24 3>"$folder/display" 2>/dev/null &
    server=$!
    trap 'kill $window_manager $server 2>/dev/null; rm -rf "$folder"' EXIT
    trap 'exit 130' INT
    trap 'exit 143' TERM
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

# Starts raystep in a fresh home folder with these options, and waits until its title names the scene, the first argument.
open() {
    scene=$1
    shift
    rm -rf "$folder/.local" "$folder/said"
    until_it_does 100 no_window || fail "$*: a window is already open"
    # The last line of its output is its exit code.
    ("$binary" inspect "$@" 2>&1; echo "exit code $?") >"$folder/said" &
    opened=$!
    until_it_does 300 shows_the_scene && [ ! -s "$folder/said" ] || fail "$*: the window did not show the scene"
}

no_window() {
    [ "$(wmctrl -l | grep -c raystep)" = 0 ]
}

shows_the_scene() {
    # If it has ended, there is nothing to wait for.
    [ -s "$folder/said" ] || wmctrl -l | grep -q "$scene"
}

# Closes the window as a user would. It says nothing but $expected.
expected=""
close() {
    wmctrl -c "$scene" || fail "$*: the window is gone"
    until_it_does 300 grep -q "exit code" "$folder/said" || fail "$*: the window does not close"
    wait "$opened"
    [ "$(cat "$folder/said")" = "${expected}exit code 0" ] || fail "$*: the window did not stay open and silent"
}

# Every ten seconds it saves its state, which contains the current pass.
is_traced() {
    find "$folder/.local" -name inspector.json -exec cat {} + >"$folder/kept"
    [ -s "$folder/said" ] || grep -q 'cornell-box.gltf.*pass=73' "$folder/kept"
}

test_with() {
    device=$1
    start=1
    while [ "$start" -le "$starts" ]; do
        open cornell-box scenes/cornell-box.gltf --device "$device"
        # Wait for the first passes, while window manager and window settle on a size.
        sleep 1
        close "--device $device, start $start"
        start=$((start + 1))
    done
    open cornell-box scenes/cornell-box.gltf --device "$device" --size 1024x1024
    for turn in 1 2 3 4 5 6 7 8 9 10; do
        wmctrl -r cornell-box -e "0,$((20 * turn)),$((10 * turn)),$((500 + 80 * turn)),$((300 + 50 * turn))"
        sleep 0.2
        wmctrl -r cornell-box -e "0,0,0,$((1380 - 80 * turn)),500"
        sleep 0.2
    done
    until_it_does 600 is_traced && [ ! -s "$folder/said" ] || fail "--device $device: the window did not trace the scene"
    close "--device $device, after twenty resizes"
}

# Closes the window in the middle of tracing, of a comparison, and of measuring choices, each time a little later.
interrupt_with() {
    device=$1
    for work in "Go to end" "Compare with BVH" "Measure choices"; do
        printf '# Work\n\n## A step\n\n```raystep\n%s\ndo %s\n```\n' \
            "open scene=built-in:terrain size=1024x1024" "$work" >"$folder/work.md"
        turn=1
        while [ "$turn" -le "$interruptions" ]; do
            open terrain --lesson "$folder/work.md" --device "$device"
            sleep "$((turn % 5)).$((turn % 10))"
            close "--device $device, in the middle of '$work', turn $turn"
            turn=$((turn + 1))
        done
    done
}

# Numbers that are none, in texels that the run goes on with; a home that cannot be written to, which is said in a line.
mistakes_with() {
    device=$1
    cat >"$folder/nan.raystep-session" <<END
{"version": 1, "here": {
    "link": "raystep:1?scene=$PWD/scenes/cornell-box.gltf&size=256x256&device=$device&pixel=96,180",
    "edits": [
        {"place": 20, "stream": "tmax", "layer": 0, "x": 96, "y": 180, "bits": $((0x7fc00000))},
        {"place": 20, "stream": "ray_direction", "layer": 1, "x": 97, "y": 180, "bits": $((0xff800000))}]}}
END
    open cornell-box "$folder/nan.raystep-session"
    sleep 2
    close "--device $device, NaN and -inf in texels"
    # A file in place of the folder: nobody can write below it, not even root.
    HOME="$folder/display"
    expected="cannot save the window's settings: $HOME/.local/share/raystep: Not a directory
"
    open cornell-box scenes/cornell-box.gltf --device "$device"
    close "--device $device, a home that cannot be written to"
    HOME=$folder expected=""
}

# `--device auto` selects one of these. They mostly wait, so run both at once.
(begin; test_with gpu; interrupt_with gpu; mistakes_with gpu) &
gpu=$!
(begin; test_with cpu; interrupt_with cpu; mistakes_with cpu) &
cpu=$!
failed=0
wait "$gpu" || failed=1
wait "$cpu" || failed=1
exit "$failed"
