//! PLY: what is read, what is left out with a note, and the errors.

#![allow(clippy::unwrap_used, reason = "a test that cannot make its input has failed")]

use crate::mesh_common::{TRIANGLE, error, notes, ply, read, scene};

const HEADER: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
const SQUARE: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
const BODY: &str = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n";

fn ascii(body: &str) -> String {
    format!("ply\nformat ascii 1.0\ncomment a test\n{HEADER}{body}")
}

/// A file of three vertices with these properties after their position, and one face.
fn with(properties: &str, values: [&str; 3]) -> String {
    let [a, b, c] = values;
    format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{properties}\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 {a}\n1 0 0 {b}\n0 1 0 {c}\n3 0 1 2\n"
    )
}

/// The square as a binary file; `order` reverses a little-endian number if necessary.
fn binary(format: &str, order: fn(&mut [u8])) -> Vec<u8> {
    let mut bytes = format!("ply\nformat {format} 1.0\n{HEADER}").into_bytes();
    for value in [0f32, 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.] {
        let mut v = value.to_le_bytes();
        order(&mut v);
        bytes.extend(v);
    }
    bytes.push(4);
    for index in 0..4i32 {
        let mut v = index.to_le_bytes();
        order(&mut v);
        bytes.extend(v);
    }
    bytes
}

#[test]
fn all_three_formats_are_read() {
    let wanted = [[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.]], [[0., 0., 0.], [1., 1., 0.], [0., 1., 0.]]];
    let text = ascii(&format!("{SQUARE}4 0 1 2 3"));
    for bytes in [
        text.clone().into_bytes(),
        text.replace('\n', "\r\n").into_bytes(),
        binary("binary_little_endian", |_| ()),
        binary("binary_big_endian", |b| b.reverse()),
    ] {
        let scene = scene("square.ply", &bytes);
        assert_eq!((scene.name.as_str(), scene.triangles.as_slice()), ("square", wanted.as_slice()));
        assert!(scene.notes.is_empty());
    }
}

#[test]
fn blanks_lines_and_comments_anywhere_are_passed_over() {
    let text = ascii(BODY);
    for text in [
        format!("\u{feff}{text}"),
        format!("\n{text}"),
        text.replace('\n', "\r"),
        text.replace('\n', " \t\n"),
        text.replace('\n', "\n\n"),
        text.replace("format", "comment first\nobj_info num_cols 3\nformat"),
        text.replace("end_header", "comment element face 9\nobj_info x\nend_header"),
        text.replace("property float y", "comment\n\nobj_info\nproperty float32 y"),
        text.replace("0 0 0\n", "0\n0\n\n0\n"),
        text.replace("3 0 1 2\n", "3\n0 1\n2\n"),
        // More than the header promises.
        text.replace("0 0 0\n", "0 0 0 7 x\n").replace("3 0 1 2\n", "3 0 1 2 6 0.5 1\n"),
        text.replace("vertex_indices", "vertex_index"),
        format!("{text}\n\n  \n"),
        text.trim_end().to_owned(),
    ] {
        assert_eq!(ply(&text).triangles, TRIANGLE, "{text:?}");
    }
}

#[test]
fn a_binary_payload_may_start_with_any_byte() {
    // -4.7e-38 and the like: the first byte is the end of a line.
    for (first, end) in [(b'\n', "\n"), (b'\r', "\n"), (b'\n', "\r"), (b'\r', "\r"), (b'\n', "\r\n"), (b' ', "\n")] {
        let good = binary("binary_little_endian", |_| ());
        let header = good.len() - 48 - 17;
        let mut bytes = String::from_utf8_lossy(&good[..header]).replace('\n', end).into_bytes();
        bytes.extend(&good[header..]);
        let first_byte = bytes.len() - 48 - 17;
        bytes[first_byte] = first;
        let x = f32::from_le_bytes([first, 0, 0, 0]);
        assert_eq!(scene("a.ply", &bytes).triangles[0][0], [x, 0., 0.], "{first} {end:?}");
    }
}

