#!/bin/sh
# Builds the page and tries it in Chromium, on a virtual display: with WebGPU in software, without WebGPU, and without
# WebGL. Installs what that takes, except Rust and Node.js. Screenshots are left in target/web/screenshots.
set -eu
cd "$(dirname "$0")/.."
PLAYWRIGHT=1.65.1

step() { printf '\n== %s\n' "$1"; }

if ! command -v chromium >/dev/null || ! command -v Xvfb >/dev/null || ! command -v node >/dev/null; then
    step "Chromium, a virtual display, Node.js"
    if ! command -v apt-get >/dev/null; then
        echo "install Chromium, Xvfb and Node.js first, to test the page" >&2
        exit 1
    fi
    as_root=""
    [ "$(id -u)" = 0 ] || as_root=sudo
    $as_root apt-get update -qq
    packages="chromium xvfb"
    command -v node >/dev/null || packages="$packages nodejs npm"
    # shellcheck disable=SC2086 # several packages
    DEBIAN_FRONTEND=noninteractive $as_root apt-get install -y -qq --no-install-recommends $packages >/dev/null
fi

target="${CARGO_TARGET_DIR:-target}/web"

step "the crates below the program and the page, for browsers"
(
    toolchain=$(sh app/web/toolchain.sh)
    eval "$toolchain"
    # The compiler may be another one than cargo's: in a folder of its own, neither invalidates what the other compiled.
    cargo check --locked --target wasm32-unknown-unknown --target-dir "$target" -p raystep-web
)

step "the page"
sh app/web/build.sh "$target/served"

step "the page in Chromium"
npm install --silent --no-fund --no-audit --prefix "$target/npm" "playwright-core@$PLAYWRIGHT"
mkdir -p "$target/screenshots"
display=$(mktemp)
Xvfb -displayfd 3 -screen 0 1400x1000x24 3>"$display" 2>/dev/null &
server=$!
trap 'kill $server 2>/dev/null; rm -f "$display"' EXIT
until [ -s "$display" ]; do sleep 0.1; done
modules=$(cd "$target/npm/node_modules" && pwd)
DISPLAY=":$(cat "$display")" NODE_PATH="$modules" node --test --test-concurrency=1 --test-reporter=spec tests/web/*.test.mjs
