//! The paper's Tables 2 and 3 with its schedules, sizes and numerics, then our schedules on the same rays.

use raystep_kernels::{Accelerator, GridSize, Numerics, ScheduleKind, Skip};

use crate::meter::{Counted, Group, Meter, Way};
use crate::scenes::Viewed;

/// Sides of the paper's square images.
const SIDES: [u32; 4] = [100, 256, 512, 756];

/// The paper's grid.
const GRID: GridSize = GridSize::Cells([20; 3]);

pub(super) fn measure(meter: &mut Meter<'_>) -> Result<(), String> {
    let viewed = Viewed::generated("cornell-box", None)?;
    let sides = if meter.machine.quick { &SIDES[..2] } else { &SIDES };
    for &side in sides {
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
