//! The camera under mouse input.

use super::*;

const SIZE: DVec2 = DVec2::new(800.0, 500.0);

fn boxed() -> Aabb {
    Aabb { min: DVec3::new(-1.0, 0.0, 2.0), max: DVec3::new(3.0, 2.0, 5.0) }
}

fn both_lenses() -> [Orbit; 2] {
    let perspective = Orbit::framing(&boxed(), SIZE.x / SIZE.y);
    let mut parallel = perspective;
    parallel.pose.lens = Lens::Orthographic { half_height: 3.0 };
    [perspective, parallel]
}

#[test]
fn zooming_keeps_what_is_under_the_cursor() {
    for mut orbit in both_lenses() {
        let cursor = DVec2::new(130.5, 410.5);
        let anchor = orbit.under(cursor, SIZE);
        for factor in [0.5, 0.01, 3.0, 70.0, 0.9] {
            let before = orbit.pose.distance;
            orbit.zoom(factor, anchor);
            let (pixel, _) = orbit.pixel(anchor, SIZE).expect("in front of the eye");
            assert!((pixel - cursor).length() < 1e-6, "{factor}: {pixel}");
            assert!((orbit.pose.distance / before - factor).abs() < 1e-12 * factor);
        }
    }
}

#[test]
fn panning_carries_the_scene_with_the_cursor() {
    for mut orbit in both_lenses() {
        let from = DVec2::new(300.0, 200.0);
        let anchor = orbit.under(from, SIZE);
        orbit.pan(DVec2::new(57.0, -31.0), SIZE);
        let (pixel, _) = orbit.pixel(anchor, SIZE).expect("in front of the eye");
        assert!((pixel - (from + DVec2::new(57.0, -31.0))).length() < 1e-9, "{pixel}");
    }
}

#[test]
fn up_never_tips_over_and_the_axes_stay_a_frame() {
    let mut orbit = Orbit::framing(&boxed(), 1.0);
    for i in 0..4000 {
        let wild = DVec2::new(f64::from(i % 37) - 11.0, f64::from(i % 53) * 4.0 - 95.0) * 3.0;
        if i % 3 == 0 {
            orbit.look(wild, SIZE)
        } else {
            orbit.orbit(wild, SIZE)
        }
        let [right, up, forward] = orbit.pose.axes();
        assert!(up.y >= 0.0, "{i}: {up}");
        assert!((right.cross(up) + forward).length() < 1e-12, "{i}");
        assert!((up.length() - 1.0).abs() < 1e-12);
    }
    // Dragged to a pole, further dragging sideways still turns the picture.
    orbit.orbit(DVec2::new(0.0, 1e6), SIZE);
    let before = orbit.pose.axes();
    assert!((before[2] - DVec3::NEG_Y).length() < 1e-12, "{}", before[2]);
    orbit.orbit(DVec2::new(SIZE.y / 2.0, 0.0), SIZE);
    assert!(orbit.pose.axes()[0].dot(before[0]).abs() < 1e-9);
}

#[test]
fn looking_around_does_not_move_the_eye() {
    let mut orbit = Orbit::framing(&boxed(), 1.0);
    let eye = orbit.pose.eye();
    let right = orbit.pose.axes()[0];
    let forward = orbit.pose.axes()[2];
    orbit.look(DVec2::new(40.0, 0.0), SIZE);
    assert!((orbit.pose.eye() - eye).length() < 1e-12);
    assert!(orbit.pose.axes()[2].dot(right) > forward.dot(right), "a move to the right looks to the right");
    orbit.fly(DVec3::Z * 0.1);
    assert!((orbit.pose.eye() - eye).dot(orbit.pose.axes()[2]) > 0.0);
}

#[test]
fn a_scenes_camera_goes_through_unchanged() {
    let directions = [
        DVec3::new(0.3, -0.4, 1.0),
        DVec3::NEG_Z,
        DVec3::Y,
        DVec3::NEG_Y,
        DVec3::new(1e-12, -1.0, 3e-13),
        DVec3::new(1e-7, 1.0, -1e-7),
    ];
    for direction in directions {
        for up in [DVec3::Y, DVec3::new(0.5, 1.0, 0.2), DVec3::X] {
            let eye = DVec3::new(2.0, 1.0, 9.0);
            let projection = raystep_scenes::Projection::Perspective { vertical_fov: 0.7 };
            let camera = Camera::look_at(eye, eye + direction, up, projection).expect("a camera");
            let back = Orbit::from_camera(&camera, &boxed()).to_camera("");
            for (a, b) in [(camera.eye, back.eye), (camera.right, back.right), (camera.up, back.up)] {
                assert!((a - b).length() < 1e-8, "{direction} {up}: {a} {b}");
            }
            assert!((camera.forward - back.forward).length() < 1e-8, "{direction}: {}", back.forward);
            assert_eq!(camera.projection, back.projection);
        }
    }
}

