//! The cell, node or triangle that was clicked: what it is, and where it occurs in a ray's history.

use std::sync::Arc;

use egui::Color32;
use raystep_kernels::export::trace::{Trace, TraceRow};
use raystep_kernels::scene_data::SceneData;
use raystep_lab::text::counted;

use super::walked::number;
use crate::draw::scene3d::Marked;
use crate::session::Model;
use crate::ui::state::{Display, Picked, Selection};
use crate::ui::units::{Scale, Units};
use crate::walk::{Aabb, WalkGeometry, above, corners, leaf_of, listed};

/// A cell by the coordinates of a walk.
pub(super) fn cell([x, y, z]: [i32; 3]) -> Option<Picked> {
    Some(Picked::Cell([u32::try_from(x).ok()?, u32::try_from(y).ok()?, u32::try_from(z).ok()?]))
}

/// Whether a row of a ray's history is about what was picked.
pub(in crate::ui) fn touches(row: &TraceRow, picked: Picked) -> bool {
    match picked {
        Picked::Cell([x, y, z]) => row.cell_before.is_some_and(|at| at.map(i64::from) == [x, y, z].map(i64::from)),
        // Only with a BVH is there a previous node, and are indices those of nodes.
        Picked::Node(node) => {
            row.after.previous.is_some_and(|previous| previous == node || row.after.cell_index == node)
        }
        Picked::Triangle(triangle) => row.tested == Some(triangle),
    }
}

/// What a row of a ray's history is about, if it is about one thing.
pub(in crate::ui) fn of_row(row: &TraceRow) -> Option<Picked> {
    let node = row.after.previous.map(|_| Picked::Node(row.after.cell_index));
    row.tested.map(Picked::Triangle).or(row.cell_before.and_then(cell)).or(node)
}

/// Its name.
pub(super) fn name(picked: Picked) -> String {
    match picked {
        Picked::Cell([x, y, z]) => format!("cell {x},{y},{z}"),
        Picked::Node(node) => format!("node {node}"),
        Picked::Triangle(triangle) => format!("triangle {triangle}"),
    }
}

/// Picks; what is picked already is picked no longer.
pub(super) fn toggle(selection: &mut Selection, picked: Picked) {
    selection.picked = if selection.picked == Some(picked) { None } else { Some(picked) };
}

/// The colour of a selection, as in the 3D view.
pub(super) fn color(visuals: &egui::Visuals) -> Color32 {
    if visuals.dark_mode { Color32::from_rgb(255, 80, 200) } else { Color32::from_rgb(190, 0, 130) }
}

/// What was picked, in a picture; `None` if this scene data has no such thing.
pub(super) fn marked(picked: Picked, data: &SceneData) -> Option<Marked> {
    match picked {
        Picked::Cell(at) => {
            let cell = in_grid(at, data)?;
            Some(Marked::Box(Aabb::of_cells(&data.grid, cell, [1; 3])))
        }
        Picked::Node(node) if data.features.bvh => {
            let node = data.bvh_nodes.get(node as usize)?;
            Some(Marked::Box(Aabb::of_f32(node.min, node.max)))
        }
        Picked::Node(_) => None,
        Picked::Triangle(triangle) => corners(data, triangle).map(Marked::Triangle),
    }
}

fn in_grid(at: [u32; 3], data: &SceneData) -> Option<[i32; 3]> {
    let [x, y, z] = at.map(i32::try_from);
    let cell = [x.ok()?, y.ok()?, z.ok()?];
    (data.features.grid && data.grid.is_in_grid(cell)).then_some(cell)
}

