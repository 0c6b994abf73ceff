use super::*;

/// An npy file of version 1.0.
fn npy(descr: &str, order: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}\n");
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend((header.len() as u16).to_le_bytes());
    file.extend(header.as_bytes());
    file.extend(data);
    file
}

fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

/// Gives one byte at a time, as a slow pipe may.
struct Slow<'a>(&'a [u8]);

impl Read for Slow<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let most = buffer.len().min(1);
        self.0.read(&mut buffer[..most])
    }
}

fn all(file: &[u8], format: RaysFormat) -> Result<RaysFile, String> {
    read_all(Slow(file), format, None, 1000).map_err(|error| error.to_string())
}

fn doubles(numbers: &[f64]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

/// The rays in a scene without an offset.
fn rays(file: &RaysFile) -> Vec<Ray> {
    file.in_scene(&Scene::default())
}

const SIX: [f32; 12] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, -1.0, 0.0, 0.5, 0.0, -0.0, 7.0];

#[test]
fn the_same_rays_come_from_every_format() {
    let six = all(&npy("'<f4'", "False", "(2, 6)", &floats(&SIX)), RaysFormat::Npy).expect("rays");
    let expected = [Ray::new([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]), Ray::new([-1.0, 0.0, 0.5], [0.0, -0.0, 7.0])];
    assert_eq!(rays(&six), expected);
    let eight = |min: [f32; 2], max: [f32; 2]| {
        let of = |ray: usize| {
            let six = &SIX[6 * ray..];
            [six[0], six[1], six[2], min[ray], six[3], six[4], six[5], max[ray]]
        };
        floats(&[of(0), of(1)].concat())
    };
    let infinite = eight([0.0; 2], [f32::INFINITY; 2]);
    assert_eq!(all(&npy("\"<f4\"", "False", "(2L,8)", &infinite), RaysFormat::Npy).expect("rays"), six);
    // What the unused numbers are does not matter.
    assert_eq!(all(&eight([f32::NAN; 2], [-1.0, 3.0]), RaysFormat::F32).expect("rays"), six);
    let cut = all(&npy("'<f4'", "False", "(2, 8)", &eight([0.5, 0.0], [2.0, 3.0])), RaysFormat::Npy).expect("rays");
    assert_eq!(rays(&cut), [expected[0].between(0.5, 2.0), expected[1].between(0.0, 3.0)]);
    assert_ne!(cut.hash, six.hash);
    assert_eq!(all(&npy("'<f4'", "False", "(0, 6)", &[]), RaysFormat::Npy).expect("none").rays, []);
}

#[test]
fn float64_tells_places_apart_that_float32_does_not() {
    let far: Vec<f64> =
        SIX[..6].iter().enumerate().map(|(i, &v)| f64::from(v) + if i == 0 { 1e7 + 0.125 } else { 0.0 }).collect();
    let file = all(&npy("'<f8'", "False", "(1, 6)", &doubles(&far)), RaysFormat::Npy).expect("rays");
    let scene = Scene { offset: DVec3::new(1e7, 0.0, 0.0), ..Scene::default() };
    assert_eq!(file.in_scene(&scene), [Ray::new([1.125, 2.0, 3.0], [4.0, 5.0, 6.0])]);
    // The same numbers have the same hash in both widths.
    let [single, double] = [("'<f4'", floats(&SIX)), ("'<f8'", doubles(&SIX.map(f64::from)))]
        .map(|(descr, data)| all(&npy(descr, "False", "(2, 6)", &data), RaysFormat::Npy).expect("rays"));
    assert_eq!((single.hash, rays(&single)), (double.hash, rays(&double)));
    let eight = [1.0, 2.0, 3.0, 0.5, 4.0, 5.0, 6.0, f64::INFINITY];
    let file = all(&npy("'<f8'", "False", "(1, 8)", &doubles(&eight)), RaysFormat::Npy).expect("rays");
    assert_eq!(rays(&file), [Ray::new([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]).between(0.5, f32::INFINITY)]);
}

