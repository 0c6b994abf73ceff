#!/bin/sh
# Builds what a release consists of into a folder, target/packages-out unless another is named:
#
#     sh app/packaging/build.sh [--archive] [DIR]
#
# the archive for this machine's system (program, scenes, manual pages, completions of shells, licences), the wheel, and
# SHA256SUMS. With --archive, without the wheel, which is for Linux. Needs Rust, Python 3.11 or later and Git; on Linux,
# zig links the program for glibc 2.28, as it does the wheel. Tools are installed into target/packaging. The same files
# give the same archive, with the commit's date, or SOURCE_DATE_EPOCH where it is set.
set -eu
parts="archive wheel"
[ "${1:-}" != --archive ] || { parts=archive; shift; }
[ $# -le 1 ] || { echo "usage: sh app/packaging/build.sh [--archive] [DIR]" >&2; exit 2; }
root=$(cd "$(dirname "$0")/../.." && pwd)
out=${1:-${CARGO_TARGET_DIR:-$root/target}/packages-out}
mkdir -p "$out"
out=$(cd "$out" && pwd)
target="${CARGO_TARGET_DIR:-$root/target}/packaging"
mkdir -p "$target"
target=$(cd "$target" && pwd)
cd "$root"
ZIGBUILD=0.24.1
ZIG=0.17.1
CARGO_ABOUT=0.9.3
GLIBC=2.28

host=$(rustc -vV | sed -n 's/^host: //p')
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct)}
export SOURCE_DATE_EPOCH
python3 -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "Python 3.11 or later is needed" >&2; exit 1; }

tools="$target/tools"
[ "$("$tools/bin/cargo-about" --version 2>/dev/null)" = "cargo-about $CARGO_ABOUT" ] ||
    cargo install --quiet --locked --features cli --root "$tools" cargo-about --version "$CARGO_ABOUT"
exe="" format=tar.gz triple=$host zig=""
case "$host" in
*-linux-gnu)
    [ -x "$tools/bin/pip" ] || python3 -m venv "$tools"
    "$tools/bin/pip" install --quiet "cargo-zigbuild==$ZIGBUILD" "ziglang==$ZIG"
    triple=$host.$GLIBC zig=zig
    PATH="$tools/bin:$PATH"
    export RAYSTEP_GLIBC=$GLIBC
    ;;
*-windows-*) exe=.exe format=zip ;;
esac

# Names of files, which messages of panics contain, start at the crate instead of at this machine's folders.
case "$host" in
*-windows-*) ;;
*)
    CARGO_ENCODED_RUSTFLAGS=$(printf -- '--remap-path-prefix=%s/registry/src=crates\037--remap-path-prefix=%s=raystep' \
        "${CARGO_HOME:-$HOME/.cargo}" "$root")
    # These replace the flags of .cargo/config.toml.
    case "$host" in
    x86_64-*) CARGO_ENCODED_RUSTFLAGS=$(printf -- '%s\037-Ctarget-cpu=x86-64-v2' "$CARGO_ENCODED_RUSTFLAGS") ;;
    esac
    export CARGO_ENCODED_RUSTFLAGS
    ;;
esac
cargo_for_release() {
    command=$1
    shift
    if [ -n "$zig" ]; then
        [ "$command" = rustc ] || command=zigbuild
        cargo-zigbuild "$command" --release --locked -p raystep --target "$triple" --target-dir "$target/build" "$@"
    else
        cargo "$command" --release --locked -p raystep --target "$triple" --target-dir "$target/build" "$@"
    fi
}
cargo_for_release rustc --bin raystep -- -C strip=symbols
# Not a command of the program, which has no use for it.
cargo_for_release build --example man
built="$target/build/$host/release"

version=$("$built/raystep$exe" --version)
version=${version#raystep }
name="raystep-$version-$host"
tree="$target/$name"
rm -rf "$tree"
share="$tree/share"
doc="$share/doc/raystep"
mkdir -p "$tree/bin" "$share/raystep/scenes" "$share/man/man1" "$share/bash-completion/completions" \
    "$share/zsh/site-functions" "$share/fish/vendor_completions.d" "$doc"

cp "$built/raystep$exe" "$tree/bin/"
cp scenes/*.gltf scenes/*.glb scenes/*.bin scenes/*.png scenes/README.md "$share/raystep/scenes/"
date=$(python3 -c 'import sys, time; print(time.strftime("%Y-%m-%d", time.gmtime(int(sys.argv[1]))))' "$SOURCE_DATE_EPOCH")
"$built/examples/man$exe" "$share/man/man1" "$date"
"$tree/bin/raystep$exe" completions bash >"$share/bash-completion/completions/raystep"
"$tree/bin/raystep$exe" completions zsh >"$share/zsh/site-functions/_raystep"
"$tree/bin/raystep$exe" completions fish >"$share/fish/vendor_completions.d/raystep.fish"
[ -z "$exe" ] || "$tree/bin/raystep$exe" completions powershell >"$doc/raystep.ps1"

cp README.md CHANGELOG.md LICENSE-MIT LICENSE-APACHE "$doc/"
rust_licences=$(rustc --print sysroot)/share/doc/rust/COPYRIGHT-library.html
# Writes the licences of a crate's dependencies. Takes minutes, so only where something may have changed.
licences_of() {
    manifest=$1 lock=$2 of=$3 file=$4
    for input in "$lock" "$manifest" app/packaging/about.toml app/packaging/licences.hbs; do
        [ "$file" -nt "$input" ] || rm -f "$file"
    done
    [ -s "$file" ] || {
        cargo fetch --quiet --locked --manifest-path "$manifest"
        "$tools/bin/cargo-about" generate --frozen --fail --manifest-path "$manifest" --target "$of" \
            --config app/packaging/about.toml --output-file "$file.part" app/packaging/licences.hbs
        mv "$file.part" "$file"
    }
}
licences_of app/Cargo.toml Cargo.lock "$host" "$target/licences-$host.txt"
cp "$target/licences-$host.txt" "$doc/LICENCES-dependencies.txt"
cp "$rust_licences" "$doc/LICENCES-rust-library.html"

rm -f "$out"/raystep-*-"$host.$format"
python3 app/packaging/pack.py "$tree" "$out/$name.$format"
echo "$out/$name.$format: $(wc -c <"$out/$name.$format") bytes, the program $(wc -c <"$tree/bin/raystep$exe")"

case "$parts" in
*wheel*)
    mkdir -p "$target/licences"
    licences_of app/python/Cargo.toml app/python/Cargo.lock "$host" "$target/licences/LICENCES-dependencies.txt"
    # Of the page, which it brings along.
    licences_of app/web/Cargo.toml Cargo.lock wasm32-unknown-unknown "$target/licences/LICENCES-page.txt"
    cp "$rust_licences" "$target/licences/LICENCES-rust-library.html"
    # Its own flags: they are part of what Cargo compares to find out what to build.
    (unset CARGO_ENCODED_RUSTFLAGS && sh app/python/build.sh --licences "$target/licences" "$out")
    ;;
esac

cd "$out"
rm -f SHA256SUMS
set -- "$name.$format"
case "$parts" in *wheel*) set -- "$@" raystep-*.whl ;; esac
if command -v sha256sum >/dev/null; then sha256sum "$@"; else shasum -a 256 "$@"; fi >SHA256SUMS.part
mv SHA256SUMS.part SHA256SUMS
