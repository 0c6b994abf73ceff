#!/bin/sh
# Checks that every file in every crate's tests is a module of its one test binary: cargo silently ignores other files.
# Searches the current folder and below.
set -eu

find . -name target -prune -o -name Cargo.toml -print | while read -r manifest; do
    tests=${manifest%/*}/tests
    # Some crates have no such tests.
    [ -f "$tests/main.rs" ] || [ -n "$(find "$tests" -maxdepth 1 -name '*.rs' 2>/dev/null)" ] || continue
    find "$tests" -name '*.rs' | while read -r file; do
        folder=${file%/*}
        name=$(basename "$file" .rs)
        parent=$folder.rs
        [ "$folder" != "$tests" ] || parent=$tests/main.rs
        [ "$file" = "$tests/main.rs" ] || grep -Eqsx "(pub(\([a-z]+\))? )?mod $name;" "$parent" || {
            echo "$file is not compiled: write \"mod $name;\" in $parent" >&2
            exit 1
        }
    done
done
