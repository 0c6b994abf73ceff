//! Paths of light, bounce by bounce, over the whole image: how many are left, why they end, and what light each bounce adds;
//! and the pixels to which a single vertex adds the most.

use std::ops::ControlFlow;

use raystep_kernels::history::RayState;
use raystep_kernels::program::paths::{Added, Density, Ending, PathStep, Paths, Shadow, Technique};
use raystep_kernels::shared::emitters::LUMINANCE;
use raystep_kernels::{Plan, Progress, RenderError, Renderer, StreamData};

/// What the paths of a sample do in one bounce.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bounce {
    /// Passes of the run before the first of this bounce.
    pub place: usize,
    /// Paths at its start, each with a ray to trace.
    pub paths: u64,
    /// Sum over these of their throughput's luminance.
    throughput: f64,
    /// Shadow rays that were cast.
    pub shadow_rays: u64,
    /// Shadow rays that something was in the way of.
    pub occluded: u64,
    /// Paths that ended here, in the order of [`Ending::ALL`].
    pub ended: [u64; Ending::ALL.len()],
    /// Luminance that was added to the image, its mean per pixel, in the order of [`Technique::ALL`].
    pub added: [f64; Technique::ALL.len()],
}

impl Bounce {
    /// Mean luminance of the throughput of the paths at its start.
    #[must_use]
    pub fn throughput(&self) -> f64 {
        self.throughput / self.paths.max(1) as f64
    }

    /// Luminance that was added to the image, its mean per pixel.
    #[must_use]
    pub fn light(&self) -> f64 {
        self.added.iter().sum()
    }
}

/// The vertex that adds the most to a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brightest {
    /// The pixel.
    pub pixel: [u32; 2],
    /// Bounces before the vertex.
    pub depth: u32,
    /// How the light was found.
    pub technique: Technique,
    /// Linear light that it adds.
    pub light: [f64; 3],
    /// Its densities, if they are known.
    pub density: Option<Density>,
    /// The number of passes after which its light is in the streams.
    pub place: usize,
}

impl Brightest {
    /// Luminance of its light.
    #[must_use]
    pub fn luminance(&self) -> f64 {
        luminance(self.light)
    }
}

/// The paths of one sample of every pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounces {
    /// The sample, from 0.
    pub sample: u32,
    /// Pixels of the image.
    pub pixels: u64,
    /// By the number of bounces before.
    pub rows: Vec<Bounce>,
    /// Of every pixel that gets light, the vertex that adds the most; the brightest first.
    pub brightest: Vec<Brightest>,
}

impl Bounces {
    /// Mean luminance per pixel.
    #[must_use]
    pub fn light(&self) -> f64 {
        self.rows.iter().map(Bounce::light).sum()
    }

    /// In a sentence or two.
    #[must_use]
    pub fn sentence(&self) -> String {
        let sum = |of: fn(&Bounce) -> u64| self.rows.iter().map(of).sum::<u64>();
        let (paths, rays) = (self.rows.first().map_or(0, |row| row.paths), sum(|row| row.paths));
        let (cast, occluded) = (sum(|row| row.shadow_rays), sum(|row| row.occluded));
        let a_path = rays as f64 / paths.max(1) as f64;
        let shadows = match cast {
            0 => "no shadow ray was cast".into(),
            cast => format!("{:.0}% of {cast} shadow rays are occluded", occluded as f64 / cast as f64 * 100.0),
        };
        format!("{paths} paths of {a_path:.2} rays on average; {shadows}; mean luminance {:.4}.", self.light())
    }
}

/// Luminance of linear light, Rec. 709.
#[must_use]
pub fn luminance(light: [f64; 3]) -> f64 {
    light.iter().zip(LUMINANCE).map(|(c, share)| c * f64::from(share)).sum()
}

/// Whether [`bounces`] can count the paths of a run.
#[must_use]
pub fn has_bounces(plan: &Plan) -> bool {
    Paths::of(plan.program, &plan.schedule).is_some()
}

