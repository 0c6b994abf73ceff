#!/bin/sh
# Everything: tests/run.sh with its long tests and the long forms of the others, and the checks that compile every
# dependency again. Before a release, and at the end of an issue.
set -eu
cd "$(dirname "$0")/.."

step() { printf '\n== %s\n' "$1"; }

RAYSTEP_THOROUGH=1 sh tests/run.sh

step "without threads"
cargo clippy -p raystep-kernels --no-default-features --locked -- -D warnings

step "a program outside of the workspace"
cargo run --quiet --locked --manifest-path tests/outside/Cargo.toml --target-dir target/outside |
    grep "the centre pixel sees triangle 0"

step "packages"
cargo package --workspace --locked --target-dir target/packages

step "documentation"
RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --locked --quiet

step "all of it holds, in full"
