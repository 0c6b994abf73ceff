//! `raystep new`: a program to begin with.

use std::io::Write as _;
use std::path::PathBuf;

use clap::Args;
use clap::builder::PossibleValuesParser;
use raystep_kernels::options::folder::Folder;

use crate::error::Error;
use crate::output::TargetFolder;
use crate::terminal::print;

/// Files by their names.
type Files = &'static [(&'static str, &'static str)];

macro_rules! examples {
    ($($name:literal: $($file:literal)*;)*) => {
        &[$(($name, &[
            ("program.toml", include_str!(concat!("../../programs/", $name, "/program.toml"))),
            $(($file, include_str!(concat!("../../programs/", $name, "/", $file))),)*
        ])),*]
    };
}

/// The examples, from short to long.
const EXAMPLES: &[(&str, Files)] = examples! {
    "life": "seed.wgsl" "generation.wgsl";
    "reaction-diffusion": "seed.wgsl" "react.wgsl";
    "bitonic-sort": "shuffle.wgsl" "exchange.wgsl";
    "prefix-sum": "fill.wgsl" "scan.wgsl" "add.wgsl";
    "binary-search": "fill.wgsl" "ask.wgsl" "halve.wgsl";
    "sphere-tracer": "shapes.wgsl" "aim.wgsl" "march.wgsl" "paint.wgsl";
    "n-body": "place.wgsl" "attract.wgsl" "advance.wgsl" "draw.wgsl";
    "grid-walk": "voxels.wgsl" "aim.wgsl" "walk.wgsl" "paint.wgsl";
    "fluid": "push.wgsl" "carry.wgsl" "diverge.wgsl" "relax.wgsl" "project.wgsl";
};

/// Make a folder with a stream program of your own
///
/// The folder has program.toml, which says what the program consists of, and a WGSL file for each kernel. It begins as a copy
/// of an example: change it, and run it. docs/own-programs.md explains the file.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  raystep new my-program
  raystep run my-program -o result.png
  raystep inspect my-program
  raystep new my-fluid --like fluid")]
pub(crate) struct NewArgs {
    /// The folder to make
    name: PathBuf,
    /// The example that it begins as
    #[arg(long, value_name = "EXAMPLE", default_value = "life", value_parser = PossibleValuesParser::new(EXAMPLES.iter().map(|(name, _)| *name)))]
    like: String,
}

pub(crate) fn run(args: &NewArgs) -> Result<(), Error> {
    let files = EXAMPLES.iter().find(|(name, _)| *name == args.like).map_or(&[][..], |(_, files)| files);
    TargetFolder::new(&args.name, false)?.fill(&[], |folder| {
        files.iter().try_for_each(|(name, text)| folder.write(name, |out| out.write_all(text.as_bytes())))
    })?;
    let name = args.name.display();
    let manifest = Folder::MANIFEST;
    print(&format!(
        "{name}: {manifest} and {} kernel files, as in {}\n  raystep run {name}\n  raystep inspect {name}\n",
        files.len() - 1,
        args.like
    ))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use raystep_kernels::programs::own;

    use super::*;

    #[test]
    fn every_example_is_a_program_and_has_all_files_of_its_folder() {
        let folders = concat!(env!("CARGO_MANIFEST_DIR"), "/programs");
        let mut names: Vec<String> = std::fs::read_dir(folders)
            .expect("the examples")
            .map(|entry| entry.expect("an example").file_name().into_string().expect("a name"))
            .collect();
        names.sort();
        let mut known: Vec<&str> = EXAMPLES.iter().map(|(name, _)| *name).collect();
        known.sort_unstable();
        assert_eq!(names, known);
        for (name, files) in EXAMPLES {
            let count = std::fs::read_dir(format!("{folders}/{name}")).expect("its files").count();
            assert_eq!(count, files.len(), "{name}");
            let files = files.iter().map(|(file, text)| ((*file).to_owned(), text.as_bytes().to_vec())).collect();
            let folder = Folder::new((*name).to_owned(), String::new(), files).expect("a folder");
            let own = own::read(&Arc::new(folder)).unwrap_or_else(|mistake| panic!("{name}: {mistake}"));
            assert!(own.result.is_some() && !own.program.summary.is_empty(), "{name}");
        }
    }
}
