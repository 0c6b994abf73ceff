//! `raystep scene`: generated and converted scenes. Every generator in the table is a subcommand.

use std::path::{Path, PathBuf};

use clap::{Arg, ArgMatches, Args, Command, FromArgMatches, Subcommand, value_parser};
use raystep_scenes::generate::{GENERATORS, GenerateError, Generator};
use raystep_scenes::{Scene, write_glb};

use crate::args::{QuietArgs, SceneArgs, whole};
use crate::error::Error;
use crate::output::{Target, ending, refuse_inputs, write};
use crate::scene_file;
use crate::terminal::{Progress, print};

/// The action.
#[derive(Debug)]
pub(crate) enum SceneCommand {
    /// Lists generators.
    List,
    /// Converts a scene's file to GLB.
    Convert(ConvertArgs),
    /// Generates a scene.
    Generate { generator: &'static Generator, parameters: Vec<(&'static str, u64)>, output: PathBuf, quiet: bool },
}

/// Convert a scene (glTF, OBJ, PLY or STL) to GLB
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  printf 'v 0 0 0\\nv 1 0 0\\nv 0 1 0\\nf 1 2 3\\n' > triangle.obj
  raystep scene convert triangle.obj -o triangle.glb")]
pub(crate) struct ConvertArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Output GLB
    #[arg(short, long, value_name = "F.glb")]
    output: PathBuf,
    #[command(flatten)]
    quiet: QuietArgs,
}

impl FromArgMatches for SceneCommand {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let missing = || clap::Error::raw(clap::error::ErrorKind::MissingSubcommand, "missing generator");
        let (name, matches) = matches.subcommand().ok_or_else(missing)?;
        match name {
            "list" => Ok(Self::List),
            "convert" => Ok(Self::Convert(ConvertArgs::from_arg_matches(matches)?)),
            _ => {
                let generator = GENERATORS.iter().find(|g| g.name == name).ok_or_else(missing)?;
                let given = |p: &raystep_scenes::generate::Parameter| Some((p.name, *matches.get_one::<u64>(p.name)?));
                Ok(Self::Generate {
                    generator,
                    parameters: generator.parameters.iter().filter_map(given).collect(),
                    output: matches.get_one::<PathBuf>("output").cloned().ok_or_else(missing)?,
                    quiet: matches.get_flag("quiet"),
                })
            }
        }
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Subcommand for SceneCommand {
    fn augment_subcommands(command: Command) -> Command {
        let command = command
            .about("Generate or convert a scene, as GLB")
            .after_help(
                "Examples:\n  raystep scene list\n  raystep scene soup --triangles 100000 --seed 7 -o soup.glb\n  \
                 raystep render soup.glb -o soup.png",
            )
            .subcommand_required(true)
            .subcommand(Command::new("list").about("List generators with parameters and their ranges"))
            .subcommand(ConvertArgs::augment_args(Command::new("convert")));
        GENERATORS.iter().fold(command, |command, g| command.subcommand(generator_command(g)))
    }

    fn augment_subcommands_for_update(command: Command) -> Command {
        Self::augment_subcommands(command)
    }

    fn has_subcommand(name: &str) -> bool {
        matches!(name, "list" | "convert") || GENERATORS.iter().any(|g| g.name == name)
    }
}

fn generator_command(generator: &'static Generator) -> Command {
    let mut command = QuietArgs::augment_args(Command::new(generator.name)).about(generator.summary);
    for p in generator.parameters {
        let help = format!("{}, {} [default: {}]", p.summary, range(p), p.default);
        let number = whole::<u64>(*p.range.start(), *p.range.end());
        let argument = Arg::new(p.name).long(p.name).value_name("N").value_parser(number).allow_negative_numbers(true);
        command = command.arg(argument.help(help));
    }
    let example = generator.parameters.first().map(|p| format!(" --{} {}", p.name, p.default)).unwrap_or_default();
    let output = Arg::new("output").short('o').long("output").value_name("F.glb").required(true);
    command
        .arg(output.value_parser(value_parser!(PathBuf)).help("Output GLB"))
        .after_help(format!("Examples:\n  raystep scene {0}{example} -o {0}.glb", generator.name))
}

fn range(p: &raystep_scenes::generate::Parameter) -> String {
    match (*p.range.start(), *p.range.end()) {
        (0, u64::MAX) => "any".into(),
        (min, max) => format!("{min} to {max}"),
    }
}

pub(crate) fn run(command: &SceneCommand) -> Result<(), Error> {
    match command {
        SceneCommand::List => print(&list()),
        SceneCommand::Convert(args) => {
            let target = glb_target(&args.output)?;
            let progress = Progress::new(args.quiet.quiet);
            progress.stage("reading");
            let file = scene_file::read(&args.scene)?;
            refuse_inputs(&[Some(&target)], &file.inputs)?;
            for note in &file.scene.notes {
                progress.say(format_args!("note: {}", note.0));
            }
            save(&file.scene, target, &args.output, &progress)
        }
        SceneCommand::Generate { generator, parameters, output, quiet } => {
            let target = glb_target(output)?;
            let progress = Progress::new(*quiet);
            progress.stage("generating");
            let scene = generator.make(parameters).map_err(|e| match e {
                GenerateError::OutOfMemory { .. } => Error::failed(e),
                _ => Error::usage(e),
            })?;
            save(&scene, target, output, &progress)
        }
    }
}

fn list() -> String {
    let mut text = String::new();
    for g in GENERATORS {
        text += &format!("{:<14} {}\n", g.name, g.summary);
        for p in g.parameters {
            text += &format!("{:<14}   --{} N  {}, {}, default {}\n", "", p.name, p.summary, range(p), p.default);
        }
    }
    text
}

fn glb_target(path: &Path) -> Result<Target, Error> {
    ending("-o", path, &["glb"])?;
    Target::new(path)
}

fn save(scene: &Scene, target: Target, path: &Path, progress: &Progress) -> Result<(), Error> {
    progress.stage("writing");
    let glb = write_glb(scene).map_err(|e| Error::failed(format!("cannot write {}: {e}", path.display())))?;
    let bytes = glb.len();
    write(vec![(target, glb)])?;
    progress.say(format_args!("{}: {} triangles, {bytes} bytes", path.display(), scene.triangles.len()));
    Ok(())
}
