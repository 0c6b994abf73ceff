//! Writes the manual pages, one a command, from the definition of the command line:
//!
//! `cargo run -p raystep --example man -- DIR [YYYY-MM-DD]`, the date of the pages.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Command;
use clap_mangen::Man;
use clap_mangen::roff::{Roff, bold, roman};

fn main() -> ExitCode {
    let mut arguments = std::env::args_os().skip(1);
    let Some(folder) = arguments.next().map(PathBuf::from) else {
        eprintln!("usage: man DIR [YYYY-MM-DD]");
        return ExitCode::from(2);
    };
    let date = arguments.next().unwrap_or_default();
    let mut program = raystep_app::definition();
    program.build();
    match write(&program, None, &folder, &date.to_string_lossy()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}: {error}", folder.display());
            ExitCode::FAILURE
        }
    }
}

/// Writes the page of a command, of which `above` is the page, and those of its subcommands.
fn write(command: &Command, above: Option<&str>, folder: &Path, date: &str) -> io::Result<()> {
    // The usage of the help, which is shorter than a list of all options.
    let usage = command.clone().render_usage().to_string();
    let defined = command
        .clone()
        .override_usage(usage.trim_start_matches("Usage: ").to_owned())
        .subcommand_help_heading("COMMANDS");
    let page =
        Man::new(defined).date(date).source(concat!("raystep ", env!("CARGO_PKG_VERSION"))).manual("raystep manual");
    let name = command.get_display_name().unwrap_or_else(|| command.get_name());
    let mut file = BufWriter::new(File::create(folder.join(page.get_filename()))?);
    page.render_title(&mut file)?;
    page.render_name_section(&mut file)?;
    page.render_synopsis_section(&mut file)?;
    page.render_description_section(&mut file)?;
    page.render_options_section(&mut file)?;
    let commands: Vec<_> = command.get_subcommands().filter(|c| !c.is_hide_set()).collect();
    if !commands.is_empty() {
        page.render_subcommands_section(&mut file)?;
    }
    let mut rest = Roff::default();
    if let Some(text) = command.get_after_long_help().or(command.get_after_help()) {
        after_help(&mut rest, &text.to_string());
    }
    if let Some(above) = above {
        rest.control("SH", ["SEE ALSO"]).text([bold(above), roman("(1)")]);
    }
    rest.to_writer(&mut file)?;
    file.flush()?;
    commands.into_iter().try_for_each(|command| write(command, Some(name), folder, date))
}

/// The text after the options, whose indented lines are commands: [`Man`] would fill them into a paragraph.
fn after_help(roff: &mut Roff, text: &str) {
    let text = match text.strip_prefix("Examples:\n") {
        Some(examples) => {
            roff.control("SH", ["EXAMPLES"]);
            examples
        }
        None => {
            roff.control("SH", ["NOTES"]);
            text
        }
    };
    roff.control("nf", []).text([roman(text)]).control("fi", []);
}
