#!/bin/sh
# Checks for every change, requiring only Rust: formatting, lints as errors, tests, documentation of libraries.
# tests/full.sh adds long tests, the library with every combination of features, and the documentation of the program.
# Installs Mesa's software Vulkan if there is no Vulkan driver, and its OpenGL if there is no EGL, so that GPU code is tested
# too.
set -eu
cd "$(dirname "$0")/.."

step() { printf '\n== %s\n' "$1"; }

has_vulkan() {
    ls /usr/share/vulkan/icd.d/*.json /etc/vulkan/icd.d/*.json /usr/local/share/vulkan/icd.d/*.json 2>/dev/null | grep -q . ||
        [ -n "${VK_DRIVER_FILES:-}" ] || [ -n "${VK_ICD_FILENAMES:-}" ]
}
# Installs what is named $1: the packages $2 of apt, $3 of dnf, or $4 of pacman.
packages() {
    step "$1"
    as_root=""
    [ "$(id -u)" = 0 ] || as_root=sudo
    if command -v apt-get >/dev/null; then
        $as_root apt-get update -qq
        DEBIAN_FRONTEND=noninteractive $as_root apt-get install -y -qq $2 >/dev/null
    elif command -v dnf >/dev/null; then
        $as_root dnf install -y -q $3
    elif command -v pacman >/dev/null; then
        $as_root pacman -S --noconfirm --needed $4
    else
        echo "install $1 first (in Debian: $2)" >&2
        exit 1
    fi
}
if [ "$(uname)" = Linux ] && ! has_vulkan; then
    packages "software Vulkan" "libvulkan1 mesa-vulkan-drivers" "vulkan-loader mesa-vulkan-drivers" \
        "vulkan-icd-loader vulkan-swrast"
fi
if [ "$(uname)" = Linux ] && ! PATH="$PATH:/sbin" ldconfig -p 2>/dev/null | grep -q libEGL.so.1; then
    packages "software OpenGL" "libegl1 libgl1-mesa-dri" "mesa-libEGL mesa-dri-drivers" mesa
fi
if [ "$(uname)" = Linux ] && {
    ! command -v Xvfb || ! command -v openbox || ! command -v wmctrl
} >/dev/null; then
    packages "a virtual display and a window manager" \
        "openbox wmctrl xvfb libx11-xcb1 libxcursor1 libxi6 libxkbcommon-x11-0 libxrandr2" \
        "openbox wmctrl xorg-x11-server-Xvfb libX11-xcb libXcursor libXi libxkbcommon-x11 libXrandr" \
        "openbox wmctrl xorg-server-xvfb libxcursor libxi libxkbcommon-x11 libxrandr"
fi
# rustup's minimal profile lacks them.
cargo fmt --version >/dev/null 2>&1 || rustup component add rustfmt
cargo clippy --version >/dev/null 2>&1 || rustup component add clippy

step "format"
cargo fmt --all --check

step "every file of tests is in its crate's test binary"
sh tests/every_file.sh

step "lints, tests and documentation"
. tests/build_env.sh
export RUSTDOC="$PWD/tests/rustdoc.sh"
# If backtraces are enabled, wgpu takes one for each of its locks, a tenth of the tests' time. Panics still show theirs.
export RUST_LIB_BACKTRACE=0
if [ -n "${RAYSTEP_THOROUGH:-}" ]; then
    cargo test --workspace --locked -- --include-ignored
else
    cargo test --workspace --locked
fi

if [ "$(uname)" = Linux ]; then
    step "the real window"
    # The binary that the tests built: built alone, its dependencies would have other features, and be built again.
    sh tests/window.sh "${CARGO_TARGET_DIR:-./target}/debug/raystep"
fi

step "all checks passed"
