//! Going back shows bit for bit what was there.

use raystep_inspector::{Session, Target};
use raystep_kernels::{Accelerator, Kernel, ScheduleKind, StreamData};
use raystep_tests::ways::{STEPPED, Way, stepped};
use raystep_tests::{block_on, devices, options, scene, streams_of};

#[test]
fn every_pass_looks_the_same_when_it_is_reached_again() {
    let ways = [
        ("cornell-box.gltf", STEPPED),
        ("flat.gltf", STEPPED),
        // In lists of live rays, rays lie in another order each time; what becomes of them must not depend on it.
        ("cornell-box.gltf", Way::new(Accelerator::Bvh, ScheduleKind::Compact, 1)),
        ("cornell-box.gltf", Way::new(Accelerator::None, ScheduleKind::Compact, 2)),
    ];
    for (name, device) in devices() {
        for (file, way) in ways {
            let scene = scene(file);
            let options = way.of(&options(&scene, 24, 20));
            let gpu = match &device {
                raystep_kernels::Device::Gpu(gpu) => Some(&**gpu),
                _ => None,
            };
            block_on(gpu, async {
                let mut session = Session::new(&scene, &options, &device).await.expect("a session");
                let streams = streams_of(session.renderer().plan());
                let mut seen: Vec<Vec<StreamData>> = Vec::new();
                loop {
                    let mut now = Vec::new();
                    for &stream in &streams {
                        now.push(session.stream(stream).await.expect("values"));
                    }
                    seen.push(now);
                    let place = session.place();
                    if session.step(Target::Next).await.expect("a pass") == place {
                        break;
                    }
                }
                assert!(seen.len() > 10, "{file} {way}: {} passes", seen.len());
                // Back from the end, one pass at a time, over the last and the first few, and some far jumps.
                let last = seen.len() - 1;
                let places = (0..6).map(|i| last - 1 - i).chain([3, last, 1, last / 2, 0]);
                for (i, place) in places.enumerate() {
                    let target = if i < 6 { Target::Previous } else { Target::Pass(place) };
                    assert_eq!(session.step(target).await.expect("a pass"), place, "{file} {name} {way}");
                    for (j, &stream) in streams.iter().enumerate() {
                        let again = session.stream(stream).await.expect("values");
                        assert_eq!(
                            again,
                            seen[place][j],
                            "{file} {name} {way}: {} after {place} passes",
                            stream.name()
                        );
                    }
                }
            });
        }
    }
}

#[test]
fn a_kernel_is_found_forward_and_back_and_a_ray_is_followed() {
    let scene = scene("cornell-box.gltf");
    let device = raystep_kernels::Device::Cpu(None);
    block_on(None, async {
        let mut session = Session::new(&scene, &stepped(&scene, 16, 16), &device).await.expect("a session");
        let traverse = Target::NextOf(Kernel::TraverseGrid);
        let first = session.step(traverse).await.expect("a pass");
        let second = session.step(traverse).await.expect("a pass");
        assert!(first < second && session.passes()[second - 1].kernel == Kernel::TraverseGrid);
        let back = session.step(Target::PreviousOf(Kernel::TraverseGrid)).await.expect("a pass");
        assert_eq!(back, first);

        assert_eq!(session.select(16, 0), None, "outside");
        assert_eq!(session.ray().await.expect("a ray"), None);
        assert_eq!(session.select(8, 8), Some([8, 8]));
        session.step(Target::End).await.expect("the end");
        let ray = session.ray().await.expect("a ray").expect("selected");
        assert!(ray.state == "DONE" && ray.triangle.is_some() && ray.color.is_some());
        assert_eq!(session.step(Target::Start).await.expect("the start"), 0);
        assert_eq!(session.ray().await.expect("a ray").expect("selected").state, "UNWRITTEN");
    });
}
