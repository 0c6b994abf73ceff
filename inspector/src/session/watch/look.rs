//! Compares streams before and after a pass, for watches.

use std::collections::BTreeMap;

use raystep_kernels::programs::closest_hit::states::{BACKGROUND, ISECT_HIT, ISECT_NO_HIT, SHADE, TRAV};
use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::programs::closest_hit::streams::{HIT_TRIANGLE, STATE_CELL, STATE_T};
use raystep_kernels::shared::constants::{INF, NO_TRIANGLE};
use raystep_kernels::tables::kernel::Role;
use raystep_kernels::tables::stream::STATE_TAG;
use raystep_kernels::{Kernel, RenderError, Renderer, Stream, StreamData};
use raystep_lab::text::counted;

use super::{Fired, Watch};
use crate::settings::traces_rays;
use crate::walk::AXES;

/// The data that watches examine at a place of a run.
pub(super) struct Look {
    watches: Vec<Watch>,
    /// Whole streams.
    streams: BTreeMap<Stream, StreamData>,
    /// The selected ray: pixel, texels of `state` and of `hit`.
    ray: Option<([u32; 2], [Vec<u32>; 2])>,
    /// Cells that each ray has visited, if the run itself does not count them.
    steps: Option<Vec<u32>>,
}

/// A watch's answer: first ray, number of rays, what happened.
type Found = (usize, u32, String);

/// The streams that watches read whole.
fn needed(renderer: &Renderer, watches: &[Watch]) -> Vec<Stream> {
    let plan = renderer.plan();
    let is_needed = |stream: Stream| {
        watches.iter().any(|watch| match watch {
            Watch::NonFinite => (0..stream.layers()).any(|layer| stream.is_float_layer(layer)),
            Watch::TMaxBackwards => [streams::TMAX, streams::STATE].contains(&stream),
            Watch::MoreSteps(_) if plan.has_stream(streams::COUNTERS) => stream == streams::COUNTERS,
            Watch::MoreSteps(_) => stream == streams::STATE,
            Watch::RayState | Watch::RayHit | Watch::RayCell => false,
        })
    };
    plan.streams.iter().map(|planned| planned.what).filter(|&stream| is_needed(stream)).collect()
}

fn has_watch_of_ray(watches: &[Watch]) -> bool {
    watches.iter().any(|watch| watch.is_of_ray())
}

impl Look {
    /// Whether the watches depend on everything since the first pass.
    pub(super) fn needs_start(renderer: &Renderer, watches: &[Watch]) -> bool {
        let counts = watches.iter().any(|watch| matches!(watch, Watch::MoreSteps(_)));
        counts && !renderer.plan().has_stream(streams::COUNTERS)
    }

    pub(super) async fn new(
        renderer: &Renderer,
        watches: &[Watch],
        pixel: Option<[u32; 2]>,
    ) -> Result<Self, RenderError> {
        let mut streams = BTreeMap::new();
        for stream in needed(renderer, watches) {
            streams.insert(stream, renderer.values(stream).await?);
        }
        let ray = match pixel.filter(|_| has_watch_of_ray(watches)) {
            Some(pixel) => Some((pixel, ray_texels(renderer, pixel).await?)),
            None => None,
        };
        let rays = renderer.plan().width as usize * renderer.plan().height as usize;
        let steps = Self::needs_start(renderer, watches).then(|| vec![0; rays]);
        Ok(Self { watches: watches.to_vec(), streams, ray, steps })
    }

