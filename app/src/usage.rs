//! Usage errors in one line: the problem, the argument, and valid values. clap detects them; its own messages contain
//! unsuitable tips and overlong lists.

use std::error::Error as _;
use std::ffi::OsString;
use std::path::Path;

use clap::CommandFactory as _;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use raystep_inspector::lesson::built_in;
use raystep_scenes::ENDINGS;

use crate::cli::Cli;
use crate::scene_file;

/// Most values that a message lists; beyond that, it lists the nearest names.
const MOST_LISTED: usize = 12;

/// Least Jaro-Winkler similarity of a suggested name: one or two typos score higher; unrelated words that share
/// letters, such as dance and cancel, score 0.82.
const LIKE: f64 = 0.85;

/// The error in `arguments`, of which the first is the program.
pub(crate) fn message(error: &clap::Error, arguments: &[OsString]) -> String {
    let all = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => vec![text.clone()],
        Some(ContextValue::Strings(texts)) => texts.clone(),
        _ => Vec::new(),
    };
    let one = |kind| all(kind).into_iter().next().unwrap_or_default();
    let argument = one(ContextKind::InvalidArg);
    let option = name_of(&argument);
    match error.kind() {
        ErrorKind::InvalidValue => {
            let (value, valid) = (one(ContextKind::InvalidValue), all(ContextKind::ValidValue));
            match (value.as_str(), valid.as_slice()) {
                ("", []) => format!("{argument}: missing value"),
                ("", valid) => wrong_value(option, "''", valid),
                (value, valid) => wrong_value(option, value, valid),
            }
        }
        ErrorKind::ValueValidation => {
            let reason = error.source().map_or_else(|| "it cannot be parsed".to_owned(), ToString::to_string);
            format!("{option} {}: {reason}", one(ContextKind::InvalidValue))
        }
        ErrorKind::UnknownArgument => {
            let similar = one(ContextKind::SuggestedArg);
            let tip = if similar.is_empty() { String::new() } else { format!("; {similar} is similar") };
            format!("unexpected argument {argument}{tip} (see --help)")
        }
        ErrorKind::InvalidSubcommand => {
            let word = one(ContextKind::InvalidSubcommand);
            if arguments.get(1).is_some_and(|first| first == "scene") {
                // clap lists the nearest last.
                no_such_generator(&word, all(ContextKind::SuggestedSubcommand).pop())
            } else {
                no_such_command(&word)
            }
        }
        ErrorKind::MissingRequiredArgument => missing(&all(ContextKind::InvalidArg), arguments),
        ErrorKind::ArgumentConflict => {
            let others = all(ContextKind::PriorArg);
            if others.is_empty() || others == [argument.clone()] {
                format!("{option} is given more than once")
            } else {
                format!("{argument} cannot be combined with {}: omit one of them", and(&others))
            }
        }
        ErrorKind::MissingSubcommand | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            "missing command (see --help)".to_owned()
        }
        ErrorKind::InvalidUtf8 => "an argument is not UTF-8; only file names may be".to_owned(),
        _ => one_line(&error.render().to_string()),
    }
}

/// The name of an argument in messages; help shows it as `--size <WxH>`.
fn name_of(argument: &str) -> &str {
    let name = argument.split(' ').next().unwrap_or(argument);
    name.trim_matches(['<', '>', '[', ']', '.'])
}

/// An invalid value.
fn wrong_value(option: &str, value: &str, valid: &[String]) -> String {
    if valid.len() <= MOST_LISTED {
        format!("{option} {value}: expected {}", or(valid))
    } else {
        format!("{option} {value}: {}(see --help)", did_you_mean(value, valid))
    }
}

/// `did you mean x or y? `, or empty if no name is near.
pub(crate) fn did_you_mean<T: AsRef<str>>(wrong: &str, names: &[T]) -> String {
    let near = nearest(wrong, names);
    if near.is_empty() { String::new() } else { format!("did you mean {}? ", or(&near)) }
}

/// The nearest names, at most three, the best first.
pub(crate) fn nearest<'a, T: AsRef<str>>(wrong: &str, names: &'a [T]) -> Vec<&'a str> {
    let wrong = wrong.to_lowercase();
    let likeness = |name: &str| {
        let name = name.to_lowercase();
        // A substring of a name counts as much as a typo.
        let is_part = wrong.chars().count() > 1 && name.contains(&wrong);
        if is_part { 1.0 } else { strsim::jaro_winkler(&wrong, &name) }
    };
    let mut near: Vec<(f64, &str)> =
        names.iter().map(|name| (likeness(name.as_ref()), name.as_ref())).filter(|(like, _)| *like >= LIKE).collect();
    near.sort_by(|a, b| b.0.total_cmp(&a.0));
    near.into_iter().take(3).map(|(_, name)| name).collect()
}

/// `a, b or c`
pub(crate) fn or<T: AsRef<str>>(names: &[T]) -> String {
    series(names, "or")
}

