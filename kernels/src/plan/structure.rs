//! A run's acceleration structure in numbers: for the terminal and for JSON.

use std::fmt;

use super::Plan;
use crate::numbers::bytes::Bytes;
use crate::options::{Accelerator, LEAST_FOR_GRID, MOST_WITHOUT};
use crate::scene_data::SceneData;
use crate::structures::bvh::WideContent;

/// The buffers that make up grids and BVHs.
const OF_STRUCTURES: [&str; 10] = [
    "grid_cells",
    "grid_items",
    "grid_distances",
    "irregular_map",
    "irregular_cells",
    "irregular_items",
    "bvh_nodes",
    "bvh_parents",
    "bvh_items",
    "wide_nodes",
];

/// The acceleration structure, why it was chosen, and its sizes.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Structure {
    /// `grid`, `irregular`, `bvh` or `none`.
    pub accelerator: &'static str,
    /// The option that requested it, or why `auto` chose it.
    pub accelerator_because: String,
    /// The grid; `null` without one.
    pub grid: Option<GridSummary>,
    /// The irregular grid; `null` without one.
    pub irregular: Option<IrregularSummary>,
    /// The BVH; `null` without one.
    pub bvh: Option<BvhSummary>,
}

/// A grid in numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct GridSummary {
    /// Cells along x, y and z.
    pub cells: [i32; 3],
    /// Lower corner of the first cell, in traced units.
    pub corner: [f32; 3],
    /// Size of a cell, in traced units.
    pub cell_width: [f32; 3],
    /// Cells with an empty list.
    pub empty_cells: u64,
    /// Entries of all lists.
    pub references: u64,
    /// Longest list.
    pub longest_list: u32,
    /// Whether rays skip empty cells.
    pub leaps: bool,
    /// Bytes of the buffers that the run binds for it.
    pub bytes: u64,
    /// Growth of the cells, in traced units.
    pub growth: f32,
}

/// An irregular grid in numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct IrregularSummary {
    /// Virtual cells along x, y and z: the finest that there can be.
    pub virtual_cells: [i32; 3],
    /// Lower corner of the first cell, in traced units.
    pub corner: [f32; 3],
    /// Size of a virtual cell, in traced units.
    pub virtual_cell_width: [f32; 3],
    /// Most halvings of a top-level cell.
    pub levels: u32,
    /// Number of cells.
    pub cells: u64,
    /// Cells with an empty list.
    pub empty_cells: u64,
    /// Entries of all lists.
    pub references: u64,
    /// Longest list.
    pub longest_list: u32,
    /// Bytes of the buffers that the run binds for it.
    pub bytes: u64,
    /// Growth of the cells, in traced units.
    pub growth: f32,
}

/// A BVH in numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct BvhSummary {
    /// Most children per inner node: 2 if rays are stepped, 8 in the fused kernel.
    pub width: u32,
    /// Number of nodes, including the leaves of a binary BVH; a wide node contains its leaves.
    pub nodes: u64,
    /// Nodes on the longest path from the root to a leaf, both included.
    pub depth: u32,
    /// Triangles in all leaves; large ones are in several.
    pub references: u64,
    /// Bytes of the buffers that the run binds for it, without the triangles' vertices.
    pub bytes: u64,
    /// Growth of the boxes, in traced units; 0 if each ray grows the boxes it meets.
    pub growth: f32,
}

impl Structure {
    /// Summarises a plan that was requested with `--accelerator asked`.
    #[must_use]
    pub fn of(asked: Accelerator, plan: &Plan, data: &SceneData) -> Self {
        let because = match (asked, plan.accelerator) {
            (Accelerator::Auto, Accelerator::None) => {
                format!("{MOST_WITHOUT} triangles or fewer are tested faster than they are looked up")
            }
            (Accelerator::Auto, Accelerator::Grid) => "most cells hold triangles, and no cell holds many".into(),
            (Accelerator::Auto, _) if plan.is_gpu && plan.triangles >= LEAST_FOR_GRID as u64 => {
                "most cells of a grid are empty, or a few hold many triangles".into()
            }
            (Accelerator::Auto, _) => format!("more than {MOST_WITHOUT} triangles"),
            _ => format!("--accelerator {asked}"),
        };
        Self {
            accelerator: plan.accelerator.name(),
            accelerator_because: because,
            grid: GridSummary::of(plan, data),
            irregular: IrregularSummary::of(plan, data),
            bvh: BvhSummary::of(plan, data),
        }
    }
}

/// Bytes of the grid's or BVH's buffers that the run binds.
#[must_use]
pub fn structure_bytes(plan: &Plan) -> u64 {
    plan.buffers.iter().filter(|b| OF_STRUCTURES.contains(&b.what)).map(|b| b.bytes).sum()
}

