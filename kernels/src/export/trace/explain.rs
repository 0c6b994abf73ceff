//! Why a pass left a ray as it did: worked out again from the ray before and after it, by the kernels' own functions
//! for the host. Where a device rounds otherwise than the host, what the device did is what is said.

use crate::export::trace::RayState;
use crate::kernel::Kernel;
use crate::real::Vec3;
use crate::scene_data::SceneData;
use crate::shared::bvh_walk::{finite_inverse, hits_box, parent_of};
use crate::shared::constants::{INF, NO_NODE};
use crate::shared::grid_walk::smallest_axis;
use crate::shared::triangle::{Candidate, Shear, hit_triangle, plane_hit};
use crate::state;

/// Which triangle a pass tested, and why it left the ray as it did.
pub(super) fn explain(kernel: Kernel, data: &SceneData, before: &RayState, after: &RayState) -> (Option<u32>, String) {
    match kernel {
        Kernel::Generate if data.features.samples => {
            (None, format!("sample {}: a ray through its place in the pixel", before.samples.unwrap_or_default() + 1))
        }
        Kernel::Generate => (None, "a ray through the pixel's centre".into()),
        Kernel::Accumulate => {
            let samples = after.samples.unwrap_or_default();
            let next = if after.tag == state::DONE { "the picture has it" } else { "on to the next sample" };
            (None, format!("mean of {samples} of {} samples: {next}", data.sampling.samples))
        }
        Kernel::Setup => (None, explain_setup(data, after)),
        Kernel::TraverseGrid => (None, explain_step(data, before, after)),
        Kernel::TraverseBvh => (None, explain_node(data, before, after)),
        Kernel::Walk => (None, explain_walk(data, before, after)),
        Kernel::Fused => (None, "the whole walk in one kernel".into()),
        Kernel::Intersect => explain_intersect(data, before, after),
        Kernel::Shade => {
            let rgb = after.color.unwrap_or_default();
            let source = match before.triangle.filter(|_| before.tag == state::SHADE) {
                Some(triangle) => format!("equation (1) at triangle {triangle}"),
                None => "nothing was hit: background".into(),
            };
            (None, format!("{source}: r {:.3} g {:.3} b {:.3}", rgb[0], rgb[1], rgb[2]))
        }
    }
}

fn explain_setup(data: &SceneData, after: &RayState) -> String {
    if data.features.bvh {
        return format!("starts at the root of {} nodes", data.bvh_nodes.len());
    }
    if !data.features.grid {
        return format!("no grid: all {} triangles are tested", data.info.triangles);
    }
    if after.tag == state::BACKGROUND {
        return "misses the grid's box".into();
    }
    let [x, y, z] = data.grid.cell_of_index(after.cell_index);
    format!("starts in cell ({x}, {y}, {z}), which lists {}", triangles(list(data, after.cell_index).len()))
}

fn explain_step(data: &SceneData, before: &RayState, after: &RayState) -> String {
    let tmax = Vec3::from(before.tmax.map(|t| t.unwrap_or(INF)));
    let axis = smallest_axis(tmax).iter().position(|&b| b).unwrap_or(2);
    let (name, t) = (["x", "y", "z"][axis], tmax.to_array()[axis]);
    let sign = if before.direction[axis] < 0.0 { '-' } else { '+' };
    let step = format!("tmax.{name} {t} is smallest: step {sign}{name}");
    match after.tag {
        state::BACKGROUND => format!("{step}, out of the grid; nothing hit"),
        state::SHADE => format!("{step}, out of the grid; the kept hit is the nearest"),
        tag => {
            let [x, y, z] = data.grid.cell_of_index(after.cell_index);
            let kept = if tag == state::ISECT_HIT { "; the hit is kept" } else { "" };
            format!(
                "{step} to cell ({x}, {y}, {z}), which lists {}{kept}",
                triangles(list(data, after.cell_index).len())
            )
        }
    }
}

fn explain_walk(data: &SceneData, before: &RayState, after: &RayState) -> String {
    let found = match (after.t, before.t) {
        (Some(t), None) => format!("; hit at t {t}"),
        (Some(t), Some(kept)) if t < kept => format!("; a nearer hit at t {t}"),
        _ => String::new(),
    };
    let next = match after.tag {
        state::BACKGROUND => "over, nothing hit".into(),
        state::SHADE => "over, the nearest hit is found".into(),
        _ if data.features.grid => {
            let [x, y, z] = data.grid.cell_of_index(after.cell_index);
            format!("now in cell ({x}, {y}, {z})")
        }
        _ if data.features.bvh => format!("now at node {}", after.cell_index),
        _ => format!("{} triangles tested", after.item),
    };
    format!("up to {} steps: {next}{found}", data.info.steps)
}

