//! Where photons are stored and what a pixel's search takes of them, for pictures and explanations: by the host, from the
//! streams of a run.

use glam::DVec3;

use crate::numbers::real::Vec3;
use crate::plan::Plan;
use crate::program::RayState;
use crate::program::ray_state::Gather;
use crate::programs::closest_hit::elements::PHOTONS;
use crate::programs::closest_hit::streams::PHOTON_RECORDS;
use crate::scene_data::SceneData;
use crate::shared::constants::RECORD;
use crate::shared::start::{Start, start_of};
use crate::shared::vector::unit3;
use crate::tables::elements::Elements;
use crate::tables::stream::{Stream, StreamData};

/// The stream that [`stored`] reads.
pub const RECORDS: Stream = PHOTON_RECORDS;
/// The set of photons.
pub const SET: &Elements = &PHOTONS;

/// A photon at a place where it is stored, in traced units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stored {
    /// The photon, counted from 0.
    pub photon: u32,
    /// How many surfaces it had left when it arrived here.
    pub bounce: u32,
    /// The place.
    pub point: [f32; 3],
    /// Where it was going; length 1.
    pub direction: [f32; 3],
    /// Its power, linear.
    pub power: [f32; 3],
    /// Whether it came by mirrors and glass alone.
    pub is_caustic: bool,
    /// Why it ended here, as its stream says; 0 if it went on.
    pub ended: u32,
}

/// Whether a run stores photons.
#[must_use]
pub fn has_photons(plan: &Plan) -> bool {
    plan.has_stream(RECORDS)
}

/// All places where photons are stored by now, bounce by bounce, in the order of photons.
#[must_use]
pub fn stored(records: &StreamData) -> Vec<Stored> {
    let (photons, layers) = (records.layer(0).len(), records.stream.layers());
    let bounces = 0..(layers / RECORD as usize);
    let at = |bounce: usize, photon: usize| {
        let first = bounce * RECORD as usize;
        let map = records.get(first + 9, photon);
        let vector = |from: usize| [0, 1, 2].map(|axis| records.get_f32(first + from + axis, photon));
        (map <= 1).then(|| Stored {
            photon: photon as u32,
            bounce: bounce as u32 + 1,
            point: vector(0),
            direction: vector(3),
            power: vector(6),
            is_caustic: map == 1,
            ended: records.get(first + 10, photon),
        })
    };
    bounces.flat_map(|bounce| (0..photons).filter_map(move |photon| at(bounce, photon))).collect()
}

/// Where a ray's search for photons begins: its hit.
fn start(data: &SceneData, ray: &RayState) -> Option<Start<f32>> {
    let (triangle, weights) = ray.triangle.zip(ray.barycentric)?;
    Some(start_of(data.corners(triangle), weights, unit3(Vec3::from_f32(ray.direction))))
}

/// The cell that a ray's search is in.
pub(super) fn cell_around(data: &SceneData, ray: &RayState) -> Option<[i32; 3]> {
    let (start, around) = (start(data, ray)?, ray.gather?.around?);
    let map = &data.photon_map;
    Some(there(map.cell_of(map.place_of(start.point)), around))
}

/// The step to one of the 27 cells around a cell.
fn step_to(around: u32) -> [i32; 3] {
    [around % 3, around / 3 % 3, around / 9].map(|step| step as i32 - 1)
}

fn there(cell: [i32; 3], around: u32) -> [i32; 3] {
    let step = step_to(around);
    [0, 1, 2].map(|axis| cell[axis] + step[axis])
}

/// The cells that a search from this hit has come to by now, by growing distance.
fn cells_searched(data: &SceneData, gather: &Gather, point: Vec3<f32>) -> Vec<[i32; 3]> {
    let map = &data.photon_map;
    let place = map.place_of(point);
    let cell = map.cell_of(place);
    let mut cells: Vec<u32> = (0..27).filter(|around| gather.visited >> around & 1 != 0).collect();
    cells.sort_by_key(|&around| map.distance_to(place, cell, step_to(around)).to_bits());
    cells.into_iter().map(|around| there(cell, around)).collect()
}

/// How far away photons may be that a search takes, as far as it is known by now: as far as the farthest of as many as are
/// wanted, or the radius; that of earlier iterations, if there were any.
pub(super) fn radius(data: &SceneData, gather: &Gather) -> f32 {
    let has_enough = gather.found >= data.photon_map.nearest && (gather.sweep == 0 || !data.features.samples);
    if has_enough { gather.farthest } else { gather.limit }
}

