//! Photons as dots, a pixel's search for them, and the way of one of them.

use std::f64::consts::TAU;

use super::light::hue;
use super::{Color, Overlay, Palette, Settings, faded};
use crate::draw::scene3d::settings::PhotonPaint;
use crate::photons::{Photons, Searched};
use crate::walk::{Aabb, to_f64};

/// Sides of a circle.
const SIDES: u32 = 64;

fn largest(power: [f32; 3]) -> f32 {
    power.into_iter().fold(0.0, f32::max)
}

impl Overlay {
    pub(super) fn photons(&mut self, photons: &Photons, settings: &Settings, palette: &Palette) {
        if settings.photons {
            let most = photons.dots.iter().map(|dot| largest(dot.power)).filter(|most| most.is_finite());
            let most = most.fold(f32::MIN_POSITIVE, f32::max);
            for dot in &photons.dots {
                let color = match settings.photon_paint {
                    PhotonPaint::Power => {
                        // Half the brightness is a sixteenth of the power.
                        let part = (largest(dot.power) / most).clamp(0.0, 1.0).sqrt().sqrt();
                        let [r, g, b, _] = hue(dot.power).map(|c| (f32::from(c) * part.max(0.25)) as u8);
                        [r, g, b, 255]
                    }
                    PhotonPaint::Bounce => palette.in_order(dot.bounce as usize - 1, photons.bounces as usize),
                    PhotonPaint::Map => of_map(dot.is_caustic, palette),
                };
                // A photon that came by mirrors and glass alone is seen among the others in any colour.
                self.dot(to_f64(dot.point), if dot.is_caustic { 3.6 } else { 2.2 }, color);
            }
        }
        if let Some(search) = photons.search.as_ref().filter(|_| settings.search) {
            self.search(search, palette);
        }
        for pair in photons.path.windows(2) {
            self.line(pair[0], pair[1], 3.2, faded(palette.edge, 0.8));
            self.line(pair[0], pair[1], 1.8, palette.current);
        }
        if let Some(&first) = photons.path.first() {
            self.dot(first, 8.0, palette.current);
        }
        for stop in &photons.stops {
            self.dot(to_f64(stop.point), 8.0, palette.ray);
            self.dot(to_f64(stop.point), 6.0, of_map(stop.is_caustic, palette));
        }
    }

    /// The cells, the circle within which photons are taken, and those taken, with their directions.
    fn search(&mut self, Searched { search, radius, taken }: &Searched, palette: &Palette) {
        for (i, &[min, max]) in search.cells.iter().enumerate() {
            let is_current = i + 1 == search.cells.len() && !search.is_over;
            let color = if is_current { palette.current } else { palette.in_order(i, search.cells.len()) };
            self.edges(
                &Aabb { min, max },
                if is_current { 2.0 } else { 1.0 },
                if is_current { color } else { faded(color, 0.6) },
            );
        }
        let (right, up) = search.normal.any_orthonormal_pair();
        let at = |side: u32| {
            let turn = TAU * f64::from(side) / f64::from(SIDES);
            search.point + (right * turn.cos() + up * turn.sin()) * *radius
        };
        for side in 0..SIDES {
            self.line(at(side), at(side + 1), 2.0, palette.picked);
        }
        self.dot(search.point, 7.0, palette.picked);
        for photon in taken {
            let [place, came] = [photon.point, photon.direction].map(to_f64);
            self.line(place - came * (0.35 * radius), place, 0.8, faded(palette.current, 0.5));
            self.dot(place, 5.0, palette.edge);
            self.dot(place, 4.0, of_map(photon.is_caustic, palette));
        }
    }
}

fn of_map(is_caustic: bool, palette: &Palette) -> Color {
    if is_caustic { palette.missed } else { palette.axes[2] }
}
