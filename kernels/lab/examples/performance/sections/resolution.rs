//! Time against rays.

use raystep_kernels::Accelerator::{Bvh, Grid};

use super::two_scenes;
use crate::meter::{Group, Meter, Way};

/// From 0.25 to 8.3 million pixels.
const SIZES: [(u32, u32); 7] =
    [(640, 384), (960, 540), (1280, 720), (1920, 1080), (2560, 1440), (3200, 1800), (3840, 2160)];

pub(super) fn measure(meter: &mut Meter<'_>) -> Result<(), String> {
    let small = [(128, 96), (256, 192), (320, 240), (512, 384)];
    let sizes = match (meter.machine.is_fast(), meter.machine.quick) {
        (true, _) => &SIZES[..],
        (false, false) => &SIZES[..4],
        (false, true) => &small[..],
    };
    for viewed in &two_scenes()? {
        for &size in sizes {
            let group = Group { viewed, size, rays: viewed.primary(size), rays_kind: "primary", counted: None };
            let ways = [Way::fused(Bvh), Way::fused(Grid), Way::compact(Bvh, 8), Way::compact(Grid, 8)];
            meter.group(&group, &ways);
        }
    }
    Ok(())
}
