//! The errors of a run as a small PNG.

use crate::Error;
use crate::png;
use crate::reference::Verdict;

/// Columns and rows of a map of directions, longitude by latitude.
const MAP: [u32; 2] = [128, 64];

/// Maximum width; longer rows are folded.
const LONGEST: u32 = 128;

const PAPER: [u8; 3] = [250, 250, 247];
const SAME: [u8; 3] = [214, 218, 216];
const TIE: [u8; 3] = [90, 150, 230];
const MISSED: [u8; 3] = [208, 32, 44];
const FALSE: [u8; 3] = [142, 46, 170];
const WRONG: [u8; 3] = [235, 130, 20];

/// Colours and their meanings, for a legend.
pub(super) const LEGEND: [([u8; 3], &str); 5] =
    [(SAME, "right"), (TIE, "undecided"), (MISSED, "missed"), (FALSE, "false hit"), (WRONG, "wrong hit")];

/// All errors and undecided rays of a run.
#[derive(Clone, Debug)]
pub(super) struct Picture {
    /// The runs with this picture.
    pub(super) runs: Vec<String>,
    /// Whether points are pixels; otherwise they are directions.
    pub(super) is_image: bool,
    width: u32,
    height: u32,
    pixels: Vec<[u8; 3]>,
}

impl Picture {
    /// `None` if every ray is right. A case without a camera has no size, and is drawn as a map of directions.
    pub(super) fn of(
        verdicts: &[Verdict],
        size: Option<[u32; 2]>,
        directions: impl FnOnce() -> Vec<[f32; 3]>,
    ) -> Option<Self> {
        if verdicts.iter().all(|v| *v == Verdict::Same) {
            return None;
        }
        let [width, height] = size.map_or(MAP, |[width, height]| match (width, height) {
            (w, h) if w > LONGEST || h > 4 * LONGEST => [LONGEST, (w * h).div_ceil(LONGEST)],
            size => size.into(),
        });
        let mut pixels = vec![if size.is_some() { SAME } else { PAPER }; width as usize * height as usize];
        let mut worst = vec![0; pixels.len()];
        let directions = if size.is_some() { Vec::new() } else { directions() };
        for (i, verdict) in verdicts.iter().enumerate() {
            let at = directions.get(i).map_or(i, |d| place(*d));
            let (rank, color) = match verdict {
                Verdict::Same => (1, SAME),
                Verdict::Tie => (2, TIE),
                Verdict::Missed => (3, MISSED),
                Verdict::False => (3, FALSE),
                Verdict::Wrong => (3, WRONG),
            };
            // Errors stay visible when other rays fall on the same point.
            if let (Some(pixel), Some(worst)) = (pixels.get_mut(at), worst.get_mut(at))
                && rank >= *worst
            {
                (*pixel, *worst) = (color, rank);
            }
        }
        Some(Self { runs: Vec::new(), is_image: size.is_some(), width, height, pixels })
    }

    pub(super) fn is_same(&self, other: &Self) -> bool {
        self.width == other.width && self.pixels == other.pixels
    }

    /// Columns and rows.
    pub(super) fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    pub(super) fn png(&self) -> Result<Vec<u8>, Error> {
        Ok(png::encode(self.width, self.height, self.pixels.as_flattened())?)
    }
}

/// A direction's position on the map: longitude to the right, up at the top.
fn place(direction: [f32; 3]) -> usize {
    let [x, y, z] = direction.map(f64::from);
    let length = (x * x + y * y + z * z).sqrt();
    let longitude = x.atan2(-z) / (2.0 * std::f64::consts::PI) + 0.5;
    let latitude = 0.5 - (y / length).clamp(-1.0, 1.0).asin() / std::f64::consts::PI;
    let cell = |part: f64, of: u32| ((part * f64::from(of)) as usize).min(of as usize - 1);
    cell(latitude, MAP[1]) * MAP[0] as usize + cell(longitude, MAP[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_seen_where_it_is_and_what_is_right_has_no_picture() {
        let none = || panic!("images need no directions");
        assert!(Picture::of(&[Verdict::Same; 4], Some([2, 2]), none).is_none());
        let verdicts = [Verdict::Same, Verdict::Tie, Verdict::Missed, Verdict::False];
        let picture = Picture::of(&verdicts, Some([2, 2]), none).expect("errors");
        assert_eq!(picture.pixels, [SAME, TIE, MISSED, FALSE]);
        assert_eq!(&picture.png().expect("a PNG")[1..4], b"PNG");
        let folded = Picture::of(&[Verdict::Wrong; 300], Some([300, 1]), none).expect("errors");
        assert_eq!(folded.size(), [128, 3]);

        let up = [0.0, 1.0, 0.0];
        let map = Picture::of(&[Verdict::Missed, Verdict::Same], None, || vec![up, up]).expect("errors");
        assert_eq!(map.pixels[place(up)], MISSED, "correct rays do not hide errors");
        assert!(place(up) < 128 && place([0.0, -1.0, 0.0]) >= 128 * 63);
    }
}
