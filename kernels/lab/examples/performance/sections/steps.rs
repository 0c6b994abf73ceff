//! Time against steps per pass.

use raystep_kernels::Accelerator::{Bvh, Grid};

use super::{one_size, two_scenes};
use crate::meter::{Group, Meter, Way};

const STEPS: [u32; 7] = [1, 2, 4, 8, 16, 32, 64];

pub(super) fn measure(meter: &mut Meter<'_>) -> Result<(), String> {
    let size = one_size(meter.machine);
    for viewed in &two_scenes()? {
        let mut ways = Vec::new();
        for accelerator in [Grid, Bvh] {
            ways.push(Way::fused(accelerator));
            ways.extend(STEPS.map(|steps| Way::compact(accelerator, steps)));
        }
        let group = Group { viewed, size, rays: viewed.primary(size), rays_kind: "primary", counted: None };
        meter.group(&group, &ways);
    }
    Ok(())
}