/// Counts the paths of a sample. `place` is the number of passes before the sample's first. Use a separate renderer: it is
/// restarted, and left after the sample's last pass. `None` if the run [has no bounces](has_bounces), or no pass at this
/// place.
///
/// `progress` is called after batches of passes and may stop it.
///
/// # Errors
/// If the device fails, or `progress` stopped it.
pub async fn bounces(
    renderer: &mut Renderer,
    place: usize,
    mut progress: impl FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Option<Bounces>, RenderError> {
    let plan = renderer.shared_plan();
    let Some(paths) = Paths::of(plan.program, &plan.schedule) else { return Ok(None) };
    renderer.restart();
    renderer.run_to(place, &mut progress).await?;
    let mut count: Option<Count> = None;
    while let Some(next) = renderer.next_kernel() {
        let is_read = paths.concern(next);
        let before = if is_read { read(renderer, paths).await? } else { Vec::new() };
        let Some(pass) = renderer.step().await? else { break };
        let count = count.get_or_insert_with(|| Count::new(pass.sample, place, &plan));
        if pass.sample != count.of.sample {
            break;
        }
        if is_read {
            let after = read(renderer, paths).await?;
            count.add(renderer, paths, pass.index, [&before, &after]);
        }
        if progress(&renderer.progress()).is_break() && renderer.next_kernel().is_some() {
            return Err(RenderError::Cancelled { passes: renderer.pass_count() });
        }
    }
    Ok(count.map(Count::finish))
}

async fn read(renderer: &Renderer, paths: Paths) -> Result<Vec<StreamData>, RenderError> {
    let mut all = Vec::new();
    for &stream in paths.streams.iter().filter(|&&stream| renderer.plan().has_stream(stream)) {
        all.push(renderer.values(stream).await?);
    }
    Ok(all)
}

/// A pixel's light so far.
#[derive(Clone, Copy)]
struct OfPixel {
    /// Of the shadow ray on its way.
    density: Option<Density>,
    /// The vertex that adds the most.
    most: Option<(u32, Added, usize)>,
}

/// What was counted so far.
struct Count {
    of: Bounces,
    width: u32,
    pixels: Vec<OfPixel>,
}

impl Count {
    fn new(sample: u32, place: usize, plan: &Plan) -> Self {
        let rays = plan.rays as usize;
        let first = Bounce { place, ..Bounce::default() };
        let of = Bounces { sample, pixels: plan.rays, rows: vec![first], brightest: Vec::new() };
        Self { of, width: plan.width, pixels: vec![OfPixel { density: None, most: None }; rays] }
    }

    /// Adds a pass, from the streams before and after it.
    fn add(&mut self, renderer: &Renderer, paths: Paths, pass: usize, [before, after]: [&[StreamData]; 2]) {
        let Some(rays) = renderer.plan().program.rays else { return };
        let mut texels = [Vec::new(), Vec::new()];
        for ray in 0..self.pixels.len() {
            let state = decoded(rays.decode, before, ray, &mut texels[0]);
            if paths.takes.contains(&state.tag) {
                let now = decoded(rays.decode, after, ray, &mut texels[1]);
                // A kernel leaves every ray alone that is not in its states.
                if now.tag != state.tag {
                    self.step(ray, pass, (paths.step)(renderer.data(), &state, &now));
                }
            }
        }
    }

    fn row(&mut self, depth: u32, place: usize) -> &mut Bounce {
        let at = depth as usize;
        while self.of.rows.len() <= at {
            self.of.rows.push(Bounce { place, ..Bounce::default() });
        }
        &mut self.of.rows[at]
    }

    fn step(&mut self, ray: usize, pass: usize, step: PathStep) {
        let pixels = self.of.pixels as f64;
        if step.goes_on {
            self.row(step.depth + 1, pass + 1);
        }
        let row = self.row(step.depth, pass);
        if let Some(throughput) = step.arrived {
            row.paths += 1;
            row.throughput += luminance(throughput.map(f64::from));
        }
        match step.shadow {
            Some(Shadow::Cast(_)) => row.shadow_rays += 1,
            Some(Shadow::Occluded) => row.occluded += 1,
            Some(Shadow::Reached) | None => {}
        }
        if let Some(why) = step.ended {
            row.ended[why as usize] += 1;
        }
        if let Some(added) = step.added {
            row.added[added.technique as usize] += luminance(added.light) / pixels;
        }
        let of = &mut self.pixels[ray];
        if let Some(added) = step.added {
            let density = if added.technique == Technique::LightSample { of.density } else { added.density };
            let most = of.most.map_or(f64::NEG_INFINITY, |(_, most, _)| luminance(most.light));
            // What is not a number counts as the most: it makes the pixel one.
            if luminance(added.light).total_cmp(&most).is_gt() {
                of.most = Some((step.depth, Added { density, ..added }, pass + 1));
            }
        }
        if let Some(Shadow::Cast(density)) = step.shadow {
            of.density = density;
        }
    }

    fn finish(mut self) -> Bounces {
        let width = self.width.max(1) as usize;
        let brightest = self.pixels.iter().enumerate().filter_map(|(ray, of)| {
            let (depth, Added { technique, light, density }, place) = of.most?;
            let pixel = [(ray % width) as u32, (ray / width) as u32];
            Some(Brightest { pixel, depth, technique, light, density, place })
        });
        self.of.brightest = brightest.collect();
        self.of.brightest.sort_by(|a, b| b.luminance().total_cmp(&a.luminance()));
        self.of
    }
}

/// Decodes a ray; `texels` is room for its words.
fn decoded(
    decode: fn(raystep_kernels::program::decoding::Texel<'_>) -> RayState,
    streams: &[StreamData],
    ray: usize,
    texels: &mut Vec<u32>,
) -> RayState {
    texels.clear();
    for stream in streams {
        texels.extend((0..stream.stream.layers()).map(|layer| stream.get(layer, ray)));
    }
    decode(&|wanted| {
        let mut first = 0;
        for StreamData { stream, .. } in streams {
            let end = first + stream.layers();
            if *stream == wanted {
                return texels.get(first..end);
            }
            first = end;
        }
        None
    })
}

#[cfg(test)]
mod tests;
