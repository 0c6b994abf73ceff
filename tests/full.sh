#!/bin/sh
# All checks: tests/run.sh with long tests and the long forms of the others, and checks that compile every dependency
# again. Run it before a release and after a larger piece of work; `sh tests/full.sh web` runs only those for browsers,
# `sh tests/full.sh python` only those of the Python wheel, and `sh tests/full.sh packaging` only those of what a release
# consists of, the wheel among it.
set -eu
cd "$(dirname "$0")/.."

step() { printf '\n== %s\n' "$1"; }

case "${1:-}" in
web | python | packaging) exec sh "tests/$1.sh" ;;
esac

RAYSTEP_THOROUGH=1 sh tests/run.sh
RAYSTEP_THOROUGH=1 sh tests/web.sh
sh tests/packaging.sh

step "every combination of features"
for features in "" gpu parallel serde gpu,parallel gpu,serde parallel,serde gpu,parallel,serde; do
    echo "features: ${features:-none}"
    cargo clippy -p raystep-kernels --no-default-features --features "$features" --lib --tests --locked -- -D warnings
done

step "a program outside of the workspace"
cargo run --quiet --locked --manifest-path tests/outside/Cargo.toml --target-dir target/outside |
    grep "the centre pixel sees triangle 0"

step "the kernel of docs/adding-a-kernel.md"
rm -rf target/example
mkdir -p target/example
tar --exclude=./target --exclude=./.git -cf - . | tar -xf - -C target/example
(
    cd target/example
    sed -n '/^```diff/,/^```/p' docs/adding-a-kernel.md | sed '1d;$d' | patch -p1
    for device in cpu gpu; do
        CARGO_TARGET_DIR=../example-build cargo run --quiet --locked -- \
            render scenes/cornell-box.gltf -o "$device.png" --device "$device" 2>&1 | grep "depth_cue 1"
    done
    cmp cpu.png gpu.png
)

step "the option of docs/adding-an-option.md"
(
    cd target/example
    sed -n '/^```diff/,/^```/p' docs/adding-an-option.md | sed '1d;$d' | patch -p1
    for device in cpu gpu; do
        CARGO_TARGET_DIR=../example-build cargo run --quiet --locked -- \
            render scenes/cornell-box.gltf -o "$device.png" --device "$device" --unlit --passes-csv "$device.csv"
        head -n 1 "$device.csv" | grep ",unlit"
    done
    cmp cpu.png gpu.png
)

step "the measurements of docs/performance.md, in short"
cargo run --quiet --locked -p raystep-lab --example performance -- \
    measure --adapter software --quick -o target/performance

step "packages"
cargo package --workspace --locked --target-dir target/packages

step "documentation"
RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --locked --quiet

step "all checks passed, in full"
