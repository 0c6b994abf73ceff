#!/bin/sh
# Checks that the crates below the program compile for browsers, without threads. Makes a toolchain if there is none.
set -eu
cd "$(dirname "$0")/.."
toolchain=$(sh app/web/toolchain.sh)
eval "$toolchain"
# The compiler may be another one than cargo's: in a folder of its own, neither invalidates what the other compiled.
cargo check --locked --target wasm32-unknown-unknown --target-dir "${CARGO_TARGET_DIR:-target}/web" \
    -p raystep-inspector --no-default-features
