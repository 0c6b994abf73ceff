//! Arrangements of panels from files: only sound ones are shown.

use std::collections::HashSet;

use egui_tiles::{Container, Tile, TileId, Tree};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};

use crate::ui::pane::Pane;

/// Most tiles of a layout.
const MOST_TILES: usize = 500;
/// Largest share of a tile.
const LARGEST_SHARE: f32 = 1e6;

/// A layout, checked.
pub(super) fn check<'de, D: Deserializer<'de>>(from: D) -> Result<Option<String>, D::Error> {
    let text = Option::<String>::deserialize(from)?;
    if let Some(text) = &text {
        read(text).map_err(D::Error::custom)?;
    }
    Ok(text)
}

/// The panels of a layout.
///
/// # Errors
/// Where it is not one, or not sound: a tile inside itself would be shown without end.
pub(crate) fn read(text: &str) -> Result<Tree<Pane>, String> {
    let tree: Tree<Pane> = serde_json::from_str(text).map_err(|e| format!("layout: {e}"))?;
    if tree.tiles.len() > MOST_TILES {
        return Err(format!("layout: {} tiles, but at most {MOST_TILES} are shown", tree.tiles.len()));
    }
    let mut seen = HashSet::new();
    let mut waiting: Vec<TileId> = tree.root.into_iter().collect();
    while let Some(id) = waiting.pop() {
        let Some(tile) = tree.tiles.get(id) else {
            return Err(format!("layout: there is no tile {}", id.0));
        };
        if !seen.insert(id) {
            return Err(format!("layout: tile {} is there twice", id.0));
        }
        if let Tile::Container(container) = tile {
            waiting.extend(container.children());
            let shares: Vec<f32> = match container {
                Container::Linear(linear) => linear.shares.iter().map(|(_, share)| *share).collect(),
                Container::Grid(grid) => grid.col_shares.iter().chain(&grid.row_shares).copied().collect(),
                Container::Tabs(_) => Vec::new(),
            };
            if shares.iter().any(|share| !(0.0..=LARGEST_SHARE).contains(share)) {
                return Err(format!("layout: the shares of tile {} are not from 0 to {LARGEST_SHARE}", id.0));
            }
        }
    }
    Ok(tree)
}