/// A search for the photons near a pixel's hit, up to some pass; traced units.
#[derive(Clone, Debug, PartialEq)]
pub struct Search {
    /// How far it has got.
    pub gather: Gather,
    /// The hit.
    pub point: DVec3,
    /// Of the hit's surface, to the side that is seen; length 1.
    pub normal: DVec3,
    /// Corners of the cells searched since it began or began again, in order.
    pub cells: Vec<[DVec3; 2]>,
    /// Photons count that are stored after so many bounces: the ray has had the others.
    pub bounces: u32,
    /// Whether no cell is left.
    pub is_over: bool,
}

impl Search {
    /// The last search in the rays after these passes, the rows of a history; `None` without any.
    #[must_use]
    pub fn of<'a>(data: &SceneData, mut rays: impl DoubleEndedIterator<Item = &'a RayState>) -> Option<Self> {
        let last = rays.rfind(|ray| ray.gather.is_some())?;
        let (gather, start) = (last.gather?, start(data, last)?);
        let vector = |v: Vec3<f32>| DVec3::from_array(v.to_f64());
        let cells = cells_searched(data, &gather, start.point);
        let is_over = gather.around.is_none() && !cells.is_empty();
        let cells = cells.into_iter().map(|cell| bounds(data, cell)).collect();
        let bounces = data.features.depth.saturating_sub(last.bounce.unwrap_or_default().depth + 1);
        Some(Self { gather, point: vector(start.point), normal: vector(start.normal), cells, bounces, is_over })
    }

    /// How far away photons may be that it takes, as far as it is known by now.
    #[must_use]
    pub fn radius(&self, data: &SceneData) -> f64 {
        f64::from(radius(data, &self.gather))
    }

    /// Which photons it has taken: those within its radius in the cells searched, that came from the side that is seen. By
    /// the host, in f64: one at the edge may be decided otherwise.
    pub fn taken<'a>(&'a self, data: &SceneData, stored: &'a [Stored]) -> impl Iterator<Item = usize> + use<'a> {
        let (radius, slack) = (self.radius(data), f64::from(data.photon_map.margin) * f64::from(data.photon_map.width));
        let maps = data.photon_map.maps;
        let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let is_taken = move |photon: &Stored| {
            let at = vector(photon.point);
            let is_searched = |[low, high]: &[DVec3; 2]| at.cmpge(*low - slack).all() && at.cmple(*high + slack).all();
            (photon.is_caustic == self.gather.is_caustic || maps == 1)
                && photon.bounce <= self.bounces
                && (at - self.point).length() <= radius * (1.0 + 1e-6)
                && vector(photon.direction).dot(self.normal) < 0.0
                && self.cells.iter().any(is_searched)
        };
        stored.iter().enumerate().filter(move |(_, photon)| is_taken(photon)).map(|(index, _)| index)
    }
}