#[test]
fn attributes_are_read_and_other_elements_passed_over() {
    let text = "ply\nformat ascii 1.0\nelement edge 1\nproperty int a\nproperty list uchar float w\n\
        element nothing 4000000000\n\
        element vertex 3\nproperty double x\nproperty double y\nproperty double z\nproperty float nx\nproperty float ny\n\
        property float nz\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty float s\nproperty float t\n\
        property list uchar int neighbours\nelement face 1\nproperty uchar flag\nproperty list uchar ushort vertex_index\n\
        property list uchar float texcoord\nend_header\n\
        7 2 1 2\n0 0 0 0 0 3 255 0 188 0.5 0.25 1 9\n1 0 0 0 0 3 255 0 188 0.5 0.25 0\n0 1 0 0 0 3 255 0 188 0.5 0.25 0\n\
        9 3 0 1 2 2 0.5 0.5\n";
    let scene = ply(text);
    assert_eq!(scene.triangles, TRIANGLE);
    assert_eq!(scene.normals.unwrap(), [[[0.0, 0.0, 1.0]; 3]]);
    assert_eq!(scene.texcoords.unwrap(), [[[0.5, 0.75]; 3]]);
    let color = scene.colors.unwrap()[0][0];
    // IEC 61966-2-1: 188/255 is 0.5029.
    assert!(color[0] == 1.0 && color[1] == 0.0 && (color[2] - 0.5029).abs() < 1e-4, "{color:?}");
}

/// Bytes of these numbers, which are of any type.
fn bytes_of(numbers: &[(&str, f64)], is_big: bool) -> Vec<u8> {
    let mut out = Vec::new();
    for &(kind, v) in numbers {
        let mut bytes = match kind {
            "char" => (v as i8).to_le_bytes().to_vec(),
            "uchar" => (v as u8).to_le_bytes().to_vec(),
            "short" => (v as i16).to_le_bytes().to_vec(),
            "ushort" => (v as u16).to_le_bytes().to_vec(),
            "int" => (v as i32).to_le_bytes().to_vec(),
            "uint" => (v as u32).to_le_bytes().to_vec(),
            "float" => (v as f32).to_le_bytes().to_vec(),
            _ => v.to_le_bytes().to_vec(),
        };
        if is_big {
            bytes.reverse();
        }
        out.extend(bytes);
    }
    out
}

#[test]
fn values_of_every_type_stand_anywhere() {
    for kind in ["char", "uchar", "short", "ushort", "int", "uint", "float", "double"] {
        for is_big in [false, true] {
            let order = if is_big { "big" } else { "little" };
            let mut bytes = format!(
                "ply\nformat binary_{order}_endian 1.0\nelement before 2\nproperty {kind} a\nproperty list {kind} {kind} b\n\
                 element vertex 3\nproperty list {kind} {kind} c\nproperty {kind} x\nproperty {kind} y\nproperty {kind} d\n\
                 property {kind} z\nelement plain 3\nproperty {kind} a\nproperty {kind} b\nelement face 1\nproperty {kind} e\n\
                 property list {kind} {kind} vertex_indices\nproperty list {kind} {kind} f\nend_header\n"
            )
            .into_bytes();
            let numbers = [
                [9., 2., 1., 1.].as_slice(),
                &[9., 0.],
                &[1., 7., 0., 0., 9., 0.],
                &[0., 1., 0., 9., 0.],
                &[2., 7., 7., 0., 1., 9., 0.],
                &[5., 5., 5., 5., 5., 5.],
                &[9., 3., 0., 1., 2., 1., 8.],
            ]
            .concat();
            let numbers: Vec<_> = numbers.into_iter().map(|v| (kind, v)).collect();
            bytes.extend(bytes_of(&numbers, is_big));
            assert_eq!(scene("a.ply", &bytes).triangles, TRIANGLE, "{kind} {order}");
        }
    }
}

