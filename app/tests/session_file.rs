//! Session files from the command line.

use std::fs;

use crate::common::{Place, scene};

/// A session of the Cornell box in a folder below the scene's.
fn session(place: &Place) -> String {
    fs::create_dir(place.path("work")).expect("a folder");
    fs::copy(scene("cornell-box.gltf"), place.path("box.gltf")).expect("a scene");
    if let Ok(buffer) = fs::read(scene("cornell-box.bin")) {
        fs::write(place.path("cornell-box.bin"), buffer).expect("its buffer");
    }
    let link = "raystep:1?scene=../box.gltf&size=32x32&pixel=12,20&pass=20&device=cpu";
    format!(
        "{{\"version\": 1,\n \"here\": {{\"link\": \"{link}\"}},\n \"runs\": [{{\"name\": \"with a tree\",\n  \"link\": \
         \"raystep:1?scene=../box.gltf&size=32x32&accelerator=bvh&device=cpu\"}}]}}"
    )
}

#[test]
fn a_session_opens_by_its_name_and_shows_what_its_link_shows() {
    let place = Place::new();
    fs::write(place.path("s.json"), session(&place)).expect("a file");
    fs::rename(place.path("s.json"), place.path("work/s.raystep-session")).expect("a file");
    let window = ["--window", "640x400", "--screenshot"];
    let shot = |name: &str, how: &[&str]| {
        let done = place.ok(&[how, &window, &[name]].concat());
        assert!(done.stdout.starts_with(&format!("{name}: 640 x 400")), "{done:?}");
        image::open(place.path(name)).expect("a picture").into_rgba8()
    };
    let by_name = shot("a.png", &["work/s.raystep-session"]);
    let by_command = shot("b.png", &["inspect", "work/s.raystep-session"]);
    let linked =
        shot("c.png", &["inspect", "--link", "raystep:1?scene=box.gltf&size=32x32&pixel=12,20&pass=20&device=cpu"]);
    let elsewhere =
        shot("d.png", &["inspect", "--link", "raystep:1?scene=box.gltf&size=32x32&pixel=12,20&pass=60&device=cpu"]);
    // The stream panel: times and messages elsewhere differ from run to run.
    let differing = |a: &image::RgbaImage, b: &image::RgbaImage| {
        let pixels = (150..360).flat_map(|x| (90..280).map(move |y| (x, y)));
        pixels.filter(|&(x, y)| a.get_pixel(x, y) != b.get_pixel(x, y)).count()
    };
    assert_eq!((differing(&by_name, &linked), differing(&by_command, &linked)), (0, 0));
    assert!(differing(&by_name, &elsewhere) > 1000);
    let panel = shot("e.png", &["inspect", "work/s.raystep-session", "--do", "Runs"]);
    let everywhere = panel.pixels().zip(by_name.pixels()).filter(|(a, b)| a != b).count();
    // A table in place of the ray's history.
    assert!(everywhere > 5000, "{everywhere} pixels: the panel of runs is not shown");
}

#[test]
fn what_is_wrong_with_a_session_is_said_in_a_line() {
    let place = Place::new();
    let good = session(&place);
    let write = |name: &str, text: &str| fs::write(place.path(name), text).expect("a file");
    write("broken.raystep-session", "{\"version\": 1,\n \"here\": 7}");
    write("old.raystep-session", &good.replace("\"version\": 1", "\"version\": 0"));
    write("unknown.raystep-session", &good.replace("\"runs\"", "\"walks\""));
    write("far.raystep-session", &good.replace("../box.gltf", "nowhere.gltf"));
    write("good.raystep-session", &good.replace("../box.gltf", "box.gltf"));
    let cases: &[(i32, &str, &[&str])] = &[
        (
            2,
            "broken.raystep-session: the session cannot be read: line 2, column 10: invalid type",
            &["broken.raystep-session"],
        ),
        (2, "version 0, but this raystep reads version 1", &["old.raystep-session"]),
        (2, "unknown field `walks`", &["unknown.raystep-session"]),
        (1, "nowhere.gltf: No such file", &["far.raystep-session"]),
        (1, "none.raystep-session: No such file", &["none.raystep-session"]),
        (2, "good.raystep-session has its own options", &["good.raystep-session", "--size", "8x8"]),
        (2, "good.raystep-session has its own options", &["good.raystep-session", "--accelerator", "bvh"]),
        (2, "good.raystep-session has its own options", &["good.raystep-session", "--pixel", "1,1"]),
    ];
    for (code, message, arguments) in cases {
        place.fails(*code, message, &[&["inspect", "--screenshot", "out.png"], *arguments].concat());
    }
}
