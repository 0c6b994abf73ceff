//! One ray's life: a row for every pass that worked on it, read from the executor's own streams, and
//! why it did what it did, in words and numbers.

use std::fmt::Write as _;
use std::ops::ControlFlow;

use serde::Serialize;

use crate::kernel::Kernel;
use crate::real::Vec3;
use crate::renderer::{Pass, RenderError, Renderer};
use crate::scene_data::SceneData;
use crate::shared::bvh_walk::{finite_inverse, hits_box, parent_of};
use crate::shared::constants::{INF, NO_NODE, NO_TRIANGLE};
use crate::shared::grid_walk::smallest_axis;
use crate::shared::triangle::{Candidate, Shear, hit_triangle, plane_hit};
use crate::state::{self, Tag};
use crate::stream::Stream;

/// A ray's texels after some pass, decoded. Lengths and t are in traced units, as in the streams.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RayState {
    /// Where the ray starts.
    pub origin: [f32; 3],
    /// Where it goes.
    pub direction: [f32; 3],
    /// The tag's name.
    pub state: &'static str,
    /// Tag of the state stream.
    #[serde(skip)]
    pub tag: Tag,
    /// Nearest t so far.
    pub t: Option<f32>,
    /// 1-D index of the cell, or index of the tree's node.
    pub cell_index: u32,
    /// The tree's node before this one; `None` without a tree.
    pub previous: Option<u32>,
    /// Offset into the cell's list.
    pub item: u32,
    /// t at which the ray leaves its cell, per axis; `None` for an axis that it never crosses.
    pub tmax: [Option<f32>; 3],
    /// Triangle hit so far.
    pub triangle: Option<u32>,
    /// Weights of vertices 1 and 2 at the hit.
    pub barycentric: Option<[f32; 2]>,
    /// Linear colour.
    pub color: Option<[f32; 3]>,
}

/// What one pass did to the ray.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TraceRow {
    /// The pass's place in the run.
    pub pass: usize,
    /// Name of its kernel.
    pub kernel: &'static str,
    /// The ray's state before it.
    pub state_before: &'static str,
    /// Cell (x, y, z) that it works in, before the pass.
    pub cell: Option<[i32; 3]>,
    /// Triangle that was tested.
    pub tested: Option<u32>,
    /// The ray after the pass.
    pub after: RayState,
    /// Why, in words.
    pub why: String,
}

/// One ray's life.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Trace {
    /// Pixel (x, y); of the row of given rays where rays were given.
    pub pixel: [u32; 2],
    /// Scene units per traced unit: multiply lengths by this.
    pub scene_units_per_stream_unit: f64,
    /// Multiply t by this to get the t of the ray as it was asked for.
    pub t_scale: f64,
    /// Passes of the whole run; the ray was idle in those that have no row.
    pub passes: usize,
    /// The rows.
    pub rows: Vec<TraceRow>,
}

/// Steps `renderer` from its first pass to its last and records one ray. `progress` is called after every
/// pass and may stop.
///
/// # Errors
/// Where the image has no such pixel, or the device fails, or `progress` said so.
pub async fn trace(
    renderer: &mut Renderer,
    x: u32,
    y: u32,
    mut progress: impl FnMut(&Pass) -> ControlFlow<()>,
) -> Result<Trace, RenderError> {
    renderer.restart();
    let mut before = ray_state(renderer, x, y).await?;
    let mut rows = Vec::new();
    while let Some(pass) = renderer.step().await? {
        // A kernel leaves alone every ray that is not in its states: nothing to read back then.
        if pass.kernel.info().active.contains(&before.tag) {
            let after = ray_state(renderer, x, y).await?;
            rows.push(row(&pass, renderer.data(), &before, &after));
            before = after;
        }
        if progress(&pass).is_break() {
            return Err(RenderError::Cancelled { passes: renderer.passes().len() });
        }
    }
    let scene_units_per_stream_unit = renderer.data().units.scene_units_per_stream_unit();
    let t_scale = renderer.t_scale(y as usize * renderer.plan().width as usize + x as usize);
    Ok(Trace { pixel: [x, y], scene_units_per_stream_unit, t_scale, passes: renderer.passes().len(), rows })
}

/// Decodes a ray's texels as they are now.
///
/// # Errors
/// Where the image has no such pixel, or the device fails.
pub async fn ray_state(renderer: &Renderer, x: u32, y: u32) -> Result<RayState, RenderError> {
    let plan = renderer.plan();
    let read = async |stream: Stream| match plan.has_stream(stream) {
        true => renderer.texel(stream, x, y).await.map(Some),
        false => Ok(None),
    };
    let floats = |texel: Option<Vec<u32>>| texel.map(|t| [t[0], t[1], t[2]].map(f32::from_bits));
    let state = renderer.texel(Stream::State, x, y).await?;
    let hit = renderer.texel(Stream::Hit, x, y).await?;
    let origin = floats(read(Stream::RayOrigin).await?).unwrap_or_default();
    let direction = floats(read(Stream::RayDirection).await?).unwrap_or_default();
    let tmax = floats(read(Stream::TMax).await?);
    let previous = read(Stream::Previous).await?.map(|texel| texel[0]);
    let tag = state[0];
    let color = if tag == state::DONE { floats(read(Stream::Color).await?) } else { None };
    let t = f32::from_bits(state[1]);
    let is_hit = hit[2] != NO_TRIANGLE;
    Ok(RayState {
        origin,
        direction,
        state: state::name(tag),
        tag,
        t: (t < INF).then_some(t),
        cell_index: state[2],
        item: state[3],
        previous,
        tmax: tmax.map_or([None; 3], |v| v.map(|t| (t < INF).then_some(t))),
        triangle: is_hit.then_some(hit[2]),
        barycentric: is_hit.then(|| [f32::from_bits(hit[0]), f32::from_bits(hit[1])]),
        color,
    })
}

