//! Twin of `gather.wgsl`: looks for the photons near a hit.

use super::key_photons::{load_vec3, place_of};
use crate::numbers::parallel::for_chunks;
use crate::numbers::real::Vec3;
use crate::programs::closest_hit::states::{GATHER, GATHERED};
use crate::scene_data::SceneData;
use crate::shared::constants::{INF, NO_CELL};
use crate::shared::photon_map::PhotonMap;
use crate::shared::start::{Start, start_of};
use crate::shared::vector::{dot3, unit3};
use crate::tables::stream::Stream;
use crate::tables::texels::Columns;

/// The cells around a cell, and itself.
const AROUND: u32 = 27;
/// Most photons that are looked at in a step.
const PHOTONS_A_STEP: u32 = 64;
/// Rays per task.
const RAYS_A_TASK: usize = 64;

/// How far a search has got: see the WGSL.
#[derive(Clone, Copy)]
struct Search {
    cell: u32,
    item: u32,
    end: u32,
    found: u32,
    sweep: u32,
    map: u32,
    visited: u32,
    limit: f32,
    low: f32,
    high: f32,
    farthest: f32,
    power: Vec3<f32>,
    weighted: Vec3<f32>,
}

/// The streams of the kernel.
struct Streams {
    state: Stream,
    hit: Stream,
    direction: Stream,
    gathering: Stream,
    gathered: Stream,
    key: Stream,
    first: Stream,
    records: Stream,
    bounce: Stream,
}

impl Streams {
    fn of(columns: &dyn Columns) -> Option<Self> {
        Some(Self {
            state: columns.stream("state")?,
            hit: columns.stream("hit")?,
            direction: columns.stream("ray_direction")?,
            gathering: columns.stream("gathering")?,
            gathered: columns.stream("gathered")?,
            key: columns.stream("photon_key")?,
            first: columns.stream("photon_first")?,
            records: columns.stream("photon_records")?,
            bounce: columns.stream("bounce")?,
        })
    }
}

impl Search {
    fn load(columns: &dyn Columns, of: &Streams, ray: usize) -> Self {
        let word = |layer| columns.load(of.gathering, layer, ray);
        let float = |layer| f32::from_bits(columns.load(of.gathered, layer, ray));
        Self {
            cell: word(0),
            item: word(1),
            end: word(2),
            found: word(3),
            sweep: word(4),
            map: word(5),
            visited: word(7),
            limit: float(0),
            low: float(1),
            high: float(2),
            farthest: float(3),
            power: Vec3::new(float(4), float(5), float(6)),
            weighted: Vec3::new(float(7), float(8), float(9)),
        }
    }

    fn store(&self, columns: &mut dyn Columns, of: &Streams, ray: usize) {
        let words = [self.cell, self.item, self.end, self.found, self.sweep, self.map];
        let floats = [self.limit, self.low, self.high, self.farthest];
        let floats = floats.into_iter().chain(self.power.to_array()).chain(self.weighted.to_array());
        words.into_iter().enumerate().for_each(|(layer, word)| columns.store(of.gathering, layer, ray, word));
        columns.store(of.gathering, 7, ray, self.visited);
        floats.enumerate().for_each(|(layer, float)| columns.store(of.gathered, layer, ray, float.to_bits()));
    }

    fn limit(&self, map: &PhotonMap) -> f32 {
        if self.sweep == 0 && self.found >= map.nearest { self.farthest } else { self.limit }
    }

    fn next_cell(self, columns: &dyn Columns, of: &Streams, map: &PhotonMap, point: Vec3<f32>) -> Self {
        let place = map.place_of(point);
        let cell = map.cell_of(place);
        let step_to = |around: u32| [around % 3, around / 3 % 3, around / 9].map(|step| step as i32 - 1);
        let there = |around| {
            let step = step_to(around);
            [0, 1, 2].map(|axis| cell[axis] + step[axis])
        };
        let (mut nearest, mut distance) = (NO_CELL, INF);
        for around in 0..AROUND {
            let away: f32 = map.distance_to(place, cell, step_to(around));
            let is_visited = self.visited >> around & 1 != 0;
            if map.has_cell(there(around)) && !is_visited && away < distance {
                (nearest, distance) = (around, away);
            }
        }
        if nearest == NO_CELL || distance > self.limit(map) {
            return Self { cell: NO_CELL, ..self };
        }
        let index = map.index_of(self.map, there(nearest)) as usize;
        let [item, end] = [index, index + 1].map(|cell| columns.load(of.first, 0, cell));
        Self { cell: nearest, visited: self.visited | 1 << nearest, item, end, ..self }
    }

