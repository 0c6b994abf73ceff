//! Differences between the streams of two runs, counted by the engine of the first.

use raystep_kernels::{Stream, StreamData};
use raystep_lab::compare::Comparison;
use raystep_lab::layer_stats::LayerStats;
use raystep_lab::text::counted;

use crate::session::request::{Job, answered, job};
use crate::ui::canvas::Moment;

/// The job's name.
pub(super) const COUNTING: &str = "comparing two runs";

/// The key of a comparison: the moments of both runs, a stream, the layer whose range is needed.
pub(super) type Question = ([Moment; 2], Stream, usize);

/// The result.
pub(super) struct Counted {
    /// What was compared.
    pub(super) question: Question,
    /// Whether any ray differs, and how many.
    pub(super) sentence: String,
    /// How the layers differ.
    pub(super) lines: Vec<String>,
    /// Smallest and largest value of the layer in the first run.
    pub(super) range: [f32; 2],
    /// The rays that differ, y * width + x, ascending.
    pub(super) rays: Vec<u32>,
    /// Rays in a row of the image.
    pub(super) width: u32,
}

/// Compares the first run's stream, as it is then, with the second's.
pub(super) fn job(question: Question, right: StreamData) -> Job {
    job!(context, {
        let ([(edition, _), other], stream, layer) = question;
        let left = context.session.stream(stream).await.map_err(|e| e.to_string())?;
        let (sentence, lines, rays) = match Comparison::new(&left, &right) {
            Ok(comparison) => {
                let rays: Vec<u32> = comparison.rays().map(|ray| ray as u32).collect();
                let all = u64::from(left.width) * u64::from(left.height);
                (sentence(stream, rays.len() as u64, all), lines(stream, &comparison), rays)
            }
            Err(error) => (error.to_string(), Vec::new(), Vec::new()),
        };
        let stats = LayerStats::of(stream, layer, left.layer(layer));
        let range = stats.span.map_or([0.0, 1.0], |span| [span.min as f32, span.max as f32]);
        let question = ([(edition, context.session.place()), other], stream, layer);
        answered(Counted { question, sentence, lines, range, rays, width: left.width.max(1) })
    })
}

/// What was found, and in how many rays.
fn sentence(stream: Stream, differing: u64, all: u64) -> String {
    let name = stream.name();
    match differing {
        0 => format!("No ray differs: {name} has the same bits in both runs, for {}.", counted(all, "ray")),
        _ => {
            let percent = 100.0 * differing as f64 / all.max(1) as f64;
            format!("{differing} of {} ({percent:.2}%) differ in {name}.", counted(all, "ray"))
        }
    }
}

/// How each layer differs; nothing if none does.
fn lines(stream: Stream, comparison: &Comparison<'_>) -> Vec<String> {
    let layers = comparison.layers();
    if layers.iter().all(|layer| layer.differing == 0) {
        return Vec::new();
    }
    let line = |(found, name): (&raystep_lab::compare::LayerDifference, &&str)| match (&found.floats, found.differing) {
        (_, 0) => format!("{name}: the same bits for all rays"),
        (Some(floats), rays) => format!(
            "{name}: {} differ, by {} ulp in the median and {} ulp at most, {:.3e} in value",
            counted(rays, "ray"),
            floats.median_ulps,
            floats.max_ulps,
            floats.largest
        ),
        (None, rays) => format!("{name}: {} differ", counted(rays, "ray")),
    };
    layers.iter().zip(stream.info().layers).map(line).collect()
}
