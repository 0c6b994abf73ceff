//! Whatever a user's WGSL is, it is refused with a place in its file, or accepted; nothing panics.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use raystep_kernels::compose::words;
use raystep_kernels::options::features::Features;
use raystep_kernels::options::replacement::Replacement;
use raystep_kernels::programs::closest_hit::kernels::INTERSECT;
use raystep_kernels::shader::{ShaderError, Variant};

/// Most are refused before the WGSL is parsed, so this takes seconds.
const MUTANTS: u64 = 20_000;

/// What other sources may have in place of a word.
const STRANGE: [&str; 24] = [
    "@if(",
    "@else",
    "@if(robust)",
    "{",
    "}",
    "(",
    ")",
    ";",
    ",",
    "import package::live::{",
    "override",
    "/*",
    "*/",
    "\t",
    "é△",
    "\0",
    "\u{feff}",
    "1e999",
    "4294967296u",
    "-",
    "&",
    "loop { }",
    "array<u32, 0>",
    "fn",
];

/// A copy in which a few words or bytes are left out, doubled, swapped, or replaced.
fn mutant(source: &str, rng: &mut fastrand::Rng) -> String {
    let mut text = source.to_owned();
    for _ in 0..rng.usize(1..=3) {
        let all: Vec<_> = words(&text).iter().map(|word| word.start..word.end()).collect();
        if all.is_empty() {
            break;
        }
        let [a, b] = [rng.usize(..all.len()), rng.usize(..all.len())].map(|index| all[index].clone());
        let other = text[b.clone()].to_owned();
        match rng.u32(..7) {
            0 => text.replace_range(a, ""),
            1 => text.insert_str(a.start, &(text[a.clone()].to_owned() + " ")),
            2 => text.replace_range(a, &other),
            3 => text.replace_range(a, STRANGE[rng.usize(..STRANGE.len())]),
            4 => text.insert_str(a.start, STRANGE[rng.usize(..STRANGE.len())]),
            // From here to there.
            5 => text.replace_range(a.start.min(b.start)..a.start.max(b.start), ""),
            _ => {
                let mut bytes = text.into_bytes();
                let at = rng.usize(..bytes.len());
                bytes[at] = rng.u8(..);
                text = String::from_utf8_lossy(&bytes).into_owned();
            }
        }
    }
    text
}

/// What a source is taken as: accepted, or refused with or without a place.
fn tried(source: String) -> usize {
    let features = Features { robust: true, watertight: true, grid: true, ..Features::default() };
    let by = Arc::new(Replacement { kernel: "intersect".into(), file: "my.wgsl".into(), source });
    match Variant::replaced(INTERSECT, &features, &[], &by) {
        Ok(_) => 0,
        Err(ShaderError::Mistake(mistake)) => {
            let place = &mistake.place;
            assert!(!mistake.message.is_empty());
            if place.line == 0 {
                return 1;
            }
            let line = by.source.lines().nth(place.line - 1).unwrap_or_default();
            // One behind the last character is the end of the line.
            let is_in = (1..=line.chars().count() + 1).contains(&place.column);
            assert!(is_in && line == place.text, "{mistake}: {line:?}, {:?}\n{}", place.text, by.source);
            2
        }
        Err(other) => panic!("{other}\n{}", by.source),
    }
}

#[test]
fn mutants_of_a_kernel_are_refused_with_a_place_or_accepted() {
    let counts = [const { AtomicUsize::new(0) }; 3];
    std::thread::scope(|scope| {
        for half in 0..2 {
            let counts = &counts;
            scope.spawn(move || {
                for seed in (half..MUTANTS).step_by(2) {
                    let source = mutant(INTERSECT.info().wgsl, &mut fastrand::Rng::with_seed(seed));
                    let found = std::panic::catch_unwind(|| tried(source.clone()));
                    let found = found.unwrap_or_else(|_| panic!("mutant {seed}:\n{source}"));
                    counts[found].fetch_add(1, Ordering::Relaxed);
                }
            });
        }
    });
    let [accepted, nowhere, placed] = counts.map(AtomicUsize::into_inner);
    eprintln!("{accepted} accepted, {nowhere} refused without a place, {placed} with one");
    // Comments and imports may change as they like; few mistakes have no place.
    assert!(accepted > 200 && placed > 10_000 && nowhere < placed / 10, "{accepted} {nowhere} {placed}");
}
