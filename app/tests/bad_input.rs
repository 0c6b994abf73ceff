//! Bad input: the right exit code, a one-line error, and no files left behind.

use std::ffi::OsStr;
use std::fs;
use std::io::Read as _;
use std::process::Stdio;

use crate::common::{Place, assert_error, outcome, scene};

fn cornell_box() -> String {
    scene("cornell-box.gltf").display().to_string()
}

#[test]
fn wrong_usage_is_code_2() {
    let place = Place::new();
    let file = cornell_box();
    let cases: &[(&str, &[&str])] = &[
        ("rendr: no such command, and no scene of that name; did you mean render?", &["rendr"]),
        ("a.glb: no such generator", &["scene", "a.glb"]),
        ("--output", &["render", &file]),
        (".png or .exr", &["render", &file, "-o", "a.jpg"]),
        ("1 to 32768", &["render", &file, "-o", "a.png", "--size", "0x0"]),
        ("1 to 32768", &["render", &file, "-o", "a.png", "--size", "1000000x1"]),
        ("1 to 32768", &["render", &file, "-o", "a.png", "--size", "99999999999x1"]),
        ("1 to 32768", &["render", &file, "-o", "a.png", "--size=-1x5"]),
        ("640x480", &["render", &file, "-o", "a.png", "--size", "64x"]),
        (
            "--accelerator kd-tree: expected auto, grid, irregular, bvh or none",
            &["render", &file, "-o", "a.png", "--accelerator", "kd-tree"],
        ),
        ("1 to 4096", &["render", &file, "-o", "a.png", "--grid", "0"]),
        ("1 to 4096", &["render", &file, "-o", "a.png", "--grid", "8,99999999999,8"]),
        ("32,8,32", &["render", &file, "-o", "a.png", "--grid", "1,2"]),
        ("1 to 4096", &["render", &file, "-o", "a.png", "--grid", "5000"]),
        ("--camera 1: the scene has one camera, number 0", &["render", &file, "-o", "a.png", "--camera", "1"]),
        ("the file has 1", &["render", &file, "-o", "a.png", "--scene-index", "1"]),
        ("--look-at", &["render", &file, "-o", "a.png", "--eye", "0,0,1"]),
        ("same point", &["render", &file, "-o", "a.png", "--eye", "0,0,1", "--look-at", "0,0,1"]),
        ("0,1.5,-3", &["render", &file, "-o", "a.png", "--eye", "0,0,inf", "--look-at", "0,0,1"]),
        (
            "between 0 and 180",
            &["render", &file, "-o", "a.png", "--eye", "0,0,1", "--look-at", "0,0,0", "--fov", "180"],
        ),
        (
            "a direction with a length above 0",
            &["render", &file, "-o", "a.png", "--eye", "0,0,1", "--look-at", "0,0,0", "--up", "0,0,0"],
        ),
        ("--device cpu uses none", &["render", &file, "-o", "a.png", "--device", "cpu", "--adapter", "x"]),
        ("two outputs", &["render", &file, "-o", "a.png", "--passes-csv", "./a.png"]),
        ("two outputs", &["render", &file, "-o", "a.png", "--passes-csv", "t", "--trace-json", "t"]),
        ("0,0 to 511,511", &["trace", &file, "--pixel", "512,0"]),
        ("0,0 to 7,7", &["trace", &file, "--pixel", "0,8", "--size", "8x8"]),
        ("--pixel", &["trace", &file]),
        ("hex bits", &["trace", &file, "--ray", "1,2,3"]),
        ("a direction other than 0", &["trace", &file, "--ray", "1,2,3,0,0,0", "--device", "cpu"]),
        ("expected finite numbers", &["trace", &file, "--ray", "0x7f800000,2,3,0,0,1", "--device", "cpu"]),
        ("ray_origin", &["dump", &file, "-o", "d", "--stream", "nose"]),
        (
            "omits it: needed only with --accelerator grid or irregular",
            &["dump", &file, "-o", "d", "--stream", "tmax", "--accelerator", "none"],
        ),
        (
            "the run has 73 passes, 0 to 72",
            &["dump", &file, "-o", "d", "--pass", "73", "--size", "64x64", "--device", "cpu"],
        ),
        (
            "--traversal 3d-dda walks through a uniform grid with the paper's rules: add --accelerator grid --numerics paper",
            &["render", &file, "-o", "a.png", "--traversal", "3d-dda"],
        ),
        ("add --accelerators grid --numerics paper", &["bench", &file, "-o", "b", "--traversals", "3d-dda"]),
        ("expected amanatides-woo or 3d-dda", &["render", &file, "-o", "a.png", "--traversal", "bresenham"]),
        ("missing command", &["scene"]),
        ("--triangles 0: expected an integer from 1", &["scene", "soup", "--triangles", "0", "-o", "s.glb"]),
        ("ends in .glb", &["scene", "soup", "-o", "s.gltf"]),
    ];
    for (wanted, arguments) in cases {
        place.fails(2, wanted, arguments);
    }
}

