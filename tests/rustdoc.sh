#!/bin/sh
# Replaces rustdoc while `cargo test` runs the examples in a library's documentation. It also builds the documentation,
# with warnings as errors, from dependencies that are already compiled; `cargo doc` would check all of them again.
set -eu

# Builds the documentation: the same arguments without those for running examples.
document() {
    left=$#
    while [ "$left" -gt 0 ]; do
        argument=$1
        shift
        left=$((left - 1))
        case $argument in
        --test) ;;
        --test-args | --test-run-directory | --test-runtool | --test-runtool-arg)
            shift
            left=$((left - 1))
            ;;
        *) set -- "$@" "$argument" ;;
        esac
    done
    folder=$(mktemp -d)
    trap 'rm -rf "$folder"' EXIT
    trap 'exit 130' INT
    trap 'exit 143' TERM
    rustdoc "$@" -D warnings --out-dir "$folder"
}

case " $* " in
*" --test "*) document "$@" ;;
esac
rustdoc "$@"
