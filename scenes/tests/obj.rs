//! OBJ: what is read, what is left out with a note, and the errors for files of which nothing can be drawn.

#![allow(clippy::unwrap_used, reason = "a test that cannot make its input has failed")]

use crate::mesh_common::{TRIANGLE, error, notes, obj, read, scene};

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
const THREE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

/// The note on vertices that are no numbers.
const NOT_FINITE: &str = "1 vertex has a position that is not finite in 32 bits: not drawn";

#[test]
fn convex_polygons_are_fans() {
    let scene = obj(&format!("{SQUARE}# a comment\no thing\nf 1 2 3 4\n"));
    assert_eq!(scene.name, "a");
    assert_eq!(
        scene.triangles,
        [[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.]], [[0., 0., 0.], [1., 1., 0.], [0., 1., 0.]]]
    );
    assert_eq!(scene.triangle_materials, [0, 0]);
    assert!(scene.normals.is_none() && scene.texcoords.is_none() && scene.colors.is_none());
    assert!(scene.materials[0].double_sided);
    assert!(scene.notes.is_empty());
}

#[test]
fn indices_count_from_both_ends_and_lines_may_continue() {
    for text in ["f -4 -3 \\\r\n -2\r\n", "f 1\\\n2 \\ # a comment\n3", "f 1 2 3\\", "fo 1 2 3 \\  \n"] {
        let scene = obj(&format!("{SQUARE}{text}"));
        assert_eq!(scene.triangles, [[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.]]], "{text}");
    }
}

#[test]
fn only_statements_that_are_read_continue() {
    // A folder of Windows at the end of a comment or a name does not take the next line with it.
    for line in ["# made in C:\\", "g C:\\parts\\", "usemtl a\\", "o a\\", "v 0 0 9 # C:\\"] {
        let scene = obj(&format!("{line}\n{THREE}f -3 -2 -1\n"));
        assert_eq!(scene.triangles, TRIANGLE, "{line}");
    }
}

#[test]
fn a_byte_order_mark_and_any_ends_of_lines_are_read() {
    let text = format!("{THREE}v 0 0 1\nf 1 2 3\n");
    for text in [format!("\u{feff}{text}"), text.replace('\n', "\r"), text.replace('\n', "\r\n")] {
        assert_eq!(obj(&text).triangles, TRIANGLE, "{text:?}");
    }
}

#[test]
fn utf_16_is_named() {
    let wanted = "the file is UTF-16 text; save it as UTF-8";
    for start in ["\u{feff}", ""] {
        let text: Vec<u16> = format!("{start}{THREE}f 1 2 3\n").encode_utf16().collect();
        for order in [u16::to_le_bytes, u16::to_be_bytes] {
            let bytes: Vec<u8> = text.iter().flat_map(|&unit| order(unit)).collect();
            assert_eq!(error("a.obj", &bytes), wanted);
        }
    }
}

#[test]
fn attributes_are_read_and_missing_ones_made_up() {
    let scene = obj(&format!(
        "{SQUARE}vn 0 0 2\nvt 0.25 0.25\nf 1 2 3\nf 1/1/1 3/1/1 4/1/1\nf 1//1 2//1 3//1\nf 1/1 2/1 3/1\n"
    ));
    let normals = scene.normals.unwrap();
    assert!(normals.as_flattened().iter().all(|&n| n == [0.0, 0.0, 1.0]), "{normals:?}");
    // v grows upwards in OBJ and downwards in glTF.
    assert_eq!(scene.texcoords.unwrap(), [[[0.0; 2]; 3], [[0.25, 0.75]; 3], [[0.0; 2]; 3], [[0.25, 0.75]; 3]]);
    assert!(obj(&format!("{THREE}vt 1 1\nvn 1 0 0\nf 1 2 3\n")).normals.is_none());
}

#[test]
fn attributes_follow_the_corners_of_a_polygon() {
    // The reflex corner comes third, so the fan around the first corner is wrong.
    let scene = obj("v 1 0 0\nv 0 2 0\nv 0 0.5 0\nv -1 0 0\n\
        vt 0.1 1\nvt 0.2 1\nvt 0.3 1\nvt 0.4 1\nf 1/1 4/4 3/3 2/2\nf 1/1 2/2 3/3 4/4\n");
    let texcoords = scene.texcoords.unwrap();
    assert_eq!(scene.triangles.len(), 4);
    for (triangle, texcoords) in scene.triangles.as_flattened().iter().zip(texcoords.as_flattened()) {
        let wanted = match triangle {
            [1.0, ..] => 0.1,
            [_, 2.0, _] => 0.2,
            [_, 0.5, _] => 0.3,
            _ => 0.4,
        };
        assert_eq!(*texcoords, [wanted, 0.0], "{triangle:?}");
    }
}