    fn with_photons(
        mut self,
        columns: &dyn Columns,
        of: &Streams,
        map: &PhotonMap,
        start: &Start<f32>,
        bounces: u32,
    ) -> Self {
        let stop = self.end.min(self.item.saturating_add(PHOTONS_A_STEP));
        for item in self.item..stop {
            let record = columns.load(of.key, 1, item as usize);
            let (photon, layer) = place_of(map, record);
            let load = |layer| load_vec3(columns, of.records, layer, photon);
            let away = load(layer) - start.point;
            let squared = dot3(away, away);
            let is_seen = map.photon_of(record).1 < bounces && dot3(load(layer + 3), start.normal) < 0.0;
            if is_seen && squared <= self.limit(map) {
                let power = load(layer + 6);
                self.found += 1;
                self.farthest = if self.farthest < squared { squared } else { self.farthest };
                self.power = self.power + power;
                self.weighted = self.weighted + power * squared.sqrt();
            }
        }
        Self { item: stop, ..self }
    }

    fn is_over(&self, map: &PhotonMap, is_exact: bool) -> bool {
        let is_first = self.sweep == 0;
        !is_exact
            || self.found == map.nearest
            || is_first && self.found < map.nearest
            || !is_first && self.limit == self.high
    }

    fn next_sweep(self, map: &PhotonMap) -> Self {
        let [low, high] = match self.sweep == 0 || self.found > map.nearest {
            true => [self.low, self.farthest],
            false => [self.limit, self.high],
        };
        let half = 0.5 * (low + high);
        let limit = if low < half && half < high { half } else { high };
        let none = Vec3::splat(0.0);
        Self {
            cell: NO_CELL,
            item: 0,
            end: 0,
            found: 0,
            sweep: self.sweep + 1,
            map: self.map,
            visited: 0,
            limit,
            low,
            high,
            farthest: 0.0,
            power: none,
            weighted: none,
        }
    }
}

/// What a pass does for one ray: the search after it, and whether that is over.
fn searched(columns: &dyn Columns, of: &Streams, scene: &SceneData, ray: usize) -> Option<(Search, u32)> {
    if columns.load(of.state, 0, ray) != GATHER {
        return None;
    }
    let map = &scene.photon_map;
    let hit = [0, 1, 2].map(|layer| columns.load(of.hit, layer, ray));
    let direction = unit3(load_vec3(columns, of.direction, 0, ray));
    let start = start_of(scene.corners(hit[2]), [hit[0], hit[1]].map(f32::from_bits), direction);
    let mut search = Search::load(columns, of, ray);
    // One bounce is here, and the ray has had others.
    let bounces = scene.features.depth.saturating_sub(columns.load(of.bounce, 0, ray) + 1);
    for _ in 0..scene.info.steps {
        if search.item >= search.end {
            search = search.next_cell(columns, of, map, start.point);
        }
        search = match search.cell != NO_CELL {
            true => search.with_photons(columns, of, map, &start, bounces),
            false if search.is_over(map, scene.features.exact) => return Some((search, GATHERED)),
            false => search.next_sweep(map),
        };
    }
    Some((search, GATHER))
}

/// Runs a pass.
pub fn gather(columns: &mut dyn Columns, scene: &SceneData) {
    let Some(of) = Streams::of(columns) else { return };
    let mut after = vec![None; columns.len(of.state)];
    let before: &dyn Columns = columns;
    for_chunks(&mut after, RAYS_A_TASK, |first, task| {
        for (ray, after) in (first..).zip(task) {
            *after = searched(before, &of, scene, ray);
        }
    });
    for (ray, after) in after.into_iter().enumerate() {
        let Some((search, tag)) = after else { continue };
        search.store(columns, &of, ray);
        columns.store(of.state, 0, ray, tag);
    }
}
