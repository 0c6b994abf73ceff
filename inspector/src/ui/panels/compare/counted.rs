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
    /// One line per layer.
    pub(super) lines: Vec<String>,
    /// Smallest and largest value of the layer in the first run.
    pub(super) range: [f32; 2],
}

/// Compares the first run's stream, as it is then, with the second's.
pub(super) fn job(question: Question, right: StreamData) -> Job {
    job!(context, {
        let ([(edition, _), other], stream, layer) = question;
        let left = context.session.stream(stream).await.map_err(|e| e.to_string())?;
        let lines = match Comparison::new(&left, &right) {
            Ok(comparison) => lines(stream, &comparison),
            Err(error) => vec![error.to_string()],
        };
        let stats = LayerStats::of(stream, layer, left.layer(layer));
        let range = stats.span.map_or([0.0, 1.0], |span| [span.min as f32, span.max as f32]);
        let question = ([(edition, context.session.place()), other], stream, layer);
        answered(Counted { question, lines, range })
    })
}

fn lines(stream: Stream, comparison: &Comparison<'_>) -> Vec<String> {
    let layers = comparison.layers();
    let line = |(found, name): (&raystep_lab::compare::LayerDifference, &&str)| match (&found.floats, found.differing) {
        (_, 0) => format!("{name}: identical bits for all rays"),
        (Some(floats), rays) => format!(
            "{name}: {} differ, median {} ulp, at most {} ulp, {:.3e} in value",
            counted(rays, "ray"),
            floats.median_ulps,
            floats.max_ulps,
            floats.largest
        ),
        (None, rays) => format!("{name}: {} differ", counted(rays, "ray")),
    };
    layers.iter().zip(stream.info().layers).map(line).collect()
}
