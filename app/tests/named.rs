//! Scenes by name: those that are installed with the executable.

use std::fs;
use std::path::Path;
use std::process::Command;

use tempfile::TempDir;

use crate::common::{Place, assert_error, outcome, scene};

/// The binary, installed with some scenes in a folder relative to it.
fn installed(executable: &str, scenes: &str) -> TempDir {
    let root = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).expect("a temporary folder");
    let place = |name: &str| {
        let path = root.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        path
    };
    // On the same file system, and not a link that the program would follow.
    fs::hard_link(env!("CARGO_BIN_EXE_raystep"), place(executable)).expect("a link");
    for file in ["cornell-box.gltf", "teapot.glb", "textures.gltf", "textures-данные.bin", "schach brett ü.png"]
    {
        fs::copy(scene(file), place(&format!("{scenes}/{file}"))).expect("a copy");
    }
    root
}

fn run(root: &TempDir, executable: &str, arguments: &[&str]) -> crate::common::Outcome {
    let mut command = Command::new(root.path().join(executable));
    for name in ["XDG_RUNTIME_DIR", "DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        command.env_remove(name);
    }
    outcome(command.current_dir(root.path()).args(arguments))
}

#[test]
fn installed_scenes_open_by_name() {
    for (executable, scenes) in [("raystep", "scenes"), ("bin/raystep", "share/raystep/scenes")] {
        let root = installed(executable, scenes);
        let run = |arguments: &[&str]| run(&root, executable, arguments);
        let told = |arguments: &[&str], wanted: &str| {
            let outcome = run(arguments);
            assert!(outcome.code == Some(0) && outcome.stdout.contains(wanted), "{arguments:?}: {outcome:?}");
        };
        told(&["info", "cornell-box"], "triangles  26");
        told(&["info", "textures"], "textures");
        told(&["plan", "teapot", "--device", "cpu", "--quiet"], "intersect");
        told(&["trace", "--link", "raystep:1?scene=cornell-box&pixel=9,9&size=32x32&device=cpu", "--quiet"], "shade");
        let outcome = run(&["render", "teapot", "-o", "t.png", "--size", "8x8", "--device", "cpu", "--quiet"]);
        assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""));
        // Alone it opens the window, for which there is no display.
        assert_error(&run(&["cornell-box"]), 1, "no display", "a name alone");

        assert_error(
            &run(&["info", "teapt"]),
            1,
            "no such file, and no scene of that name; did you mean teapot? scenes: cornell-box, teapot, textures",
            "a typo",
        );
        for path in ["./teapot", "teapot.glb", "scenes.d/teapot"] {
            assert_error(
                &run(&["info", path]),
                1,
                &format!("{path}: no such file; 'teapot' alone opens the scene that comes with raystep"),
                "a path",
            );
        }
    }
}

#[test]
fn a_file_comes_before_a_scene_of_its_name() {
    let root = installed("raystep", "scenes");
    fs::copy(scene("single-triangle.gltf"), root.path().join("teapot")).expect("a copy");
    let outcome = run(&root, "raystep", &["info", "teapot"]);
    assert!(outcome.stdout.contains("triangles  1\n"), "{outcome:?}");
    fs::create_dir(root.path().join("cornell-box")).expect("a folder");
    assert_error(&run(&root, "raystep", &["info", "cornell-box"]), 1, "it is a folder", "a folder");
    assert!(Path::new(&root.path().join("scenes/cornell-box.gltf")).is_file());
}

