//! `raystep run`, and the program sort in other commands.

use std::collections::BTreeMap;

use crate::common::Place;
use crate::files::cornell_box;

/// Rows of a file of passes.
fn rows(csv: &[u8]) -> Vec<BTreeMap<String, String>> {
    csv::Reader::from_reader(csv).deserialize().map(|row| row.expect("a row")).collect()
}

/// The layers of an npy array of uint32.
fn layers(npy: &[u8], count: usize) -> [Vec<u32>; 2] {
    let data = &npy[10 + usize::from(u16::from_le_bytes([npy[8], npy[9]]))..];
    let words: Vec<u32> =
        data.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().expect("4 bytes"))).collect();
    let layer = |layer: &[u32]| layer[..count].to_vec();
    [layer(&words[..words.len() / 2]), layer(&words[words.len() / 2..])]
}

#[test]
fn keys_are_sorted_in_the_passes_of_the_network_on_every_device() {
    for device in ["cpu", "gpu"] {
        let place = Place::new();
        let all = ["run", "sort", "--elements", "3000", "--seed", "7", "--device", device, "--check"];
        let files = ["-o", "keys.npy", "--passes-csv", "passes.csv", "--quiet"];
        let text = place.ok(&[&all[..], &files].concat()).stdout;
        assert!(text.contains("passes    78\n") && text.contains("check     as on the host\n"), "{text}");
        let passes = rows(&place.read("passes.csv"));
        assert_eq!(passes.len(), 78, "12 stages of 1 to 12 steps");
        let of = |pass: usize| {
            (passes[pass]["kernel"].as_str(), passes[pass]["rays_in"].as_str(), passes[pass]["loops"].as_str())
        };
        assert_eq!(
            (of(0), of(1), of(77)),
            (("exchange", "3000", "0 0"), ("exchange", "3000", "1 0"), ("exchange", "3000", "11 11"))
        );
        let [keys, from] = layers(&place.read("keys.npy"), 3000);
        assert!(keys.is_sorted() && keys[0] < keys[2999]);
        let mut all = from.clone();
        all.sort_unstable();
        assert!(all.into_iter().eq(0..3000), "every element once");
    }
}

#[test]
fn numbers_that_cannot_be_sorted_are_refused_in_a_line() {
    let place = Place::new();
    for (number, is_wrong) in [("0", true), ("4194305", true), ("-1", true), ("many", true), ("1", false)] {
        let all = ["run", "sort", "--elements", number, "--device", "cpu", "--check", "--quiet"];
        match is_wrong {
            true => place.fails(2, &format!("--elements {number}: expected an integer from 1 to 4194304"), &all),
            false => assert!(place.ok(&all).stdout.contains("passes    1\n"), "one key is sorted"),
        }
    }
}

#[test]
fn a_sort_is_planned_and_dumped_as_any_program() {
    let (place, scene) = (Place::new(), cornell_box());
    let sort = ["--program", "sort", "--elements", "20", "--device", "cpu"];
    let plan = place.ok(&[&["plan", &scene][..], &sort].concat()).stdout;
    assert!(plan.contains("exchange") && plan.contains("updates stream  key"), "{plan}");
    place.ok(&[&["dump", &scene, "--pass", "all", "-o", "out", "--quiet"][..], &sort].concat());
    let index: serde_json::Value = serde_json::from_slice(&place.read("out/index.json")).expect("JSON");
    let passes = index["passes"].as_array().expect("passes");
    assert_eq!(passes.len(), 15);
    assert_eq!(passes[14]["loops"], serde_json::json!([4, 4]));
}