#[test]
fn what_follows_the_needed_elements_may_be_wrong() {
    let more = |text: &str| ascii(BODY).replace("end_header", &format!("{text}\nend_header"));
    for text in [
        more("element edge 99\nproperty int a"),
        more("element edge 4000000000\nproperty list uchar int a") + "1 x",
        more("element camera 1\nproperty float view_px") + "nan(ind)",
    ] {
        assert_eq!(ply(&text).triangles, TRIANGLE, "{text}");
    }
    let mut bytes = binary("binary_little_endian", |_| ());
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let at = text.find("end_header").unwrap();
    bytes.splice(at..at, *b"element edge 7\nproperty list uint int a\n");
    bytes.extend([0xff; 9]);
    assert_eq!(scene("a.ply", &bytes).triangles.len(), 2);
}

#[test]
fn strips_are_read_with_alternate_windings_and_restarts() {
    let strips = |kind: &str, list: &str| {
        let list = format!("{} {list}", list.split(' ').count());
        let header = HEADER.replace("face", "tristrips").replace("uchar int", &format!("int {kind}"));
        ply(&format!("ply\nformat ascii 1.0\n{header}0 0 0\n1 0 0\n0 1 0\n1 1 0\n{list}\n"))
    };
    assert_eq!(strips("int", "0 1 2 -1 3").triangles, TRIANGLE);
    // Both triangles of the strip face +Z.
    let second = [[1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
    assert_eq!(strips("int", "0 1 2 3").triangles, [TRIANGLE[0], second]);
    for (kind, end) in [("int", "-1"), ("uchar", "255"), ("ushort", "65535"), ("uint", "4294967295"), ("float", "-1")] {
        let scene = strips(kind, &format!("0 1 2 {end} 0 1 2 3 {end} {end} 3"));
        assert_eq!(scene.triangles, [TRIANGLE[0], TRIANGLE[0], second], "{kind}");
        assert!(scene.notes.is_empty());
    }
    // Repeated vertices join strips.
    assert_eq!(strips("int", "0 1 2 2 0 0 0 1 2").triangles, [TRIANGLE[0], TRIANGLE[0]]);
    let [a, b, c] = TRIANGLE[0];
    assert_eq!(strips("int", "0 1 2 2 0 0 1 2").triangles, [TRIANGLE[0], [a, c, b]]);
    let some = strips("int", "0 1 2 9 1");
    assert_eq!(some.triangles, TRIANGLE);
    assert_eq!(notes(&some), ["2 faces have a corner that is no vertex of the file: left out"]);
}

#[test]
fn numbers_that_nothing_needs_do_not_refuse_a_file() {
    for word in ["nan", "-nan(ind)", "1.#QNAN", "inf", "1e40", "x"] {
        let unused = ascii(BODY).replace("1 1 0\n", &format!("{word} 1 0\n"));
        assert_eq!(ply(&unused).triangles, TRIANGLE, "{word}");
        assert_eq!(notes(&ply(&unused)), ["1 vertex has a position that is not finite in 32 bits: not drawn"]);
        for (properties, note) in [
            ("property float nx\nproperty float ny\nproperty float nz\n", "1 normal has no direction"),
            ("property float s\nproperty float t\nproperty float other\n", "1 texture coordinate has parts"),
        ] {
            let scene = ply(&with(properties, [&format!("{word} 0 0"), "0 0 1", "0 0 1"]));
            assert!(scene.triangles == TRIANGLE && scene.notes[0].0.starts_with(note), "{word}: {:?}", scene.notes);
        }
        let scene = ply(&with("property float quality\n", [word; 3]));
        assert!(scene.triangles == TRIANGLE && scene.notes.is_empty());
    }
}

#[test]
fn faces_that_cannot_be_drawn_are_left_out_and_counted() {
    for (face, note) in [
        ("2 0 1", "1 face has fewer than 3 corners: left out"),
        ("0", "1 face has fewer than 3 corners: left out"),
        ("3 0 1 4", "1 face has a corner that is no vertex of the file: left out"),
        ("3 0 1 -1", "1 face has a corner that is no vertex of the file: left out"),
        ("3 0 1 x", "1 face has a corner that is no vertex of the file: left out"),
        ("3 0 1 1.5", "1 face has a corner that is no vertex of the file: left out"),
        ("3 0 1 5000000000", "1 face has a corner that is no vertex of the file: left out"),
    ] {
        let scene = ply(&ascii(&format!("0 0 0\n1 0 0\n0 1 0\n1 1 0\n{face}\n3 0 1 2\n")).replace("face 1", "face 2"));
        assert_eq!((notes(&scene), scene.triangles.as_slice()), (vec![note], TRIANGLE.as_slice()), "{face}");
    }
    let scene = ply(&ascii("0 0 0\n1 0 0\n0 1 0\nnan 1 0\n3 0 1 2\n3 0 1 3\n").replace("face 1", "face 2"));
    assert_eq!(scene.triangles, TRIANGLE);
    assert_eq!(notes(&scene)[1], "1 face has a corner that is not finite in 32 bits: left out");
}

#[test]
fn colors_have_the_scale_of_their_type_unless_the_file_shows_another() {
    let color = |kind: &str, value: &str| {
        let properties = ["red", "green", "blue"].map(|name| format!("property {kind} {name}\n")).concat();
        let scene = ply(&with(&properties, [value; 3]));
        let colors = scene.colors.as_ref().unwrap().as_flattened();
        assert!(colors.iter().all(|color| *color == colors[0]));
        (colors[0], notes(&scene).join("; "))
    };
    let note = "vertex colours are read as 0 to 255, since the largest is 128";
    // 128 64 32 of 255 are linear 0.2159, 0.0513, 0.0144.
    for (kind, value, wanted) in [
        ("uchar", "128 64 32", ""),
        ("ushort", "32896 16448 8224", ""),
        ("int", "1077952512 538976256 269488128", ""),
        ("float", "0.50196 0.25098 0.12549", ""),
        ("ushort", "128 64 32", note),
        ("int", "128 64 32", note),
        ("float", "128 64 32", note),
        ("double", "128 64 32", note),
    ] {
        let (color, notes) = color(kind, value);
        assert!(color.iter().zip([0.2159, 0.0513, 0.0144]).all(|(a, b)| (a - b).abs() < 1e-4), "{kind}: {color:?}");
        assert_eq!(notes, wanted, "{kind} {value}");
    }
    assert_eq!(
        color("float", "1 nan 0"),
        ([1., 1., 0.], "3 vertex colours have parts that are no numbers: drawn as 1".into())
    );
    assert_eq!(color("float", "1 -2 inf").0, [1., 0., 1.]);
    assert_eq!(color("float", "0 0 1.000001"), ([0., 0., 1.], String::new()));
}

#[test]
fn doubles_far_from_the_origin_keep_their_shape() {
    let body = "12958095.5 1e7 0\n12958095.875 1e7 0\n12958095.5 10000000.625 0\n0 0 0\n3 0 1 2\n";
    let scene = ply(&ascii(body).replace("float", "double"));
    let [a, b, c] = scene.triangles[0];
    assert_eq!((b[0] - a[0], c[1] - a[1]), (0.375, 0.625));
    assert_eq!(scene.offset.x + f64::from(a[0]), 12_958_095.5);
}

#[test]
fn a_wrong_file_is_one_line_that_says_what_is_wrong() {
    let claim = |what: &str, count: &str| {
        let text = ascii(&format!("{SQUARE}3 0 1 2\n"));
        text.replace(what, &format!("{} {count}", what.rsplit_once(' ').unwrap().0)).into_bytes()
    };
    let strips = ascii(SQUARE).replace("face", "polygons").replace("element vertex", "element edge 2\nelement vertex");
    let lists = |count: &str| format!("{SQUARE}{count} 0 1 2\n");
    for (bytes, wanted) in [
        (vec![], "the file is empty"),
        (b"not a ply".to_vec(), "the file does not start with a line 'ply'"),
        (b"ply x\n".to_vec(), "the file does not start with a line 'ply'"),
        (b"ply\nformat ascii 1.0\n".to_vec(), "the file ends before the line 'end_header'"),
        (b"ply\nformat ascii 1.0\nelement vertex -1\n".to_vec(), "line 3: '-1' is not a number of elements"),
        (b"ply\r\rformat text\r".to_vec(), "line 3: 'text' is not a format; expected ascii, binary_little_endian"),
        (b"ply\nformat ascii 1.0\nproperty int x\n".to_vec(), "line 3: a property before any element"),
        (b"ply\nelement vertex 1\nproperty half x\n".to_vec(), "line 3: 'half' is not a type of numbers"),
        (b"ply\nend_header\n".to_vec(), "the header has no line 'format'"),
        (b"ply\nformat ascii 1.0\nend_header\n".to_vec(), "there are no vertices with a property 'x'"),
        (
            strips.into_bytes(),
            "there are no faces with a list 'vertex_indices', only 2 of 'edge', 4 of 'vertex', 1 of 'polygons'; \
             only faces and tristrips can be traced",
        ),
        (claim("face 1", "0"), "there are no faces with a list 'vertex_indices', only 4 of 'vertex';"),
        (
            claim("vertex 4", "4000000000"),
            "the 4000000000 of 'vertex' take at least 24000000000 bytes, but only 32 are left",
        ),
        (claim("vertex 4", "18446744073709551615"), "the 18446744073709551615 of 'vertex' take at least"),
        (claim("vertex 4", "18446744073709551616"), "line 4: '18446744073709551616' is not a number of elements"),
        (claim("face 1", "1000000"), "the 1000000 of 'face' take at least 2000000 bytes"),
        (claim("face 1", "4"), "face 1: the file ends before it; the header promises 4"),
        (ascii(&lists("x")).into_bytes(), "line 15: 'x' is not the length of a list"),
        (ascii(&lists("-1")).into_bytes(), "line 15: '-1' is not the length of a list"),
        (ascii(&lists("2.5")).into_bytes(), "line 15: '2.5' is not the length of a list"),
        (ascii(&lists("4000000000")).into_bytes(), "face 0: the file ends before it"),
        (ascii(&lists("2")).into_bytes(), "face 0: it has fewer than 3 corners, and no other face can be drawn"),
        (
            ascii(&format!("{SQUARE}3 0 1 4\n")).into_bytes(),
            "face 0: its corner 3 is none of the 4 vertices; no other face can be drawn",
        ),
        (
            ascii("0 0 1e39\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n").into_bytes(),
            "face 0: the position of its corner 1 is not finite in 32 bits, and no other face can be drawn",
        ),
    ] {
        let error = error("bad.ply", &bytes);
        assert!(error.starts_with(wanted), "{error}\nof {}", String::from_utf8_lossy(&bytes));
    }
}

#[test]
fn a_file_cut_or_flipped_anywhere_never_panics() {
    let good = binary("binary_little_endian", |_| ());
    for length in 0..good.len() {
        assert!(read("cut.ply", &good[..length]).is_err(), "{length} bytes passed");
    }
    for at in 0..good.len() {
        for bit in 0..8 {
            let mut bytes = good.clone();
            bytes[at] ^= 1 << bit;
            let _ = read("flipped.ply", &bytes);
        }
    }
    let huge_list = HEADER.replace("uchar int", "uint int");
    let mut bytes = format!("ply\nformat binary_little_endian 1.0\n{huge_list}").into_bytes();
    bytes.extend([0; 48]);
    bytes.extend(u32::MAX.to_le_bytes());
    assert_eq!(error("list.ply", &bytes), "face 0: the file ends before it; the header promises 1");
}
