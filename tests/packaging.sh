#!/bin/sh
# Builds the archive and the wheel of a release for Linux, and tries each: the archive in a root that has nothing but the C
# library, the wheel in an environment that has nothing else. Installs what that takes, except Rust, Python and Git.
# `sh tests/packaging.sh --archive` leaves the wheel to tests/python.sh.
set -eu
cd "$(dirname "$0")/.."
GLIBC=2.28

step() { printf '\n== %s\n' "$1"; }
fail() {
    echo "$1" >&2
    exit 1
}

if ! command -v mandoc >/dev/null || ! command -v zsh >/dev/null || ! command -v fish >/dev/null ||
    ! command -v objdump >/dev/null; then
    step "mandoc, zsh, fish, objdump"
    command -v apt-get >/dev/null || fail "install mandoc, zsh, fish and binutils first, to test the archive"
    as_root=""
    [ "$(id -u)" = 0 ] || as_root=sudo
    $as_root apt-get update -qq
    DEBIAN_FRONTEND=noninteractive $as_root apt-get install -y -qq --no-install-recommends mandoc zsh fish binutils \
        >/dev/null
fi

target="${CARGO_TARGET_DIR:-target}"
mkdir -p "$target"
target=$(cd "$target" && pwd)
tried="$target/packages-tried"
out="$tried/out"
rm -rf "$tried"
mkdir -p "$tried/root"

step "the archive and the wheel"
if [ "${1:-}" = --archive ]; then
    sh app/packaging/build.sh --archive "$out"
else
    sh app/packaging/build.sh "$out"
fi
(cd "$out" && sha256sum --check --strict SHA256SUMS)
[ "$(wc -l <"$out/SHA256SUMS")" = "$(find "$out" -name 'raystep-*' | wc -l)" ]
archive=$(ls "$out"/raystep-*.tar.gz)
name=$(basename "$archive" .tar.gz)
tar -xzf "$archive" -C "$tried"
tree="$tried/$name"
program="$tree/bin/raystep"
[ "$name" = "raystep-$("$program" --version | cut -d ' ' -f 2)-$(rustc -vV | sed -n 's/^host: //p')" ]

step "the same files give the same archive"
repacked="$tried/$name.tar.gz"
chmod -R go-rwx "$tree"
find "$tree" -exec touch {} +
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct)} python3 app/packaging/pack.py "$tree" "$repacked"
cmp "$archive" "$repacked"

step "what the program needs of the system"
needs=$(objdump -T "$program" | sed -n 's/.*GLIBC_\([0-9.]*\).*/\1/p' | sort -uV | tail -n 1)
objdump -p "$program" | sed -n 's/^ *NEEDED */needs /p'
echo "needs glibc $needs, of at most $GLIBC"
[ "$(printf '%s\n' "$needs" "$GLIBC" | sort -V | tail -n 1)" = "$GLIBC" ]
[ -z "$(objdump --syms "$program" 2>/dev/null | grep 'F .text' | head -n 1)" ] || fail "the program is not stripped"
! grep -q -a -F -e "${CARGO_HOME:-$HOME/.cargo}/registry" -e "$PWD/" "$program" ||
    fail "the program names folders of this machine"

step "a root with the C library and nothing else"
root="$tried/root"
cp -R "$tree"/. "$root"
ldd "$program" | grep -o '/[^ ]*' | while read -r library; do
    mkdir -p "$root/$(dirname "$library")"
    cp -L "$library" "$root/$library"
done
mkdir "$root/proc"
# Some systems let only root mount, others everybody in a namespace of their own.
as_root="" map=""
if [ "$(id -u)" != 0 ]; then
    if unshare --map-root-user --mount true 2>/dev/null; then map=--map-root-user; else as_root=sudo; fi