impl GridSummary {
    /// Summarises the grid of a run.
    #[must_use]
    pub fn of(plan: &Plan, data: &SceneData) -> Option<Self> {
        if data.grid_cells.len() < 2 {
            return None;
        }
        let lengths = || data.grid_cells.windows(2).map(|w| w[1] - w[0]);
        Some(Self {
            cells: data.grid.cells,
            corner: data.grid.corner,
            cell_width: data.grid.width,
            empty_cells: lengths().filter(|&n| n == 0).count() as u64,
            references: data.grid_items.len() as u64,
            longest_list: lengths().max().unwrap_or(0),
            leaps: plan.features.skip,
            bytes: structure_bytes(plan),
            growth: data.growth,
        })
    }
}

impl IrregularSummary {
    /// Summarises the irregular grid of a run.
    #[must_use]
    pub fn of(plan: &Plan, data: &SceneData) -> Option<Self> {
        if !plan.features.irregular {
            return None;
        }
        let lengths = || data.irregular_lengths.iter().copied();
        Some(Self {
            virtual_cells: data.grid.cells,
            corner: data.grid.corner,
            virtual_cell_width: data.grid.width,
            levels: data.grid.levels,
            cells: data.irregular_cells.len() as u64,
            empty_cells: lengths().filter(|&n| n == 0).count() as u64,
            references: lengths().map(u64::from).sum(),
            longest_list: lengths().max().unwrap_or(0),
            bytes: structure_bytes(plan),
            growth: data.growth,
        })
    }
}

impl BvhSummary {
    /// Summarises the BVH of a run.
    #[must_use]
    pub fn of(plan: &Plan, data: &SceneData) -> Option<Self> {
        if plan.accelerator != Accelerator::Bvh {
            return None;
        }
        let is_wide = !data.wide_nodes.is_empty();
        let references = if is_wide { data.packed_triangles.len() } else { data.bvh_items.len() };
        Some(Self {
            width: if is_wide { 8 } else { 2 },
            nodes: if is_wide { data.wide_nodes.len() } else { data.bvh_nodes.len() } as u64,
            depth: if is_wide { wide_depth(data) } else { binary_depth(data) },
            // An empty BVH has one entry that no leaf lists.
            references: if plan.triangles == 0 { 0 } else { references as u64 },
            bytes: structure_bytes(plan),
            growth: data.growth,
        })
    }
}

fn binary_depth(data: &SceneData) -> u32 {
    depth(|node, below| {
        let node = &data.bvh_nodes[node as usize];
        if node.is_inner() {
            below.extend([node.first, node.first + 1]);
        }
    })
}

fn wide_depth(data: &SceneData) -> u32 {
    depth(|node, below| {
        let node = &data.wide_nodes[node as usize];
        below.extend((0..8).filter_map(|slot| match node.content(slot)? {
            WideContent::Inner(child) => Some(child),
            WideContent::Leaf { .. } => None,
        }));
    })
}

/// Levels of a tree whose root is node 0; `children` pushes the children of a node.
fn depth(children: impl Fn(u32, &mut Vec<u32>)) -> u32 {
    let (mut level, mut below, mut depth) = (vec![0], Vec::new(), 0);
    while !level.is_empty() {
        depth += 1;
        below.clear();
        level.iter().for_each(|&node| children(node, &mut below));
        std::mem::swap(&mut level, &mut below);
    }
    depth
}

impl fmt::Display for Structure {
    /// One line, beginning with the accelerator's name in a column of nine characters.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:<9} ", self.accelerator)?;
        match (&self.grid, &self.irregular, &self.bvh) {
            (Some(g), ..) => {
                let [x, y, z] = g.cells;
                let leaps = match (g.empty_cells, g.leaps) {
                    (0, _) => "",
                    (_, true) => ", skipped",
                    (_, false) => ", not skipped",
                };
                write!(
                    f,
                    "{x} x {y} x {z} cells; {} empty cells{leaps}; {} references, longest list {}; {}",
                    g.empty_cells,
                    g.references,
                    g.longest_list,
                    Bytes(g.bytes)
                )?;
            }
            (None, None, Some(b)) => {
                let kind = if b.width == 2 { "binary" } else { "eight-wide" };
                let (nodes, depth, references) = (b.nodes, b.depth, b.references);
                write!(f, "{kind} tree: nodes {nodes}, depth {depth}, references {references}; {}", Bytes(b.bytes))?;
            }
            (None, Some(g), _) => {
                let [x, y, z] = g.virtual_cells;
                if self.accelerator == Accelerator::Grid.name() {
                    let [x, y, z] = [x, y, z].map(|n| n >> g.levels);
                    write!(f, "{x} x {y} x {z} cells, the crowded ones divided further: ")?;
                }
                write!(
                    f,
                    "{} cells on {x} x {y} x {z} virtual ones, {} empty; {} references, longest list {}; {}",
                    g.cells,
                    g.empty_cells,
                    g.references,
                    g.longest_list,
                    Bytes(g.bytes)
                )?;
            }
            (None, None, None) => write!(f, "every ray tests every triangle")?,
        }
        let because = &self.accelerator_because;
        if because.starts_with("--") { Ok(()) } else { write!(f, " (auto: {because})") }
    }
}

