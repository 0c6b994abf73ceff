# How tests are compiled, by run.sh and web.sh alike: otherwise all would be compiled twice. To be sourced.
# clippy-driver lints and compiles in one go, so nothing is compiled twice. It generates code as rustc does, except that
# it sets mir-opt-level to 0.
export RUSTC_WORKSPACE_WRAPPER=clippy-driver CLIPPY_ARGS=-D__CLIPPY_HACKERY__warnings__CLIPPY_HACKERY__
# From nothing, a crate in few pieces is built in less time than in the many that a later build could reuse; and the lines of
# backtraces take a tenth of the time. Panics still have their place.
export CARGO_INCREMENTAL=0 CARGO_PROFILE_DEV_DEBUG=false
