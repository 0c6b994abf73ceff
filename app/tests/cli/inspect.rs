//! The inspector from the command line: drawn without a display, or refused in one line.

use image::RgbaImage;

use crate::common::{Place, scene};

fn cornell_box() -> String {
    scene("cornell-box.gltf").display().to_string()
}

fn picture(place: &Place, name: &str) -> RgbaImage {
    image::open(place.path(name)).expect("a picture").into_rgba8()
}

/// How many pixels two pictures of one size do not share.
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
    // The red and the green wall of the finished picture.
    let is_red = |p: &&image::Rgba<u8>| p[0] > 120 && p[1] < 90 && p[2] < 90;
    let is_green = |p: &&image::Rgba<u8>| p[1] > 120 && p[0] < 120 && p[2] < 120;
    assert!(end.pixels().filter(is_red).count() > 500 && end.pixels().filter(is_green).count() > 500);
    // Another pass, another ray, another theme, twice the pixels.
    assert!(differing(&end, &shot("pass.png", &["--pass", "20"])) > 5_000);
    assert!(differing(&end, &shot("ray.png", &["--pixel", "3,4"])) > 100);
    assert!(differing(&end, &shot("light.png", &["--do", "Light or dark"])) > 100_000);
    assert_eq!(shot("large.png", &["--scale", "2"]).dimensions(), (1280, 800));
}

#[test]
fn a_link_says_where_to_go() {
    let place = Place::new();
    let link = format!("raystep:1?scene={}&size=32x32&pixel=12,20&pass=20&stream=tmax.z", cornell_box());
    let window = ["--window", "640x400", "--screenshot"];
    place.ok(&[&["inspect", "--link", &link], &window[..], &["link.png"]].concat());
    let options = ["inspect", &cornell_box(), "--size", "32x32", "--pixel", "12,20", "--pass", "20"];
    place.ok(&[&options[..], &window[..], &["options.png"]].concat());
    // The same but for the stream: the views differ, the passes at the left do not.
    let (a, b) = (picture(&place, "link.png"), picture(&place, "options.png"));
    assert!(differing(&a, &b) > 1_000);
}

#[test]
fn what_cannot_be_shown_is_said_in_a_line_and_leaves_no_file() {
    let place = Place::new();
    std::fs::write(place.path("broken.gltf"), "{").expect("a file");
    let file = cornell_box();
    let cases: &[(i32, &str, &[&str])] = &[
        (1, "broken.gltf: the glTF JSON is wrong", &["broken.gltf"]),
        (1, "nothing.glb: No such file", &["nothing.glb"]),
        (2, "the image has pixels 0,0 to 7,7", &[&file, "--size", "8x8", "--pixel", "8,0"]),
        (2, "no command is called \"dance\"", &[&file, "--do", "dance"]),
        (2, "cannot be stepped", &[&file, "--schedule", "fused"]),
        (2, "a number from 0.25 to 8 is wanted", &[&file, "--scale", "0"]),
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
    place.fails(1, "there is no display to open a window on; --screenshot", &[&cornell_box()]);
}
