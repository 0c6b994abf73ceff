//! Photons as geometry, in traced units: where they are stored, what a pixel's search takes of them, and the way of one of
//! them, for any kind of picture.

use glam::DVec3;
use raystep_kernels::export::trace::{Trace, TraceRow};
use raystep_kernels::programs::photons::stored::{Search, Stored};
use raystep_kernels::scene_data::SceneData;
use raystep_lab::text::counted;

use crate::walk::{Aabb, to_f64};

/// Most places that are drawn: of more, one in so many.
pub const MOST_DOTS: usize = 20_000;

/// A search for the photons near a pixel's hit.
#[derive(Clone, Debug, PartialEq)]
pub struct Searched {
    /// How far it has got.
    pub search: Search,
    /// Within which photons are taken.
    pub radius: f64,
    /// The photons taken.
    pub taken: Vec<Stored>,
}

impl Searched {
    /// The latest search in these rows of a pixel's history.
    #[must_use]
    pub fn of(rows: &[TraceRow], data: &SceneData, stored: &[Stored]) -> Option<Self> {
        let search = Search::of(data, rows.iter().map(|row| &row.after))?;
        let taken = search.taken(data, stored).filter_map(|index| stored.get(index).copied()).collect();
        Some(Self { radius: search.radius(data), taken, search })
    }

    /// In words; lengths are multiplied by this.
    #[must_use]
    pub fn sentence(&self, number: impl Fn(f64) -> String) -> String {
        let Search { gather, cells, is_over, .. } = &self.search;
        let map = if gather.is_caustic { " of the caustic map" } else { "" };
        format!(
            "the pixel's search {} {}{map} in {}, none farther away than {}",
            if *is_over { "found" } else { "has found" },
            counted(u64::from(gather.found), "photon"),
            counted(cells.len(), "cell"),
            number(self.radius)
        )
    }
}

/// What is drawn of photons.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Photons {
    /// Places where they are stored, or some of them.
    pub dots: Vec<Stored>,
    /// Number of all places.
    pub places: usize,
    /// How many of them are in the caustic map.
    pub caustic: usize,
    /// Highest bounce of any.
    pub bounces: u32,
    /// The selected pixel's search.
    pub search: Option<Searched>,
    /// The points where the selected photon's way bends, from its light on.
    pub path: Vec<DVec3>,
    /// The places where it is stored.
    pub stops: Vec<Stored>,
}

impl Photons {
    /// Of all places where photons are stored, one in so many that no more than [`MOST_DOTS`] are drawn.
    #[must_use]
    pub fn of(stored: &[Stored]) -> Self {
        let every = stored.len().div_ceil(MOST_DOTS).max(1);
        Self {
            dots: stored.iter().step_by(every).copied().collect(),
            places: stored.len(),
            caustic: stored.iter().filter(|at| at.is_caustic).count(),
            bounces: stored.iter().map(|at| at.bounce).max().unwrap_or_default(),
            ..Self::default()
        }
    }

    /// How many places there are, and whether all are drawn.
    #[must_use]
    pub fn sentence(&self) -> String {
        let caustic = if self.caustic > 0 { format!(", {} of them caustic", self.caustic) } else { String::new() };
        let shown = if self.dots.len() < self.places { format!(", {} shown", self.dots.len()) } else { String::new() };
        format!("{}{caustic}{shown}", counted(self.places, "stored photon"))
    }
}

