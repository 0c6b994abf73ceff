#!/bin/sh
# Builds the inspector for browsers into a folder that any file server serves:
#
#     sh app/web/build.sh DIR
#
# Takes Rust, and npm for wasm-opt, which makes what is fetched smaller; fails where that is more than MOST_BYTES.
# Minutes faster, for tests, without wasm-opt: `sh app/web/build.sh DIR --quick`.
set -eu
folder=${1:?usage: sh app/web/build.sh DIR [--quick]}
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
cd "$(dirname "$0")/../.."
MOST_BYTES=6000000
BINARYEN=132.0.0

target="${CARGO_TARGET_DIR:-target}/web"
wasm="$target/wasm32-unknown-unknown/release/raystep_web.wasm"

# Written by the installed compiler; the other one may be for browsers only.
cargo build --quiet --locked --manifest-path app/web/bindgen/Cargo.toml --target-dir "$target/bindgen"
(
    toolchain=$(sh app/web/toolchain.sh)
    eval "$toolchain"
    # Instructions that browsers have had since 2023: the same speed, but 6% less to fetch.
    export RUSTFLAGS="-C target-feature=+simd128"
    cargo build --locked --release --target wasm32-unknown-unknown --target-dir "$target" -p raystep-web
)
rm -rf "$target/page"
mkdir -p "$target/page"
"$target/bindgen/debug/bindgen" "$wasm" "$target/page"

module="$target/page/raystep_web_bg.wasm"
if [ "${2:-}" = --quick ]; then
    echo "note: without wasm-opt, the page is larger" >&2
elif command -v npm >/dev/null; then
    npm install --silent --no-fund --no-audit --prefix "$target/npm" "binaryen@$BINARYEN"
    "$target/npm/node_modules/.bin/wasm-opt" -Oz --enable-bulk-memory --enable-bulk-memory-opt \
        --enable-reference-types --enable-nontrapping-float-to-int --enable-sign-ext --enable-mutable-globals \
        --enable-multivalue "$module" -o "$module"
else
    echo "note: no npm, so no wasm-opt: the page is larger" >&2
fi
# Compressed here, so that it does not matter whether the server does.
gzip -9 -n "$module"

cp app/web/page/* docs/web/lessons.html docs/web/lessons.css "$target/page/"
mkdir -p "$target/page/scenes" "$target/page/pictures"
cp scenes/*.gltf scenes/*.glb scenes/*.bin scenes/*.png "$target/page/scenes/"
for name in step walk compare; do cp "docs/images/inspector/$name.png" "$target/page/pictures/"; done
cp LICENSE-APACHE LICENSE-MIT "$target/page/"
cp -R "$target/page/." "$folder/"

bytes=0
for file in "$folder"/*.js "$folder"/*.css "$folder"/*.html; do
    bytes=$((bytes + $(gzip -9 -n -c "$file" | wc -c)))
done
bytes=$((bytes + $(wc -c <"$folder/raystep_web_bg.wasm.gz")))
echo "$folder: $bytes bytes to fetch, compressed, of at most $MOST_BYTES (without scenes)"
[ "$bytes" -le "$MOST_BYTES" ]
