//! How often the rays of a run come to each cell or node, and test each triangle.

use std::ops::ControlFlow;

use raystep_kernels::options::features::StructureKind;
use raystep_kernels::program::{Decoding, Path, RayState};
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::shared::bvh_walk::parent_of;
use raystep_kernels::tables::kernel::Role;
use raystep_kernels::tables::stream::{STATE_TAG, Texel};
use raystep_kernels::{
    Kernel, Options, Plan, Progress, RenderError, Renderer, Samples, ScheduleKind, Stream, StreamData,
};

/// Most streams that are read, and their most layers.
const MOST: [usize; 2] = [4, 4];

/// Counts over all rays of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Visits {
    /// Rays that came to each cell, or whose box test reached each node. Returning to a node from below it does not
    /// count. Empty without a structure.
    pub places: Vec<u32>,
    /// Tests of each triangle.
    pub triangles: Vec<u32>,
}

impl Visits {
    fn none(data: &SceneData) -> Self {
        let places = match data.features.structure() {
            StructureKind::None => 0,
            StructureKind::Grid => data.grid_cells.len().saturating_sub(1),
            StructureKind::Irregular => data.irregular_cells.len(),
            StructureKind::Bvh => data.bvh_nodes.len(),
        };
        Self { places: vec![0; places], triangles: vec![0; data.info.triangles as usize] }
    }

    fn add(&mut self, kernel: Kernel, rays: Decoding, data: &SceneData, before: &RayState, after: &RayState) {
        let count = |counts: &mut Vec<u32>, at: Option<u32>| {
            if let Some(count) = at.and_then(|at| counts.get_mut(at as usize)) {
                *count = count.saturating_add(1);
            }
        };
        count(&mut self.places, place(kernel, data, before, after));
        if kernel.role() == Role::Test {
            count(&mut self.triangles, (rays.tested)(data, before, after));
        }
    }
}

/// The cell that a pass took a ray to, or the node whose box it tested.
fn place(kernel: Kernel, data: &SceneData, before: &RayState, after: &RayState) -> Option<u32> {
    if data.features.structure() == StructureKind::Bvh {
        let parent = data.bvh_parents.get(before.cell_index as usize).map(|&parent| parent_of(parent));
        let is_from_above = parent.is_some() && before.previous == parent;
        return (kernel.info().path == Path::NextNode && is_from_above).then_some(before.cell_index);
    }
    let has_moved = !before.is_walking || after.cell_index != before.cell_index;
    (after.is_walking && has_moved).then_some(after.cell_index)
}

/// Whether the passes of a run take one step at a time, so that its streams tell every step.
#[must_use]
pub fn has_single_steps(plan: &Plan) -> bool {
    let tests = plan.schedule.kernels().iter().any(|kernel| kernel.role() == Role::Test);
    tests && !plan.features.many_steps
}

/// The options of a run with single steps, one ray per pixel, and nothing else that takes time.
#[must_use]
pub fn single_steps(options: &Options) -> Options {
    Options {
        schedule: ScheduleKind::Second,
        steps_per_pass: 1,
        samples: Samples::default(),
        shade: false,
        counters: false,
        timings: false,
        keep_passes: false,
        ..options.clone()
    }
}

