//! Rays per second by kind of ray, and their counters.

use raystep_kernels::{Accelerator, ScheduleKind, Skip};
use raystep_lab::RayKind;

use super::one_size;
use crate::args::MeshArg;
use crate::meter::{Group, Meter, Way};
use crate::scenes::Viewed;

pub(super) fn measure(meter: &mut Meter<'_>, meshes: &[MeshArg]) -> Result<(), String> {
    let size = one_size(meter.machine);
    let mut scenes = vec![Viewed::generated("cornell-box", None)?];
    for mesh in meshes {
        scenes.push(Viewed::read(mesh)?);
    }
    let hits = scenes.iter().map(|viewed| viewed.hits(size, meter.machine)).collect::<Result<Vec<_>, _>>()?;
    // By kind first: if time runs out, every scene has at least its primary rays.
    for &kind in RayKind::ALL {
        for (viewed, hits) in scenes.iter().zip(&hits) {
            let Some((rays, counted)) = viewed.rays(kind, size, hits) else { continue };
            let group = Group { viewed, size, rays, rays_kind: kind.name(), counted: Some((counted, is_counted)) };
            meter.group(&group, &ways());
        }
    }
    Ok(())
}

/// Only one schedule is counted: the others take the same steps.
fn is_counted(way: &Way) -> bool {
    way.schedule == ScheduleKind::Fused || way.schedule == ScheduleKind::Compact && way.steps == 1
}

fn ways() -> Vec<Way> {
    use Accelerator::{Bvh, Grid, Irregular};
    let mut ways = Vec::new();
    for way in
        [Bvh, Irregular, Grid].into_iter().map(Way::fused).chain([Bvh, Irregular, Grid].map(|a| Way::compact(a, 8)))
    {
        ways.push(way);
        if way.accelerator == Grid {
            ways.push(way.skip(Skip::On));
        }
    }
    for schedule in [ScheduleKind::Compact, ScheduleKind::Second] {
        ways.extend([Bvh, Irregular, Grid].map(|accelerator| Way::new(accelerator, schedule)));
    }
    ways
}
