//! OBJ and PLY: what is read, and the errors for invalid files.

#![allow(clippy::unwrap_used, reason = "a test that cannot make its input has failed")]

use raystep_scenes::Scene;
use raystep_scenes::convert::{obj, ply};

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn obj_ok(text: &str) -> Scene {
    obj("dir/test.obj", text.as_bytes()).unwrap()
}

#[test]
fn obj_polygons_are_fans() {
    let scene = obj_ok(&format!("{SQUARE}# a comment\no thing\nf 1 2 3 4\n"));
    assert_eq!(scene.name, "test");
    assert_eq!(
        scene.triangles,
        [[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.]], [[0., 0., 0.], [1., 1., 0.], [0., 1., 0.]]]
    );
    assert_eq!(scene.triangle_materials, [0, 0]);
    assert!(scene.normals.is_none() && scene.texcoords.is_none() && scene.colors.is_none());
    assert!(scene.materials[0].double_sided);
}

#[test]
fn obj_indices_count_from_both_ends_and_lines_may_continue() {
    let scene = obj_ok(&format!("{SQUARE}f -4 -3 \\\r\n -2\r\n"));
    assert_eq!(scene.triangles, [[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.]]]);
}

#[test]
fn obj_attributes_are_read_and_missing_ones_made_up() {
    let scene = obj_ok(&format!(
        "{SQUARE}vn 0 0 2\nvt 0.25 0.25\nf 1 2 3\nf 1/1/1 3/1/1 4/1/1\nf 1//1 2//1 3//1\nf 1/1 2/1 3/1\n"
    ));
    let normals = scene.normals.unwrap();
    assert!(normals.as_flattened().iter().all(|&n| n == [0.0, 0.0, 1.0]), "{normals:?}");
    // v grows upwards in OBJ and downwards in glTF.
    assert_eq!(scene.texcoords.unwrap(), [[[0.0; 2]; 3], [[0.25, 0.75]; 3], [[0.0; 2]; 3], [[0.25, 0.75]; 3]]);
    let scene = obj_ok("v 0 0 0 1 0 0\nv 1 0 0 0.5 0 0\nv 0 1 0 0 0 1\nmtllib a b.mtl\nf 1 2 3\n");
    let colors = scene.colors.unwrap();
    assert_eq!(colors[0][0], [1.0, 0.0, 0.0]);
    // IEC 61966-2-1: 0.5 is 0.2140.
    assert!((colors[0][1][0] - 0.2140).abs() < 1e-4);
    assert!(scene.notes[0].0.contains("a b.mtl"));
}

#[test]
fn obj_takes_bytes_that_are_not_utf8() {
    let bytes = [b"# M\xfcller\no \xff\n".as_slice(), SQUARE.as_bytes(), b"f 1 2 3"].concat();
    assert_eq!(obj("a.obj", &bytes).unwrap().triangles.len(), 1);
}

#[test]
fn bad_obj_says_what_where_and_what_would_be_right() {
    for (text, wanted) in [
        ("", "bad.obj: there is no face (a line like 'f 1 2 3'); only faces can be traced"),
        ("v 1 2\n", "bad.obj, line 1: too few numbers; right would be 'v x y z'"),
        ("\nv 1 2 x\n", "bad.obj, line 2: 'x' is not a number"),
        ("v 1 2 nan\n", "bad.obj, line 1: 'nan' is not finite in 32 bits"),
        ("v 1 2 1e39\n", "bad.obj, line 1: '1e39' is not finite in 32 bits"),
        ("f 1 2 3\n", "bad.obj, line 1: vertex (v) 1 does not exist; there is none before this line"),
        ("v 0 0 0\nf 1 1 2\n", "bad.obj, line 2: vertex (v) 2 does not exist; before this line there are 1 to 1"),
        ("v 0 0 0\nf 1 1 0\n", "bad.obj, line 2: vertex (v) 0 does not exist; before this line there are 1 to 1"),
        ("v 0 0 0\nf 1 1 -2\n", "bad.obj, line 2: vertex (v) -2 does not exist; before this line there are 1 to 1"),
        ("v 0 0 0\nf 1 1\n", "bad.obj, line 2: a face of 2, but it needs at least 3 corners"),
        ("v 0 0 0\nf 1 1 1.5\n", "bad.obj, line 2: '1.5' is not the number of a vertex (v)"),
        (
            "v 0 0 0\nf 1//9223372036854775807 1 1\n",
            "bad.obj, line 2: normal (vn) 9223372036854775807 does not exist; there is none before this line",
        ),
        (
            "v 0 0 0\nf 1/-9223372036854775808 1 1\n",
            "bad.obj, line 2: texture coordinate (vt) -9223372036854775808 does not exist; there is none before this line",
        ),
        (
            "v 0 0 0\nf 1/1/1/1 1 1\n",
            "bad.obj, line 2: '1/1/1/1' has too many slashes; a corner is v, v/vt, v//vn or v/vt/vn",
        ),
    ] {
        // Slashes are counted before indices are looked up.
        assert_eq!(obj("bad.obj", text.as_bytes()).unwrap_err().to_string(), wanted);
    }
}

const HEADER: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";

fn ascii(body: &str) -> Vec<u8> {
    format!("ply\nformat ascii 1.0\ncomment a test\n{HEADER}{body}").into_bytes()
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
fn ply_reads_all_three_formats() {
    let wanted = [[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.]], [[0., 0., 0.], [1., 1., 0.], [0., 1., 0.]]];
    for bytes in [
        ascii("0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3"),
        ascii("0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n")
            .iter()
            .flat_map(|&b| if b == b'\n' { vec![13, 10] } else { vec![b] })
            .collect(),
        binary("binary_little_endian", |_| ()),
        binary("binary_big_endian", |b| b.reverse()),
    ] {
        let scene = ply("a/square.ply", &bytes).unwrap();
        assert_eq!((scene.name.as_str(), scene.triangles.as_slice()), ("square", wanted.as_slice()));
    }
}