/// The corners of a cell of the map.
fn bounds(data: &SceneData, cell: [i32; 3]) -> [DVec3; 2] {
    let map = &data.photon_map;
    let corner = |by: f64| {
        let along = |axis: usize| f64::from(map.corner[axis]) + (f64::from(cell[axis]) + by) * f64::from(map.width);
        DVec3::from_array([0, 1, 2].map(along))
    };
    [corner(0.0), corner(1.0)]
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use raystep_scenes::generate;

    use super::*;
    use crate::history::{Rays, TraceRow, trace, trace_element};
    use crate::options::{Accelerator, Integrator, Options, Photons, RaySource, ScheduleKind};
    use crate::renderer::{Device, Renderer};

    fn renderer() -> Renderer {
        let scene = generate::cornell_box();
        let rays = RaySource::Camera { camera: scene.cameras[0].clone(), width: 24, height: 24 };
        let photons = Photons { count: 2000, radius: 60, nearest: 20, ..Photons::default() };
        let (integrator, accelerator) = (Integrator::Photons, Accelerator::Bvh);
        let schedule = ScheduleKind::Second;
        let steps_per_pass = 1;
        let options = Options { integrator, accelerator, schedule, photons, steps_per_pass, ..Options::new(rays) };
        pollster::block_on(Renderer::new(&scene, &options, &Device::Cpu(None))).expect("a plan")
    }

    fn all_stored(renderer: &Renderer) -> Vec<Stored> {
        stored(&pollster::block_on(renderer.values(RECORDS)).expect("values"))
    }

    fn states(rows: &[TraceRow]) -> impl DoubleEndedIterator<Item = &RayState> {
        rows.iter().map(|row| &row.after)
    }

    /// The photons within the circle, by the host, are as many as the search has found, for pixels all over the image.
    #[test]
    fn a_pixels_photons_are_those_that_its_search_took() {
        let mut renderer = renderer();
        let (mut searches, mut most) = (0, 0);
        for pixel in [[12, 20], [4, 18], [20, 21], [12, 12], [2, 6]] {
            let go_on = |_: &_| ControlFlow::Continue(());
            let history = trace(&mut renderer, pixel[0], pixel[1], Rays::One, go_on);
            let history = pollster::block_on(history).expect("a history");
            let data = renderer.shared_data();
            let Some(search) = Search::of(&data, states(&history.rows)) else { continue };
            assert!(search.is_over, "{search:?}");
            let photons = all_stored(&renderer);
            let taken = search.taken(&data, &photons).count() as u32;
            assert_eq!(taken, search.gather.found, "{pixel:?}: {search:?}");
            let gathers: Vec<_> = history.rows.iter().filter(|row| row.kernel == "gather").collect();
            let cells = gathers.iter().filter(|row| row.why.starts_with("cell (")).count();
            assert!(cells >= search.cells.len() && !search.cells.is_empty(), "{history:?}");
            let told = format!("none farther away than {}", search.radius(&data) as f32);
            assert!(gathers.last().is_some_and(|row| row.why.ends_with(&told)), "{told}: {gathers:?}");
            let brought = format!(" by {} photon", search.gather.found);
            assert!(history.rows.iter().any(|row| row.why.contains(&brought)), "{brought}: {history:?}");
            // While it is under way, it has not taken more.
            let half = history.rows.len() - 2;
            let part = Search::of(&data, states(&history.rows[..half])).expect("a search");
            assert!(part.gather.found <= search.gather.found && part.cells.len() <= search.cells.len());
            (searches, most) = (searches + 1, most.max(taken));
        }
        assert!(searches > 2 && most > 0, "{searches} searches, {most} photons");
    }

    /// A photon's history leads from a light to its end, and each of its records is a row.
    #[test]
    fn a_photons_history_is_told_from_a_light_to_its_end() {
        let mut renderer = renderer();
        let (mut bounces, mut places) = (0, 0);
        for photon in [0, 7, 123, 1999] {
            let history = trace_element(&mut renderer, SET, photon, |_| ControlFlow::Continue(()));
            let history = pollster::block_on(history).expect("a history");
            let named = history.element.expect("an element");
            assert_eq!((named.set, named.index), (SET.name, photon));
            let [first, .., last] = &history.rows[..] else { panic!("{history:?}") };
            assert!(first.kernel == "emit_photons" && first.why.starts_with("emitted by "), "{first:?}");
            assert!(first.why.ends_with(&format!("b {:.3e}", first.after.photon.expect("it").power[2])), "{first:?}");
            assert!(last.kernel == "scatter_photons" && last.after.state == "PHOTON_DONE", "{last:?}");
            assert!(last.why.contains("ends: ") || last.why.contains("leaves the scene"), "{last:?}");
            let records = all_stored(&renderer).into_iter().filter(|at| at.photon == photon).count();
            let told = history.rows.iter().filter(|row| row.why.contains("; stored in the ")).count();
            assert_eq!(told, records, "{history:?}");
            let walks = history.rows.iter().filter(|row| row.kernel == "photon_setup").count();
            assert_eq!(walks, history.rows.iter().filter(|row| row.kernel == "scatter_photons").count());
            assert!(history.table(crate::history::units::Units::Scene).contains("This photon waited in "));
            (bounces, places) = (bounces + walks, places + records);
        }
        assert!(bounces > 4 && places > 0, "{bounces} walks, {places} places");
        let missing = trace_element(&mut renderer, SET, u32::MAX, |_| ControlFlow::Continue(()));
        let error = pollster::block_on(missing).expect_err("too large").to_string();
        assert!(error.contains("photon"), "{error}");
    }
}