#[test]
fn attributes_may_be_defined_after_faces() {
    let scene = obj(&format!("f 1/1/1 2/1/1 3/1/1\n{THREE}vt 0.5 0.5\nvn 1 0 0\n"));
    assert_eq!(scene.triangles, TRIANGLE);
    assert_eq!((scene.normals, scene.texcoords), (Some(vec![[[1., 0., 0.]; 3]]), Some(vec![[[0.5, 0.5]; 3]])));
}

#[test]
fn attributes_that_do_not_exist_leave_the_face() {
    for (face, note) in [
        ("f 1//1 2//1 3//1", "3 corners have a normal that does not exist: drawn flat there"),
        ("f 1//0 2//-7 3//x", "3 corners have a normal that does not exist: drawn flat there"),
        ("f 1/1 2/2 3/3", "3 corners have texture coordinates that do not exist: drawn as 0"),
        ("f 1/9223372036854775807 2 3", "1 corner has texture coordinates that do not exist: drawn as 0"),
        ("f 1/-9223372036854775808 2 3", "1 corner has texture coordinates that do not exist: drawn as 0"),
        ("f 1/4294967295 2/4294967296 3", "2 corners have texture coordinates that do not exist: drawn as 0"),
    ] {
        let scene = obj(&format!("{THREE}{face}\n"));
        assert_eq!((notes(&scene), scene.triangles.as_slice()), (vec![note], TRIANGLE.as_slice()), "{face}");
        assert!(scene.normals.is_none() && scene.texcoords.is_none());
    }
    let some = obj(&format!("{THREE}vn 1 0 0\nf 1//1 2//2 3\n"));
    assert_eq!(some.normals.as_deref(), Some([[[1., 0., 0.], [0., 0., 1.], [0., 0., 1.]]].as_slice()));
    assert_eq!(notes(&some), ["1 corner has a normal that does not exist: drawn flat there"]);
}

#[test]
fn numbers_that_nothing_needs_do_not_refuse_a_file() {
    const NORMAL: &str = "1 normal has no direction (zeros, NaN or infinities): drawn flat there";
    const TEXCOORD: &str = "1 texture coordinate has parts that are no numbers: drawn as 0";
    const COLOR: &str = "1 vertex colour has parts that are no numbers: drawn as 1";
    for word in ["nan", "-nan(ind)", "1.#QNAN", "x", "\u{661}"] {
        for (line, wanted) in [
            (format!("v {word} 0 0"), vec![NOT_FINITE]),
            (format!("v 0 0 {word} 1 1 1"), vec![NOT_FINITE]),
            (format!("v 0 0 0 {word}"), vec![]),
            (format!("v 0 0 0 0 {word} 0"), vec![COLOR]),
            (format!("v 0 0 0 {word} 0 0 1"), vec![]),
            (format!("vn 0 {word} 0"), vec![NORMAL]),
            (format!("vt {word} 0"), vec![TEXCOORD]),
            (format!("vt 0 {word}"), vec![TEXCOORD]),
            (format!("vt 0 0 {word}"), vec![]),
            (format!("vp {word}"), vec![]),
            (format!("s {word}"), vec![]),
            (format!("{word} 1 2"), vec![]),
        ] {
            let scene = obj(&format!("{THREE}{line}\nf 1 2 3\n"));
            assert_eq!((notes(&scene), scene.triangles.as_slice()), (wanted, TRIANGLE.as_slice()), "{line}");
        }
    }
    for word in ["inf", "-inf", "1e40", "1e400", "1.#INF"] {
        for (line, note) in [
            (format!("v {word} 0 0"), NOT_FINITE),
            (format!("vt {word} 0"), TEXCOORD),
            (format!("vn {word} 0 0"), NORMAL),
        ] {
            let scene = obj(&format!("{THREE}{line}\nf 1 2 3\n"));
            assert_eq!((notes(&scene), scene.triangles.as_slice()), (vec![note], TRIANGLE.as_slice()), "{line}");
        }
    }
    for (line, note) in [("v 1 2", NOT_FINITE), ("v", NOT_FINITE), ("vt", TEXCOORD), ("vn 1", NORMAL)] {
        assert_eq!(notes(&obj(&format!("{THREE}{line}\nf 1 2 3\n"))), [note], "{line}");
    }
}

