//! Scenes by name: those that are installed with the executable.

use std::fs;
use std::path::Path;
use std::process::Command;

use tempfile::TempDir;

use crate::common::{assert_error, outcome, scene};

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
            "nor a scene of this name; did you mean teapot? scenes: cornell-box, teapot, textures",
            "a typo",
        );
        for path in ["./teapot", "teapot.glb", "scenes.d/teapot"] {
            assert_error(
                &run(&["info", path]),
                1,
                &format!("{path}: No such file; the installed scene opens by its name, teapot"),
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