fn explain_node(data: &SceneData, before: &RayState, after: &RayState) -> String {
    let (at, to) = (before.cell_index, after.cell_index);
    let node = data.bvh_nodes.get(at as usize).copied().unwrap_or_default();
    let parent = data.bvh_parents.get(at as usize).map_or(NO_NODE, |&above| parent_of(above));
    let next = match after.tag {
        state::BACKGROUND => "the tree is done; nothing hit".into(),
        state::SHADE => "the tree is done; the kept hit is the nearest".into(),
        state::ISECT_HIT | state::ISECT_NO_HIT => format!("a leaf, which lists {}", triangles(node.count() as usize)),
        _ if to == parent => format!("up to node {to}"),
        _ if data.bvh_parents.get(to as usize).is_some_and(|&above| parent_of(above) == at) => {
            format!("down to node {to}, the nearer child")
        }
        _ => format!("on to node {to}, the sibling"),
    };
    if before.previous != Some(parent) {
        return format!("node {at} is done: {next}");
    }
    let [o, d] = [before.origin, before.direction].map(Vec3::<f32>::from_f32);
    let is_met = hits_box(&node, o, finite_inverse(d), before.t.unwrap_or(INF));
    format!("node {at}: its box is {}: {next}", if is_met { "met" } else { "missed, or beyond the nearest hit" })
}

fn explain_intersect(data: &SceneData, before: &RayState, after: &RayState) -> (Option<u32>, String) {
    let exit = before.tmax.iter().flatten().fold(INF, |m, &t| m.min(t));
    let next = match after.tag {
        state::TRAV if data.features.bvh => "the leaf is done".into(),
        state::SHADE if data.features.any_hit => "any hit ends the ray".into(),
        state::SHADE if !data.features.grid => "last triangle: the nearest hit is accepted".into(),
        state::SHADE if !data.features.in_cell => {
            format!("list ended: t {} <= exit {exit}, accepted", after.t.unwrap_or(INF))
        }
        state::SHADE => "list ended with a hit: accepted".into(),
        state::BACKGROUND => "last triangle: nothing hit".into(),
        state::TRAV => match after.t {
            Some(t) => format!("list ended: t {t} is beyond the exit {exit}, kept; on to the next cell"),
            None => "list ended: on to the next cell".into(),
        },
        _ => String::new(),
    };
    let (first, count) = data.list(before.cell_index);
    let tested = (before.item < count).then(|| data.listed(first + before.item));
    let Some(triangle) = tested else {
        let is_empty = data.features.grid && count == 0;
        return (None, if is_empty { format!("empty cell; {next}") } else { next });
    };
    let [o, d] = [before.origin, before.direction].map(Vec3::<f32>::from_f32);
    let (rules, shear, corners) = (data.features.triangle_rules(), Shear::of(d), data.corners(triangle));
    let mut candidate = hit_triangle::<f32>(rules, o, d, &shear, corners);
    if rules.watertight && !candidate.is_hit {
        candidate = plane_hit(o, &shear, corners);
    }
    let accepted = after.triangle == Some(triangle) && after.t != before.t || before.triangle != after.triangle;
    let test = describe_test(triangle, &candidate, accepted, !data.features.in_cell, before);
    (tested, if next.is_empty() { test } else { format!("{test}; {next}") })
}

fn describe_test(triangle: u32, c: &Candidate<f32>, accepted: bool, anywhere: bool, before: &RayState) -> String {
    let w = 1.0 - c.u - c.v;
    let t = c.t;
    if c.is_hit && accepted {
        return format!("triangle {triangle}: hit at t {t}, u {}, v {}", c.u, c.v);
    }
    if c.is_hit {
        return match before.t {
            Some(nearest) if before.triangle == Some(triangle) => {
                format!("triangle {triangle}: tested again, the same hit at t {nearest}")
            }
            Some(nearest) if t >= nearest => format!("triangle {triangle}: hit at t {t}, not nearer than {nearest}"),
            // Worked out again here, on the CPU: the device's own rounding decided.
            _ if anywhere => format!("triangle {triangle}: missed by less than a rounding"),
            _ => format!("triangle {triangle}: hit at t {t}, but outside of this cell"),
        };
    }
    if !(c.u.is_finite() && c.v.is_finite()) {
        return format!("triangle {triangle}: seen edge-on");
    }
    let weights = [("u", c.u), ("v", c.v), ("1 - u - v", w)];
    let smallest = weights.iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or(&weights[0]);
    if smallest.1 < 0.0 {
        return format!("triangle {triangle}: {} = {}, outside", smallest.0, smallest.1);
    }
    if t <= 0.0 {
        return format!("triangle {triangle}: t {t}, behind the origin");
    }
    format!("triangle {triangle}: outside by less than a rounding")
}

fn triangles(count: usize) -> String {
    if count == 1 { "1 triangle".into() } else { format!("{count} triangles") }
}

fn list(data: &SceneData, cell: u32) -> &[u32] {
    let cell = cell as usize;
    match (data.grid_cells.get(cell), data.grid_cells.get(cell + 1)) {
        (Some(&first), Some(&end)) => &data.grid_items[first as usize..end as usize],
        _ => &[],
    }
}