fi
# The program finds the scenes beside itself, and itself in /proc.
in_root() {
    # shellcheck disable=SC2016,SC2086 # the inner shell's; no argument where it is empty
    $as_root env -i PATH=/bin:/usr/bin:/usr/sbin unshare $map --mount \
        sh -c 'mount --rbind /proc "$0/proc" && exec chroot "$0" "$@"' "$root" "$@"
}
in_root raystep --version
in_root raystep info
in_root raystep render cornell-box -o /box.png --device cpu
in_root raystep render /share/raystep/scenes/cornell-box.gltf -o /file.png --device cpu --quiet
cmp "$root/box.png" "$root/file.png"
in_root raystep trace teapot --pixel 256,256 --quiet | grep -q "SHADE > DONE"
if in_root raystep render no-such-scene -o /no.png 2>"$tried/message"; then fail "no-such-scene was rendered"; fi
[ "$(wc -l <"$tried/message")" = 1 ] || fail "$(cat "$tried/message")"
[ ! -e "$root/no.png" ]
begin=$(date +%s%N)
for _ in 1 2 3 4 5 6 7 8 9 10; do "$program" --version >/dev/null; done
echo "starts in $((($(date +%s%N) - begin) / 10000000)) ms"

step "manual pages"
# clap_mangen breaks a line that ends anyway before each list of values.
mandoc -T lint -W warning "$tree"/share/man/man1/*.1 >"$tried/lint" || true
if grep -v "skipping paragraph macro: br" "$tried/lint"; then fail "mandoc warns"; fi
pages="raystep"
for command in $("$program" --help | sed -n '/^Commands:/,/^$/s/^  \([a-z]*\) .*/\1/p'); do
    pages="$pages raystep-$command"
done
for page in $pages; do
    mandoc -T utf8 "$tree/share/man/man1/$page.1" | col -bx >"$tried/page"
    for part in NAME SYNOPSIS OPTIONS EXAMPLES; do
        grep -q "^$part$" "$tried/page" || fail "$page.1 has no $part"
    done
done
mandoc -T utf8 "$tree/share/man/man1/raystep-render.1" | col -bx |
    grep -q -x " *raystep render cornell-box -o box.png --spp 64" || fail "an example is not on its own line"
echo "$(find "$tree/share/man" -name '*.1' | wc -l) pages"

step "completions"
bash -c '
    . "$1/share/bash-completion/completions/raystep"
    complete -p raystep
    completed() { COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMPREPLY=(); _raystep raystep "${@: -1}" "${@: -2:1}"; }
    completed raystep ren && [ "${COMPREPLY[*]}" = render ] || exit 1
    completed raystep render --accelerator b && [ "${COMPREPLY[*]}" = bvh ]
' bash "$tree" || fail "bash does not complete"
zsh -f -c 'fpath=($1/share/zsh/site-functions $fpath); autoload -Uz compinit; compinit -u -D
    [ "$_comps[raystep]" = _raystep ] && autoload +X _raystep' zsh "$tree" || fail "zsh does not know the command"
fish --no-config -c 'source $argv[1]/share/fish/vendor_completions.d/raystep.fish
    complete -C "raystep ren" | string match -q "render*"; and complete -C "raystep render --accelerator b" | string match -q "bvh*"' \
    "$tree" || fail "fish does not complete"

step "licences"
# Whether a file has the licence of each crate that another is made from.
has_licences() {
    cargo tree --locked --manifest-path "$1" -e normal,no-proc-macro --target "$2" \
        --prefix none --format '{p}' | sed 's/ v/ /; s/ (.*//' | sort -u >"$tried/crates"
    [ "$(wc -l <"$tried/crates")" -gt 100 ]
    while read -r crate; do
        grep -q "^    $crate\(,\|$\)" "$3" || fail "no licence of $crate in $3"
    done <"$tried/crates"
    [ -s "$(dirname "$3")/LICENCES-rust-library.html" ]
    echo "of $(wc -l <"$tried/crates") crates; $(wc -c <"$3") bytes"
}
host=$(rustc -vV | sed -n 's/^host: //p')
has_licences app/Cargo.toml "$host" "$tree/share/doc/raystep/LICENCES-dependencies.txt"
if [ "${1:-}" != --archive ]; then
    mkdir "$tried/wheel"
    python3 -m zipfile -e "$(ls "$out"/raystep-*.whl)" "$tried/wheel"
    licences=$(ls -d "$tried"/wheel/raystep-*.dist-info/licenses)
    has_licences app/python/Cargo.toml "$host" "$licences/LICENCES-dependencies.txt"
    has_licences app/web/Cargo.toml wasm32-unknown-unknown "$licences/LICENCES-page.txt"
fi

if [ "${1:-}" != --archive ]; then
    sh tests/python.sh "$(ls "$out"/raystep-*.whl)"
fi

step "archive and wheel are right"
ls -l "$out"
