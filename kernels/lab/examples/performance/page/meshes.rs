//! Rays per second by kind of ray, and their counters.

use super::Measured;
use super::text::{distinct, number, or_dash, percent, table};
use crate::row::Row;

pub(super) fn tables(machine: &Measured) -> String {
    let rows: Vec<&Row> = machine.timed("meshes").collect();
    let mut text = String::new();
    for scene in distinct(rows.iter().map(|r| r.scene.as_str())) {
        let of_scene: Vec<&Row> = rows.iter().copied().filter(|r| r.scene == scene).collect();
        let kinds = distinct(of_scene.iter().map(|r| r.rays_kind.as_str()));
        let ways = distinct(of_scene.iter().map(|r| r.way()));
        let find = |way: &str, kind: &str| of_scene.iter().find(|r| r.way() == way && r.rays_kind == kind).copied();
        let Some(first) = of_scene.first() else { continue };
        text += &format!(
            "{scene}, {} triangles, {}×{} pixels, million rays per second:\n\n",
            first.triangles, first.width_px, first.height_px
        );
        let mut names = vec!["configuration".to_owned()];
        names.extend(kinds.iter().map(|kind| (*kind).to_owned()));
        let lines = ways.iter().map(|way| {
            let cells = kinds.iter().map(|kind| or_dash(find(way, kind).and_then(Row::mray_per_s), number));
            std::iter::once(way.clone()).chain(cells).collect()
        });
        text += &table(&names, &lines.collect::<Vec<_>>());
    }
    text
}

/// What rays do in each scene. It is the same on every machine except for the number of rays counted, so the first
/// machine that has the scene is used.
pub(super) fn work(machines: &[Measured]) -> String {
    let mut text = String::new();
    let scenes = distinct(machines.iter().flat_map(|m| m.timed("meshes").map(|r| r.scene.clone())));
    for scene in scenes {
        let of_scene = |m: &'_ Measured| m.timed("meshes").any(|r| r.scene == scene);
        let Some(machine) = machines.iter().find(|m| of_scene(m)) else { continue };
        // The number of steps per pass does not change what a ray does.
        let is_wanted = |r: &&Row| {
            r.scene == scene
                && matches!(
                    r.way().as_str(),
                    "bvh, fused"
                        | "irregular, fused"
                        | "grid, fused"
                        | "grid with skipping, fused"
                        | "bvh, compact K=1"
                        | "grid, compact K=1"
                )
        };
        let rows: Vec<&Row> = machine.timed("meshes").filter(is_wanted).collect();
        let kinds = distinct(rows.iter().map(|r| r.rays_kind.as_str()));
        let mut names = vec![scene.clone()];
        names.extend(kinds.iter().map(|kind| (*kind).to_owned()));
        names.push("bytes per triangle".into());
        let mut lines = Vec::new();
        for way in distinct(rows.iter().map(|r| r.way())) {
            let of_way: Vec<&&Row> = rows.iter().filter(|r| r.way() == way).collect();
            let cell = |kind: &&str| {
                let row = of_way.iter().find(|r| r.rays_kind == *kind)?;
                let (cells, tests) = row.cells_per_ray.zip(row.tests_per_ray)?;
                let share = row.repeated_per_ray.filter(|_| tests > 0.0 && row.accelerator == "grid");
                let share = share.map_or(String::new(), |n| format!(" ({} repeated)", percent(n / tests)));
                Some(format!("{} + {}{share}", number(cells), number(tests)))
            };
            let mut line = vec![way.clone()];
            line.extend(kinds.iter().map(|kind| cell(kind).unwrap_or("–".into())));
            line.push(or_dash(of_way.first().and_then(|r| r.bytes_per_triangle), number));
            lines.push(line);
        }
        text += &table(&names, &lines);
    }
    text
}
