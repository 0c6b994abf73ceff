//! Photons as dots, a pixel's search for them, and the way of one of them.

use std::f64::consts::TAU;

use glam::DVec3;
use raystep_kernels::programs::photons::stored::Stored;

use super::light::hue;
use super::{Color, Overlay, Palette, Settings, faded};
use crate::draw::scene3d::settings::PhotonPaint;
use crate::photons::{Photons, Searched};

/// Sides of a circle.
const SIDES: u32 = 64;

fn place(of: &Stored) -> DVec3 {
    DVec3::from_array(of.point.map(f64::from))
}

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
                self.dot(place(dot), if dot.is_caustic { 3.6 } else { 2.2 }, color);
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
            self.dot(place(stop), 8.0, palette.ray);
            self.dot(place(stop), 6.0, of_map(stop.is_caustic, palette));
        }
    }

    /// The cells, the circle within which photons are taken, and those taken, with their directions.
    fn search(&mut self, search: &Searched, palette: &Palette) {
        let last = search.cells.len().saturating_sub(1);
        for (i, cell) in search.cells.iter().enumerate() {
            let is_current = i == last && !search.is_over;
            let color = if is_current { palette.current } else { palette.in_order(i, search.cells.len()) };
            self.edges(cell, if is_current { 2.0 } else { 1.0 }, if is_current { color } else { faded(color, 0.6) });
        }
        let (right, up) = search.normal.any_orthonormal_pair();
        let at = |side: u32| {
            let turn = TAU * f64::from(side) / f64::from(SIDES);
            search.point + (right * turn.cos() + up * turn.sin()) * search.radius
        };
        for side in 0..SIDES {
            self.line(at(side), at(side + 1), 2.0, palette.picked);
        }
        self.dot(search.point, 7.0, palette.picked);
        for taken in &search.taken {
            let came = DVec3::from_array(taken.direction.map(f64::from));
            self.line(place(taken) - came * (0.35 * search.radius), place(taken), 0.8, faded(palette.current, 0.5));
            self.dot(place(taken), 5.0, palette.edge);
            self.dot(place(taken), 4.0, of_map(taken.is_caustic, palette));
        }
    }
}

fn of_map(is_caustic: bool, palette: &Palette) -> Color {
    if is_caustic { palette.missed } else { palette.axes[2] }
}