/// `a, b and c`
fn and<T: AsRef<str>>(names: &[T]) -> String {
    series(names, "and")
}

fn series<T: AsRef<str>>(names: &[T], word: &str) -> String {
    let names: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
    match names.split_last() {
        Some((last, [])) => (*last).to_owned(),
        Some((last, rest)) => format!("{} {word} {last}", rest.join(", ")),
        None => String::new(),
    }
}

fn no_such_generator(word: &str, nearest: Option<String>) -> String {
    let tip = nearest.map(|name| format!("did you mean {name}? ")).unwrap_or_default();
    format!("{word}: no such generator; {tip}'raystep scene list' lists them")
}

/// A first word that is not a command: perhaps a file, a scene or a lesson.
fn no_such_command(word: &str) -> String {
    let path = Path::new(word);
    if path.is_dir() {
        return format!("{word}: it is a folder; expected a command or a scene's file (see --help)");
    }
    if path.exists() || path.components().count() > 1 || path.extension().is_some() {
        let endings = or(&ENDINGS.map(|ending| format!(".{ending}")));
        return format!("{word}: expected a command, or a file whose name ends in {endings} (see --help)");
    }
    if built_in::lesson(word).is_some() {
        return format!("{word}: no such command, but a lesson; 'raystep inspect --lesson {word}' begins it");
    }
    let commands = Cli::command();
    let commands = commands.get_subcommands().map(|command| command.get_name().to_owned());
    let names: Vec<String> = commands.chain(scene_file::names()).collect();
    let tip = did_you_mean(word, &names);
    let tip = if tip.is_empty() { tip } else { format!("; {}", tip.trim_end()) };
    format!("{word}: no such command, and no scene of that name{tip} (see --help)")
}

/// Options, and another one that each requires.
const REQUIRED_BY: [(&str, &str); 7] = [
    ("--family", "--cost"),
    ("--step", "--lesson"),
    ("--check", "--lesson"),
    ("--do", "--screenshot"),
    ("--scale", "--screenshot"),
    ("--count-fragments", "--passes-csv"),
    ("--force", "--output"),
];

/// Missing arguments.
fn missing(arguments: &[String], given: &[OsString]) -> String {
    const OF_CAMERA: [&str; 4] = ["--eye", "--look-at", "--up", "--fov"];
    let is_given = |option: &&str| {
        let starts = |given: &OsString| given.to_str().and_then(|g| g.strip_prefix(option)).is_some_and(is_whole);
        given.iter().any(starts)
    };
    let is_of_camera = |argument: &String| OF_CAMERA.contains(&name_of(argument));
    if let Some(option) =
        OF_CAMERA.iter().find(|option| is_given(option)).filter(|_| arguments.iter().all(is_of_camera))
    {
        let place = |argument: &String| OF_CAMERA.iter().position(|&option| option == name_of(argument));
        let mut arguments = arguments.to_vec();
        arguments.sort_by_key(place);
        return format!("{option} requires {} as well", and(&arguments));
    }
    let is_missing = |needed: &str| matches!(arguments, [only] if name_of(only) == needed);
    if let Some((option, _)) = REQUIRED_BY.iter().find(|(option, needed)| is_given(option) && is_missing(needed)) {
        return format!("{option} requires {} as well", and(arguments));
    }
    let is = if arguments.len() == 1 { "is" } else { "are" };
    format!("{} {is} missing (see --help)", and(arguments))
}

/// Whether an option's name ends here.
fn is_whole(rest: &str) -> bool {
    rest.is_empty() || rest.starts_with('=')
}

/// clap's message in one line, without usage and the pointer to help.
fn one_line(message: &str) -> String {
    let message = message.strip_prefix("error: ").unwrap_or(message);
    let paragraphs =
        message.split("\n\n").filter(|p| !p.starts_with("Usage:") && !p.starts_with("For more information"));
    let lines = paragraphs.map(|p| p.split_whitespace().collect::<Vec<_>>().join(" ")).collect::<Vec<_>>().join("; ");
    format!("{lines} (see --help)")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_names_come_first_and_far_ones_not_at_all() {
        let names = ["Toggle light/dark theme", "Overview layout", "Step layout", "Fit to panel", "Quit"];
        assert_eq!(nearest("stp layuot", &names), ["Step layout"]);
        assert_eq!(nearest("layout", &names), ["Overview layout", "Step layout"]);
        assert_eq!(nearest("dance", &names), Vec::<&str>::new());
        assert_eq!(did_you_mean("quiet", &names), "did you mean Quit? ");
        assert_eq!(did_you_mean("x", &names), "");
    }

    #[test]
    fn names_stand_in_a_series() {
        assert_eq!(
            (or(&["a"]), or(&["a", "b"]), and(&["a", "b", "c"])),
            ("a".into(), "a or b".into(), "a, b and c".into())
        );
    }
}