#[test]
fn work_that_fails_is_code_1() {
    let place = Place::new();
    let whole = fs::read(scene("teapot.glb")).expect("the teapot");
    fs::write(place.path("short.glb"), &whole[..whole.len() / 2]).expect("a file");
    fs::write(place.path("empty.glb"), "").expect("a file");
    fs::write(place.path("lost.gltf"), r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"../a/b.bin"}],"bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}]}"#)
        .expect("a file");
    fs::write(place.path("bad.ply"), "ply\nformat ascii 1.0\nelement vertex 9999999999\n").expect("a file");
    fs::create_dir(place.path("folder.png")).expect("a folder");
    let file = cornell_box();
    let cases: &[(&str, &[&str])] = &[
        ("short.glb", &["render", "short.glb", "-o", "a.png"]),
        ("empty.glb", &["render", "empty.glb", "-o", "a.png"]),
        ("a/b.bin", &["render", "lost.gltf", "-o", "a.png"]),
        ("bad.ply", &["scene", "convert", "bad.ply", "-o", "a.glb"]),
        ("nothing.glb: No such file", &["render", "nothing.glb", "-o", "a.png"]),
        ("it is a folder", &["render", ".", "-o", "a.png"]),
        ("folder.png is a folder", &["render", &file, "-o", "folder.png"]),
        ("there is no folder nowhere", &["render", &file, "-o", "nowhere/a.png"]),
        ("there is no folder nowhere", &["render", &file, "-o", "a.png", "--summary-json", "nowhere/a.json"]),
        ("there is no folder nowhere", &["dump", &file, "-o", "nowhere/d"]),
        ("short.glb is not a folder", &["dump", &file, "-o", "short.glb"]),
        ("no such adapter", &["render", &file, "-o", "a.png", "--adapter", "no such adapter"]),
    ];
    for (wanted, arguments) in cases {
        place.fails(1, wanted, arguments);
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_device_that_never_ends_is_refused_and_one_that_is_full_is_said() {
    let place = Place::new();
    let file = cornell_box();
    place.fails(1, "not a regular file", &["render", "/dev/zero", "-o", "a.png"]);
    let render = ["render", &file, "-o", "a.png", "--size", "8x8", "--device", "cpu", "--quiet"];
    place.fails(
        1,
        "cannot write /dev/full: No space left on device",
        &[&render[..], &["--passes-csv", "/dev/full"]].concat(),
    );
    let is_device = fs::metadata("/dev/full").is_ok_and(|found| !found.is_file());
    assert!(is_device, "the device is still there");
    for arguments in [&["plan", file.as_str(), "--quiet"][..], &["info"], &["--help"], &["completions", "bash"]] {
        let arguments: Vec<&OsStr> = arguments.iter().map(OsStr::new).collect();
        let full = fs::File::options().write(true).open("/dev/full").expect("the device");
        let result = place.command(&arguments).stdout(full).stderr(Stdio::piped()).spawn().expect("a process");
        let output = result.wait_with_output().expect("an end");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {stderr}");
        assert!(stderr.contains("cannot write to standard output: No space left on device"), "{arguments:?}: {stderr}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_link_is_followed_and_a_pipe_is_written_to() {
    let place = Place::new();
    let file = cornell_box();
    fs::write(place.path("real.png"), "old").expect("a file");
    std::os::unix::fs::symlink("real.png", place.path("link.png")).expect("a link");
    let render = ["render", &file, "-o", "link.png", "--size", "8x8", "--device", "cpu", "--quiet"];
    let outcome = place.ok(&[&render[..], &["--passes-csv", "/dev/stdout"]].concat());
    assert!(outcome.stdout.starts_with("schema_version,"), "{outcome:?}");
    assert!(place.read("real.png").starts_with(b"\x89PNG"));
    assert!(fs::symlink_metadata(place.path("link.png")).expect("the link").is_symlink());
}

#[test]
fn no_output_replaces_what_the_scene_is_read_from() {
    let place = Place::new();
    let names = ["textures.gltf", "textures-данные.bin", "schach brett ü.png"];
    for name in names {
        fs::copy(scene(name), place.path(name)).expect("a copy");
    }
    fs::copy(scene("cornell-box.gltf"), place.path("index.json")).expect("a copy");
    fs::write(place.path("one.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("a file");
    #[cfg(unix)]
    for (to, link) in [(names[1], "link.csv"), ("one.obj", "link.glb")] {
        std::os::unix::fs::symlink(to, place.path(link)).expect("a link");
    }
    let before: Vec<_> = names.iter().map(|name| place.read(name)).collect();
    let render = ["render", "textures.gltf", "--size", "8x8", "--device", "cpu", "-o"];
    let mut cases = vec![
        [&render[..], &["a.png", "--summary-json", "./textures.gltf"]].concat(),
        [&render[..], &["a.png", "--passes-csv", "textures-данные.bin"]].concat(),
        [&render[..], &["schach brett ü.png"]].concat(),
        vec!["dump", "index.json", "-o", ".", "--force", "--size", "8x8", "--device", "cpu"],
    ];
    if cfg!(unix) {
        cases.push([&render[..], &["a.png", "--passes-csv", "link.csv"]].concat());
        cases.push(vec!["scene", "convert", "one.obj", "-o", "link.glb"]);
    }
    for arguments in &cases {
        place.fails(2, "would be replaced, but the scene is read from it", arguments);
    }
    assert_eq!(names.map(|name| place.read(name)).to_vec(), before);
}

#[test]
fn a_reader_that_leaves_is_no_error() {
    let place = Place::new();
    let file = scene("cornell-box.gltf");
    let arguments = ["trace".as_ref(), file.as_os_str(), "--pixel".as_ref(), "9,9".as_ref(), "--quiet".as_ref()];
    let mut child =
        place.command(&arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the binary starts");
    drop(child.stdout.take());
    let mut stderr = String::new();
    child.stderr.take().expect("a pipe").read_to_string(&mut stderr).expect("text");
    assert_eq!((child.wait().expect("an end").code(), stderr.as_str()), (Some(0), ""));
}

#[test]
#[cfg(unix)]
fn names_need_not_be_text() {
    use std::os::unix::ffi::OsStrExt as _;
    let place = Place::new();
    let input = OsStr::from_bytes(b"caf\xe9.glb");
    let output = OsStr::from_bytes(b"out\xff.png");
    fs::copy(scene("teapot.glb"), place.path(input)).expect("a copy");
    let wrong = outcome(&mut place.command(&["render".as_ref(), input, "-o".as_ref(), OsStr::from_bytes(b"\xff")]));
    assert_error(&wrong, 2, "ends in .png or .exr", "a name that is not text");
    let arguments = ["render".as_ref(), input, "-o".as_ref(), output, "--size=8x8".as_ref(), "--device=cpu".as_ref()];
    let right = outcome(&mut place.command(&arguments));
    assert_eq!(right.code, Some(0), "{right:?}");
    assert!(fs::read(place.path(output)).is_ok_and(|bytes| bytes.starts_with(b"\x89PNG")));
}
