//! What a scene may read: files in its own folder, within a memory limit.

use std::fs;

use crate::common::{Outcome, Place, assert_error, outcome};

/// A triangle whose positions are in the file at `uri`.
fn triangle(uri: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":36,"uri":"{uri}"}}],"bufferViews":[{{"buffer":0,"byteLength":36}}],"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{{"mesh":0}}]}}"#
    )
}

/// The positions of that triangle.
fn positions() -> Vec<u8> {
    [0f32, 0., 0., 1., 0., 0., 0., 1., 0.].iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// A folder with scenes in `scenes` and other files around it.
fn surroundings() -> Place {
    let place = Place::new();
    for folder in ["scenes/sub", "other", "scenes beside"] {
        fs::create_dir_all(place.path(folder)).expect("a folder");
    }
    for file in ["scenes/x.bin", "scenes/sub/x.bin", "scenes/ü %.bin", "other/x.bin", "x.bin", "scenes beside/x.bin"] {
        fs::write(place.path(file), positions()).expect("a file");
    }
    place
}

fn write_scene(place: &Place, uri: &str) {
    fs::write(place.path("scenes/s.gltf"), triangle(uri)).expect("a scene");
}

#[test]
fn files_are_read_from_the_scenes_folder_and_below() {
    let place = surroundings();
    for uri in [
        "x.bin",
        "./x.bin",
        "sub/x.bin",
        "sub/../x.bin",
        "sub/%2e%2e/x.bin",
        "../scenes/x.bin",
        "%C3%BC%20%25.bin",
        "ü %25.bin",
    ] {
        write_scene(&place, uri);
        place.ok(&["info", "scenes/s.gltf"]);
        place.ok(&["info", "scenes/s.gltf", "--allow-outside"]);
    }
    // The folder in messages has no `..` and no link, however the scene's path was written.
    write_scene(&place, "x.bin");
    place.ok(&["info", "other/../scenes/sub/../s.gltf"]);
    for (uri, words) in [
        ("../x.bin", "buffers[0].uri: \"../x.bin\" lies outside of"),
        ("%2e%2e/x.bin", "buffers[0].uri: \"%2e%2e/x.bin\" lies outside of"),
        ("%2E./other/x.bin", "\"%2E./other/x.bin\" lies outside of"),
        ("sub/../../x.bin", "\"sub/../../x.bin\" lies outside of"),
        // A folder whose name starts with the scene folder's name.
        ("../scenes%20beside/x.bin", "\"../scenes%20beside/x.bin\" lies outside of"),
        // Messages do not tell whether a file outside exists.
        ("../missing.bin", "\"../missing.bin\" lies outside of"),
        ("../missing/x.bin", "\"../missing/x.bin\" lies outside of"),
        ("../../../../../../../../../../etc/passwd", "etc/passwd\" lies outside of"),
    ] {
        write_scene(&place, uri);
        place.fails(1, words, &["info", "scenes/s.gltf"]);
        let folder = fs::canonicalize(place.path("scenes")).expect("the folder").display().to_string();
        place.fails(1, &format!("{folder}, the scene's folder"), &["info", "scenes/s.gltf"]);
        place.fails(1, "--allow-outside", &["info", "scenes/s.gltf"]);
        let lifted = place.run(&["info", "scenes/s.gltf", "--allow-outside"]);
        match uri {
            _ if uri.contains("missing") => assert_error(&lifted, 1, "No such file", uri),
            _ if uri.contains("passwd") => assert!(!lifted.stderr.contains("outside"), "{lifted:?}"),
            _ => assert_eq!(lifted.code, Some(0), "{lifted:?}"),
        }
    }
    write_scene(&place, "missing.bin");
    place.fails(1, "cannot read \"missing.bin\": No such file", &["info", "scenes/s.gltf"]);
    for uri in ["/etc/passwd", "%2Fetc%2Fpasswd", "C:/x.bin", "C:%5C%5Cx.bin", "//host/x.bin", "file:///etc/passwd"] {
        write_scene(&place, uri);
        let words = if uri.starts_with("file") { "is a file: URI" } else { "is an absolute path" };
        place.fails(1, words, &["info", "scenes/s.gltf"]);
        place.fails(1, words, &["info", "scenes/s.gltf", "--allow-outside"]);
    }
}

#[test]
#[cfg(unix)]
fn links_are_followed_before_a_file_is_said_to_lie_in_the_folder() {
    use std::os::unix::fs::symlink;
    let place = surroundings();
    let links = [
        ("../x.bin", "scenes/out.bin"),
        ("sub/x.bin", "scenes/in.bin"),
        ("../other", "scenes/out"),
        ("sub", "scenes/in"),
        ("missing.bin", "scenes/broken.bin"),
    ];
    for (to, link) in links {
        symlink(to, place.path(link)).expect("a link");
    }
    symlink("scenes", place.path("link to scenes")).expect("a link");
    for (uri, is_inside) in
        [("out.bin", false), ("out/x.bin", false), ("in.bin", true), ("in/x.bin", true), ("x.bin", true)]
    {
        write_scene(&place, uri);
        // The scene's own folder may be reached through a link.
        for scene in ["scenes/s.gltf", "link to scenes/s.gltf"] {
            if is_inside {
                place.ok(&["info", scene]);
            } else {
                place.fails(1, &format!("\"{uri}\" lies outside of"), &["info", scene]);
            }
            place.ok(&["info", scene, "--allow-outside"]);
        }
    }
    write_scene(&place, "broken.bin");
    place.fails(1, "No such file", &["info", "scenes/s.gltf"]);
    // If the scene is a link, files beside it are those in the link's folder.
    write_scene(&place, "x.bin");
    symlink("../scenes/s.gltf", place.path("other/linked.gltf")).expect("a link");
    place.ok(&["info", "other/linked.gltf"]);
    fs::remove_file(place.path("other/x.bin")).expect("a file");
    place.fails(1, "cannot read \"x.bin\"", &["info", "other/linked.gltf"]);
}

/// A textured triangle as a GLB.
fn textured(picture: &[u8]) -> Vec<u8> {
    let mut bin = positions();
    bin.extend(picture);
    bin.resize(bin.len().next_multiple_of(4), 0);
    let json = triangle("")
        .replace(r#""buffers":[{"byteLength":36,"uri":""}]"#, &format!(r#""buffers":[{{"byteLength":{}}}]"#, bin.len()))
        .replace(
            r#""bufferViews":[{"buffer":0,"byteLength":36}]"#,
            &format!(
                r#""bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":{}}}],"images":[{{"bufferView":1}}],"textures":[{{"source":0}}],"materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}]"#,
                picture.len()
            ),
        )
        .replace(r#"{"POSITION":0}"#, r#"{"POSITION":0},"material":0"#);
    let mut json = json.into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((28 + json.len() as u32 + bin.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &bin)] {
        glb.extend((chunk.len() as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(chunk);
    }
    glb
}

/// The header of a grey PNG with sides of this many texels, without image data.
fn png_head(side: u32) -> Vec<u8> {
    let mut body = b"IHDR".to_vec();
    body.extend(side.to_be_bytes());
    body.extend(side.to_be_bytes());
    body.extend([8, 0, 0, 0, 0]);
    let crc = !body.iter().fold(!0_u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 })
    });
    [b"\x89PNG\r\n\x1a\n\0\0\0\r", &body[..], &crc.to_be_bytes(), b"\0\0\0\x01IDATx"].concat()
}

/// Runs with at most this many MiB of address space.
#[cfg(unix)]
fn limited(place: &Place, mib: u64, arguments: &[&str]) -> Outcome {
    let shell = format!("ulimit -v {}; exec \"$0\" \"$@\"", mib * 1024);
    let mut command = std::process::Command::new("sh");
    command.current_dir(place.path("")).args(["-c", &shell, env!("CARGO_BIN_EXE_raystep")]).args(arguments);
    // glibc reserves 64 MiB of address space for each thread that allocates while another does: a matter of chance.
    command.env("MALLOC_ARENA_MAX", "1");
    outcome(&mut command)
}

#[test]
#[cfg(unix)]
fn pictures_that_cannot_be_held_are_left_out_by_their_headers() {
    let place = Place::new();
    for side in [30_000, 22_000, 12_000] {
        fs::write(place.path(format!("{side}.glb")), textured(&png_head(side))).expect("a scene");
    }
    let render = |scene: &'static str| ["render", scene, "-o", "a.png", "--size", "8x8", "--device", "cpu"];
    let noted = |outcome: &Outcome, words: &str| {
        assert!(outcome.code == Some(0) && outcome.stderr.contains(words), "{words}: {outcome:?}");
    };
    // More than any device can bind, regardless of memory.
    let words = "images[0]: is 30000 x 30000 texels, and 900000000 texels";
    for mib in [4096, 8192] {
        noted(&limited(&place, mib, &render("30000.glb")), words);
    }
    noted(&place.ok(&[&render("30000.glb")[..], &["--max-memory", "64G"]].concat()), words);
    // Above --max-memory, and then above the available memory.
    let outcome = place.ok(&[&render("22000.glb")[..], &["--max-memory", "4G"]].concat());
    noted(&outcome, "--max-memory, currently 4.0 GiB, raises the limit");
    let outcome = place.ok(&[&render("12000.glb")[..], &["--max-memory", "1G"]].concat());
    noted(&outcome, "takes 1728000000 more bytes");
    for (mib, scene) in [(4096, "22000.glb"), (512, "12000.glb")] {
        // The larger one fits in memory, but then has no image data.
        let words =
            if mib == 512 { "images[0]: not enough memory for the 576000000 bytes" } else { "cannot be decoded" };
        noted(&limited(&place, mib, &render(scene)), words);
    }
}

#[test]
fn a_picture_outside_is_left_out_and_how_to_allow_it_is_said() {
    let place = surroundings();
    let picture = textured(b"");
    let json = String::from_utf8_lossy(&picture[20..picture.len() - 8 - positions().len()]).into_owned();
    let json =
        json.trim_end().replace(r#""buffers":[{"byteLength":36}]"#, r#""buffers":[{"byteLength":36,"uri":"x.bin"}]"#);
    for (uri, words) in [
        ("../picture.png", "\"../picture.png\" lies outside of"),
        ("..\\\\picture.png", "\"..\\picture.png\" lies outside of"),
        // Whether it exists is not told.
        ("../missing.png", "\"../missing.png\" lies outside of"),
    ] {
        let scene = json.replace(r#""images":[{"bufferView":1}]"#, &format!(r#""images":[{{"uri":"{uri}"}}]"#));
        fs::write(place.path("scenes/s.gltf"), scene).expect("a scene");
        let outcome = place.ok(&["info", "scenes/s.gltf"]);
        let note = outcome.stdout.lines().find(|line| line.contains(words)).unwrap_or_else(|| panic!("{outcome:?}"));
        assert!(note.contains("; --allow-outside lets a scene read such files"), "{note}");
        let allowed = place.ok(&["info", "scenes/s.gltf", "--allow-outside"]);
        assert!(!allowed.stdout.contains("outside"), "{allowed:?}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_large_picture_is_read_in_less_than_twice_its_texels() {
    const SIDE: u32 = 6000;
    let place = Place::new();
    let mut png = std::io::Cursor::new(Vec::new());
    let deep = image::DynamicImage::ImageLuma16(image::ImageBuffer::new(SIDE, SIDE));
    deep.write_to(&mut png, image::ImageFormat::Png).expect("a picture");
    let mut jpeg = std::io::Cursor::new(Vec::new());
    let grey = image::DynamicImage::ImageRgb8(image::ImageBuffer::new(SIDE, SIDE));
    grey.write_to(&mut jpeg, image::ImageFormat::Jpeg).expect("a picture");
    for (name, picture) in [("png.glb", png), ("jpeg.glb", jpeg)] {
        fs::write(place.path(name), textured(picture.get_ref())).expect("a scene");
        // 137 MiB of texels, once and not twice; the program and its libraries take some 70 MiB of address space.
        let outcome = limited(&place, 137 + 120, &["info", name]);
        assert_eq!(outcome.code, Some(0), "{name}: {outcome:?}");
    }
}

#[test]
fn every_command_that_opens_a_scene_has_both_options() {
    let place = surroundings();
    write_scene(&place, "../x.bin");
    let scene = "scenes/s.gltf";
    let small = ["--size", "8x8", "--device", "cpu"];
    let commands: [&[&str]; 8] = [
        &["info", scene],
        &["plan", scene, small[0], small[1], small[2], small[3]],
        &["render", scene, "-o", "a.png", small[0], small[1], small[2], small[3]],
        &["trace", scene, "--pixel", "4,4", small[0], small[1], small[2], small[3]],
        &["dump", scene, "-o", "dump", small[0], small[1], small[2], small[3]],
        &["bench", scene, "-o", "bench", "--sizes", "8x8", "--repeats", "1", "--warmups", "0", "--device", "cpu"],
        &["report", scene, "-o", "report", "--quick", "--device", "cpu"],
        &["inspect", scene, "--screenshot", "w.png"],
    ];
    for arguments in commands {
        place.fails(1, "\"../x.bin\" lies outside of", arguments);
        let allowed = [arguments, &["--allow-outside"]].concat();
        place.fails(
            1,
            "--max-memory, currently 700 bytes, raises the limit",
            &[&allowed[..], &["--max-memory", "700"]].concat(),
        );
        for wrong in ["0", "-1", "4X", "G", "1.5G", "99999999999999999999", "999999999T"] {
            let size = format!("--max-memory={wrong}");
            place.fails(2, "such as 512M, 4G", &[&allowed[..], &[&size]].concat());
        }
        if !["report", "inspect"].contains(&arguments[0]) {
            place.ok(&[&allowed[..], &["--max-memory", "1m"]].concat());
        }
    }
    // A link to a view does not change what may be read.
    let link = format!("raystep:1?scene={scene}&pixel=4,4&size=8x8&device=cpu");
    place.fails(1, "--allow-outside", &["trace", "--link", &link]);
    place.ok(&["trace", "--link", &link, "--allow-outside"]);
}
