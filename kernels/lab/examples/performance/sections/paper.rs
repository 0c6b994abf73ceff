//! The paper's Tables 2 and 3 with its schedules, sizes and numerics, then our schedules on the same rays.

use raystep_kernels::{Accelerator, GridSize, Numerics, ScheduleKind, Skip};
use raystep_lab::paper::{GRID, SECONDS};

use crate::meter::{Counted, Group, Meter, Way};
use crate::scenes::Viewed;

pub(super) fn measure(meter: &mut Meter<'_>) -> Result<(), String> {
    let viewed = Viewed::generated("cornell-box", None)?;
    let rows = if meter.machine.quick { &SECONDS[..2] } else { &SECONDS[..] };
    for &(side, _) in rows {
        let size = (side, side);
        let rays = viewed.primary(size);
        let counted: Option<Counted> = Some((rays.clone(), |_| true));
        let group = Group { viewed: &viewed, size, rays, rays_kind: "primary", counted };
        meter.group(&group, &ways());
    }
    Ok(())
}

fn ways() -> Vec<Way> {
    use Accelerator::{Bvh, Grid, Irregular, None};
    use ScheduleKind::{First, Second};
    let mut ways = Vec::new();
    for numerics in [Numerics::Paper, Numerics::Robust] {
        for grid in [GRID, GridSize::Auto] {
            ways.extend([First, Second].map(|schedule| Way { numerics, grid, ..Way::new(Grid, schedule) }));
        }
        ways.push(Way { numerics, ..Way::new(None, Second) });
    }
    for way in [Way::compact(Grid, 1), Way::compact(Grid, 8), Way::fused(Grid)] {
        ways.extend([way, way.skip(Skip::On), Way { grid: GRID, ..way }]);
    }
    for accelerator in [Bvh, Irregular, None] {
        ways.extend([Way::compact(accelerator, 1), Way::compact(accelerator, 8), Way::fused(accelerator)]);
    }
    ways
}