#[test]
fn bad_rays_end_the_reading_or_are_replaced_and_told() {
    let mut numbers = SIX;
    numbers[4] = f32::NAN;
    numbers[9..].fill(0.0);
    let file = npy("'<f4'", "False", "(3, 6)", &floats(&[&SIX[..6], &numbers[..]].concat()));
    let reader = || RaysReader::new(&file[..], RaysFormat::Npy, None).expect("a reader");
    let mut batch = Batch::default();
    let error = reader().read(9, DVec3::ZERO, &mut batch).expect_err("a bad ray").to_string();
    assert!(error.starts_with("ray 1 (counted from 0, of 3)"), "{error}");
    let mut batch = Batch::default();
    let mut lenient = reader().with_bad_rays(BadRays::Miss);
    assert_eq!(lenient.read(9, DVec3::ZERO, &mut batch).expect("rays"), 3);
    assert_eq!((batch.rays.len(), &batch.bad[..]), (3, &[1, 2][..]));
    assert!(batch.rays.iter().all(|ray| ray.fault().is_none()), "what stands in their place can be traced");
}

#[test]
fn batches_are_no_larger_than_asked_for() {
    let numbers: Vec<f32> = (0..7 * 8).map(|i| i as f32 + 1.0).collect();
    for total in [None, Some(7)] {
        let bytes = floats(&numbers);
        let mut reader = RaysReader::new(&bytes[..], RaysFormat::F32, total).expect("a reader");
        assert_eq!(reader.total(), total);
        let mut counts = Vec::new();
        let mut batch = Batch::default();
        loop {
            counts.push(reader.read(3, DVec3::ZERO, &mut batch).expect("rays"));
            if counts.last() == Some(&0) {
                break;
            }
        }
        assert_eq!((counts, batch.rays.len(), reader.done()), (vec![3, 3, 1, 0], 7, 7));
        reader.finish().expect("nothing follows");
    }
}

#[test]
fn what_is_wrong_with_a_file_is_said() {
    let good = floats(&SIX);
    let changed = |place: usize, number: f32| {
        let mut numbers = SIX;
        numbers[place] = number;
        npy("'<f4'", "False", "(2, 6)", &floats(&numbers))
    };
    let mut no_direction = SIX;
    no_direction[9..].fill(0.0);
    let with_length = |length: u32| [&b"\x93NUMPY\x02\x00"[..], &length.to_le_bytes()].concat();
    for (file, wanted) in [
        (Vec::new(), "does not begin with"),
        (b"\x93NUMPZ\x01\x00aaaaaaa".to_vec(), "does not begin with"),
        (b"\x93NUMPY\x04\x00aaaaaaa".to_vec(), "version 4.0"),
        (b"\x93NUMPY\x01\x00\x20\x00{'descr'".to_vec(), "header is cut off"),
        (b"\x93NUMPY\x01\x00\x20".to_vec(), "header is cut off"),
        (with_length(u32::MAX), "at most 65536"),
        (npy("'<f2'", "False", "(2, 6)", &good), "type '<f2': expected '<f4' or '<f8'"),
        (npy("'>f4'", "False", "(2, 6)", &good), "type '>f4'"),
        (npy("[('t', '<f4'), ('u', '<f4')]", "False", "(2,)", &good), "type '[('t', '<f4'), ('u', '<f4')]'"),
        (npy("'<f4'", "True", "(2, 6)", &good), "Fortran order"),
        (npy("'<f4'", "Maybe", "(2, 6)", &good), "header is not a dictionary"),
        (npy("'<f4'", "False", "(2, -6)", &good), "header is not a dictionary"),
        (npy("'<f4'", "False", "(2, 99999999999999999999)", &good), "header is not a dictionary"),
        (npy("'<f4'", "False", "(12,)", &good), "shape is (12,): expected (N, 6) or (N, 8)"),
        (npy("'<f4'", "False", "(1, 2, 6)", &good), "shape is (1, 2, 6)"),
        (npy("'<f4'", "False", "(2, 7)", &good), "shape is (2, 7)"),
        (npy("'<f4'", "False", "()", &good), "shape is ()"),
        (npy("'<f4'", "False", "(2, 6)", &good[..47]), "ends 23 bytes into ray 1 (counted from 0, of 2)"),
        (npy("'<f4'", "False", "(2, 6)", &good[..24]), "ends 0 bytes into ray 1 (counted from 0, of 2)"),
        (npy("'<f4'", "False", "(1, 6)", &good), "goes on after its 1 rays"),
        (npy("'<f4'", "False", "(1001, 6)", &good), "has 1001, at most 1000"),
        (changed(7, f32::NAN), "ray 1 (counted from 0, of 2): a component is not finite"),
        (changed(0, f32::INFINITY), "ray 0 (counted from 0, of 2): a component is not finite"),
        (npy("'<f4'", "False", "(2, 6)", &floats(&no_direction)), "ray 1 (counted from 0, of 2): its direction is 0"),
    ] {
        let error = all(&file, RaysFormat::Npy).expect_err(wanted);
        assert!(error.contains(wanted), "{error:?} does not say {wanted:?}");
    }
    let eight = |t_min: f32, t_max: f32| floats(&[1.0, 2.0, 3.0, t_min, 4.0, 5.0, 6.0, t_max]);
    for (t_min, t_max, wanted) in [(-1.0, 1.0, "t_min"), (f32::NAN, 1.0, "t_min"), (2.0, 1.0, "t_max")] {
        let error = all(&npy("'<f4'", "False", "(1, 8)", &eight(t_min, t_max)), RaysFormat::Npy).expect_err(wanted);
        assert!(error.contains("ray 0 (counted from 0, of 1)") && error.contains(wanted), "{error}");
    }
    let error = all(&floats(&SIX), RaysFormat::F32).expect_err("one ray and a half");
    assert!(error.contains("ends 16 bytes into ray 1 (counted from 0, of an unknown number)"), "{error}");
    let many = floats(&[1.0; 8 * 1001]);
    assert!(all(&many, RaysFormat::F32).expect_err("too many").contains("at most 1000"));
}

