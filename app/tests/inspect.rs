//! The inspector from the command line: drawn without a display, or rejected with a one-line error.

use image::RgbaImage;

use crate::common::{Place, scene};

fn cornell_box() -> String {
    scene("cornell-box.gltf").display().to_string()
}

fn picture(place: &Place, name: &str) -> RgbaImage {
    image::open(place.path(name)).expect("a picture").into_rgba8()
}

/// How many pixels differ between two images of the same size.
fn differing(a: &RgbaImage, b: &RgbaImage) -> usize {
    assert_eq!(a.dimensions(), b.dimensions());
    a.pixels().zip(b.pixels()).filter(|(a, b)| a != b).count()
}

#[test]
fn the_window_is_drawn_without_a_display_and_shows_what_it_is_asked_to() {
    let place = Place::new();
    let file = cornell_box();
    let shot = |name: &str, more: &[&str]| {
        let inspect = ["inspect", &file, "--size", "32x32", "--window", "640x400", "--screenshot", name];
        let done = place.ok(&[&inspect[..], more].concat());
        assert!(done.stdout.starts_with(&format!("{name}: ")), "{done:?}");
        picture(&place, name)
    };
    let end = shot("end.png", &[]);
    assert_eq!(end.dimensions(), (640, 400));
    // The red and the green wall of the finished image.
    let is_red = |p: &&image::Rgba<u8>| p[0] > 120 && p[1] < 90 && p[2] < 90;
    let is_green = |p: &&image::Rgba<u8>| p[1] > 120 && p[0] < 120 && p[2] < 120;
    assert!(end.pixels().filter(is_red).count() > 500 && end.pixels().filter(is_green).count() > 500);
    // Another pass, another ray, another theme, twice the resolution.
    assert!(differing(&end, &shot("pass.png", &["--pass", "20"])) > 5_000);
    assert!(differing(&end, &shot("ray.png", &["--pixel", "3,4"])) > 100);
    assert!(differing(&end, &shot("light.png", &["--do", "Toggle light/dark theme"])) > 100_000);
    assert_eq!(shot("large.png", &["--scale", "2"]).dimensions(), (1280, 800));
}

/// The stream panel, with its tab.
const STREAM: [std::ops::Range<u32>; 2] = [0..273, 75..318];
/// In it, the image of 32 x 32 texels: its corner and side length, in pixels.
const TEXELS: ([f32; 2], f32) = ([90.0, 220.0], 90.0);

/// Where two images differ, by more than rounding: a glyph need not have the same place in the atlas.
fn differences(a: &RgbaImage, b: &RgbaImage) -> Vec<[u32; 2]> {
    assert_eq!(a.dimensions(), b.dimensions());
    let pairs = a.enumerate_pixels().zip(b.pixels());
    pairs.filter(|((_, _, a), b)| (0..3).any(|i| a[i].abs_diff(b[i]) > 1)).map(|((x, y, _), _)| [x, y]).collect()
}

#[test]
fn a_link_says_where_to_go() {
    let place = Place::new();
    let file = cornell_box();
    let shot = |name: &str, how: &[&str]| {
        place.ok(&[&["inspect", "--window", "640x400", "--screenshot", name], how].concat());
        picture(&place, name)
    };
    let link = |more: &str| format!("raystep:1?scene={file}&size=32x32&{more}");
    let options = shot("options.png", &[&file, "--size", "32x32", "--pixel", "12,20", "--pass", "20"]);
    let linked = shot("link.png", &["--link", &link("pixel=12,20&pass=20")]);
    assert_eq!(differences(&options, &linked), Vec::<[u32; 2]>::new(), "the link and the options show different views");
    for elsewhere in ["pixel=12,20&pass=22", "pixel=20,12&pass=20"] {
        assert!(differences(&linked, &shot("other.png", &["--link", &link(elsewhere)])).len() > 100, "{elsewhere}");
    }

    // With another stream, only the stream panel changes.
    let tmax = shot("tmax.png", &["--link", &link("pixel=12,20&pass=20&stream=tmax.z")]);
    let is_inside = |[x, y]: &[u32; 2]| STREAM[0].contains(x) && STREAM[1].contains(y);
    let changed = differences(&linked, &tmax);
    assert!(changed.len() > 5_000 && changed.iter().all(is_inside), "{:?}", changed.iter().find(|p| !is_inside(p)));
    // It shows that stream and layer: larger values after that pass have brighter texels.
    let dump = ["dump", &file, "--size", "32x32", "--stream", "tmax", "--pass", "19", "--device", "gpu", "-o", "dump"];
    place.ok(&dump);
    let values = place.read("dump/pass-000019.tmax.npy");
    let z = &values[values.len() - 4 * 32 * 32..];
    let mut texels = Vec::new();
    for (i, bytes) in z.chunks_exact(4).enumerate() {
        let (x, y) = (i % 32, i / 32);
        // The marker of the selected ray covers adjacent texels.
        if x.abs_diff(12) <= 3 && y.abs_diff(20) <= 3 {
            continue;
        }
        let at = |corner: f32, texel: usize| (corner + TEXELS.1 * (texel as f32 + 0.5) / 32.0) as u32;
        let [r, g, b, _] = tmax.get_pixel(at(TEXELS.0[0], x), at(TEXELS.0[1], y)).0.map(u32::from);
        texels.push((f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]), 2 * r + 5 * g + b, [x, y]));
    }
    texels.sort_by(|a, b| a.0.total_cmp(&b.0));
    let distinct = texels.chunk_by(|a, b| a.0 == b.0).count();
    assert!(distinct >= 5, "{distinct} values");
    for pair in texels.windows(2) {
        let ((value, light, at), (next, lighter, there)) = (pair[0], pair[1]);
        let is_right = if value == next { light == lighter } else { light < lighter };
        assert!(is_right, "{value} at {at:?} is drawn with {light}, {next} at {there:?} with {lighter}");
    }
}

#[test]
fn what_cannot_be_shown_is_said_in_a_line_and_leaves_no_file() {
    let place = Place::new();
    std::fs::write(place.path("broken.gltf"), "{").expect("a file");
    let file = cornell_box();
    let cases: &[(i32, &str, &[&str])] = &[
        (1, "broken.gltf: the glTF JSON is invalid", &["broken.gltf"]),
        (1, "nothing.glb: No such file", &["nothing.glb"]),
        (2, "the image has pixels 0,0 to 7,7", &[&file, "--size", "8x8", "--pixel", "8,0"]),
        (2, "--do dance: no such command; 'raystep inspect --list' lists them", &[&file, "--do", "dance"]),
        (2, "cannot be stepped", &[&file, "--schedule", "fused"]),
        (2, "expected a number from 0.25 to 8", &[&file, "--scale", "0"]),
        (2, "so does --pass", &["--link", "raystep:1?scene=x.glb&pass=3", "--pass", "4"]),
        (2, "16 to 16384", &[&file, "--window", "0x0"]),
    ];
    for (code, message, arguments) in cases {
        place.fails(*code, message, &[&["inspect", "--screenshot", "out.png"], *arguments].concat());
    }
}

#[cfg(all(unix, not(target_os = "macos")))]
#[test]
fn without_a_display_a_scene_alone_says_what_can_be_done() {
    let place = Place::new();
    place.fails(1, "no display to open a window on; use --screenshot", &[&cornell_box()]);
}
