//! All surfaces that a traced ray crosses.

use raystep_kernels::export::trace::Trace;
use raystep_kernels::shared::crossing::sees_front;
use raystep_kernels::{Caster, Device, Options, Ray, RenderError};
use raystep_lab::text::aligned;
use raystep_scenes::Scene;
use serde::Serialize;

/// Surfaces in a table.
const MOST: usize = 64;

/// A surface that the ray crosses.
#[derive(Serialize)]
pub(super) struct Crossed {
    /// In multiples of the ray's direction as it was given.
    t: f64,
    triangle: u32,
    material: u32,
    /// Whether the ray comes from the side that a closed surface turns outwards.
    front: bool,
}

/// The surfaces that a ray crosses, in exact order.
pub(super) async fn crossed(scene: &Scene, history: &Trace) -> Result<Vec<Crossed>, RenderError> {
    let Some(row) = history.rows.first() else { return Ok(Vec::new()) };
    // A power of two.
    let unit = history.scene_units_per_stream_unit;
    let origin = row.after.origin.map(|v| (f64::from(v) * unit) as f32);
    let options = Options { all_hits: true, ..Caster::options() };
    let mut caster = Caster::new(scene.clone(), &options, &Device::Cpu(None)).await?;
    let found = caster.cast_all(&[Ray::new(origin, row.after.direction)]).await?;
    let crossed = found.hits.iter().map(|hit| Crossed {
        t: f64::from(hit.t) / unit * history.t_scale,
        triangle: hit.triangle,
        material: hit.material,
        front: sees_front(row.after.direction, scene.triangles[hit.triangle as usize]),
    });
    Ok(crossed.collect())
}

/// A table for people.
pub(super) fn table(all: &[Crossed]) -> String {
    let title = match all.len() {
        0 => return "\nThe ray crosses no surface.\n".into(),
        1 => "\nThe ray crosses 1 surface:\n\n".into(),
        count => format!("\nThe ray crosses {count} surfaces, in this order:\n\n"),
    };
    let mut lines = vec![["side", "t", "triangle", "material"].map(str::to_owned)];
    lines.extend(all.iter().take(MOST).map(|one| {
        let side = if one.front { "front" } else { "back" };
        [side.into(), format!("{}", one.t as f32), one.triangle.to_string(), one.material.to_string()]
    }));
    let mut text = title + &aligned(&lines, 1).concat();
    if all.len() > MOST {
        text += &format!("and {} more: --format json lists all\n", all.len() - MOST);
    }
    text
}