/// Counts visits in a run from its first pass, by its streams before and after each. `progress` is called after every
/// pass and may stop the run. `None` if its passes do not take [single steps](has_single_steps).
///
/// # Errors
/// If the device fails, or `progress` stopped the run.
pub async fn visits(
    renderer: &mut Renderer,
    mut progress: impl FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Option<Visits>, RenderError> {
    let plan = renderer.shared_plan();
    let Some(rays) = plan.program.rays.filter(|_| has_single_steps(&plan)) else { return Ok(None) };
    let data = renderer.shared_data();
    renderer.restart();
    let mut visits = Visits::none(&data);
    let mut before = Columns::read(renderer).await?;
    while let Some(pass) = renderer.step().await? {
        let after = Columns::read(renderer).await?;
        for ray in 0..plan.rays as usize {
            if pass.kernel.takes().contains(&before.word(0, STATE_TAG, ray)) {
                let [was, is] = [&before, &after].map(|columns| columns.ray(rays, ray));
                visits.add(pass.kernel, rays, &data, &was, &is);
            }
        }
        before = after;
        if progress(&renderer.progress()).is_break() && renderer.next_kernel().is_some() {
            return Err(RenderError::Cancelled { passes: renderer.pass_count() });
        }
    }
    Ok(Some(visits))
}

/// The streams that tell where all rays are, which are those without floats: the states first.
struct Columns(Vec<StreamData>);

impl Columns {
    async fn read(renderer: &Renderer) -> Result<Self, RenderError> {
        let plan = renderer.plan();
        let states = plan.program.state_stream();
        let others = plan.program.rays.into_iter().flat_map(|rays| rays.streams.iter().copied());
        let tells = |stream: &Stream| stream.info().texel == Texel::U32 && plan.has_stream(*stream);
        let streams = states.into_iter().chain(others.filter(|&stream| Some(stream) != states));
        let mut columns = Vec::new();
        for stream in streams.filter(tells).take(MOST[0]) {
            columns.push(renderer.values(stream).await?);
        }
        Ok(Self(columns))
    }

    fn word(&self, column: usize, layer: usize, ray: usize) -> u32 {
        self.0.get(column).and_then(|values| values.layer(layer).get(ray)).copied().unwrap_or_default()
    }

    fn ray(&self, rays: Decoding, ray: usize) -> RayState {
        let mut texels = [[0; MOST[1]]; MOST[0]];
        for (column, texel) in texels.iter_mut().enumerate().take(self.0.len()) {
            let layers = self.0[column].stream.layers().min(MOST[1]);
            (0..layers).for_each(|layer| texel[layer] = self.word(column, layer, ray));
        }
        (rays.decode)(&|wanted: Stream| {
            let column = self.0.iter().position(|values| values.stream == wanted)?;
            Some(&texels[column][..wanted.layers().min(MOST[1])])
        })
    }
}

#[cfg(test)]
mod tests {
    use raystep_kernels::programs::closest_hit::streams;
    use raystep_kernels::{Accelerator, Device, RaySource};
    use raystep_scenes::generate;

    use super::super::{Measure, costs};
    use super::*;

    async fn of(accelerator: Accelerator, schedule: ScheduleKind) -> (Option<Visits>, Vec<u32>, Vec<u32>, u32) {
        let scene = generate::cornell_box();
        let camera = scene.cameras[0].clone();
        let options =
            Options { accelerator, schedule, ..Options::new(RaySource::Camera { camera, width: 24, height: 20 }) };
        let wanted = match schedule {
            ScheduleKind::Second => single_steps(&options),
            _ => options.clone(),
        };
        let mut renderer = Renderer::new(&scene, &wanted, &Device::Cpu(None)).await.expect("a renderer");
        let visits = visits(&mut renderer, |_| ControlFlow::Continue(())).await.expect("visits");
        let counting = Options { counters: true, ..single_steps(&options) };
        let mut counted = Renderer::new(&scene, &counting, &Device::Cpu(None)).await.expect("a renderer");
        counted.run(|_| ControlFlow::Continue(())).await.expect("the run");
        let counters = counted.values(streams::COUNTERS).await.expect("counters");
        let [cells, triangles] =
            [Measure::Cells, Measure::Triangles].map(|by| costs(&counters, 480, by).expect("counts"));
        let entered = counted.values(streams::STATE).await.expect("states");
        (visits, cells, triangles, entered.layer(0).len() as u32)
    }

    fn sum(counts: &[u32]) -> u64 {
        counts.iter().map(|&count| u64::from(count)).sum()
    }

    /// The kernels count for each ray what is counted here for each triangle and cell.
    #[test]
    fn all_tests_and_visits_are_counted_once() {
        pollster::block_on(async {
            for accelerator in [Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh, Accelerator::None] {
                let (visits, cells, triangles, _) = of(accelerator, ScheduleKind::Second).await;
                let visits = visits.expect("single steps");
                assert_eq!(sum(&visits.triangles), sum(&triangles), "{accelerator:?}");
                match accelerator {
                    Accelerator::None => assert!(visits.places.is_empty()),
                    // The root's box is tested once for each ray; a leaf that was left is not tested again.
                    Accelerator::Bvh => {
                        assert_eq!(visits.places[0], 480);
                        assert!(sum(&visits.places) <= sum(&cells) && sum(&visits.places) > 480 * 3);
                    }
                    // A ray enters its first cell without a step, and its last step may leave the grid.
                    _ => {
                        let off = sum(&visits.places).abs_diff(sum(&cells));
                        assert!(off <= 480, "{accelerator:?}: {} {}", sum(&visits.places), sum(&cells));
                    }
                }
            }
        });
    }

    #[test]
    fn passes_of_several_steps_tell_nothing() {
        pollster::block_on(async {
            for schedule in [ScheduleKind::Compact, ScheduleKind::Fused] {
                assert_eq!(of(Accelerator::Grid, schedule).await.0, None, "{schedule:?}");
            }
        });
    }
}
