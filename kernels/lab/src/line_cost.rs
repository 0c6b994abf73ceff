//! What each line of a kernel takes: how often it runs, operations, bytes, and their ratio, counted while the interpreter runs
//! all elements of a pass, or of all passes. What counts is defined at [`Work`].

use raystep_kernels::interpret::{LineWork, Work};
use raystep_kernels::shader::{FileLine, Sourced};
use raystep_kernels::{RenderError, Renderer};
use serde::Serialize;

use crate::passed::{Code, step};
use crate::stops::{Outcome, StopsError, begun};
use crate::tidy::Table;

/// The columns of the CSV file.
pub const COLUMNS: &[&str] = columns![
    schema_version kernel passes elements file line line_runs float_operations integer_operations comparisons stream_bytes_read
    stream_bytes_written buffer_bytes_read uniform_bytes_read operations_per_byte text
];

/// A kernel's lines.
#[derive(Clone, Debug)]
pub struct LineCosts {
    /// Passes that were counted.
    pub passes: u64,
    /// Elements that they worked on, added.
    pub elements: u64,
    /// The lines that ran or would take something, by file and line.
    pub lines: Vec<(FileLine, LineWork)>,
}

impl LineCosts {
    /// What all lines took.
    #[must_use]
    pub fn total(&self) -> Work {
        let mut sum = Work::default();
        self.lines.iter().for_each(|(_, line)| sum.add(&line.work, 1));
        sum
    }

    /// A row for each line, with means per element.
    ///
    /// # Errors
    /// If it cannot be written as CSV.
    pub fn csv(&self, of: &Sourced) -> Result<Vec<u8>, crate::Error> {
        let kernel = of.variant.kernel.name();
        let mean = |sum: u64| sum as f64 / self.elements.max(1) as f64;
        let rows = self.lines.iter().map(|(at, line)| Row {
            kernel,
            passes: self.passes,
            elements: self.elements,
            file: &of.files[at.file].name,
            line: at.line,
            line_runs: line.runs,
            float_operations: mean(line.work.float_operations),
            integer_operations: mean(line.work.integer_operations),
            comparisons: mean(line.work.comparisons),
            stream_bytes_read: mean(line.work.stream_bytes_read),
            stream_bytes_written: mean(line.work.stream_bytes_written),
            buffer_bytes_read: mean(line.work.buffer_bytes_read),
            uniform_bytes_read: mean(line.work.uniform_bytes_read),
            operations_per_byte: per_byte(&line.work),
            text: of.text_of(*at).trim(),
        });
        let rows = rows.map(|row| crate::tidy::Row::new(COLUMNS).with(&row)).collect();
        Ok(Table { columns: COLUMNS, rows }.csv()?)
    }
}

/// Operations per byte; `None` where no byte is moved.
#[must_use]
pub fn per_byte(work: &Work) -> Option<f64> {
    (work.bytes() > 0).then(|| work.operations() as f64 / work.bytes() as f64)
}

#[derive(Serialize)]
struct Row<'a> {
    kernel: &'a str,
    passes: u64,
    elements: u64,
    file: &'a str,
    line: usize,
    line_runs: u64,
    float_operations: f64,
    integer_operations: f64,
    comparisons: f64,
    stream_bytes_read: f64,
    stream_bytes_written: f64,
    buffer_bytes_read: f64,
    uniform_bytes_read: f64,
    operations_per_byte: Option<f64>,
    text: &'a str,
}

/// Counts a pass of a kernel, or without one all of its passes up to so many.
///
/// # Errors
/// If the device fails, an element cannot be interpreted, or `progress` stops it.
pub async fn line_costs(
    renderer: &mut Renderer,
    of: &Sourced,
    code: &Code,
    pass: Option<usize>,
    mut progress: impl FnMut(usize) -> bool,
) -> Result<Result<LineCosts, Outcome>, StopsError> {
    let mut runs = vec![0; code.interpreter().statements().len()];
    let (mut passes, mut elements) = (0, 0);
    loop {
        let begun = match (pass, renderer.next_kernel()) {
            (Some(_), _) if passes > 0 => break,
            (Some(pass), _) => match begun(renderer, code, pass).await? {
                Ok(begun) => Some(begun),
                Err(outcome) => return Ok(Err(outcome)),
            },
            (None, None) => break,
            (None, Some(kernel)) if kernel == code.kernel() => step(renderer, code.streams()).await?,
            (None, Some(_)) => {
                if !progress(renderer.pass_count()) {
                    return Err(RenderError::Cancelled { passes: renderer.pass_count() }.into());
                }
                renderer.step().await?;
                continue;
            }
        };
        let Some(begun) = begun else { break };
        let index = begun.pass.index;
        let counted = code.runs(&begun, renderer.data());
        let (count, ran) = counted.map_err(|failure| StopsError::Failed { pass: index, failure })?;
        passes += 1;
        elements += count;
        runs.iter_mut().zip(ran).for_each(|(sum, ran)| *sum += ran);
        if !progress(renderer.pass_count()) {
            return Err(RenderError::Cancelled { passes: renderer.pass_count() }.into());
        }
    }
    let by_line = code.interpreter().by_line(&runs);
    let mut lines: Vec<_> = by_line.into_iter().filter_map(|(line, work)| Some((of.place(line)?, work))).collect();
    lines.sort_by_key(|(at, _)| *at);
    Ok(Ok(LineCosts { passes, elements, lines }))
}
