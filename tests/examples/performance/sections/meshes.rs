//! Rays a second by kind of ray, and what the rays did.

use raystep_kernels::{Accelerator, RayKind, ScheduleKind, Skip};

use super::one_size;
use crate::args::MeshArg;
use crate::meter::{Group, Meter, Way};
use crate::scenes::Viewed;

pub(super) fn measure(meter: &mut Meter<'_>, meshes: &[MeshArg]) -> Result<(), String> {
    let size = one_size(meter.machine);
    // Counting every repeated test walks back for each: fewer rays say as much.
    let counted_size = (size.0 / 4, size.1 / 4);
    for viewed in std::iter::once(Viewed::generated("cornell-box", None)).chain(meshes.iter().map(Viewed::read)) {
        let viewed = viewed?;
        for &kind in RayKind::ALL {
            let Some(rays) = viewed.rays(kind, size, meter.machine)? else { continue };
            let counted = viewed.rays(kind, counted_size, meter.machine)?;
            let group = Group { viewed: &viewed, size, rays, rays_kind: kind.name(), counted };
            meter.group(&group, &ways());
        }
    }
    Ok(())
}

fn ways() -> Vec<Way> {
    use Accelerator::{Bvh, Grid};
    let mut ways = Vec::new();
    for way in [Way::fused(Bvh), Way::fused(Grid), Way::compact(Bvh, 8), Way::compact(Grid, 8)] {
        ways.push(way);
        if way.accelerator == Grid {
            ways.push(way.skip(Skip::On));
        }
    }
    for schedule in [ScheduleKind::Compact, ScheduleKind::Second] {
        ways.extend([Bvh, Grid].map(|accelerator| Way::new(accelerator, schedule)));
    }
    ways
}
