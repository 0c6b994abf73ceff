use super::*;
use crate::program::schedule::Cursor;
use crate::tables::state::Population;

fn passes(keys: u32) -> Vec<(u32, Vec<u32>)> {
    let (schedule, mut cursor) = (schedule(keys), Cursor::start());
    let population = Population::default();
    let next = || cursor.next(&schedule, &population).map(|_| (cursor.parameter, cursor.loops()));
    std::iter::from_fn(next).collect()
}

#[test]
fn a_sort_takes_as_many_passes_as_batchers_network_has_levels() {
    for (keys, levels) in [(0, 1), (1, 1), (2, 1), (3, 3), (8, 6), (9, 10), (65_536, 136), (1 << 22, 253)] {
        assert_eq!(passes(keys).len(), levels, "{keys} keys");
        assert_eq!(schedule(keys).passes_expected(), levels as u64, "{keys} keys");
    }
    let expected = [(0, [0, 0]), (32, [1, 0]), (33, [1, 1]), (64, [2, 0]), (65, [2, 1]), (66, [2, 2])];
    assert_eq!(passes(8), expected.map(|(parameter, loops)| (parameter, loops.to_vec())));
}

/// By the 0-1 principle (Knuth, The Art of Computer Programming 3, 5.3.4), a network sorts all keys if it sorts all
/// sequences of zeros and ones.
#[test]
fn the_network_sorts_any_keys_of_any_number() {
    for keys in 0..=13usize {
        let passes = passes(keys as u32);
        for bits in 0..1u32 << keys {
            let mut sorted: Vec<u32> = (0..keys).map(|i| bits >> i & 1).collect();
            for (parameter, _) in &passes {
                for i in 0..keys {
                    let j = exchange::partner(i, *parameter);
                    if i < j && j < keys && sorted[j] < sorted[i] {
                        sorted.swap(i, j);
                    }
                }
            }
            assert!(sorted.is_sorted(), "{bits:b} of {keys}");
        }
    }
}