    /// Examines one more pass and returns what fires. `edited` are streams that were edited since.
    pub(super) async fn after_pass(
        &mut self,
        renderer: &Renderer,
        edited: &[Stream],
    ) -> Result<Option<Fired>, RenderError> {
        let Some(pass) = renderer.last_pass() else { return Ok(None) };
        let mut changed: Vec<Stream> =
            renderer.plan().variant(pass.kernel).into_iter().flat_map(|v| v.written_streams()).collect();
        let instance = pass.kernel.instance();
        changed.extend(instance.adopts.iter().chain(instance.copies).map(|(stream, _)| stream));
        changed.extend(edited);
        let mut before = BTreeMap::new();
        for (&stream, data) in self.streams.iter_mut().filter(|(stream, _)| changed.contains(stream)) {
            let now = renderer.values(stream).await?;
            before.insert(stream, std::mem::replace(data, now));
        }
        let steps_before = self.count_steps(pass.kernel, before.get(&streams::STATE));
        let mut ray_before = None;
        if let Some((pixel, texels)) = &mut self.ray {
            let now = ray_texels(renderer, *pixel).await?;
            ray_before = Some(std::mem::replace(texels, now));
        }

        let width = renderer.plan().width as usize;
        let of_ray = |before: &[Vec<u32>; 2], watch| {
            let (pixel, now) = self.ray.as_ref()?;
            let value = ray_change(renderer, watch, before, now)?;
            Some((pixel[1] as usize * width + pixel[0] as usize, 1, value))
        };
        for &watch in &self.watches {
            let found = match watch {
                Watch::NonFinite => non_finite(&before, &self.streams),
                Watch::TMaxBackwards => backwards(&before, &self.streams),
                Watch::MoreSteps(most) => match (&self.steps, &steps_before) {
                    (Some(now), Some(before)) => more_steps(before, now, most),
                    _ => before.get(&streams::COUNTERS).and_then(|before| {
                        more_steps(before.layer(0), self.streams.get(&streams::COUNTERS)?.layer(0), most)
                    }),
                },
                Watch::RayState | Watch::RayHit | Watch::RayCell => {
                    ray_before.as_ref().and_then(|before| of_ray(before, watch))
                }
            };
            if let Some((first, rays, value)) = found {
                let ray = [(first % width) as u32, (first / width) as u32];
                return Ok(Some(Fired { watch, place: renderer.pass_count(), ray, rays, value }));
            }
        }
        Ok(None)
    }

    /// Counts a pass's steps; returns the counts before it, if the pass takes steps.
    fn count_steps(&mut self, kernel: Kernel, before: Option<&StreamData>) -> Option<Vec<u32>> {
        let (steps, before) = (self.steps.as_mut()?, before?);
        let now = self.streams.get(&streams::STATE)?;
        if kernel.role() != Role::Step {
            return None;
        }
        let earlier = steps.clone();
        for ((count, &from), &to) in steps.iter_mut().zip(before.layer(STATE_TAG)).zip(now.layer(STATE_TAG)) {
            // A ray that leaves the grid visits no cell.
            *count += u32::from(from == TRAV && to != SHADE && to != BACKGROUND);
        }
        Some(earlier)
    }
}

/// The streams of the elements that the run is about.
fn own_streams(renderer: &Renderer) -> Vec<Stream> {
    let plan = renderer.plan();
    let is_own = |stream: &Stream| stream.info().elements == plan.program.elements[0];
    plan.streams.iter().map(|planned| planned.what).filter(is_own).collect()
}

/// Texels of `state` and `hit`; in a program without rays all texels of the element, one after the other.
async fn ray_texels(renderer: &Renderer, [x, y]: [u32; 2]) -> Result<[Vec<u32>; 2], RenderError> {
    if !traces_rays(renderer.plan().program) {
        return Ok([renderer.texels(&own_streams(renderer), x, y).await?.concat(), Vec::new()]);
    }
    let mut texels = renderer.texels(&[streams::STATE, streams::HIT], x, y).await?.into_iter();
    Ok([texels.next().unwrap_or_default(), texels.next().unwrap_or_default()])
}

/// The first ray that satisfies a condition, and how many do.
fn first_and_count(rays: usize, is_so: impl Fn(usize) -> bool) -> Option<(usize, u32)> {
    let mut all = (0..rays).filter(|&ray| is_so(ray));
    let first = all.next()?;
    Some((first, 1 + all.count() as u32))
}

fn is_finite(bits: u32) -> bool {
    f32::from_bits(bits).is_finite()
}

