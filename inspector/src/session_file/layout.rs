//! Arrangements of panels from files: only sound ones are shown.

use std::collections::HashSet;

use egui_tiles::{Container, Tile, TileId, Tree};
use serde::de::{DeserializeOwned, Error as _};
use serde::{Deserialize, Deserializer, Serialize};

use crate::command::PaneKind;

/// Most tiles of a layout.
const MOST_TILES: usize = 500;
/// Largest share of a tile.
const LARGEST_SHARE: f32 = 1e6;

/// A panel as it is saved.
#[derive(Serialize, Deserialize)]
pub(crate) struct SavedPane {
    pub(crate) kind: PaneKind,
    /// A text of the panel.
    #[serde(default)]
    pub(crate) state: String,
}

/// A layout, checked.
pub(super) fn check<'de, D: Deserializer<'de>>(from: D) -> Result<Option<String>, D::Error> {
    let text = Option::<String>::deserialize(from)?;
    if let Some(text) = &text {
        read::<SavedPane>(text).map_err(D::Error::custom)?;
    }
    Ok(text)
}

/// Whether a layout can be saved: it would be read again.
pub(crate) fn is_sound(text: &str) -> bool {
    read::<SavedPane>(text).is_ok()
}

/// The panels of a layout.
///
/// # Errors
/// Where it is not one, or not sound: a tile inside itself would be shown without end.
pub(crate) fn read<P: DeserializeOwned>(text: &str) -> Result<Tree<P>, String> {
    let tree: Tree<P> = serde_json::from_str(text).map_err(|e| format!("layout: {e}"))?;
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
