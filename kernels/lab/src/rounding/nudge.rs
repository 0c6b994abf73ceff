//! Neighbouring rays, for passes that take many decisions. There, the device's result for a ray must be that of some
//! ray whose components differ by no more than the rounding of a division, a product and a sum.

use std::sync::Arc;

use raystep_kernels::executor::cpu::{CpuError, CpuExecutor};
use raystep_kernels::plan::Plan;
use raystep_kernels::program::schedule::Call;
use raystep_kernels::programs::closest_hit::streams::{HIT, HIT_TRIANGLE};
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::shared::constants::NO_TRIANGLE;
use raystep_kernels::tables::elements::{Count, Elements, Size};
use raystep_kernels::tables::kernel::Role;
use raystep_kernels::tables::stream::{Stream, StreamData};

use super::{RAY, Rounding};

/// Distance, in half units in the last place of the largest component, and the stream to change.
type Move = (f32, Stream);
const MOVES: [Move; 4] = [(1.0, RAY[0]), (4.0, RAY[0]), (1.0, RAY[1]), (4.0, RAY[1])];
/// What begins at a hit does so at another place of its triangle.
const MOVES_OF_HIT: [Move; 4] = [(1.0, HIT), (4.0, HIT), (16.0, HIT), (64.0, HIT)];

/// The plan of a run with this many elements of a set, in one row.
fn in_a_row(plan: &Plan, set: &Elements, elements: usize) -> Plan {
    let mut plan = plan.clone();
    let size = Size { width: elements as u32, height: 1, count: elements as u32 };
    if set.count == Count::Image {
        (plan.width, plan.height, plan.rays) = (size.width, 1, elements as u64);
    }
    plan.sets.iter_mut().filter(|planned| planned.what.name == set.name).for_each(|set| set.size = Some(size));
    plan
}

impl Rounding<'_> {
    /// Which of `rays` have, in `after`, the result of a ray whose components differ by up to 4 roundings of the
    /// largest, along any combination of axes. Needs memory for these rays' streams once more, or for those of all
    /// rays if the kernel generates them itself.
    pub(super) fn are_nearly(&self, rays: &[usize], after: &[&StreamData]) -> Result<Vec<bool>, CpuError> {
        // Kernels derive rays that they generate from their pixels, and the numbers that decide a path; other rays can be
        // stored anywhere.
        let generates = self.data.features.eye_rays;
        let is_gathered = !(generates || self.data.features.whole_paths);
        let (plan, before);
        let over = self.kernel.instance().over;
        let (plan, before) = if is_gathered {
            plan = Arc::new(in_a_row(self.plan, over, rays.len()));
            let of_set = |s: &StreamData| s.stream.info().elements.name == over.name;
            let moved = self.before.iter().map(|s| if of_set(s) { gathered(s, rays) } else { s.clone() });
            before = moved.collect::<Vec<_>>();
            (&plan, before.as_slice())
        } else {
            (self.plan, self.before)
        };
        let mut own_data = generates.then(|| self.data.clone());
        let mut are = vec![false; rays.len()];
        let moves = if self.kernel.role() == Role::Finish { MOVES_OF_HIT } else { MOVES };
        for (roundings, moved) in moves {
            for corner in 0..27 {
                let signs = [corner % 3 - 1, corner / 3 % 3 - 1, corner / 9 - 1].map(|s| s as f32);
                let by = signs.map(|s| s * roundings * 0.5 * f32::EPSILON);
                if let Some(data) = &mut own_data {
                    data.camera = self.data.camera;
                    let of_eye = if moved == RAY[0] { &mut data.camera.forward } else { &mut data.camera.eye };
                    *of_eye = nudged(*of_eye, by);
                }
                let data = own_data.as_ref().unwrap_or(self.data);
                let moved_on = self.after_moving(moved, by, (plan, data, before))?;
                for (i, &ray) in rays.iter().enumerate() {
                    are[i] = are[i] || self.is_same((&moved_on, if is_gathered { i } else { ray }), (after, ray));
                }
                if are.iter().all(|&is| is) {
                    return Ok(are);
                }
            }
        }
        Ok(are)
    }

    /// The streams after the twin's pass, with this stream of every ray changed.
    fn after_moving(
        &self,
        own: Stream,
        by: [f32; 3],
        (plan, data, before): (&Arc<Plan>, &SceneData, &[StreamData]),
    ) -> Result<Vec<StreamData>, CpuError> {
        let mut twin = CpuExecutor::<f32>::new(plan, None)?;
        let part = self.kernel.stream(own);
        for stream in before {
            if Some(stream.stream) != part {
                twin.write(stream);
                continue;
            }
            let mut stream = stream.clone();
            let rays = stream.bits.len() / stream.stream.layers();
            // The last layer of a hit is its triangle.
            let axes = if own == HIT { 2 } else { 3 };
            for ray in 0..rays {
                let v = [0, 1, 2].map(|axis| if axis < axes { stream.get_f32(axis, ray) } else { 0.0 });
                let v = nudged(v, by);
                (0..axes).for_each(|axis| stream.bits[axis * rays + ray] = v[axis].to_bits());
            }
            twin.write(&stream);
        }
        twin.run(Call::of(self.kernel), data)?;
        Ok(before.iter().filter_map(|s| twin.read(s.stream)).collect())
    }

    fn is_same(&self, (moved, at): (&[StreamData], usize), (after, ray): (&[&StreamData], usize)) -> bool {
        let of = |stream: Stream| moved.iter().find(|s| s.stream == stream);
        let hit = self.kernel.stream(HIT).and_then(of);
        let possible = self.tested(ray, hit.map_or(NO_TRIANGLE, |s| s.get(HIT_TRIANGLE, at)));
        // What was moved, if the kernel leaves it as it is, and what is of other elements, does not count.
        let over = self.kernel.instance().over;
        let leaves = self.kernel.role() == Role::Finish;
        let is_moved = |stream: Stream| {
            RAY.into_iter().chain(leaves.then_some(HIT)).any(|own| self.kernel.stream(own) == Some(stream))
        };
        let counts = |s: &&&StreamData| !is_moved(s.stream) && s.stream.info().elements.name == over.name;
        after.iter().filter(counts).all(|now| {
            (0..now.stream.layers()).all(|layer| {
                let (a, b) = (of(now.stream).map_or(0, |s| s.get(layer, at)), now.get(layer, ray));
                a == b || self.allows((now.stream, layer), a, b, possible.as_ref())
            })
        })
    }
}

/// A vector changed along each axis by a share of its largest component.
fn nudged(v: [f32; 3], by: [f32; 3]) -> [f32; 3] {
    let largest = v.iter().fold(0.0f32, |m, c| m.max(c.abs()));
    [0, 1, 2].map(|axis| v[axis] + by[axis] * largest)
}

/// The texels of some rays, in one row.
fn gathered(stream: &StreamData, rays: &[usize]) -> StreamData {
    let bits = (0..stream.stream.layers()).flat_map(|layer| rays.iter().map(move |&ray| stream.get(layer, ray)));
    StreamData { stream: stream.stream, width: rays.len() as u32, height: 1, bits: bits.collect() }
}
