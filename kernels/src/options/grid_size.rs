//! How fine a uniform grid is.

use std::fmt;
use std::str::FromStr;

/// The grid's resolution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum GridSize {
    /// From the number of triangles and the scene's extent, see [`automatic_cells`](crate::structures::grid::automatic_cells).
    #[default]
    Auto,
    /// Cells along x, y and z.
    Cells([u32; 3]),
}

/// Most cells of a grid along an axis that can be asked for.
pub const MOST_CELLS: u32 = 4096;

impl fmt::Display for GridSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Cells([x, y, z]) => write!(f, "{x},{y},{z}"),
        }
    }
}

impl FromStr for GridSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        let wrong =
            || "expected auto, one number of cells, or one each for x, y and z, such as 32 or 32,8,32".to_owned();
        let number = |part: &str| {
            let digits = part.strip_prefix('-').unwrap_or(part);
            if digits.is_empty() || !digits.bytes().all(|b| b.is_ascii_digit()) {
                return Err(wrong());
            }
            let number = part.parse().ok().filter(|n| (1..=MOST_CELLS).contains(n));
            number.ok_or_else(|| format!("expected 1 to {MOST_CELLS} cells along an axis"))
        };
        let cells = text.split(',').take(4).map(number).collect::<Result<Vec<_>, _>>()?;
        match cells[..] {
            [n] => Ok(Self::Cells([n; 3])),
            [x, y, z] => Ok(Self::Cells([x, y, z])),
            _ => Err(wrong()),
        }
    }
}
