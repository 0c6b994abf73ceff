use super::*;

const SIZE: [usize; 2] = [40, 30];

/// A ramp with a chequered blue, and the same with a patch, a point and a border changed.
fn pictures() -> [Vec<[f32; 3]>; 2] {
    let texel = |x: usize, y: usize| {
        let blue = if (x / 5 + y / 5) % 2 == 1 { 0.8 } else { 0.0 } + 0.1;
        [(x as f64 / 39.0) as f32, (y as f64 / 29.0) as f32, blue as f32]
    };
    let changed = |x: usize, y: usize| {
        let mut rgb = texel(x, y);
        if (10..22).contains(&x) && (8..14).contains(&y) {
            rgb[0] = 1.0 - rgb[0];
        }
        if (x, y) == (30, 20) {
            rgb = [1.0, 1.0, 0.0];
        }
        if x < 4 { rgb.map(|v| 0.5 * v) } else { rgb }
    };
    let all = || (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
    [all().map(|(x, y)| texel(x, y)).collect(), all().map(|(x, y)| changed(x, y)).collect()]
}

/// Figures of the authors' program, flip-evaluator 1.7 from PyPI: `evaluate(reference, test, "LDR", inputsRGB=False,
/// applyMagma=False)` of these pictures. It computes in f32, with kernels in tables of f32: 2e-4 is some 10 times what
/// that leaves here.
#[test]
fn it_is_the_flip_of_its_authors() {
    let [reference, test] = pictures();
    let (found, map) = (errors(&reference, &test).expect("sound"), flip(&reference, &test, SIZE).expect("sound"));
    let texels = [(12, 10, 0.594_658_85), (30, 20, 0.166_217_71), (31, 21, 0.097_579_08), (2, 5, 0.522_038_46)];
    let more = [(16, 15, 0.101_688_87), (39, 29, 8.670_838e-5), (0, 0, 0.319_582_9)];
    for (x, y, wanted) in texels.into_iter().chain(more) {
        let value = map[y * SIZE[0] + x];
        assert!((value - wanted).abs() < 2e-4, "{x},{y}: {value}, {wanted}");
    }
    let mean = map.iter().map(|&value| f64::from(value)).sum::<f64>() / map.len() as f64;
    assert!((mean - 0.117_535_1).abs() < 2e-4, "{mean}");
    assert!((found.rmse - 0.088_171_25).abs() < 1e-6 && (found.mae - 0.021_930_22).abs() < 1e-6, "{found:?}");
}

#[test]
fn the_same_picture_has_no_difference_and_what_is_no_picture_none() {
    let [picture, _] = pictures();
    assert_eq!(errors(&picture, &picture), Some(Errors::default()));
    assert!(flip(&picture, &picture, SIZE).expect("sound").iter().all(|&value| value == 0.0));
    let mut broken = picture.clone();
    broken[7][1] = f32::NAN;
    assert_eq!((errors(&picture, &broken), flip(&picture, &broken, SIZE)), (None, None));
    assert_eq!((errors(&picture, &picture[1..]), flip(&picture, &picture[1..], SIZE)), (None, None));
    assert_eq!((errors(&[], &[]), flip(&[], &[], [0, 7])), (None, None));
}

#[test]
fn black_and_white_are_nearly_as_far_apart_as_flip_goes() {
    let map = flip(&[[0.0; 3]; 81], &[[1.0; 3]; 81], [9, 9]).expect("sound");
    assert!(map.iter().all(|value| (0.9..=1.0).contains(value)), "{map:?}");
}