#[test]
fn ply_attributes_are_read_and_other_elements_passed_over() {
    let text = "ply\nformat ascii 1.0\nelement edge 1\nproperty int a\nproperty list uchar float w\n\
        element vertex 3\nproperty double x\nproperty double y\nproperty double z\nproperty float nx\nproperty float ny\n\
        property float nz\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty float s\nproperty float t\n\
        property list uchar int neighbours\nelement face 1\nproperty uchar flag\nproperty list uchar ushort vertex_index\nend_header\n\
        7 2 1 2\n0 0 0 0 0 3 255 0 188 0.5 0.25 1 9\n1 0 0 0 0 3 255 0 188 0.5 0.25 0\n0 1 0 0 0 3 255 0 188 0.5 0.25 0\n9 3 0 1 2\n";
    let scene = ply("a.ply", text.as_bytes()).unwrap();
    assert_eq!(scene.triangles, [[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]]]);
    assert_eq!(scene.normals.unwrap(), [[[0.0, 0.0, 1.0]; 3]]);
    assert_eq!(scene.texcoords.unwrap(), [[[0.5, 0.75]; 3]]);
    let color = scene.colors.unwrap()[0][0];
    // IEC 61966-2-1: 188/255 is 0.5029.
    assert!(color[0] == 1.0 && color[1] == 0.0 && (color[2] - 0.5029).abs() < 1e-4, "{color:?}");
}

#[test]
fn bad_ply_is_one_line_that_says_what_is_wrong() {
    let square = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    let claim = |what: &str, count: &str| {
        let text = String::from_utf8(ascii(&format!("{square}3 0 1 2\n"))).unwrap();
        text.replace(what, &format!("{} {count}", what.rsplit_once(' ').unwrap().0)).into_bytes()
    };
    let strips = format!("ply\nformat ascii 1.0\n{}", HEADER.replace("face", "tristrips"));
    let nothing = format!(
        "ply\nformat binary_little_endian 1.0\n{}",
        HEADER.replace("element face", "element x 4000000000\nelement face")
    );
    for (bytes, wanted) in [
        (vec![], "bad.ply: "),
        (b"solid".to_vec(), "bad.ply: "),
        (b"ply\nformat ascii 1.0\nelement vertex -1\n".to_vec(), "bad.ply: Line 3"),
        (b"ply\nformat ascii 1.0\nend_header\n".to_vec(), "bad.ply: there are no vertices with a property 'x'"),
        (strips.into_bytes(), "bad.ply: there are no faces with a property 'vertex_indices'"),
        (nothing.into_bytes(), "bad.ply: element 'x' has 4000000000 entries but no property"),
        (
            claim("vertex 4", "4000000000"),
            "bad.ply: the header promises at least 24000000002 bytes of elements, but only 32 follow it",
        ),
        (claim("vertex 4", "18446744073709551615"), "bad.ply: the header promises at least"),
        (claim("face 1", "1000000"), "bad.ply: the header promises at least"),
        (ascii(&format!("{square}3 0 1\n")), "bad.ply: Line "),
        (ascii(&format!("{square}3 0 1 x\n")), "bad.ply: Line "),
        (ascii(&format!("{square}2 0 1\n")), "bad.ply: face 0 has 2 corners, but needs at least 3"),
        (ascii(&format!("{square}3 0 1 4\n")), "bad.ply: face 0 names vertex 4, but there are 4, counted from 0"),
        (ascii(&format!("{square}3 0 1 -1\n")), "bad.ply: face 0 names vertex -1, but there are 4, counted from 0"),
        (
            ascii("0 0 1e39\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n"),
            "bad.ply: face 0 has corner 0, whose position is not finite",
        ),
        (ascii(&format!("{square}4000000000 0 1 2\n")), "bad.ply: Line "),
    ] {
        let shown = String::from_utf8_lossy(&bytes).into_owned();
        let error = ply("bad.ply", &bytes).expect_err(&shown).to_string();
        assert!(error.starts_with(wanted) && !error.contains('\n') && error.len() < 300, "{error}\nof {shown}");
    }
}

#[test]
fn a_ply_cut_or_flipped_anywhere_never_panics() {
    let good = binary("binary_little_endian", |_| ());
    for length in 0..good.len() {
        assert!(ply("cut.ply", &good[..length]).is_err(), "{length} bytes passed");
    }
    for at in 0..good.len() {
        for bit in 0..8 {
            let mut bytes = good.clone();
            bytes[at] ^= 1 << bit;
            let _ = ply("flipped.ply", &bytes);
        }
    }
    let huge_list = [HEADER.replace("uchar int", "uint int"), String::new()].concat();
    let mut bytes = format!("ply\nformat binary_little_endian 1.0\n{huge_list}").into_bytes();
    bytes.extend([0; 48]);
    bytes.extend(u32::MAX.to_le_bytes());
    assert!(ply("list.ply", &bytes).is_err());
}

#[test]
fn an_obj_cut_or_flipped_anywhere_never_panics() {
    let good = format!("{SQUARE}vt 0 1\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\nf -1 -2 -3\n");
    for at in 0..good.len() {
        let _ = obj("cut.obj", &good.as_bytes()[..at]);
        for bit in 0..8 {
            let mut bytes = good.clone().into_bytes();
            bytes[at] ^= 1 << bit;
            let _ = obj("flipped.obj", &bytes);
        }
    }
}