#[test]
fn strata_are_integers_of_any_type_as_many_as_rays() {
    let rays = npy("'<f4'", "False", "(2, 6)", &floats(&SIX));
    let with = |strata: Vec<u8>| {
        let read = read_all(&rays[..], RaysFormat::Npy, Some(&mut &strata[..]), 1000);
        read.map(|file| file.strata.expect("strata")).map_err(|error| error.to_string())
    };
    for (descr, data) in [
        ("|u1", vec![3, 200]),
        ("<u2", [3u16, 200].map(u16::to_le_bytes).concat()),
        ("<i2", [3i16, 200].map(i16::to_le_bytes).concat()),
        ("<u4", [3u32, 200].map(u32::to_le_bytes).concat()),
        ("<i4", [3i32, 200].map(i32::to_le_bytes).concat()),
        ("<u8", [3u64, 200].map(u64::to_le_bytes).concat()),
        ("<i8", [3i64, 200].map(i64::to_le_bytes).concat()),
    ] {
        assert_eq!(with(npy(&format!("'{descr}'"), "False", "(2,)", &data)), Ok(vec![3, 200]), "{descr}");
    }
    for (file, wanted) in [
        (npy("'|i1'", "False", "(2,)", &[3, 200]), "strata: number 1 is -56: expected 0 to"),
        (npy("'<u8'", "False", "(2,)", &[0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]), "number 0 is 4294967296"),
        (npy("'<f4'", "False", "(2,)", &[0; 8]), "strata: its numbers are of type '<f4': expected an integer"),
        (npy("'|u1'", "False", "(3,)", &[1, 2, 3]), "shape is (3,): expected (2,), one for each ray"),
        (npy("'|u1'", "False", "(2, 1)", &[1, 2]), "shape is (2, 1)"),
        (npy("'<u2'", "False", "(2,)", &[1, 2, 3]), "ends 1 bytes into ray 1 (counted from 0, of 2)"),
        (npy("'|u1'", "False", "(2,)", &[1, 2, 3]), "goes on after its 2 rays"),
    ] {
        let error = with(file).expect_err(wanted);
        assert!(error.contains(wanted), "{error:?} does not say {wanted:?}");
    }
}