fn non_finite(before: &BTreeMap<Stream, StreamData>, now: &BTreeMap<Stream, StreamData>) -> Option<Found> {
    let mut layers = Vec::new();
    for (stream, before) in before {
        let now = now.get(stream)?;
        let floats = (0..stream.layers()).filter(|&layer| stream.is_float_layer(layer));
        layers.extend(floats.map(|layer| (*stream, layer, before.layer(layer), now.layer(layer))));
    }
    let rays = layers.first()?.2.len();
    let became = |before: &[u32], now: &[u32], ray: usize| !is_finite(now[ray]) && is_finite(before[ray]);
    let (first, count) = first_and_count(rays, |ray| layers.iter().any(|(_, _, b, n)| became(b, n, ray)))?;
    let (stream, layer, _, now) = layers.iter().find(|(_, _, b, n)| became(b, n, first))?;
    let value = f32::from_bits(now[first]);
    Some((first, count, format!("{}.{} is {value}", stream.name(), stream.info().layers[*layer])))
}

fn backwards(before: &BTreeMap<Stream, StreamData>, now: &BTreeMap<Stream, StreamData>) -> Option<Found> {
    let (tmax_before, tmax) = (before.get(&streams::TMAX)?, now.get(&streams::TMAX)?);
    // A pass that does not write the state leaves the tags unchanged.
    let state = before.get(&streams::STATE).or(now.get(&streams::STATE))?;
    let is_less = |axis: usize, ray: usize| tmax.get_f32(axis, ray) < tmax_before.get_f32(axis, ray);
    let walks = |ray: usize| matches!(state.get(STATE_TAG, ray), TRAV | ISECT_NO_HIT | ISECT_HIT);
    let rays = tmax.layer(0).len();
    let (first, count) = first_and_count(rays, |ray| walks(ray) && (0..3).any(|axis| is_less(axis, ray)))?;
    let axis = (0..3).find(|&axis| is_less(axis, first))?;
    let (from, to) = (tmax_before.get_f32(axis, first), tmax.get_f32(axis, first));
    Some((first, count, format!("tmax.{} from {from} to {to}", AXES[axis])))
}

fn more_steps(before: &[u32], now: &[u32], most: u32) -> Option<Found> {
    let (first, count) = first_and_count(now.len(), |ray| now[ray] > most && before[ray] <= most)?;
    Some((first, count, counted(now[first], "step")))
}

/// The first component of the selected element that changes, in a program without states.
fn texel_change(renderer: &Renderer, before: &[u32], now: &[u32]) -> Option<String> {
    let streams = own_streams(renderer);
    let names = streams.iter().flat_map(|s| s.info().layers.iter().map(move |layer| (s.name(), layer)));
    let (((stream, layer), from), to) = names.zip(before).zip(now).find(|((_, from), to)| from != to)?;
    Some(format!("{stream}.{layer}: {from} > {to}"))
}

/// Changes of the selected ray.
fn ray_change(renderer: &Renderer, watch: Watch, before: &[Vec<u32>; 2], now: &[Vec<u32>; 2]) -> Option<String> {
    let [(state_before, hit_before), (state_now, hit_now)] = [before, now].map(|[state, hit]| (state, hit));
    let both = |layer: usize| Some((*state_before.get(layer)?, *state_now.get(layer)?));
    if !traces_rays(renderer.plan().program) {
        return if watch == Watch::RayState { texel_change(renderer, state_before, state_now) } else { None };
    }
    match watch {
        Watch::RayState => {
            let (from, to) = both(STATE_TAG).filter(|(from, to)| from != to)?;
            let states = renderer.plan().program.states;
            Some(format!("{} > {}", states.name(from), states.name(to)))
        }
        Watch::RayCell => {
            let (from, to) = both(STATE_CELL).filter(|(from, to)| from != to)?;
            let data = renderer.data();
            let name = |cell: u32| match data.features.grid {
                true => data.grid.cell_of_index(cell).map(|c| c.to_string()).join(","),
                false => cell.to_string(),
            };
            Some(format!("{} > {}", name(from), name(to)))
        }
        _ => {
            let (from, to) = (hit_before.get(HIT_TRIANGLE)?, hit_now.get(HIT_TRIANGLE)?);
            let t = both(STATE_T)?;
            if from == to && t.0 == t.1 {
                return None;
            }
            let name = |triangle: u32, t: u32| match (triangle, f32::from_bits(t)) {
                (NO_TRIANGLE, t) if t >= INF => "nothing".into(),
                (NO_TRIANGLE, t) => format!("nothing, t {t}"),
                (triangle, t) => format!("triangle {triangle} at t {t}"),
            };
            Some(format!("{} > {}", name(*from, t.0), name(*to, t.1)))
        }
    }
}