#[test]
fn a_ray_through_a_pixel_is_seen_at_that_pixel() {
    for orbit in both_lenses() {
        for pixel in [DVec2::new(0.5, 0.5), DVec2::new(799.5, 12.5), SIZE / 2.0] {
            let [origin, direction] = orbit.ray(pixel, SIZE);
            for t in [0.5, 4.0, 300.0] {
                let (seen, depth) = orbit.pixel(origin + direction * t, SIZE).expect("in front of the eye");
                assert!((seen - pixel).length() < 1e-6 && depth > 0.0, "{pixel} {seen}");
            }
        }
        // The matrix that pictures are drawn by says the same.
        let point = DVec3::new(0.7, 1.1, 4.0);
        let center = DVec3::new(0.2, 0.4, 3.0);
        let clip = orbit.clip_from_world(center, SIZE.x / SIZE.y) * (point - center).extend(1.0);
        let seen = DVec2::new(clip.x / clip.w + 1.0, 1.0 - clip.y / clip.w) * 0.5 * SIZE;
        assert!((seen - orbit.pixel(point, SIZE).expect("in front").0).length() < 1e-6);
        assert!((0.0..=1.0).contains(&(clip.z / clip.w)));
    }
}

#[test]
fn a_framed_box_is_seen_whole_and_large() {
    for mut orbit in both_lenses() {
        for aspect in [0.4, 1.0, 2.5] {
            orbit.frame(&boxed(), aspect);
            let size = DVec2::new(500.0 * aspect, 500.0);
            let seen = boxed().corners().map(|corner| orbit.pixel(corner, size).expect("in front of the eye").0);
            assert!(seen.iter().all(|p| p.cmpge(DVec2::ZERO).all() && p.cmple(size).all()), "{aspect}: {seen:?}");
            let width = |axis: usize| {
                let values = seen.map(|p| p[axis]);
                values.iter().fold(0.0f64, |m, &v| m.max(v)) - values.iter().fold(1e9f64, |m, &v| m.min(v))
            };
            assert!(width(0).max(width(1)) > 0.6 * size.min_element(), "{aspect}: {} {}", width(0), width(1));
        }
    }
    let point = Aabb { min: DVec3::ONE, max: DVec3::ONE };
    assert!(Orbit::framing(&point, 1.0).pose.distance.is_finite());
}

#[test]
fn a_view_is_saved_and_read_back_and_nonsense_is_brought_into_range() {
    let [mut orbit, parallel] = both_lenses();
    orbit.orbit(DVec2::new(70.0, 30.0), SIZE);
    for orbit in [orbit, parallel] {
        let text = serde_json::to_string(&orbit).expect("text");
        assert_eq!(serde_json::from_str::<Orbit>(&text).expect("a view"), orbit);
    }
    for nonsense in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1.0] {
        for lens in [Lens::Perspective { vertical_fov: nonsense }, Lens::Orthographic { half_height: nonsense }] {
            let pose = Pose {
                target: DVec3::new(1.0, nonsense, 3.0),
                distance: nonsense,
                yaw: nonsense,
                pitch: nonsense,
                roll: nonsense,
                lens,
            };
            let far = Orbit { pose, home: pose, radius: nonsense };
            let text = serde_json::to_string(&far).expect("text");
            let read: Orbit = serde_json::from_str(&text).unwrap_or_else(|e| panic!("{e}: {text}"));
            assert!(read.pose.distance > 0.0 && read.radius > 0.0 && read.pose.pitch.abs() < 4.0, "{text}");
            assert!(read.pose.target.is_finite() && read.pose.yaw.is_finite() && read.pose.roll.is_finite(), "{text}");
            assert_eq!((read.pose.target.x, read.home), (1.0, read.pose), "{text}");
        }
    }
    // As a file from elsewhere may have it.
    let text = serde_json::to_string(&orbit).expect("text").replacen("\"pitch\":", "\"pitch\":1e300,\"was\":", 1);
    assert!(serde_json::from_str::<Orbit>(&text).expect("a view").pose.pitch.abs() < 4.0, "{text}");
    orbit.reset();
    assert_eq!(orbit, both_lenses()[0]);
    let scaled = orbit.scaled(8.0).scaled(0.125);
    assert_eq!(scaled, orbit);
}
