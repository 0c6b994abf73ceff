//! The first screen of a report, for a window: the answer in sentences, two diagrams and a small table.

use std::sync::Arc;
use std::time::Duration;

use raystep_kernels::GridSize;

use super::{About, Only, Report, SECTIONS, SEED, SEEDS, Wanted, measure};
use crate::html::{plain, spans};
use crate::meter::Meter;
use crate::plots::Format;
use crate::plots::picture::Picture;
use crate::reporter::Reporter;
use crate::stiff::{self, Start};
use crate::subject::{Size, Subject};
use crate::{Error, html};

/// Pixels per side of a square view, quick and thorough.
const SIDES: [f64; 2] = [128.0, 192.0];

/// The sections that the first screen shows.
const SHOWN: [&str; 2] = ["choices", "rules"];

/// Which choice to take, what it costs, and what it gets wrong.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answer {
    /// Sentences of pieces of text, each with whether it is emphasised.
    pub sentences: Vec<Vec<html::Span>>,
    /// Diagrams with their captions.
    pub figures: Vec<(Picture, String)>,
    /// Names of the table's columns.
    pub columns: Vec<&'static str>,
    /// Its rows.
    pub rows: Vec<Vec<String>>,
    /// What readers of the table need to know, and missing results with reasons.
    pub notes: Vec<String>,
    /// The tables behind it, as CSV, and the diagrams as PDF and SVG with their captions for LaTeX: names with
    /// contents.
    pub files: Vec<(String, Vec<u8>)>,
}

/// Shows an answer as far as it is known.
pub type Ready<'a> = &'a (dyn Fn(Answer) + Sync);

/// What to measure for an answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Width and height of the view; only their ratio counts.
    pub size: [u32; 2],
    /// The grid's resolution.
    pub grid: GridSize,
    /// Fewer rays and repeats.
    pub is_quick: bool,
    /// About how long each of the two sections may take.
    pub time: Duration,
}

/// Measures every choice and rule for a view of a scene; `ready` gets what is known so far. Never blocks, and on the CPU lets other tasks run every few
/// milliseconds, or after a pass; only building a structure and drawing a diagram are done in one go.
///
/// # Errors
/// If the device fails, nothing could be measured, or it was cancelled.
pub async fn answer(
    subject: Subject,
    extent: Extent,
    meter: &Meter,
    reporter: &dyn Reporter,
    ready: Ready<'_>,
) -> Result<Answer, Error> {
    let Extent { size: [width, height], grid, is_quick, time } = extent;
    let side = SIDES[usize::from(!is_quick)];
    let aspect = f64::from(width.max(1)) / f64::from(height.max(1));
    let of = |pixels: f64| pixels.round().clamp(1.0, side * side) as u32;
    let run_id = "inspector".to_owned();
    let wanted = Wanted {
        sections: SECTIONS.iter().filter(|section| SHOWN.contains(&section.name)).collect(),
        size: Size { width: of(side * aspect.sqrt()), height: of(side / aspect.sqrt()) },
        grid,
        is_quick,
        time,
        only: Only::default(),
        seed: SEED,
        seeds: SEEDS,
        has_rays: false,
        methods: Vec::new(),
        rays: None,
        stiff: Arc::new(Start::new(stiff::Wanted::new(run_id.clone(), true), stiff::Kept::default(), |_, _| Ok(()))),
    };
    let reporter = &Rows { reporter, ready };
    let so_far = |report: &Report| -> Result<(), Error> {
        ready(of_report(report, &subject, meter)?);
        Ok(())
    };
    let report = measure(&wanted, std::slice::from_ref(&subject), run_id, meter, reporter, so_far).await?;
    of_report(&report, &subject, meter)
}

/// Turns rows of choices into an answer without sentences.
struct Rows<'a> {
    reporter: &'a dyn Reporter,
    ready: Ready<'a>,
}

impl Reporter for Rows<'_> {
    fn next(&self) -> Option<&dyn Reporter> {
        Some(self.reporter)
    }

    fn rows(&self, names: &[&'static str], rows: &[Vec<String>]) {
        let rows = rows.iter().map(|row| row.iter().map(|cell| plain(cell)).collect()).collect();
        (self.ready)(Answer { columns: names.to_vec(), rows, ..Answer::default() });
    }
}

/// The answer of a report, or of as much of it as there is.
fn of_report(report: &Report, subject: &Subject, meter: &Meter) -> Result<Answer, Error> {
    let adapter = meter.machine.name();
    let mut answer = Answer::default();
    for (_, part) in report.scenes.iter().flat_map(|scene| &scene.parts) {
        answer.sentences.extend(part.lead.iter().map(|sentence| spans(sentence)));
        let caption = |text: &str| format!("{text} {}, {adapter}; seed {SEED}.", subject.scene.name);
        answer.figures.extend(
            part.lead_figures.iter().filter_map(|f| Some((f.plot.picture(Format::OneColumn)?, caption(&f.caption)))),
        );
        if let Some(table) = &part.lead_table {
            answer.columns.clone_from(&table.names);
            answer.rows = table.rows.iter().map(|row| row.iter().map(|cell| plain(cell)).collect()).collect();
            answer.notes.push(table.note.clone());
        }
        answer.notes.extend(part.notes.iter().cloned());
    }
    answer.files = files(report, &vec![("adapter", adapter)])?;
    Ok(answer)
}