#[test]
fn the_cornell_box_is_in_the_program() {
    let place = Place::new();
    let small = ["--size", "16x16", "--device", "cpu", "--quiet"];
    let file = scene("cornell-box.gltf").display().to_string();
    for (name, output) in [("cornell-box", "a.png"), ("built-in:cornell-box", "b.png"), (file.as_str(), "c.png")] {
        place.ok(&[&["render", name, "-o", output], &small[..]].concat());
    }
    assert!(place.read("a.png") == place.read("c.png") && place.read("b.png") == place.read("c.png"));
    assert!(place.ok(&["info", "cornell-box"]).stdout.contains("cornell-box"));
    assert!(place.ok(&["info", "built-in:terrain"]).stdout.contains("triangles  20000\n"));
    // Alone it opens the window, for which there is no display.
    place.fails(1, "no display", &["cornell-box"]);
    place.fails(1, "no such file, and no scene of that name; scenes: cornell-box", &["info", "palace"]);
    place.fails(1, "there is no generator 'palace'; there are cornell-box", &["info", "built-in:palace"]);
    // It has a hash, a name in a bundle, and a file of its own name comes first.
    let bench = ["bench", "cornell-box", "built-in:soup", "--repeats", "1", "--warmups", "0", "-o", "bench"];
    place.ok(&[&bench[..], &small[..]].concat());
    let run: serde_json::Value = serde_json::from_slice(&place.read("bench/run.json")).expect("JSON");
    let hashes: Vec<&str> =
        run["scenes"].as_array().expect("scenes").iter().filter_map(|s| s["hash"].as_str()).collect();
    assert!(hashes.len() == 2 && hashes[0] != hashes[1], "{run}");
    let report = ["report", "cornell-box", "--quick", "--section", "grid", "--bundle", "report.zip", "-o", "report"];
    place.ok(&[&report[..], &small[..]].concat());
    let zip = String::from_utf8_lossy(&place.read("report.zip")).into_owned();
    assert!(zip.contains("inputs/0/cornell-box.glb"), "a bundle has its scene");
    fs::copy(scene("single-triangle.gltf"), place.path("cornell-box")).expect("a copy");
    assert!(place.ok(&["info", "cornell-box"]).stdout.contains("triangles  1\n"));
}

#[test]
fn scenes_of_a_checkout_open_by_name_in_all_its_folders() {
    let place = Place::new();
    let folder = place.path("scenes");
    fs::create_dir_all(place.path("app/src")).expect("a folder");
    fs::create_dir(&folder).expect("a folder");
    for file in ["cornell-box.gltf", "teapot.glb", "Cargo.toml"] {
        fs::copy(scene(file), folder.join(file)).expect("a copy");
    }
    for here in ["", "app/src"] {
        let run = |arguments: &[&str]| {
            let arguments: Vec<&std::ffi::OsStr> = arguments.iter().map(std::ffi::OsStr::new).collect();
            outcome(place.command(&arguments).current_dir(place.path(here)))
        };
        let teapot = run(&["info", "teapot"]);
        assert!(teapot.code == Some(0) && teapot.stdout.contains("triangles  994\n"), "{here:?}: {teapot:?}");
        assert_error(&run(&["teapot"]), 1, "no display", "a name alone");
        assert_error(&run(&["info", "teapt"]), 1, "did you mean teapot? scenes: cornell-box, teapot", "a typo");
        assert_error(&run(&["teapt"]), 2, "no scene of that name; did you mean teapot? (see --help)", "a typo alone");
    }
    place.fails(
        1,
        "scenes/cornel-box.gltf: no such file; did you mean scenes/cornell-box.gltf?",
        &["info", "scenes/cornel-box.gltf"],
    );
}

#[test]
fn a_wrong_name_is_told_the_files_that_are_near() {
    let place = Place::new();
    for file in ["own-room.glb", "own-room.gltf"] {
        fs::copy(scene("teapot.glb"), place.path(file)).expect("a copy");
    }
    place.fails(
        1,
        "own-room: no such file, and no scene of that name; did you mean own-room.glb or own-room.gltf? scenes: ",
        &["info", "own-room"],
    );
    place.fails(1, "own-rom.glb: no such file; did you mean own-room.glb or own-room.gltf?", &["info", "own-rom.glb"]);
    place.fails(1, "nothing.obj: No such file or directory", &["info", "nothing.obj"]);
}

#[test]
fn lessons_open_by_name_without_a_scene() {
    let place = Place::new();
    let lesson = |name: &str| {
        let shot = ["--screenshot", "a.png", "--device", "cpu", "--window", "640x480"];
        place.run(&[&["inspect", "--lesson", name], &shot[..]].concat())
    };
    let begun = lesson("one-ray");
    assert!(begun.code == Some(0) && begun.stdout.starts_with("a.png: 640 x 480"), "{begun:?}");
    assert_error(
        &lesson("one-rya"),
        1,
        "one-rya: no such file, and no lesson of that name; did you mean one-ray? lessons: one-ray, grid-2004",
        "a typo",
    );
    assert_error(&lesson("one-rya.md"), 1, "one-rya.md: No such file or directory", "a file");
    place.fails(
        1,
        "one-ray: no such scene, but a lesson; 'raystep inspect --lesson one-ray' begins it",
        &["inspect", "one-ray"],
    );
}