/// A sentence about what was picked, for a ray with this walk.
pub(super) fn describe(picked: Picked, data: &SceneData, walk: Option<&WalkGeometry>, scale: &Scale) -> String {
    let mut parts = Vec::new();
    let (t, unit) = (|t| number(scale.t64(t)), scale.units.name());
    let times = |n: usize| match n {
        1 => "once".to_owned(),
        2 => "twice".to_owned(),
        n => format!("{n} times"),
    };
    match picked {
        Picked::Cell([x, y, z]) => {
            if let Some(cell) = in_grid([x, y, z], data) {
                parts.push(counted(listed(data, data.grid.cell_index(cell)).count(), "triangle") + " in its list");
            }
            if let Some(walk) = walk.filter(|_| in_grid([x, y, z], data).is_some()) {
                let visit = walk.cells.iter().find(|visit| cell(visit.cell) == Some(picked));
                parts.push(visit.map_or_else(
                    || "not visited by this ray".into(),
                    |visit| format!("visited by this ray, t {} to {} {unit}", t(visit.t_in), t(visit.t_out)),
                ));
            }
        }
        Picked::Node(index) => {
            let node = data.bvh_nodes.get(index as usize).filter(|_| data.features.bvh);
            if let Some(node) = node {
                parts.push(match node.count() {
                    0 => "inner node".into(),
                    count => "leaf with ".to_owned() + &counted(count, "triangle"),
                });
            }
            if let Some(walk) = walk.filter(|_| node.is_some()) {
                let visit = walk.nodes.iter().find(|visit| visit.node == index);
                parts.push(match visit.map(|visit| (visit.is_met, visit.inside)) {
                    None => "not tested by this ray".into(),
                    Some((true, Some([near, far]))) => {
                        format!("entered by this ray, t {} to {} {unit}", t(near), t(far))
                    }
                    Some((true, None)) => "entered by this ray".into(),
                    Some((false, Some(_))) => "tested by this ray, not entered: beyond the nearest hit".into(),
                    Some((false, None)) => "tested and missed by this ray".into(),
                });
            }
        }
        Picked::Triangle(triangle) => {
            let lists = |items: &[u32]| items.iter().filter(|&&item| item == triangle).count();
            if data.features.grid {
                parts.push("in ".to_owned() + &counted(lists(&data.grid_items), "cell"));
            } else if data.features.bvh {
                parts.push("in ".to_owned() + &counted(lists(&data.bvh_items), "leaf"));
            }
            if let Some(walk) = walk {
                let tests: Vec<_> = walk.tested.iter().filter(|test| test.triangle == triangle).collect();
                parts.push(match tests.as_slice() {
                    [] => "not tested by this ray".into(),
                    tests => format!("tested {} by this ray", times(tests.len())),
                });
                if let Some(best) = tests.into_iter().max_by_key(|test| test.outcome) {
                    let t = best.t.filter(|_| best.outcome.is_hit()).map(|at| format!(", t {} {unit}", t(at)));
                    let why = if best.outcome.is_hit() && best.why == crate::walk::Why::Accepted {
                        String::new()
                    } else {
                        format!(" ({})", best.why)
                    };
                    parts.push(format!("{}{}{why}", best.outcome.name(), t.unwrap_or_default()));
                }
            }
        }
    }
    let name = name(picked);
    if parts.is_empty() { name } else { format!("{name}: {}", parts.join(", ")) }
}

/// The sentence, made again only where it may have changed.
#[derive(Default)]
pub(super) struct About {
    known: Option<(Key, Said)>,
}

/// The sentence, and the nodes from the root to what was picked, without itself.
#[derive(Clone, Default)]
struct Said {
    text: String,
    parents: Vec<u32>,
}

/// What was picked, the run, the history, whether the structure beside it is known, and the units.
type Key = (Picked, u64, usize, usize, Units);

impl About {
    /// Shows what is picked, with a button that clears it. Nothing is shown if nothing is picked.
    pub(super) fn show(&mut self, ui: &mut egui::Ui, model: &Model, selection: &mut Selection, display: &Display) {
        let Some(picked) = selection.picked else { return };
        let Said { text, parents } = self.said(picked, model, display);
        ui.horizontal(|ui| {
            let clear = ui.small_button("×").on_hover_text("clear this selection (Escape)");
            clear.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, "clear selection"));
            if clear.clicked() {
                selection.picked = None;
            }
            let text = egui::RichText::new(text).color(color(ui.visuals()));
            ui.add(egui::Label::new(text).truncate());
        });
        if parents.is_empty() {
            return;
        }
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 3.0;
            ui.weak("in");
            for (level, node) in parents.into_iter().enumerate() {
                if level > 0 {
                    ui.weak("›");
                }
                let link = ui.link(if level == 0 { "root".into() } else { node.to_string() });
                link.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Link, true, format!("select node {node}")));
                if link.on_hover_text(format!("select node {node}, level {level}")).clicked() {
                    selection.picked = Some(Picked::Node(node));
                }
            }
        });
    }

    fn said(&mut self, picked: Picked, model: &Model, display: &Display) -> Said {
        let at = |history: Option<&Arc<Trace>>| history.map_or(0, |history| Arc::as_ptr(history) as usize);
        let beside = display.beside.as_ref().map_or(0, |data| Arc::as_ptr(data) as usize);
        let key = (picked, model.generation, at(model.history.as_ref()), beside, display.units);
        if let Some((known, said)) = &self.known
            && *known == key
        {
            return said.clone();
        }
        let said = model.opened.as_ref().map_or_else(Said::default, |opened| {
            let walk = model.history.as_ref().map(|history| WalkGeometry::new(history, &opened.data, usize::MAX));
            // A node of the other structure, while this run has the grid.
            let is_here = marked(picked, &opened.data).is_some();
            let scale = model.history.as_ref().map_or(Scale::TRACED, |history| Scale::of(display.units, history));
            match display.beside.as_ref().filter(|_| !is_here) {
                Some(other) => Said { text: describe(picked, other, None, &scale), parents: parents(picked, other) },
                None => Said {
                    text: describe(picked, &opened.data, walk.as_ref(), &scale),
                    parents: parents(picked, &opened.data),
                },
            }
        });
        self.known = Some((key, said.clone()));
        said
    }
}

