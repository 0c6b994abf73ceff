#!/bin/sh
# Finds or makes a Rust toolchain for WebAssembly, and prints the shell commands that select it:
#
#     toolchain=$(sh app/web/toolchain.sh) && eval "$toolchain"
#
# In order: the installed toolchain, if it has the standard library for wasm32; rustup's; or Debian's compiler for
# WebAssembly, whose standard library is built once, in target/wasm-toolchain (850 MB).
set -eu
cd "$(dirname "$0")/../.."
target=wasm32-unknown-unknown

has_std() {
    lib=$("$1" --print target-libdir --target "$target" 2>/dev/null) && ls "$lib"/libstd-*.rlib >/dev/null 2>&1
}

if has_std rustc || { command -v rustup && rustup target add "$target" && has_std rustc; } >/dev/null 2>&1; then
    exit 0
fi
if ! command -v apt-get >/dev/null; then
    echo "no Rust for $target: install it, e.g. with rustup target add $target" >&2
    exit 1
fi

version=1.96
root="$PWD/${CARGO_TARGET_DIR:-target}/wasm-toolchain"
case ${CARGO_TARGET_DIR:-} in /*) root="$CARGO_TARGET_DIR/wasm-toolchain" ;; esac
export LD_LIBRARY_PATH="$root/usr/lib/$(uname -m)-linux-gnu"
export RUSTC="$root/usr/bin/rustc"
export CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER="$root/usr/bin/wasm-ld-22"
if ! has_std "$RUSTC"; then
    echo "making a toolchain for $target in $root" >&2
    rm -rf "$root"
    mkdir -p "$root/packages" "$root/empty/src"
    [ "$(id -u)" != 0 ] || apt-get update -qq >&2
    # The source of the standard library must be the compiler's own.
    (cd "$root/packages" && apt-get download -qq \
        rustc-web "libstd-rust-web-$version" libstd-rust-web-dev libllvm22 rust-web-src lld-22) >&2
    for package in "$root"/packages/*.deb; do dpkg -x "$package" "$root"; done
    printf '[package]\nname = "empty"\nedition = "2024"\n[lib]\ncrate-type = ["cdylib"]\n[workspace]\n' >"$root/empty/Cargo.toml"
    : >"$root/empty/src/lib.rs"
    (cd "$root/empty" && RUSTC_BOOTSTRAP=1 cargo build --quiet --release --target "$target" --target-dir "$root/empty/target" \
        -Zbuild-std=std,panic_abort) >&2
    lib="$root/usr/lib/rustlib/$target/lib"
    rm -rf "$lib" "$lib.part"
    mkdir -p "$lib.part"
    find "$root/empty/target/$target/release/deps" -name '*.rlib' ! -name 'libempty*' -exec cp {} "$lib.part" \;
    # All of it at once: what is there is taken as complete.
    mv "$lib.part" "$lib"
    rm -rf "$root/packages" "$root/empty"
fi
for name in LD_LIBRARY_PATH RUSTC CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER; do
    eval "value=\$$name"
    printf "export %s='%s'\n" "$name" "$value"
done