#[test]
fn a_normal_without_a_direction_is_drawn_flat() {
    for line in ["vn nan nan nan", "vn 0 0 0", "vn inf 0 0"] {
        let scene = obj(&format!("{THREE}vn 1 0 0\n{line}\nf 1//1 2//2 3//2\n"));
        assert_eq!(scene.normals.unwrap(), [[[1., 0., 0.], [0., 0., 1.], [0., 0., 1.]]], "{line}");
    }
}

#[test]
fn faces_that_cannot_be_drawn_are_left_out_and_counted() {
    const SHORT: &str = "1 face has fewer than 3 corners: left out";
    const MISSING: &str = "1 face has a corner that is no vertex of the file: left out";
    const WRONG: &str = "1 face has a corner that is not finite in 32 bits: left out";
    for (text, wanted) in [
        ("f", vec![SHORT]),
        ("f 1", vec![SHORT]),
        ("f 1 2", vec![SHORT]),
        ("f 1 2 9", vec![MISSING]),
        ("f 0 1 2", vec![MISSING]),
        ("f -9 1 2", vec![MISSING]),
        ("f 1 2 1.5", vec![MISSING]),
        ("f 1 2 / 3", vec![MISSING]),
        ("f 1 2 4294967297", vec![MISSING]),
        ("f 1 2 99999999999999999999", vec![MISSING]),
        ("v nan 0 0\nf 1 2 4", vec![NOT_FINITE, WRONG]),
        ("v 0 1e40 0\nf 1 2 3 4", vec![NOT_FINITE, WRONG]),
        ("v 0 1,5 0\nf 1 2 -1", vec![NOT_FINITE, WRONG]),
    ] {
        let scene = obj(&format!("{THREE}{text}\nf 1 2 3\n"));
        assert_eq!((notes(&scene), scene.triangles.as_slice()), (wanted, TRIANGLE.as_slice()), "{text}");
    }
    let many = obj(&format!("{THREE}f 1 2\nf\nf 1 2 3\nf 1 2 8\nf 1 2 7\n"));
    assert_eq!(
        notes(&many),
        [
            "2 faces have fewer than 3 corners: left out",
            "2 faces have a corner that is no vertex of the file: left out"
        ]
    );
}

#[test]
fn odd_but_valid_faces_are_drawn() {
    for (face, triangles) in [("f 1 1 2 3", 2), ("f 1 1 1", 1), ("f 1//// 2 3", 1), ("f 3 2 1 3", 2), ("f +1 2 3", 1)] {
        assert_eq!(obj(&format!("{THREE}{face}\n")).triangles.len(), triangles, "{face}");
    }
    let zero = obj("v -0 0 0\nv 1 -0.0 0\nv 0 1 -0\nf 1 2 3\n");
    assert_eq!((zero.triangles.as_slice(), zero.notes.len()), (TRIANGLE.as_slice(), 0));
}

#[test]
fn colors_are_srgb_of_0_to_1_or_of_0_to_255() {
    let scene = obj("v 0 0 0 1 0 0\nv 1 0 0 0.5 0 0\nv 0 1 0 0 0 1\nf 1 2 3\n");
    let colors = scene.colors.unwrap();
    assert_eq!(colors[0][0], [1.0, 0.0, 0.0]);
    // IEC 61966-2-1: 0.5 is 0.2140.
    assert!((colors[0][1][0] - 0.2140).abs() < 1e-4);
    assert!(scene.notes.is_empty());

    // The same colours, 128 64 32 of 255, which are linear 0.2159, 0.0513, 0.0144.
    let colors = |color: &str| {
        let scene = obj(&format!("v 0 0 0 {color}\nv 1 0 0 {color}\nv 0 1 0 {color}\nf 1 2 3\n"));
        let color = scene.colors.as_ref().unwrap()[0][0];
        (color, notes(&scene).join("; "))
    };
    let note = "vertex colours are read as 0 to 255, since the largest is 128";
    for (text, note) in
        [("128 64 32", note), ("1 128 64 32", note), ("0.50196 0.25098 0.12549", ""), ("1 0.50196 0.25098 0.12549", "")]
    {
        let (color, notes) = colors(text);
        assert!(color.iter().zip([0.2159, 0.0513, 0.0144]).all(|(a, b)| (a - b).abs() < 1e-4), "{text}: {color:?}");
        assert_eq!(notes, note, "{text}");
    }
    // The file decides, not the vertex; a single absurd value does not.
    let dark = obj("v 0 0 0 1 1 1\nv 1 0 0 255 0 0\nv 0 1 0 0 0 0\nf 1 2 3\n");
    assert!(dark.colors.unwrap()[0][0][0] < 0.001);
    let odd = obj("v 0 0 0 1 0 0\nv 1 0 0 1e30 -1 0\nv 0 1 0 0 0 1\nf 1 2 3\n");
    assert_eq!(odd.colors.as_ref().unwrap()[0][1], [1.0, 0.0, 0.0]);
    assert_eq!(notes(&odd), ["1 vertex colour has parts out of range: drawn as the nearest colour"]);
    // Vertices without a colour are white.
    let some = obj("v 0 0 0\nv 1 0 0 0 0 0\nv 0 1 0\nf 1 2 3\n");
    assert_eq!(some.colors.unwrap(), [[[1.0; 3], [0.0; 3], [1.0; 3]]]);
}

