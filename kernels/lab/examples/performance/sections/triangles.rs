//! Time against triangles.

use raystep_kernels::{Accelerator, Skip};

use super::Deadline;
use crate::meter::{Group, Meter, Way};
use crate::row::Row;
use crate::scenes::Viewed;

const COUNTS: [u64; 14] = [2, 8, 18, 32, 72, 128, 512, 2_048, 8_192, 32_768, 131_072, 524_288, 2_000_000, 10_000_000];

/// A run without an accelerator is skipped if it is expected to take longer than this.
const MOST_NS: f64 = 0.5e9;

/// Most triangles for which the host builds an irregular grid: it takes some 5 s for a million.
const MOST_IRREGULAR: u64 = 600_000;

pub(super) fn measure(meter: &mut Meter<'_>) -> Result<(), String> {
    let (most, size) = match (meter.machine.is_fast(), meter.machine.quick) {
        (true, true) => (131_072, (512, 512)),
        (true, false) => (10_000_000, (1024, 1024)),
        (false, true) => (8_192, (128, 128)),
        (false, false) => (2_000_000, (256, 256)),
    };
    // The last time without an accelerator, per scene: it is proportional to triangles from a few hundred up.
    let mut without = [None::<(f64, f64)>; 2];
    for &count in COUNTS.iter().filter(|&&count| count <= most) {
        for (scene, without) in ["terrain", "soup"].into_iter().zip(&mut without) {
            if meter.deadline.is_over() {
                let (section, reason) = (meter.section.into(), Deadline::OVER.into());
                meter.rows.push(Row { section, scene: scene.into(), triangles: count, reason, ..Row::default() });
                continue;
            }
            let viewed = Viewed::generated(scene, Some(count))?;
            let triangles = viewed.scene.triangles.len() as f64;
            let expected_ns = without.map_or(0.0, |(before, ns)| ns * triangles / before);
            let mut ways = vec![
                Way::fused(Accelerator::Grid).skip(Skip::Auto),
                Way::fused(Accelerator::Bvh),
                Way::compact(Accelerator::Grid, 8).skip(Skip::Auto),
                Way::compact(Accelerator::Bvh, 8),
            ];
            if count <= MOST_IRREGULAR {
                ways.insert(1, Way::fused(Accelerator::Irregular));
            }
            if expected_ns < MOST_NS {
                ways.push(Way::fused(Accelerator::None));
            }
            let rays = viewed.primary(size);
            let group = Group { viewed: &viewed, size, rays, rays_kind: "primary", counted: None };
            meter.group(&group, &ways);
            let last = meter.rows.last().filter(|row| row.accelerator == "none");
            *without = last.and_then(|row| row.median_device_ns).map(|ns| (triangles, ns)).or(*without);
            if expected_ns >= MOST_NS {
                let reason = format!("not begun: {:.1} s were expected", expected_ns / 1e9);
                meter.rows.push(Row { reason, ..meter.row(&group, &Way::fused(Accelerator::None)) });
            }
        }
    }
    Ok(())
}