/// The points where a photon's way bends, by these rows of its history: its light, the surfaces, and where it is stopped,
/// or leaves the box of the scene and goes on for a while.
#[must_use]
pub fn path(history: &Trace, rows: usize, scene: &Aabb) -> Vec<DVec3> {
    let mut points: Vec<DVec3> = Vec::new();
    let Some(rows) = history.rows.get(..rows) else { return points };
    let mut states = rows.iter().filter_map(|row| Some((&row.after, row.after.photon?)));
    for (ray, photon) in states.clone() {
        let from = to_f64(ray.origin);
        if photon.hits == 0 && points.len() > 1 {
            // It is emitted once more.
            points.clear();
        }
        if points.last() != Some(&from) {
            points.push(from);
        }
    }
    if let Some((last, photon)) = states.next_back().filter(|(ray, _)| !ray.is_walking) {
        let [from, direction] = [last.origin, last.direction].map(to_f64);
        match last.t.filter(|_| last.triangle.is_some()) {
            Some(t) => points.push(from + direction * f64::from(t)),
            None if photon.ended != 0 => {
                let leaves = scene.interval(from, direction).map_or(0.0, |[_, leaves]| leaves);
                points.push(from + direction * leaves + direction.normalize_or_zero() * (0.3 * scene.radius()));
            }
            None => {}
        }
    }
    points.retain(|point| point.is_finite());
    points
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use raystep_kernels::export::trace::{Rays, trace, trace_element};
    use raystep_kernels::options::{Integrator, Photons as OfRun};
    use raystep_kernels::programs::photons::stored;
    use raystep_kernels::{Device, Options, Renderer};

    use super::*;
    use crate::walk::tests::{CORNELL, options, scene};

    fn renderer() -> Renderer {
        let scene = scene(CORNELL);
        let photons = OfRun { count: 3000, radius: 60, nearest: 20, ..OfRun::default() };
        let options = Options { integrator: Integrator::Photons, photons, ..options(&scene) };
        pollster::block_on(Renderer::new(&scene, &options, &Device::Cpu(None))).expect("a plan")
    }

    #[test]
    fn a_photons_way_goes_from_a_light_past_its_places_to_its_end() {
        let mut renderer = renderer();
        let (mut bends, mut lost) = (0, 0);
        for photon in 0..6 {
            let history = trace_element(&mut renderer, stored::SET, photon, |_| ControlFlow::Continue(()));
            let history = pollster::block_on(history).expect("a history");
            let data = renderer.shared_data();
            let bounds = Aabb::of_vertices(&data.vertices);
            let way = path(&history, history.rows.len(), &bounds);
            assert!(way.len() > 1, "{way:?}");
            let records = stored::stored(&pollster::block_on(renderer.values(stored::RECORDS)).expect("values"));
            for at in records.iter().filter(|at| at.photon == photon) {
                let place = to_f64(at.point);
                let nearest = way.iter().map(|point| (*point - place).length()).fold(f64::MAX, f64::min);
                assert!(nearest < 1e-4, "{place} is {nearest} off {way:?}");
            }
            let hits = history.rows.last().and_then(|row| row.after.photon).expect("it").hits as usize;
            assert_eq!(way.len(), hits + 2, "{history:?}");
            // Before its first pass it is nowhere.
            assert!(path(&history, 0, &bounds).is_empty());
            assert_eq!(path(&history, 1, &bounds).len(), 1);
            let end = way[way.len() - 1];
            bends += hits;
            lost += usize::from(end.cmplt(bounds.min).any() || end.cmpgt(bounds.max).any());
        }
        assert!(bends > 0, "{bends} bends, {lost} lost");
    }

    #[test]
    fn more_places_than_can_be_drawn_are_thinned_out_and_said() {
        let at = |photon: u32| Stored {
            photon,
            bounce: photon % 3 + 1,
            point: [0.0; 3],
            direction: [0.0, 0.0, 1.0],
            power: [1.0; 3],
            is_caustic: photon.is_multiple_of(4),
            ended: 0,
        };
        let few: Vec<Stored> = (0..8).map(at).collect();
        let shown = Photons::of(&few);
        assert_eq!((shown.dots.len(), shown.bounces), (8, 3));
        assert_eq!(shown.sentence(), "8 stored photons, 2 of them caustic");
        let many: Vec<Stored> = (0..MOST_DOTS as u32 + 1).map(at).collect();
        let shown = Photons::of(&many);
        assert!(shown.dots.len() <= MOST_DOTS && shown.dots.len() > MOST_DOTS / 3, "{}", shown.dots.len());
        assert!(shown.sentence().ends_with(&format!(", {} shown", shown.dots.len())), "{}", shown.sentence());
        assert_eq!(Photons::of(&[]).sentence(), "0 stored photons");
    }

    #[test]
    fn a_pixels_search_has_its_photons_cells_and_radius() {
        let mut renderer = renderer();
        let mut searches = 0;
        for [x, y] in [[32, 50], [20, 52], [48, 50], [32, 40]] {
            let history = trace(&mut renderer, x, y, Rays::One, |_| ControlFlow::Continue(()));
            let history = pollster::block_on(history).expect("a history");
            let records = stored::stored(&pollster::block_on(renderer.values(stored::RECORDS)).expect("values"));
            let Some(found) = Searched::of(&history.rows, &renderer.shared_data(), &records) else { continue };
            let search = &found.search;
            assert_eq!(found.taken.len() as u32, search.gather.found);
            assert!(search.is_over && found.radius > 0.0, "{found:?}");
            let [min, max] = search.cells[0];
            assert!(min.cmple(search.point).all() && max.cmpge(search.point).all());
            let told = found.sentence(|radius| format!("{radius:.2}"));
            assert!(
                told.contains(&format!(" found {} photon", search.gather.found)) && told.contains(" in "),
                "{told}"
            );
            searches += 1;
        }
        assert!(searches > 1, "{searches}");
    }
}