#[test]
fn what_is_not_read_is_noted() {
    let text = format!("{THREE}mtllib a b.mtl # c\nmtllib d.mtl\np 1\nl 1 2\ncurv 0 1 1 2\nsurf 0 1 0 1 1\nf 1 2 3\n");
    assert_eq!(
        notes(&obj(&text)),
        [
            "materials of a b.mtl are not read: everything is light grey",
            "points and lines are omitted",
            "curves and surfaces of OBJ are omitted",
        ]
    );
}

#[test]
fn takes_bytes_that_are_not_utf8() {
    let bytes = [b"# M\xfcller\no \xff\nmtllib \xfc\n".as_slice(), THREE.as_bytes(), b"f 1 2 3"].concat();
    assert_eq!(scene("a.obj", &bytes).triangles, TRIANGLE);
}

#[test]
fn a_city_far_from_the_origin_keeps_its_shape() {
    // A metre at 12,958,095 m, where f32 has a lattice of 1 m.
    let at = |x: f64, y: f64| format!("v {} {} 35.25\n", 12_958_095.5 + x, 4_852_834.125 + y);
    let text = at(0.0, 0.0) + &at(0.375, 0.0) + &at(0.0, 0.625) + "v 0 0 0\nv nan 0 0\nf 1 2 3\n";
    let scene = obj(&text);
    let [a, b, c] = scene.triangles[0].map(|p| glam::DVec3::from(p.map(f64::from)));
    assert_eq!((b - a, c - a), (glam::DVec3::new(0.375, 0.0, 0.0), glam::DVec3::new(0.0, 0.625, 0.0)));
    assert_eq!(a + scene.offset, glam::DVec3::new(12_958_095.5, 4_852_834.125, 35.25));
    // Nothing is lost on the way through a GLB.
    let again = crate::mesh_common::scene("a.glb", &raystep_scenes::write_glb(&scene).unwrap());
    assert_eq!((again.bounds_in_file(), again.triangles), (scene.bounds_in_file(), scene.triangles.clone()));
    // Unused vertices have no influence, near ones no offset.
    assert!(scene.offset.x > 1e7 && obj(&format!("{SQUARE}f 1 2 3\n")).offset == glam::DVec3::ZERO);
}

#[test]
fn a_file_of_which_nothing_can_be_drawn_says_what_where_and_what_it_has_instead() {
    for (text, wanted) in [
        ("", "the file is empty"),
        ("\u{feff}\n ", "the file is empty"),
        ("# nothing", "there is no face (a line like 'f 1 2 3'); only faces can be traced"),
        (
            "v 0 0 0\nv 1 0 0\np 1\nl 1 2\nl 2 1\ncurv 0 1 1 2\n",
            "there is no face (a line like 'f 1 2 3'), only 2 vertices, 1 point, 2 lines, 1 curve or surface; \
             only faces can be traced",
        ),
        ("f 1 2 3\n", "line 1: no face of the file can be drawn; of this one, its corner 1 is no vertex of the file"),
        (
            "v 0 0 0\n\nf 1 1 \\\n2\nf\n",
            "line 3: no face of the file can be drawn; of this one, its corner 3 is no vertex of the file",
        ),
        ("v 0 0 0\rf 1 1\r", "line 2: no face of the file can be drawn; of this one, it has fewer than 3 corners"),
        (
            "v 0 0 0\nv nan 0 0\nf 1 1 2\n",
            "line 3: no face of the file can be drawn; of this one, the position of its corner 3 is not finite in 32 bits",
        ),
    ] {
        assert_eq!(error("bad.obj", text.as_bytes()), wanted, "{text:?}");
    }
}

#[test]
fn a_file_cut_or_flipped_anywhere_never_panics() {
    let good = format!("{SQUARE}vt 0 1\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\nf -1 -2 -3\nf 1 3 2 4\n");
    for at in 0..good.len() {
        let _ = read("cut.obj", &good.as_bytes()[..at]);
        for bit in 0..8 {
            let mut bytes = good.clone().into_bytes();
            bytes[at] ^= 1 << bit;
            let _ = read("flipped.obj", &bytes);
        }
    }
}
