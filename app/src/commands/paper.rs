//! `raystep paper`

use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use raystep_kernels::Plan;
use raystep_lab::intensity::intensity;
use raystep_lab::meter::Meter;
use raystep_lab::paper::{self, FILES};
use raystep_lab::tidy::package::{self, Resource};
use raystep_lab::{Size, Subject, block_on};

use super::json_text;
use crate::args::{DeviceArgs, QuietArgs, whole};
use crate::device;
use crate::error::Error;
use crate::output::{self, TargetFolder};
use crate::session::run_id;
use crate::terminal::{Progress, print};

/// Repeat the tables of the paper: Mølhave, Implementing a Ray Tracer on a GPU, 2004
///
/// Prints each table with the paper's numbers beside those of this machine: Table 1, the output streams of each kernel;
/// Tables 2 and 3, render times with and without a grid; the arithmetic intensity of its section 3.1; the numbers of
/// programs, textures and lines of its sections 4.5 and 5.2. The Cornell box is built in. Takes about a minute on two
/// cores.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  raystep paper
  raystep paper -o paper
  raystep paper --device gpu --repeats 20 -o paper
  raystep paper --section table-1,intensity,counts")]
pub(crate) struct PaperArgs {
    /// Output folder for the tables as CSV: new, or empty
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Replace the tables in a folder that is not empty; other files are kept
    #[arg(long, requires = "output")]
    force: bool,
    /// Only these sections
    #[arg(long = "section", value_name = "A,B…", value_delimiter = ',')]
    sections: Vec<Section>,
    /// Measured runs of each row of Tables 2 and 3; an interval takes 6
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = whole::<u32>(1, 100_000),
          allow_negative_numbers = true)]
    repeats: u32,
    #[command(flatten)]
    quiet: QuietArgs,
    #[command(flatten)]
    device: DeviceArgs,
}

/// What is printed; in the order of [`FILES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Section {
    /// Table 1: output textures of each kernel
    #[value(name = "table-1")]
    Table1,
    /// Tables 2 and 3: render times
    #[value(name = "tables-2-3")]
    Tables2And3,
    /// Section 3.1: operations for each byte, by kernel
    Intensity,
    /// Sections 4.5 and 5.2: programs, textures, lines
    Counts,
}

/// The size of the image whose plan Table 1 is reflected from; the tables do not depend on it.
const SIZE: Size = Size { width: 512, height: 512 };

/// The name of the data package.
const PACKAGE: &str = "raystep-paper";

pub(crate) fn run(args: &PaperArgs) -> Result<(), Error> {
    let progress = Progress::new(args.quiet.quiet);
    let Some(path) = &args.output else { return tables(args, None, &progress).map(drop) };
    refuse_others(path)?;
    let stale: Vec<String> = FILES.iter().map(|file| file.file.to_owned()).chain([package::FILE.to_owned()]).collect();
    let files = TargetFolder::new(path, args.force)?.fill(&stale, |folder| tables(args, Some(folder), &progress))?;
    let names: Vec<&str> = files.iter().map(|file| file.file).collect();
    progress.say(format_args!("wrote {} and {} to {}", names.join(", "), package::FILE, path.display()));
    Ok(())
}

/// Refuses a folder with files of these names that are from something else.
fn refuse_others(path: &Path) -> Result<(), Error> {
    let names: Vec<&str> = FILES.iter().map(|file| file.file).chain([package::FILE]).collect();
    output::refuse_others(path, &names, "'raystep paper'", package::FILE, |bytes| {
        serde_json::from_slice::<serde_json::Value>(bytes).is_ok_and(|about| about["name"] == PACKAGE)
    })
}

/// Prints each table as soon as it is known, and writes its file.
fn tables(
    args: &PaperArgs,
    folder: Option<&TargetFolder>,
    progress: &Progress,
) -> Result<Vec<Resource<'static>>, Error> {
    let all = [Section::Table1, Section::Tables2And3, Section::Intensity, Section::Counts];
    let subject = paper::subject();
    let mut files = Vec::new();
    for (section, file) in all.into_iter().zip(FILES) {
        if !args.sections.is_empty() && !args.sections.contains(&section) {
            continue;
        }
        let (text, csv) = table(section, args, &subject, progress)?;
        progress.finish();
        let gap = if files.is_empty() { "" } else { "\n" };
        print(&format!("{gap}{text}"))?;
        if let Some(folder) = folder {
            folder.write(file.file, |out| out.write_all(&csv))?;
        }
        files.push(file);
    }
    if let Some(folder) = folder {
        let schema = json_text(&package::describe(PACKAGE, "raystep paper", &files))?;
        folder.write(package::FILE, |out| out.write_all(schema.as_bytes()))?;
    }
    Ok(files)
}

/// A section as text and as CSV.
fn table(
    section: Section,
    args: &PaperArgs,
    subject: &Subject,
    progress: &Progress,
) -> Result<(String, Vec<u8>), Error> {
    let options = paper::options(subject, SIZE);
    Ok(match section {
        Section::Table1 => {
            let (plan, _) = Plan::new(&subject.scene, &options, &raystep_kernels::Limits::CPU)?;
            let outputs = paper::outputs(&plan);
            (outputs.text(), outputs.csv()?)
        }
        Section::Tables2And3 => {
            progress.stage("looking for a device");
            let meter = Meter::new(device::choose(&args.device)?);
            let times = paper::times(subject, args.repeats, run_id(), &meter, progress)?;
            (times.text(), times.csv()?)
        }
        Section::Intensity => {
            let counted = block_on(None, intensity(&subject.scene, &options, progress))?;
            (format!("Section 3.1: {}", counted.text()), counted.csv()?)
        }
        Section::Counts => {
            let counts = paper::counts(subject)?;
            (counts.text(), counts.csv()?)
        }
    })
}
