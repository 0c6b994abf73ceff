//! A quick picture of a scene that is being opened: at a lower resolution, without steps and counters, by the CPU
//! reference kernels. A window shows it until the run has a picture of its own.

use raystep_kernels::{Accelerator, Device, Options, RenderError, Renderer, Samples, ScheduleKind};
use raystep_scenes::Scene;

use crate::session::request::flow;
use crate::settings::Settings;

/// Most pixels along a side.
const MOST_SIDE: u32 = 256;
/// The preview has a structure of its own. Over more triangles, that takes too long, and too much memory.
const MOST_TRIANGLES: usize = 1 << 20;
/// Without a structure, more triangles take too long.
const MOST_WITHOUT_STRUCTURE: usize = 1 << 10;

/// A preview.
#[derive(Clone, PartialEq, Eq)]
pub struct Preview {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// R G B of each pixel, rows from the top, sRGB-encoded.
    pub rgb: Vec<u8>,
}

impl Preview {
    /// Traces a scene as a run with these settings will show it, while `goes_on` returns true. `None` for a run without
    /// an image, for a scene that is too large, and after a stop.
    ///
    /// # Errors
    /// If the scene or the settings do not fit, which the run itself will report.
    pub async fn trace(
        scene: &Scene,
        settings: &Settings,
        mut goes_on: impl FnMut() -> bool + Send,
    ) -> Result<Option<Self>, RenderError> {
        let triangles = scene.triangles.len();
        if !settings.traces_rays() || settings.ray.is_some() || triangles > MOST_TRIANGLES {
            return Ok(None);
        }
        let settings = Settings { size: reduced(settings.size), ..settings.clone() }.computed();
        let accelerator = match settings.choices.accelerator {
            Accelerator::None if triangles > MOST_WITHOUT_STRUCTURE => Accelerator::Auto,
            chosen => chosen,
        };
        let options = Options {
            accelerator,
            schedule: ScheduleKind::Fused,
            samples: Samples::default(),
            counters: false,
            timings: false,
            keep_passes: false,
            ..settings.options(scene)
        };
        let mut renderer = Renderer::new(scene, &options, &Device::Cpu(None)).await?;
        let flow = |_: &_| flow(goes_on());
        match renderer.run(flow).await {
            Err(RenderError::Cancelled { .. }) => return Ok(None),
            result => result?,
        }
        let image = renderer.image().await?;
        Ok(Some(Self { size: [image.width, image.height], rgb: image.to_srgb8() }))
    }
}

/// A size of the same proportions, with at most [`MOST_SIDE`] pixels along a side.
fn reduced(size: [u32; 2]) -> [u32; 2] {
    let by = size[0].max(size[1]).div_ceil(MOST_SIDE).max(1);
    size.map(|side| side.div_ceil(by).max(1))
}

#[cfg(test)]
mod tests {
    use raystep_kernels::Choices;
    use raystep_kernels::options::ProgramName;
    use raystep_scenes::generate;

    use super::*;
    use crate::ray_text::GivenRay;

    fn preview(settings: &Settings, goes_on: bool) -> Option<Preview> {
        let scene = generate::cornell_box();
        pollster::block_on(Preview::trace(&scene, settings, || goes_on)).expect("a small scene")
    }

    #[test]
    fn a_preview_is_what_the_run_shows_at_a_lower_resolution() {
        let settings = Settings { size: [32, 24], ..Settings::default() };
        let shown = preview(&settings, true).expect("a preview");
        // A small image is not reduced, so each pixel has to be the same.
        let scene = generate::cornell_box();
        let image = pollster::block_on(async {
            let mut renderer = Renderer::new(&scene, &settings.options(&scene), &Device::Cpu(None)).await?;
            renderer.run(|_| flow(true)).await?;
            renderer.image().await
        });
        assert_eq!((shown.size, shown.rgb), ([32, 24], image.expect("an image").to_srgb8()));
        let large = preview(&Settings { size: [1024, 300], ..settings }, true).expect("a preview");
        assert_eq!((large.size, large.rgb.len()), ([256, 75], 3 * 256 * 75));
    }

    #[test]
    fn where_there_is_no_image_or_no_time_there_is_no_preview() {
        let settings = Settings { size: [16, 16], ..Settings::default() };
        assert!(preview(&settings, true).is_some());
        assert!(preview(&settings, false).is_none(), "it was stopped");
        let ray = Some(GivenRay([0.0, 0.0, 0.0, 0.0, 0.0, -1.0]));
        assert!(preview(&Settings { ray, ..settings.clone() }, true).is_none(), "a single ray has no image");
        let program = ProgramName::GridBuild;
        assert!(
            preview(&Settings { choices: Choices { program, ..settings.choices }, ..settings }, true).is_none(),
            "a build has no image"
        );
    }

    #[test]
    fn sizes_are_reduced_in_proportion() {
        let sizes = [[512, 512], [1, 1], [256, 1], [257, 1], [4096, 2048]].map(reduced);
        assert_eq!(sizes, [[256, 256], [1, 1], [256, 1], [129, 1], [256, 128]]);
    }
}
