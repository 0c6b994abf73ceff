//! A light tree as lines and dots.

use glam::DVec3;
use raystep_kernels::export::light_tree::VertexKind;
use raystep_kernels::scene_data::linear_to_srgb;

use super::{Color, Overlay, Palette, faded};
use crate::walk::Branch;

/// Dashes of what a ray did not reach.
const DASHES: u32 = 24;
/// Most rays drawn.
const MOST: usize = 5_000;

/// The hue of some light at full brightness: a dim lamp is visible, too.
pub(super) fn hue(light: [f32; 3]) -> Color {
    let most = light.into_iter().fold(0.0, f32::max);
    if !(most.is_finite() && most > 0.0) {
        return [128, 128, 128, 255];
    }
    let [r, g, b] = light.map(|c| (linear_to_srgb((c / most).clamp(0.0, 1.0)) * 255.0).round() as u8);
    [r, g, b, 255]
}

impl Overlay {
    pub(super) fn light(&mut self, branches: &[Branch], palette: &Palette) {
        for branch in branches.iter().take(MOST) {
            let Branch { from, to, beyond, kind, light, .. } = branch;
            match (light, beyond) {
                (Some(light), None) => {
                    self.edged(*from, *to, 2.2, hue(*light), palette);
                    self.dot(*to, 9.0, palette.ray);
                    self.dot(*to, 7.0, hue(*light));
                }
                (Some(light), Some(end)) => {
                    self.line(*from, *to, 2.0, palette.dark);
                    self.dashed(*to, *end, palette.dark);
                    if from != to {
                        self.dot(*to, 6.0, palette.missed);
                    }
                    self.dot(*end, 7.0, palette.dark);
                    self.dot(*end, 4.0, hue(*light));
                }
                (None, _) => {
                    let is_lost = *kind == VertexKind::Background;
                    self.line(*from, *to, 1.6, if is_lost { palette.dim_ray } else { palette.ray });
                    if !is_lost {
                        self.dot(*to, 6.0, palette.ray);
                    }
                }
            }
        }
    }

    /// A line with edges: of any colour, on any ground.
    fn edged(&mut self, a: DVec3, b: DVec3, widths: f32, color: Color, palette: &Palette) {
        self.line(a, b, widths + 1.6, faded(palette.edge, 0.8));
        self.line(a, b, widths, color);
    }

    fn dashed(&mut self, a: DVec3, b: DVec3, color: Color) {
        for i in 0..DASHES {
            let at = |part: f64| a.lerp(b, (f64::from(i) + part) / f64::from(DASHES));
            self.line(at(0.25), at(0.75), 1.4, color);
        }
    }
}