/// The CSV files of a report, and its plots with their captions.
fn files(report: &Report, about: &About) -> Result<Vec<(String, Vec<u8>)>, Error> {
    let mut files = report.files(about)?;
    let is_kept = |name: &str| [".csv", ".svg", ".pdf", ".tex"].iter().any(|kind| name.ends_with(kind));
    files.retain(|(name, _)| is_kept(name) && name != super::ABOUT);
    Ok(files)
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::pin::pin;
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicU32, Ordering};
    use std::task::{Context, Poll, Wake, Waker};

    use raystep_kernels::Device;
    use raystep_scenes::generate;

    use super::*;
    use crate::machine::now_ns;
    use crate::reporter::Silent;
    use crate::{Hash, Machine};

    /// Cancels after some stages.
    struct Patience(AtomicU32);

    impl Reporter for Patience {
        fn stage(&self, _name: &str) {
            let _ = self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1));
        }

        fn part(&self, _what: &str, _done: u64, _of: u64) {}

        fn note(&self, _text: &str) {}

        fn is_cancelled(&self) -> bool {
            self.0.load(Ordering::Relaxed) == 0
        }
    }

    fn cornell_box() -> Subject {
        let scene = generate::cornell_box();
        Subject { camera: scene.cameras[0].clone(), scene, hash: Hash::default(), file: String::new() }
    }

    fn meter(clock: fn() -> u64) -> Meter {
        Meter::new(Machine { device: Device::Cpu(Some(clock)), reason: String::new() })
    }

    const EXTENT: Extent =
        Extent { size: [32, 32], grid: GridSize::Auto, is_quick: true, time: Duration::from_secs(20) };

    fn of_cornell_box(patience: u32, ready: Ready<'_>) -> Result<Answer, Error> {
        let (meter, patience) = (meter(now_ns), Patience(AtomicU32::new(patience)));
        meter.machine.wait(answer(cornell_box(), EXTENT, &meter, &patience, ready))
    }

    #[test]
    fn it_has_the_sentences_diagrams_and_table_of_a_page() {
        let so_far = Mutex::new(Vec::new());
        let answer =
            of_cornell_box(u32::MAX, &|answer| so_far.lock().expect("no panic").push(answer)).expect("an answer");
        let of = |i: usize| answer.sentences[i].iter().map(|(text, _)| text.as_str()).collect::<String>();
        assert!(
            of(0).starts_with("Use --accelerator ") && of(0).contains(" per ray, none of 16,384 rays wrong"),
            "{}",
            of(0)
        );
        assert!(of(1).starts_with("On cornell-box with ") && of(2).starts_with("The paper's rules ("), "{}", of(2));
        assert!(answer.sentences[0][0].1, "the answer itself is emphasised");
        assert_eq!((answer.sentences.len(), answer.figures.len()), (5, 2));
        // What is known so far is shown: rows one after another, then the section's sentences.
        let so_far = so_far.into_inner().expect("no panic");
        let rows: Vec<usize> = so_far.iter().filter(|a| a.sentences.is_empty()).map(|a| a.rows.len()).collect();
        assert!(rows.is_sorted() && rows.first() == Some(&1) && rows.len() > 8, "{rows:?}");
        assert_eq!(so_far.last().map(|answer| answer.sentences.len()), Some(4));
        assert!(answer.figures[0].1.ends_with("cornell-box, cpu; seed 2007."), "{}", answer.figures[0].1);
        assert!(
            (2..=7).contains(&answer.rows.len()) && answer.rows.iter().all(|row| row.len() == answer.columns.len())
        );
        assert!(answer.rows.iter().flatten().all(|cell| !cell.contains('<')), "{:?}", answer.rows);
        let names: Vec<&str> = answer.files.iter().map(|(name, _)| name.as_str()).collect();
        let expected = [
            "cornell-box-choices-precision-one-column.svg",
            "cornell-box-rules-rules-two-columns.pdf",
            "captions.tex",
            "choices.csv",
            "rules.csv",
        ];
        assert!(expected.iter().all(|name| names.contains(name)) && names.contains(&"runs.csv"), "{names:?}");
    }

    /// Counts how often it was woken.
    #[derive(Default)]
    struct Woken(AtomicU32);

    impl Wake for Woken {
        fn wake(self: Arc<Self>) {
            self.0.fetch_add(1, Ordering::Relaxed);
        }
    }

    #[test]
    fn it_lets_others_run_after_every_pass() {
        thread_local! { static READINGS: Cell<u32> = const { Cell::new(0) }; }
        // Read before and after every pass.
        let clock = || {
            READINGS.set(READINGS.get() + 1);
            now_ns()
        };
        let (meter, woken) = (meter(clock), Arc::new(Woken::default()));
        let mut answer = pin!(answer(cornell_box(), EXTENT, &meter, &Silent, &drop));
        let mut polls = 0;
        loop {
            READINGS.set(0);
            let state = answer.as_mut().poll(&mut Context::from_waker(&Waker::from(woken.clone())));
            assert!(READINGS.get() <= 2, "poll {polls} ran {} passes", READINGS.get() / 2);
            polls += 1;
            match state {
                Poll::Ready(answer) => break drop(answer.expect("an answer")),
                Poll::Pending => assert_eq!(woken.0.load(Ordering::Relaxed), polls, "nobody would poll again"),
            }
        }
        assert!(polls > 1000, "{polls} polls");
    }

    #[test]
    fn it_can_be_cancelled() {
        for stages in [1, 5, 30] {
            assert!(matches!(of_cornell_box(stages, &drop), Err(Error::Cancelled)), "after {stages} stages");
        }
    }
}
