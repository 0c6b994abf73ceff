//! The panels of a step.

use egui_tiles::{Container, Linear, LinearDir, Tile, TileId, Tiles, Tree};

use crate::command::PaneKind;
use crate::ui::panes::Pane;

/// The panels at the start of a lesson.
const FIRST: [PaneKind; 3] = [PaneKind::Passes, PaneKind::Stream, PaneKind::Ray];

/// Panels in rows from top to bottom; those at the start without any. The others have a row at the bottom: there is no
/// largest tile yet to add them to.
pub(super) fn arrange(rows: Option<&[Vec<PaneKind>]>, more: &[PaneKind]) -> Tree<Pane> {
    let mut rows = rows.map_or_else(|| vec![FIRST.to_vec()], <[_]>::to_vec);
    let mut last = Vec::new();
    for kind in more {
        if !last.contains(kind) && !rows.iter().flatten().any(|shown| shown == kind) {
            last.push(*kind);
        }
    }
    rows.extend((!last.is_empty()).then_some(last));
    let mut tiles = Tiles::default();
    let rows: Vec<(TileId, f32)> = rows
        .iter()
        .map(|kinds| {
            let columns = kinds.iter().map(|&kind| {
                let pane = tiles.insert_pane(Pane::new(kind));
                (tiles.insert_tab_tile(vec![pane]), share(kind))
            });
            let columns: Vec<_> = columns.collect();
            (side_by_side(&mut tiles, LinearDir::Horizontal, &columns), 1.0)
        })
        .collect();
    let root = side_by_side(&mut tiles, LinearDir::Vertical, &rows);
    Tree::new(egui::Id::unique("panes"), root, tiles)
}

/// How much of a row's width a panel takes, relative to others.
fn share(kind: PaneKind) -> f32 {
    match kind {
        PaneKind::Passes => 0.6,
        PaneKind::Ray => 1.2,
        _ => 1.0,
    }
}

fn side_by_side(tiles: &mut Tiles<Pane>, dir: LinearDir, children: &[(TileId, f32)]) -> TileId {
    if let [(only, _)] = children {
        return *only;
    }
    let mut linear = Linear::new(dir, children.iter().map(|(child, _)| *child).collect());
    children.iter().for_each(|&(child, part)| linear.shares.set_share(child, part));
    tiles.insert_new(Tile::Container(Container::Linear(linear)))
}
