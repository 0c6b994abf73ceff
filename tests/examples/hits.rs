//! The hits of the CPU reference kernels in the pictures that some links describe, for the test of the page:
//!
//! `cargo run -p raystep-tests --example hits -- LINKS WORDS`
//!
//! reads links of this repository's scenes, one a line, and writes [five words](raystep_inspector::hits::hit_words) a ray,
//! little-endian.

use raystep_inspector::hits::hit_words;
use raystep_inspector::link::Link;
use raystep_kernels::Device;
use raystep_tests::{block_on, scene};

fn main() {
    let [from, to] = [1, 2].map(|i| std::env::args().nth(i).expect("a file of links, and one to write to"));
    let links = std::fs::read_to_string(&from).expect("links");
    let mut bytes: Vec<u8> = Vec::new();
    for line in links.lines() {
        let link: Link = line.parse().expect("a link");
        let scene = scene(link.scene.as_deref().expect("a scene"));
        let words = block_on(None, hit_words(&link, &scene, &Device::Cpu(None))).expect("hits");
        bytes.extend(words.iter().flat_map(|word| word.to_le_bytes()));
    }
    std::fs::write(&to, bytes).expect("a file that can be written");
}
