//! `--shard I/N`: one of N parts of a command's work, for as many machines, and what its folder says of it, so that
//! `raystep merge` combines only what belongs together.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;
use std::path::Path;
use std::str::FromStr;

use clap::Args;
use raystep_kernels::export::json::AdapterInfo;
use raystep_lab::Machine;
use raystep_lab::text::visible;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::error::Error;
use crate::scene_file::read_file;

/// `--shard`
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct ShardArgs {
    /// Run only part I of N (counted from 1), to divide the work among N machines or jobs; 'raystep merge' combines the parts
    #[arg(long, value_name = "I/N", requires = "output")]
    pub(crate) shard: Option<Shard>,
}

/// One part of several.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Shard {
    /// Its number, from 1.
    pub(crate) index: u32,
    /// How many there are.
    pub(crate) of: u32,
}

/// Most parts.
const MOST: u32 = 65_536;

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(index, of)| Some((index.parse().ok()?, of.parse().ok()?)));
        match numbers {
            Some((index, of)) if (1..=of).contains(&index) && of <= MOST => Ok(Self { index, of }),
            _ => Err(format!("expected I/N, part I of N, with I from 1 to N and N at most {MOST}, such as 1/4")),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.of)
    }
}

impl Shard {
    /// What this part does of so many `units`, which are adjacent: never nothing.
    pub(crate) fn range(self, units: usize, name: &str) -> Result<Range<usize>, Error> {
        let Self { index, of } = self;
        if units < of as usize {
            let most = if units == 1 { "omit --shard".to_owned() } else { format!("use at most {units} parts") };
            return Err(Error::usage(format!("--shard {self}: too few {name} to divide, {units}: {most}")));
        }
        let up_to = |part: u32| (units as u64 * u64::from(part) / u64::from(of)) as usize;
        Ok(up_to(index - 1)..up_to(index))
    }
}

/// The file in a part's folder that describes it.
pub(crate) const FILE: &str = "shard.json";

/// Most bytes of that file: thousands of scenes.
const MOST_BYTES: u64 = 1 << 24;

/// What a part is of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Part {
    /// The command: render, bench or stability.
    pub(crate) command: String,
    raystep_version: String,
    /// Which part.
    pub(crate) shard: Shard,
    /// Every scene of all parts: its name, and the hash of its files.
    scenes: Vec<(String, String)>,
    /// The options that determine the results.
    options: BTreeMap<String, Value>,
    /// The device, and the driver of an adapter.
    pub(crate) device: String,
    /// Of a picture.
    pub(crate) picture: Option<Picture>,
}

/// The picture that blocks of samples belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Picture {
    /// Pixels per row.
    pub(crate) width: u32,
    /// Rows.
    pub(crate) height: u32,
    /// Samples per pixel, of all parts.
    pub(crate) samples: u32,
}

impl Part {
    /// A part of a command's results. `options` is an object.
    pub(crate) fn new(
        command: &str,
        shard: Shard,
        scenes: Vec<(String, String)>,
        options: &impl Serialize,
        machine: &Machine,
    ) -> Result<Self, Error> {
        let options = match serde_json::to_value(options) {
            Ok(Value::Object(map)) => map.into_iter().collect(),
            _ => return Err(Error::failed("cannot write the options as JSON")),
        };
        let device = match machine.gpu().map(AdapterInfo::from) {
            Some(adapter) => format!("{} ({}, {})", adapter.name, adapter.backend, adapter.driver),
            None => machine.kind().to_owned(),
        };
        let raystep_version = env!("CARGO_PKG_VERSION").to_owned();
        Ok(Self { command: command.to_owned(), raystep_version, shard, scenes, options, device, picture: None })
    }

    /// The same of a picture.
    pub(crate) fn of_picture(self, picture: Picture) -> Self {
        Self { picture: Some(picture), ..self }
    }

    /// The file's text.
    pub(crate) fn text(&self) -> Result<String, Error> {
        crate::commands::json_text(self)
    }

    /// What a text says. The last bits of its numbers may not be those that were written: only what was read from text is
    /// compared.
    pub(crate) fn parse(text: &[u8]) -> Result<Self, String> {
        serde_json::from_slice(text).map_err(|e| format!("it does not describe a part of a split run: {e}"))
    }

    /// Reads that of a folder; `None` if it has none.
    pub(crate) fn read(folder: &Path) -> Result<Option<Self>, Error> {
        let path = folder.join(FILE);
        if !path.exists() {
            return Ok(None);
        }
        let failed = |problem: &dyn fmt::Display| Error::failed(format!("{}: {problem}", path.display()));
        let bytes = read_file(&path, MOST_BYTES).map_err(|e| failed(&e))?;
        let part = Self::parse(&bytes).map_err(|e| failed(&e))?;
        let is_right = (1..=part.shard.of).contains(&part.shard.index) && part.shard.of <= MOST;
        if is_right {
            Ok(Some(part))
        } else {
            Err(failed(&format!(
                "part {} is invalid: expected I/N, with I from 1 to N and N at most {MOST}",
                part.shard
            )))
        }
    }

    /// Why another part is not of the same whole: what differs, with both values. Devices are compared only if results
    /// of several kinds must not be mixed.
    pub(crate) fn difference(&self, other: &Self, is_mixed: bool) -> Option<String> {
        let differ = |what: &str, a: &dyn fmt::Display, b: &dyn fmt::Display| {
            let (a, b) = (a.to_string(), b.to_string());
            (a != b).then(|| format!("{what}: {} and {}", visible(&a), visible(&b)))
        };
        let scenes = |part: &Self| part.scenes.iter().map(|(name, hash)| format!("{name} {hash}")).collect::<Vec<_>>();
        let names = self.options.keys().chain(other.options.keys());
        let option = |part: &Self, name: &str| part.options.get(name).map_or("not set".to_owned(), Value::to_string);
        differ("command", &self.command, &other.command)
            .or_else(|| differ("version of raystep", &self.raystep_version, &other.raystep_version))
            .or_else(|| differ("number of parts", &self.shard.of, &other.shard.of))
            .or_else(|| differ("scene", &scenes(self).join(", "), &scenes(other).join(", ")))
            .or_else(|| names.into_iter().find_map(|name| differ(name, &option(self, name), &option(other, name))))
            .or_else(|| {
                let text = |part: &Self| {
                    part.picture.map_or("none".into(), |p| format!("{}x{}, {} samples", p.width, p.height, p.samples))
                };
                differ("image", &text(self), &text(other))
            })
            .or_else(|| differ("device", &self.device, &other.device).filter(|_| !is_mixed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_cover_everything_once() {
        for (units, of) in [(16, 1), (16, 3), (16, 7), (16, 16), (5, 4), (100, 99)] {
            let ranges = (1..=of).map(|index| Shard { index, of }.range(units, "blocks").expect("enough"));
            let all: Vec<usize> = ranges.inspect(|r| assert!(!r.is_empty(), "{units} in {of}")).flatten().collect();
            assert_eq!(all, (0..units).collect::<Vec<_>>(), "{units} in {of}");
        }
        let error = Shard { index: 2, of: 5 }.range(4, "scenes").expect_err("too few");
        assert!(error.message().contains("too few scenes to divide, 4: use at most 4 parts"), "{error}");
    }

    #[test]
    fn only_a_part_of_several_is_one() {
        assert_eq!("3/7".parse(), Ok(Shard { index: 3, of: 7 }));
        for wrong in ["", "3", "0/4", "5/4", "1/0", "a/b", "-1/2", "1/65537", "1/2/3"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }
}
