//! Records what the program is built from, for bundles of reports: the commit, and Cargo.lock.

use std::path::{Path, PathBuf};
use std::process::Command;

fn main() {
    let of_git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let commit = of_git(&["rev-parse", "HEAD"]).unwrap_or_else(|| "unknown".into());
    println!("cargo::rustc-env=RAYSTEP_COMMIT={commit}");
    if let Some(log) = of_git(&["rev-parse", "--git-path", "logs/HEAD"]).filter(|log| Path::new(log).exists()) {
        println!("cargo::rerun-if-changed={log}");
    }
    // In the repository it is beside the workspace, in a package beside Cargo.toml.
    let lock = ["../Cargo.lock", "Cargo.lock"].into_iter().find(|path| Path::new(path).exists());
    let bytes = lock.and_then(|path| std::fs::read(path).ok()).unwrap_or_default();
    println!("cargo::rerun-if-changed={}", lock.unwrap_or("build.rs"));
    println!("cargo::rerun-if-changed=build.rs");
    pack_relocations();
    fold_identical_code();
    let out = PathBuf::from(std::env::var_os("OUT_DIR").unwrap_or_default());
    if let Err(error) = std::fs::write(out.join("Cargo.lock"), bytes) {
        println!("cargo::error=cannot write to {}: {error}", out.display());
    }
}

/// Keeps one copy of functions that are the same, a fiftieth of the binary, where LLD links: it comes with Rust, which uses
/// it by default for this target. Another linker may not know the option, so LLD is named, unless the user has named one.
fn fold_identical_code() {
    let variable = |name: &str| std::env::var(name).unwrap_or_default();
    let target = "x86_64-unknown-linux-gnu";
    println!("cargo::rerun-if-env-changed=CARGO_ENCODED_RUSTFLAGS");
    let is_chosen = !variable("RUSTC_LINKER").is_empty() || variable("CARGO_ENCODED_RUSTFLAGS").contains("link");
    if variable("HOST") != target || variable("TARGET") != target || variable("PROFILE") != "release" || is_chosen {
        return;
    }
    let output = Command::new(variable("RUSTC")).args(["--print", "sysroot"]).output();
    let sysroot = output.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned()).unwrap_or_default();
    let folder = Path::new(&sysroot).join("lib/rustlib").join(target).join("bin/gcc-ld");
    if folder.join("ld.lld").exists() {
        println!("cargo::rustc-link-arg-bins=-B{}", folder.display());
        println!("cargo::rustc-link-arg-bins=-fuse-ld=lld");
        println!("cargo::rustc-link-arg-bins=-Wl,--icf=all");
    }
}

/// Packs the relocations of the binary, a twentieth of its size, where the system's loader can read them that way: from
/// glibc 2.36 on, if it is built for this machine. `RAYSTEP_GLIBC` replaces the version of this machine's glibc by that of
/// the oldest on which the binary has to run.
fn pack_relocations() {
    let variable = |name: &str| std::env::var(name).unwrap_or_default();
    if variable("HOST") != variable("TARGET") || variable("CARGO_CFG_TARGET_ENV") != "gnu" {
        return;
    }
    println!("cargo::rerun-if-env-changed=RAYSTEP_GLIBC");
    let output = Command::new("getconf").arg("GNU_LIBC_VERSION").output();
    let text = output.map(|output| String::from_utf8_lossy(&output.stdout).into_owned()).unwrap_or_default();
    let here = text.trim().strip_prefix("glibc ").map(str::to_owned);
    let version = std::env::var("RAYSTEP_GLIBC").ok().or(here).and_then(|version| {
        let (major, minor) = version.split_once('.')?;
        Some((major.parse::<u32>().ok()?, minor.parse::<u32>().ok()?))
    });
    if version.is_some_and(|version| version >= (2, 36)) && variable("CARGO_CFG_TARGET_OS") == "linux" {
        println!("cargo::rustc-link-arg-bins=-Wl,-z,pack-relative-relocs");
    }
}
