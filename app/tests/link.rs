//! Links: the link printed by a trace traces the same again; options that a link sets cannot be given beside it.

use crate::common::{Place, scene};

fn cornell_box() -> String {
    scene("cornell-box.gltf").display().to_string()
}

/// The link that a trace prints, between the quotes.
fn printed(stderr: &str) -> &str {
    let line = stderr.lines().find_map(|l| l.strip_prefix("open in the inspector: raystep inspect --link \""));
    line.and_then(|l| l.strip_suffix('"')).unwrap_or_else(|| panic!("no link: {stderr}"))
}

#[test]
fn a_printed_link_traces_the_same_ray_the_same_way() {
    let place = Place::new();
    let file = cornell_box();
    let eye = ["--eye", "0.1,-0.3,2.7", "--look-at=-0,0.3333333333333333,0", "--up", "0,1,0.1", "--fov", "33.3"];
    let cases: &[&[&str]] = &[
        &["--pixel", "270,256"],
        &["--pixel", "3,4", "--size", "8x6", "--accelerator", "bvh", "--schedule", "second"],
        &["--pixel", "3,4", "--size", "8x6", "--grid", "3,4,5", "--skip", "on", "--steps-per-pass", "7"],
        &["--pixel", "3,4", "--size", "8x6", "--numerics", "paper", "--schedule", "first", "--camera", "0"],
        &["--ray", "0x3f800000,0.1,5,-0.2,0,-1", "--scene-index", "0", "--keep-all"],
        &[&["--pixel", "3,4", "--size", "8x6"], &eye[..]].concat(),
    ];
    for case in cases {
        let trace = ["trace", &file, "--device", "cpu", "--quiet", "--print-link"];
        let first = place.ok(&[&trace[..], case].concat());
        let link = printed(&first.stderr);
        let again = place.ok(&["trace", "--link", link, "--quiet", "--print-link"]);
        assert_eq!(again.stdout, first.stdout, "{case:?}: {link}");
        assert_eq!(printed(&again.stderr), link, "{case:?}");
        let data = place.ok(&["trace", "--link", link, "--quiet", "--format", "csv"]);
        assert!(data.stdout.starts_with("pass,kernel,") && data.stderr.is_empty(), "{data:?}");
    }
}

#[test]
#[cfg(unix)]
fn a_printed_line_can_be_pasted_into_a_shell() {
    let place = Place::new();
    let name = "a $HOME `x` \"b\" & 100% !.gltf";
    std::fs::copy(scene("single-triangle.gltf"), place.path(name)).expect("a copy");
    let first =
        place.ok(&["trace", name, "--pixel", "4,4", "--size", "8x8", "--device", "cpu", "--quiet", "--print-link"]);
    let mut shell = std::process::Command::new("sh");
    let line = format!("'{}' trace --quiet --link \"{}\"", env!("CARGO_BIN_EXE_raystep"), printed(&first.stderr));
    let again = crate::common::outcome(shell.args(["-c", &line]).current_dir(place.path("")));
    assert_eq!((again.code, again.stdout), (Some(0), first.stdout), "{line}: {}", again.stderr);
}

#[test]
fn a_device_may_stand_beside_a_link_that_names_none() {
    let place = Place::new();
    let link = format!("raystep:1?scene={}&size=8x8&pixel=1,1&pass=3&stream=tmax.x", cornell_box());
    let beside = place.ok(&["trace", "--link", &link, "--device", "cpu", "--quiet", "--print-link"]);
    assert!(printed(&beside.stderr).contains("device=cpu"), "{beside:?}");
    let beside = ["--pixel", "2,2", "--device", "cpu", "--quiet"];
    let without = link.replace("&pixel=1,1", "");
    place.ok(&[&["trace", "--link", &without], &beside[..]].concat());
}

#[test]
fn what_a_link_sets_is_not_set_again() {
    let place = Place::new();
    let file = cornell_box();
    let link = format!("raystep:1?scene={file}&size=8x8&pixel=1,1&device=cpu");
    let cases: &[(&str, &str, &[&str])] = &[
        ("cannot be combined with", &link, &[&file]),
        ("--link <LINK> cannot be combined with --scene-index <N>", &link, &["--scene-index", "0"]),
        ("cannot be combined with", &link, &["--size", "9x9"]),
        ("cannot be combined with", &link, &["--camera", "0"]),
        ("cannot be combined with", &link, &["--eye", "0,0,1", "--look-at", "0,0,0"]),
        ("--accelerator", &link, &["--accelerator", "bvh"]),
        ("--schedule", &link, &["--schedule", "first"]),
        ("cannot be combined with", &link, &["--grid", "8"]),
        ("cannot be combined with", &link, &["--steps-per-pass", "1"]),
        ("cannot be combined with", &link, &["--keep-all"]),
        ("cannot be combined with", &link, &["--spp", "2"]),
        ("--link has a ray, and so does --pixel or --ray", &link, &["--pixel", "1,1"]),
        ("--link has a ray", &link, &["--ray", "0,0,5,0,0,-1"]),
        ("--link has a device", &link, &["--device", "gpu"]),
        ("has no scene: add scene=FILE", "raystep:1?pixel=1,1", &[]),
        ("missing ray", &format!("raystep:1?scene={file}"), &["--device", "cpu"]),
        ("\"colour\" is not a key of a link; the keys are scene,", "raystep:1?colour=red", &[]),
        ("version \"2\"", "raystep:2?scene=a", &[]),
        ("is not a link: links start with \"raystep:1?\"", "a.gltf", &[]),
        ("--schedule fused", &format!("{link}&schedule=fused"), &[]),
        ("--skip on applies to a uniform grid", &format!("{link}&skip=on&accelerator=bvh"), &[]),
    ];
    for (wanted, link, more) in cases {
        place.fails(2, wanted, &[&["trace", "--link", link], *more].concat());
    }
    place.fails(2, "--link", &["trace"]);
    place.fails(1, "nothing.gltf", &["trace", "--link", "raystep:1?scene=nothing.gltf&pixel=1,1&device=cpu"]);
}