/// The nodes that contain what was picked, from the root on; none without a BVH.
fn parents(picked: Picked, data: &SceneData) -> Vec<u32> {
    let (node, leaf) = match picked {
        _ if !data.features.bvh => return Vec::new(),
        Picked::Cell(_) => return Vec::new(),
        Picked::Node(node) => (Some(node), None),
        Picked::Triangle(triangle) => {
            let leaf = leaf_of(data, triangle);
            (leaf, leaf)
        }
    };
    let mut chain: Vec<u32> = leaf.into_iter().chain(node.into_iter().flat_map(|node| above(data, node))).collect();
    chain.reverse();
    chain
}

#[cfg(test)]
mod tests {
    use raystep_kernels::Accelerator;

    use super::super::walked::tests::history;
    use super::*;

    #[test]
    fn rows_are_found_by_what_they_are_about() {
        for accelerator in [Accelerator::Grid, Accelerator::Bvh, Accelerator::None] {
            let (history, data) = history(accelerator);
            let walk = WalkGeometry::new(&history, &data, usize::MAX);
            let rows = |picked| history.rows.iter().filter(|row| touches(row, picked)).count();
            for test in &walk.tested {
                let picked = Picked::Triangle(test.triangle);
                assert!(touches(&history.rows[test.row], picked) && of_row(&history.rows[test.row]) == Some(picked));
                assert_eq!(rows(picked), walk.tested.iter().filter(|t| t.triangle == test.triangle).count());
                assert!(marked(picked, &data).is_some());
                let text = describe(picked, &data, Some(&walk), &Scale::TRACED);
                assert!(text.contains("tested ") && text.contains("by this ray"), "{text}");
            }
            for visit in &walk.cells {
                let picked = cell(visit.cell).expect("in the grid");
                assert!(rows(picked) > 0, "{picked:?}");
                assert_eq!(marked(picked, &data), Some(Marked::Box(visit.bounds)));
                let text = describe(picked, &data, Some(&walk), &Scale::TRACED);
                assert!(
                    text.contains(&format!(
                        "{}, visited by this ray",
                        counted(visit.listed, "triangle") + " in its list"
                    )),
                    "{text}"
                );
            }
            for visit in &walk.nodes {
                let picked = Picked::Node(visit.node);
                // A node that is missed is left for its neighbour at once: the row that brings the ray to it is marked.
                assert!(
                    touches(&history.rows[visit.row], picked) || touches(&history.rows[visit.row - 1], picked),
                    "{picked:?}"
                );
                assert_eq!(marked(picked, &data), Some(Marked::Box(visit.bounds)));
                // From the root down, each is a child of the one before.
                let chain: Vec<u32> = parents(picked, &data).into_iter().chain([visit.node]).collect();
                assert_eq!((chain.first(), chain.len() - 1), (Some(&0), visit.depth as usize));
                for pair in chain.windows(2) {
                    let first = data.bvh_nodes[pair[0] as usize].first;
                    assert!(pair[1] == first || pair[1] == first + 1, "{chain:?}");
                }
            }
            for test in walk.tested.iter().filter(|_| accelerator == Accelerator::Bvh) {
                let chain = parents(Picked::Triangle(test.triangle), &data);
                let leaf = data.bvh_nodes[*chain.last().expect("a leaf") as usize];
                let items = leaf.first as usize..(leaf.first + leaf.count()) as usize;
                assert!(data.bvh_items[items].contains(&test.triangle), "{chain:?}");
            }
            // A grid has no nodes, although cells have indices; a BVH has no cells.
            let others = if accelerator == Accelerator::Bvh { Picked::Cell([0; 3]) } else { Picked::Node(0) };
            assert_eq!((rows(others), marked(others, &data)), (0, None), "{accelerator:?}");
        }
    }

    #[test]
    fn a_triangle_is_counted_in_lists_and_tests() {
        let (history, data) = history(Accelerator::Grid);
        let walk = WalkGeometry::new(&history, &data, usize::MAX);
        let hit = walk.hit.expect("a hit").triangle;
        let lists = data.grid_items.iter().filter(|&&item| item == hit).count();
        let text = describe(Picked::Triangle(hit), &data, Some(&walk), &Scale::TRACED);
        assert!(text.starts_with(&format!("triangle {hit}: in {}, tested ", counted(lists, "cell"))), "{text}");
        assert!(text.contains("hit, t "), "{text}");
        let none = describe(Picked::Triangle(u32::MAX), &data, Some(&walk), &Scale::TRACED);
        assert!(none.contains("in 0 cells, not tested by this ray"), "{none}");
    }

    #[test]
    fn picking_the_same_thing_again_unpicks_it() {
        let mut selection = Selection::default();
        toggle(&mut selection, Picked::Node(3));
        toggle(&mut selection, Picked::Triangle(3));
        assert_eq!(selection.picked, Some(Picked::Triangle(3)));
        toggle(&mut selection, Picked::Triangle(3));
        assert_eq!(selection.picked, None);
    }
}