fn row(pass: &Pass, data: &SceneData, before: &RayState, after: &RayState) -> TraceRow {
    let walks = pass.kernel.is_walk();
    let (tested, why) = explain(pass.kernel, data, before, after);
    TraceRow {
        pass: pass.index,
        kernel: pass.kernel.name(),
        state_before: before.state,
        cell: (data.features.grid && walks).then(|| data.grid.cell_of_index(before.cell_index)),
        tested,
        after: *after,
        why,
    }
}

/// Which triangle a pass tested, and why it left the ray as it did.
#[must_use]
pub fn explain(kernel: Kernel, data: &SceneData, before: &RayState, after: &RayState) -> (Option<u32>, String) {
    match kernel {
        Kernel::Generate => (None, "a ray through the pixel's centre".into()),
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
        state::SHADE if data.features.robust => {
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
        let empty = data.features.grid && list(data, before.cell_index).is_empty();
        return (None, if empty { format!("empty cell; {next}") } else { next });
    };
    let [o, d] = [before.origin, before.direction].map(Vec3::<f32>::from_f32);
    let (robust, shear, corners) = (data.features.robust, Shear::of(d), data.corners(triangle));
    let mut candidate = hit_triangle::<f32>(robust, o, d, &shear, corners);
    if robust && !candidate.is_hit {
        candidate = plane_hit(o, &shear, corners);
    }
    let accepted = after.triangle == Some(triangle) && after.t != before.t || before.triangle != after.triangle;
    let test = describe_test(triangle, &candidate, accepted, data.features.robust, before);
    (tested, if next.is_empty() { test } else { format!("{test}; {next}") })
}

fn describe_test(triangle: u32, c: &Candidate<f32>, accepted: bool, is_robust: bool, before: &RayState) -> String {
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
            _ if is_robust => format!("triangle {triangle}: missed by less than a rounding"),
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

impl Trace {
    /// A table for people: a line a row.
    #[must_use]
    pub fn table(&self) -> String {
        let mut out = String::new();
        let header = ["pass", "kernel", "state", "cell", "tmax", "item", "t", "hit"];
        let rows: Vec<[String; 8]> = self.rows.iter().map(cells).collect();
        let width = |c: usize| rows.iter().map(|r| r[c].len()).chain([header[c].len()]).max().unwrap_or(0);
        let widths: Vec<usize> = (0..8).map(width).collect();
        let mut line = |cells: [&str; 8], why: &str| {
            for (cell, width) in cells.iter().zip(&widths) {
                let _ = write!(out, "{cell:<width$}  ");
            }
            let _ = writeln!(out, "{why}");
        };
        line(header, "why");
        for (row, cells) in self.rows.iter().zip(&rows) {
            line(cells.each_ref().map(String::as_str), &row.why);
        }
        let idle = self.passes - self.rows.len();
        let _ = writeln!(out, "\n{} passes, in {idle} of them this ray waited", self.passes);
        let (unit, t) = (self.scene_units_per_stream_unit, self.t_scale);
        let _ =
            writeln!(out, "lengths are in traced units, of {unit} scene units each; {t} times t is the ray's own t");
        out
    }

    /// RFC 4180, raw numbers; what is not there is empty.
    ///
    /// # Errors
    /// Where `out` cannot be written.
    pub fn write_csv(&self, out: impl std::io::Write) -> Result<(), csv::Error> {
        let mut csv = csv::WriterBuilder::new().terminator(csv::Terminator::CRLF).from_writer(out);
        csv.write_record([
            "pass",
            "kernel",
            "state_before",
            "state_after",
            "cell_x",
            "cell_y",
            "cell_z",
            "tmax_x",
            "tmax_y",
            "tmax_z",
            "item",
            "tested_triangle",
            "t",
            "u",
            "v",
            "triangle",
            "why",
        ])?;
        fn text<T: ToString>(value: Option<T>) -> String {
            value.map_or_else(String::new, |v| v.to_string())
        }
        for row in &self.rows {
            let a = &row.after;
            let mut record = vec![row.pass.to_string(), row.kernel.into(), row.state_before.into(), a.state.into()];
            record.extend((0..3).map(|i| text(row.cell.map(|c| c[i]))));
            record.extend(a.tmax.map(text));
            record.extend([a.item.to_string(), text(row.tested), text(a.t)]);
            record.extend((0..2).map(|i| text(a.barycentric.map(|b| b[i]))));
            record.extend([text(a.triangle), row.why.clone()]);
            csv.write_record(record)?;
        }
        csv.flush()?;
        Ok(())
    }
}

fn cells(row: &TraceRow) -> [String; 8] {
    let a = &row.after;
    let short = |t: Option<f32>| t.map_or_else(|| "-".into(), |t| format!("{t:.5}"));
    let [x, y, z] = a.tmax;
    [
        row.pass.to_string(),
        row.kernel.into(),
        if row.state_before == a.state { a.state.into() } else { format!("{} > {}", row.state_before, a.state) },
        row.cell.map_or_else(|| "-".into(), |[x, y, z]| format!("{x},{y},{z}")),
        format!("{} {} {}", short(x), short(y), short(z)),
        a.item.to_string(),
        short(a.t),
        a.triangle.map_or_else(|| "-".into(), |t| t.to_string()),
    ]
}
