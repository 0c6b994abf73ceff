#!/bin/sh
# Compiles the kernels' variants with Dawn, Chromium's WebGPU; builds the page, and tries it in Chromium on a virtual
# display: with WebGPU in software, with WebGL 2, and with neither; typical mistakes in a dropped kernel; hits by WebGPU and
# by WebGL 2 against the CPU reference kernels; the debug adapter. Installs what that takes, except Rust and Node.js.
# Screenshots are left in target/web/screenshots.
set -eu
cd "$(dirname "$0")/.."
PLAYWRIGHT=1.65.1
DAWN=0.6.2
TESTSUPPORT=1.68.0

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

step "the page, and with it all crates below the program, without threads"
quick=--quick
[ -z "${RAYSTEP_THOROUGH:-}" ] || quick=""
sh app/web/build.sh "$target/served" $quick

npm install --silent --no-fund --no-audit --prefix "$target/npm" "playwright-core@$PLAYWRIGHT" "webgpu@$DAWN" \
    "@vscode/debugadapter-testsupport@$TESTSUPPORT"
modules=$(cd "$target/npm/node_modules" && pwd)
export NODE_PATH="$modules"

step "every variant of every kernel in Dawn"
shaders="$target/shaders"
rm -rf "$shaders"
mkdir -p "$shaders"
shaders=$(cd "$shaders" && pwd)
# As tests/run.sh compiles them, so that it happens once.
. tests/build_env.sh
# Everything, the desktop's programs included: parts alone would be compiled with other features.
cargo test --quiet --workspace --locked --no-run
RAYSTEP_SHADERS="$shaders" cargo test --quiet --workspace --locked --test kernels -- every_variant_is_valid every_fragment_program_is_valid
RAYSTEP_SHADERS="$shaders" VK_DRIVER_FILES="$(dirname "$(readlink -f /usr/lib/chromium/libvk_swiftshader.so)")/vk_swiftshader_icd.json" \
    XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-/tmp}" node --test --test-reporter=spec tests/web/shaders.test.mjs

programs=$(cd "${CARGO_TARGET_DIR:-target}/debug" && pwd)
export RAYSTEP="$programs/raystep" RAYSTEP_HITS="$programs/examples/hits"

step "the debug adapter, by the client of its protocol's authors"
node --test --test-reporter=spec tests/web/debug_adapter.test.mjs

step "the page in Chromium"
mkdir -p "$target/screenshots"
display=$(mktemp)
Xvfb -displayfd 3 -screen 0 1400x1000x24 3>"$display" 2>/dev/null &
server=$!
trap 'kill $server 2>/dev/null; rm -f "$display"' EXIT
trap 'exit 130' INT
trap 'exit 143' TERM
until [ -s "$display" ]; do kill -0 "$server" && sleep 0.1; done
DISPLAY=":$(cat "$display")" node --test --test-concurrency=1 --test-reporter=spec \
    tests/web/page.test.mjs tests/web/own_kernels.test.mjs tests/web/hard.test.mjs tests/web/hits.test.mjs