#[cfg(test)]
mod tests {
    use raystep_scenes::{Scene, generate};

    use super::*;
    use crate::options::{Options, RaySource, ScheduleKind};
    use crate::plan::Limits;

    fn of(scene: &Scene, asked: Accelerator, schedule: ScheduleKind) -> Structure {
        on(&Limits::CPU, scene, asked, schedule)
    }

    fn on(limits: &Limits, scene: &Scene, asked: Accelerator, schedule: ScheduleKind) -> Structure {
        let rays = RaySource::Given(Vec::new());
        let options = Options { accelerator: asked, schedule, shade: false, ..Options::new(rays) };
        let (plan, data) = Plan::new(scene, &options, limits).expect("a small scene");
        Structure::of(asked, &plan, &data)
    }

    #[test]
    fn a_tree_is_as_deep_as_its_builder_says() {
        let scene = generate::cornell_box();
        let (binary, wide) = (ScheduleKind::Second, ScheduleKind::Fused);
        let options = Options { accelerator: Accelerator::Bvh, ..Options::new(RaySource::Given(Vec::new())) };
        let (_, data) = Plan::new(&scene, &options, &Limits::CPU).expect("a small scene");
        let how = crate::structures::bvh::BvhOptions::default();
        let built = crate::structures::bvh::build(&data.vertices, data.growth, &how).expect("a tree");
        let two = of(&scene, Accelerator::Bvh, binary).bvh.expect("a tree");
        assert_eq!((two.width, two.depth, two.nodes), (2, built.depth, built.nodes.len() as u64));
        assert_eq!((two.references, two.bytes), (built.items.len() as u64, two.nodes * 36 + two.references * 4));
        let built = crate::structures::bvh::build_wide(&data.vertices, data.growth, &how).expect("a tree");
        let eight = of(&scene, Accelerator::Bvh, wide).bvh.expect("a tree");
        assert_eq!((eight.width, eight.depth, eight.nodes), (8, built.depth, built.nodes.len() as u64));
        assert_eq!((eight.references, eight.bytes), (built.triangles.len() as u64, eight.nodes * 80));

        for schedule in [binary, wide] {
            let empty =
                of(&Scene { materials: scene.materials.clone(), ..Scene::default() }, Accelerator::Bvh, schedule);
            assert_eq!(empty.bvh.map(|b| (b.depth, b.nodes, b.references)), Some((1, 1, 0)));
        }
    }

    #[test]
    fn auto_says_what_it_chose_and_why() {
        let scene = generate::cornell_box();
        let many = of(&scene, Accelerator::Auto, ScheduleKind::Compact);
        assert_eq!((many.accelerator, many.bvh.is_some(), many.grid), ("bvh", true, None));
        assert!(many.to_string().ends_with("(auto: more than 6 triangles)"), "{many}");
        let few = Scene {
            triangles: scene.triangles[..6].to_vec(),
            triangle_materials: vec![0; 6],
            normals: None,
            texcoords: None,
            colors: None,
            ..scene.clone()
        };
        let few = of(&few, Accelerator::Auto, ScheduleKind::Compact);
        assert_eq!((few.accelerator, few.bvh, few.grid), ("none", None, None));
        assert!(few.to_string().starts_with("none      every ray tests every triangle (auto: 6 "), "{few}");
        let [cloud, surface] =
            [generate::soup(2000, 1), generate::terrain(2000, 1)].map(|scene| scene.expect("a scene"));
        let gpu = Limits { is_gpu: true, ..Limits::CPU };
        for (scene, limits, accelerator, because) in [
            (&cloud, &gpu, "grid", "most cells hold triangles, and no cell holds many"),
            (&surface, &gpu, "bvh", "most cells of a grid are empty, or a few hold many triangles"),
            (&cloud, &Limits::CPU, "bvh", "more than 6 triangles"),
            (&surface, &Limits::CPU, "bvh", "more than 6 triangles"),
        ] {
            let chosen = on(limits, scene, Accelerator::Auto, ScheduleKind::Compact);
            assert_eq!((chosen.accelerator, chosen.accelerator_because.as_str()), (accelerator, because));
        }
        let asked = of(&scene, Accelerator::Grid, ScheduleKind::Compact);
        assert_eq!(asked.accelerator_because, "--accelerator grid");
        assert!(asked.to_string().starts_with("grid      ") && !asked.to_string().contains("auto"), "{asked}");
    }
}
