//! Error messages, word for word, so that changes to them are reviewed.

use std::fs;

use crate::common::{Place, scene};

fn cornell_box() -> String {
    scene("cornell-box.gltf").display().to_string()
}

/// Expects these errors, word for word. None may contain clap's tips or be too long.
fn expect(place: &Place, cases: &[(i32, &str, &[&str])]) {
    for (code, message, arguments) in cases {
        let outcome = place.run(arguments);
        assert_eq!(outcome.stderr, format!("error: {message}\n"), "{arguments:?}");
        assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(*code), ""), "{arguments:?}");
        assert!(outcome.stderr.chars().count() <= 240 && !outcome.stderr.contains("'--"), "{outcome:?}");
    }
}

#[test]
fn numbers_out_of_range_are_told_what_is_right() {
    let place = Place::new();
    let file = cornell_box();
    let render = |more: &[&'static str]| [&["render", &file, "-o", "a.png", "--device", "cpu"], more].concat();
    let trace = |more: &[&'static str]| [&["trace", &file, "--device", "cpu"], more].concat();
    let bench = |more: &[&'static str]| [&["bench", &file, "-o", "out"], more].concat();
    let shot = |more: &[&'static str]| [&["inspect", &file, "--screenshot", "a.png"], more].concat();
    let samples = "expected an integer from 1 to 65536";
    let counted = "expected an integer of at least 0";
    let pixel = "expected two integers separated by a comma, such as 256,256";
    let size = "expected 1 to 32768 pixels per side";
    let window = "expected two integers from 16 to 16384 separated by x, such as 1280x800";
    let cases: &[(String, Vec<&str>)] = &[
        (format!("--spp -1: {samples}"), render(&["--spp", "-1"])),
        (format!("--spp 0: {samples}"), render(&["--spp", "0"])),
        (format!("--spp 65537: {samples}"), render(&["--spp=65537"])),
        (format!("--spp 1.5: {samples}"), render(&["--spp", "1.5"])),
        (format!("--spp many: {samples}"), render(&["--spp", "many"])),
        ("--seed -1: expected an integer from 0 to 4294967295".into(), render(&["--seed", "-1"])),
        (format!("--camera -1: {counted}"), render(&["--camera", "-1"])),
        (format!("--scene-index -1: {counted}"), render(&["--scene-index", "-1"])),
        (format!("--size -1x5: {size}"), render(&["--size", "-1x5"])),
        ("--grid -8: expected 1 to 4096 cells along an axis".into(), render(&["--grid", "-8"])),
        ("--fov wide: expected an angle between 0 and 180 degrees".into(), {
            render(&["--eye", "0,0,2", "--look-at", "0,0,0", "--fov", "wide"])
        }),
        ("--fov -40: expected an angle between 0 and 180 degrees".into(), {
            render(&["--eye", "0,0,2", "--look-at", "0,0,0", "--fov", "-40"])
        }),
        ("--steps-per-pass -1: expected an integer from 1 to 4096".into(), render(&["--steps-per-pass", "-1"])),
        (format!("--pixel -1: {pixel}"), trace(&["--pixel", "-1"])),
        (format!("--pixel -1,5: {pixel}"), trace(&["--pixel", "-1,5"])),
        (format!("--pixel 5,-1: {pixel}"), shot(&["--pixel", "5,-1"])),
        ("--pass -1: expected an integer of at least 0".into(), shot(&["--pass", "-1"])),
        ("--pass -1: expected a pass number of at least 0, last or all".into(), {
            vec!["dump", &file, "-o", "d", "--pass", "-1"]
        }),
        ("--scale -1: expected a number from 0.25 to 8".into(), shot(&["--scale", "-1"])),
        ("--scale big: expected a number from 0.25 to 8".into(), shot(&["--scale", "big"])),
        ("--scale nan: expected a number from 0.25 to 8".into(), shot(&["--scale", "nan"])),
        (format!("--window -1x5: {window}"), shot(&["--window", "-1x5"])),
        ("--repeats -1: expected an integer from 1 to 100000".into(), bench(&["--repeats", "-1"])),
        ("--warmups x: expected an integer from 0 to 100000".into(), bench(&["--warmups", "x"])),
        (format!("--size -1x5: {size}"), bench(&["--size", "-1x5"])),
        (format!("--size -1x5: {size}"), bench(&["--sizes", "-1x5"])),
        ("--triangles -5: expected an integer from 1 to 200000000".into(), {
            vec!["scene", "soup", "--triangles", "-5", "-o", "s.glb"]
        }),
        ("--seed x: expected an integer of at least 0".into(), vec!["scene", "soup", "--seed", "x", "-o", "s.glb"]),
    ];
    for (message, arguments) in cases {
        expect(&place, &[(2, message, arguments)]);
    }
    assert!(place.names().is_empty());
}

#[test]
fn names_that_do_not_exist_are_told_the_nearest_or_all_where_they_are_few() {
    let place = Place::new();
    let file = cornell_box();
    let render = |more: &[&'static str]| [&["render", &file, "-o", "a.png"], more].concat();
    let shot = |name: &'static str| vec!["inspect", &file, "--screenshot", "a.png", "--do", name];
    let commands = "'raystep inspect --list' lists them";
    let cases: &[(&str, Vec<&str>)] = &[
        ("--device cuda: expected auto, gpu or cpu", render(&["--device", "cuda"])),
        ("--sampler blue: expected sobol or random", render(&["--spp", "4", "--sampler", "blue"])),
        ("SHELL fsh: expected bash, elvish, fish, powershell or zsh", vec!["completions", "fsh"]),
        (&format!("--do dance: no such command; {commands}"), shot("dance")),
        (
            &format!(
                "--do stp layout: no such command; did you mean Step layout, Cost layout or Reset layout? {commands}"
            ),
            shot("stp layout"),
        ),
        (
            "--case axis-bellow: no case has this in its name; did you mean axis-below-1e-3 or axis-0? \
             'raystep stability --list' lists them",
            vec!["stability", "--case", "axis-bellow"],
        ),
        (
            "--stream nose: no such stream; the streams are ray_origin, ray_direction, ray_interval, state, tmax, control, voxel, previous, hit, bounds, \
             color, counters, accumulated, blocks, place, trail, scan, surface, and all",
            vec!["dump", &file, "-o", "d", "--stream", "nose"],
        ),
        ("rendr: no such command, and no scene of that name; did you mean render? (see --help)", vec!["rendr"]),
        (
            "cornel-box: no such command, and no scene of that name; did you mean cornell-box? (see --help)",
            vec!["cornel-box"],
        ),
        ("blorp: no such command, and no scene of that name (see --help)", vec!["blorp"]),
        ("one-ray: no such command, but a lesson; 'raystep inspect --lesson one-ray' begins it", vec!["one-ray"]),
        (
            "terain: no such generator; did you mean terrain? 'raystep scene list' lists them",
            vec!["scene", "terain", "-o", "t.glb"],
        ),
        ("unexpected argument --forse; --force is similar (see --help)", vec!["dump", &file, "-o", "d", "--forse"]),
        ("unexpected argument -1 (see --help)", vec!["plan", &file, "-1"]),
    ];
    for (message, arguments) in cases {
        expect(&place, &[(2, message, arguments)]);
    }
    let listed = place.ok(&["inspect", "--list"]).stdout;
    assert!(listed.lines().count() > 50 && listed.contains("Step layout\n"), "{listed}");
    let listed = place.ok(&["stability", "--list"]).stdout;
    assert!(listed.contains("axis-below-1e-3"), "{listed}");
}

#[test]
fn a_first_word_that_is_a_file_is_said_to_be_one() {
    let place = Place::new();
    fs::write(place.path("notes.txt"), "").expect("a file");
    fs::create_dir(place.path("folder")).expect("a folder");
    let wanted = "expected a command, or a file whose name ends in .gltf, .glb, .obj, .ply or .stl (see --help)";
    expect(
        &place,
        &[
            (1, "nosuch.gltf: No such file or directory", &["nosuch.gltf"]),
            (1, "nosuch.glb: No such file or directory", &["inspect", "nosuch.glb"]),
            (1, "nosuch.obj: No such file or directory", &["nosuch.obj"]),
            (2, &format!("notes.txt: {wanted}"), &["notes.txt"]),
            (2, &format!("a/nosuch: {wanted}"), &["a/nosuch"]),
            (2, "folder: it is a folder; expected a command or a scene's file (see --help)", &["folder"]),
        ],
    );
}

#[test]
fn outputs_that_cannot_be_are_told_what_a_name_must_be() {
    let place = Place::new();
    let file = cornell_box();
    fs::create_dir(place.path("folder")).expect("a folder");
    let render = |output: &'static str| vec!["render", &file, "--size", "8x8", "--device", "cpu", "-o", output];
    let shot = |output: &'static str| vec!["inspect", &file, "--screenshot", output];
    let mut cases: Vec<(&str, Vec<&str>)> = vec![
        ("-o .png: there is nothing before the ending; use for example out.png", render(".png")),
        ("-o a.jpg: expected a name that ends in .png or .exr", render("a.jpg")),
        ("-o picture: expected a name that ends in .png or .exr", render("picture")),
        ("-o folder: it is a folder; name a file in it, such as folder/out.png", render("folder")),
        ("--output <OUT.png|OUT.exr>: missing value", render("")),
        ("--screenshot x.jpg: expected a name that ends in .png", shot("x.jpg")),
        ("--screenshot .png: there is nothing before the ending; use for example out.png", shot(".png")),
        ("-o .glb: there is nothing before the ending; use for example out.glb", vec!["scene", "soup", "-o", ".glb"]),
        ("-o s.gltf: expected a name that ends in .glb", vec!["scene", "soup", "-o", "s.gltf"]),
    ];
    if cfg!(target_os = "linux") {
        let device = "-o /dev/full: its name has no ending, which determines the format; use a name that ends in .png \
                      or .exr";
        cases.push((device, render("/dev/full")));
    }
    for (message, arguments) in &cases {
        expect(&place, &[(2, message, arguments)]);
    }
    assert_eq!(place.names(), ["folder"]);
    assert!(fs::read_dir(place.path("folder")).is_ok_and(|mut entries| entries.next().is_none()));
}

#[test]
fn options_that_need_others_or_do_not_fit_say_which() {
    let place = Place::new();
    let file = cornell_box();
    let render = |more: &[&'static str]| [&["render", &file, "-o", "a.png", "--device", "cpu"], more].concat();
    let dump = |more: &[&'static str]| {
        [&["dump", &file, "-o", "d", "--size", "8x8", "--device", "cpu", "--quiet"], more].concat()
    };
    let camera = "requires";
    let large = "an image of 32768x32768 pixels";
    let cases: &[(String, Vec<&str>)] = &[
        (
            "--grid applies to a uniform grid, and accelerator auto chooses its own: omit it, or use --accelerator grid".into(),
            render(&["--grid", "8", "--accelerator", "auto"]),
        ),
        (
            "--grid applies to a uniform grid, and accelerator bvh has no such grid: omit it, or use --accelerator grid".into(),
            render(&["--grid", "8", "--accelerator", "bvh"]),
        ),
        (format!("--up {camera} --eye <X,Y,Z> and --look-at <X,Y,Z> as well"), render(&["--up", "0,1,0"])),
        (format!("--fov {camera} --eye <X,Y,Z> and --look-at <X,Y,Z> as well"), render(&["--fov=40"])),
        (format!("--eye {camera} --look-at <X,Y,Z> as well"), render(&["--eye", "0,0,1", "--up", "0,1,0"])),
        ("--camera 9: the scene has one camera, number 0".into(), render(&["--camera", "9"])),
        ("--family requires --cost as well".into(), vec!["stability", "--family", "room"]),
        ("--do requires --screenshot <F.png> as well".into(), vec!["inspect", &file, "--do", "Quit"]),
        ("--by-bounce divides the light of paths: add --integrator path".into(), render(&["--by-bounce"])),
        (
            "--by-bounce writes layers, which a PNG does not have: use a name that ends in .exr".into(),
            render(&["--by-bounce", "--integrator", "path"]),
        ),
        (
            "--by-bounce divides the light of paths: add --integrator path".into(),
            render(&["--by-bounce", "--integrator", "photons"]),
        ),
        (
            "--shard divides samples, and with --integrator photons each depends on those before it: omit one of them".into(),
            render(&["--shard", "1/2", "--integrator", "photons"]),
        ),
        ("--size is given more than once".into(), render(&["--size", "8x8", "--size", "9x9"])),
        ("--spp is given more than once".into(), render(&["--spp", "2", "--iterations", "2"])),
        ("--output <OUT.png|OUT.exr> is missing (see --help)".into(), vec!["render", &file]),
        ("--output <OUT.png|OUT.exr> and <SCENE> are missing (see --help)".into(), vec!["render"]),
        (
            format!("{large} has 1073741824; the limit of this device is 67108864: choose a smaller size"),
            render(&["--size", "32768x32768"]),
        ),
        (
            "--stream previous: this run omits it: needed only with --accelerator bvh".into(),
            dump(&["--stream", "previous"]),
        ),
        (
            "--stream tmax: this run omits it: needed only with --accelerator grid or irregular".into(),
            dump(&["--stream", "tmax", "--accelerator", "none"]),
        ),
        (
            "--stream accumulated: this run omits it: needed only with --spp 2 or more".into(),
            dump(&["--stream", "accumulated"]),
        ),
        (
            "--stream tmax: this run omits it: needed only with one step per pass: --schedule first or second, or compact with \
             --steps-per-pass 1"
                .into(),
            dump(&["--stream", "tmax", "--schedule", "fused"]),
        ),
    ];
    for (message, arguments) in cases {
        expect(&place, &[(2, message, arguments)]);
    }
    assert!(place.names().is_empty());
    // Every suggestion works.
    for (i, more) in [
        &["--stream", "previous", "--accelerator", "bvh"][..],
        &["--stream", "tmax", "--accelerator", "grid"],
        &["--stream", "accumulated", "--spp", "2"],
        &["--stream", "tmax", "--schedule", "compact"],
    ]
    .iter()
    .enumerate()
    {
        let folder = format!("d{i}");
        place.ok(&[&["dump", &file, "-o", &folder, "--size", "8x8", "--device", "cpu", "--quiet"], *more].concat());
    }
}

#[test]
fn an_image_with_a_side_too_long_for_an_adapter_says_so() {
    let place = Place::new();
    let file = cornell_box();
    let outcome = place.run(&["render", &file, "-o", "a.png", "--size", "32768x8", "--device", "gpu"]);
    let info: serde_json::Value = serde_json::from_str(&place.ok(&["info", "--json"]).stdout).expect("JSON");
    let usable = info["adapters"].as_array().expect("adapters").iter().find(|a| a["is_usable"] == true);
    let side = usable.and_then(|a| a["image_side_px"].as_u64()).expect("an adapter, if only software");
    if side >= 32768 {
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        return;
    }
    let message = format!(
        "error: an image of 32768x8 pixels exceeds {side} per side, the limit of this device: choose a smaller size\n"
    );
    assert_eq!((outcome.code, outcome.stderr), (Some(2), message));
}
