#!/bin/sh
# Builds the wheel into a folder:
#
#     sh app/python/build.sh [--sdist] [--page PAGE] [--licences FOLDER] [--quick] DIR
#
# instead of another wheel of raystep there; with --sdist, the source distribution. Needs Rust and Python 3.11 or later;
# maturin, and zig as a linker for an old glibc, are installed into target/python. --page takes the folder of a page that
# app/web/build.sh has built before, --licences a folder with those of the dependencies, LICENCES-*, which go into the
# wheel beside raystep's own. For tests, --quick optimises only what traces rays, and links for this machine.
set -eu
usage() { echo "usage: sh app/python/build.sh [--sdist] [--page PAGE] [--licences FOLDER] [--quick] DIR" >&2; exit 2; }
what=wheel page="" licences="" quick=""
while [ $# -gt 1 ]; do
    case $1 in
    --sdist) what=sdist ;;
    --quick) quick=yes ;;
    --page)
        page=$(cd "$2" && pwd)
        shift
        ;;
    --licences)
        licences=$(cd "$2" && pwd)
        shift
        ;;
    *) usage ;;
    esac
    shift
done
case ${1:---} in -*) usage ;; esac
mkdir -p "$1"
out=$(cd "$1" && pwd)
target="${CARGO_TARGET_DIR:-$(dirname "$0")/../../target}/python"
mkdir -p "$target"
target=$(cd "$target" && pwd)
cd "$(dirname "$0")"
MATURIN=1.16.0
ZIG=0.17.1

[ -x "$target/tools/bin/pip" ] || python3 -m venv "$target/tools"
"$target/tools/bin/pip" install --quiet "maturin==$MATURIN" "ziglang==$ZIG"

# The scenes that open by name, with the files that they refer to. Those that only tests read stay behind.
scenes=python/raystep/scenes
rm -rf "$scenes"
mkdir "$scenes"
for name in cornell-box flat instances lights primitives single-triangle skin-and-morph textures; do
    cp "../../scenes/$name.gltf" "$scenes"
done
for name in quantized sphere-flake teapot terrain; do
    cp "../../scenes/$name.glb" "$scenes"
done
cp ../../scenes/textures-*.bin ../../scenes/*.png "$scenes"

# What is named like this, maturin takes along.
rm -f LICENCES-*
[ -z "$licences" ] || cp "$licences"/LICENCES-* .

# The inspector for browsers, without scenes: `view` serves the one that is shown.
[ -n "$page" ] || {
    page="$target/page"
    rm -rf "$page"
    sh ../web/build.sh "$page" ${quick:+--quick}
}
[ "$page" = "$PWD/python/raystep/page" ] || {
    rm -rf python/raystep/page
    cp -R "$page" python/raystep/page
}
rm -rf python/raystep/page/scenes python/raystep/page/lessons.*

PATH="$target/tools/bin:$PATH"
export PATH CARGO_TARGET_DIR="$target/build"
# pip would not know which of two to install.
[ "$what" = sdist ] || rm -f "$out"/raystep-*.whl
case $what$quick in
wheel) maturin build --quiet --release --locked --zig --compatibility manylinux_2_28 --out "$out" ;;
wheelyes)
    traces() { printf ' --config profile.release.package.%s.opt-level=3' "$@"; }
    # shellcheck disable=SC2046
    CARGO_PROFILE_RELEASE_OPT_LEVEL=0 maturin build --quiet --release --locked --compatibility linux --out "$out" \
        $(traces raystep-kernels raystep-scenes glam obvhs rayon rayon-core)
    ;;
sdist*) maturin sdist --out "$out" ;;
esac
for file in "$out"/raystep-*; do
    echo "$file: $(wc -c <"$file") bytes"
done
[ "$what" = wheel ] || exit 0

# How long it takes to start, in an environment of its own.
rm -rf "$target/start"
python3 -m venv "$target/start"
"$target/start/bin/pip" install --quiet "$out"/raystep-*.whl
"$target/start/bin/python" - <<'END'
import subprocess, sys, time

for what, words in ("raystep --version", ["-m", "raystep", "--version"]), ("import raystep", ["-c", "import raystep"]):
    times = []
    for _ in range(5):
        begin = time.perf_counter()
        subprocess.run([sys.executable, *words], check=True, stdout=subprocess.DEVNULL)
        times.append(time.perf_counter() - begin)
    print(f"{what}: {sorted(times)[2] * 1000:.0f} ms")
END
