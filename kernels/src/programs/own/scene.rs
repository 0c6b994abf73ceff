//! Programs that read a scene: it is prepared for them as for a program of ours.

use toml::Value;

use super::reader::Reader;
use crate::options::rows::ROWS;
use crate::options::{Choices, Options, ProgramName, ScheduleKind};
use crate::programs::{Registered, chosen};
use crate::shader::Mistake;

/// What a program reads of a scene.
#[derive(Clone, Debug)]
pub struct OfScene {
    /// The scene if none is named: a name such as `cornell-box`, or a file in the folder.
    pub file: Option<String>,
    /// The options of the run of ours that it is prepared for, and their values.
    options: Vec<(&'static str, String)>,
}

impl OfScene {
    /// The options of that run, where the others are these.
    #[must_use]
    pub fn choices(&self, others: &Choices) -> Choices {
        // A run that has a kernel for each step binds everything a walk may need.
        let mut choices = Choices { program: ProgramName::ClosestHit, schedule: ScheduleKind::Second, ..*others };
        for (name, value) in &self.options {
            if let Some(row) = ROWS.iter().find(|row| row.name == *name) {
                // They were set once before.
                let _ = row.set(&mut choices, value);
            }
        }
        choices
    }

    /// Our program whose buffers it has.
    pub(super) fn base(&self) -> &'static Registered {
        chosen(&self.choices(&Choices::default()))
    }

    /// The same run of ours with other options as these.
    pub(super) fn options(&self, options: &Options) -> Options {
        let choices = self.choices(&options.choices());
        Options { folder: None, shade: true, any_hit: false, all_hits: false, ..options.clone() }.chosen(&choices)
    }
}

impl Reader<'_> {
    /// What the program reads of a scene, if it does.
    pub(super) fn scene(&self) -> Result<Option<OfScene>, Mistake> {
        let Some(entry) = &self.manifest.scene else { return Ok(None) };
        let written = entry.get_ref();
        let mut options = Vec::new();
        let mut choices = Choices::default();
        for (name, value) in &written.options.0 {
            let wrong = |message: String| self.at(value.span(), message);
            let row = ROWS.iter().find(|row| row.name == name);
            let row = row.ok_or_else(|| wrong(format!("no option of a run is named {name}")))?;
            let text = match value.get_ref() {
                Value::String(text) => text.clone(),
                Value::Integer(number) => number.to_string(),
                Value::Boolean(is_on) => is_on.to_string(),
                _ => return Err(wrong(format!("{name} is a text, an integer, true or false"))),
            };
            row.set(&mut choices, &text).map_err(|why| wrong(format!("{name}: {why}")))?;
            options.push((row.name, text));
        }
        if let Some(why) = ROWS.iter().find_map(|row| (row.refused)(&choices)?.impossible()) {
            return Err(self.at(entry.span(), why));
        }
        if choices.mapping != crate::options::mapping::Mapping::Compute {
            return Err(self.at(entry.span(), "kernels of one's own are compute shaders: omit mapping"));
        }
        Ok(Some(OfScene { file: written.file.clone(), options }))
    }
}
