//! The elements that stop, in words and as files.

use std::fmt::Write as _;
use std::path::Path;

use raystep_kernels::export::npy;
use raystep_kernels::interpret::{Stopped, Watched};
use raystep_kernels::shader::{FileLine, Sourced};
use raystep_kernels::tables::elements::Count;
use raystep_lab::png;
use raystep_lab::stops::StoppedPass;

use crate::commands::extension;
use crate::error::Error;

/// Elements that are named.
const MOST_NAMED: usize = 5;
/// A pixel of the mask that only comes to the line.
const REACHED: u8 = 90;

/// The elements of a pass, and what was asked.
pub(super) struct Shown<'a> {
    pub(super) found: &'a StoppedPass,
    pub(super) of: &'a Sourced,
    pub(super) at: FileLine,
    pub(super) when: Option<&'a str>,
    /// The variables of the condition.
    pub(super) names: &'a [String],
    pub(super) watched: &'a [Watched],
}

impl Shown<'_> {
    fn is_image(&self) -> bool {
        self.of.variant.kernel.instance().over.count == Count::Image
    }

    /// Its own numbers, one after the other.
    fn name_of(&self, element: usize) -> String {
        let width = self.found.size.width.max(1) as usize;
        match self.is_image() {
            true => format!("{},{}", element % width, element / width),
            false => element.to_string(),
        }
    }

    /// The variables with their values.
    fn values<'b>(&'b self, stopped: &'b Stopped) -> impl Iterator<Item = (&'b str, Watched, &'b [u32])> {
        let mut first = 0;
        self.watched.iter().filter_map(move |watched| {
            let end = first + watched.words as usize;
            let values = stopped.values.get(first..end)?;
            first = end;
            Some((self.names.get(watched.index)?.as_str(), *watched, values))
        })
    }

    pub(super) fn words(&self) -> String {
        let Self { found, of, at, .. } = self;
        let kernel = of.variant.kernel;
        let held: Vec<_> = found.held().collect();
        let name = &of.files[at.file].name;
        let mut text = format!(
            "pass {}, {}, {name}:{}: {} of {} {} come here",
            found.pass,
            kernel.name(),
            at.line,
            found.elements.len(),
            found.size.count,
            kernel.instance().over.name,
        );
        if let Some(when) = self.when {
            let _ = write!(text, ", {when} holds for {}", held.len());
        }
        let _ = writeln!(text, "\n  {}", of.text_of(*at).trim());
        for (element, stopped) in held.iter().take(MOST_NAMED) {
            let _ = write!(text, "  {}", self.name_of(*element));
            for (name, watched, values) in self.values(stopped) {
                let _ = write!(text, "  {name} = {}", watched.told(values));
            }
            match (self.when, stopped.reached, stopped.held) {
                (_, 1, _) => {}
                (None, reached, _) => _ = write!(text, "  {reached} times"),
                (Some(_), reached, held) => _ = write!(text, "  {held} of {reached} times"),
            }
            text.push('\n');
        }
        if held.len() > MOST_NAMED {
            let _ = writeln!(text, "  and {} more", held.len() - MOST_NAMED);
        }
        text
    }

    pub(super) fn file(&self, path: &Path) -> Result<Vec<u8>, Error> {
        match extension(path).as_str() {
            "png" => self.mask(),
            "csv" => Ok(self.list().into_bytes()),
            _ => self.array(),
        }
    }

    fn mask(&self) -> Result<Vec<u8>, Error> {
        if !self.is_image() {
            return Err(Error::usage(
                "-o: the elements of the kernel are not the pixels of an image: choose .csv or .npy",
            ));
        }
        let size = self.found.size;
        let mut rgb = vec![0; 3 * size.texels() as usize];
        for (element, stopped) in &self.found.elements {
            if let Some(pixel) = rgb.get_mut(3 * element..3 * element + 3) {
                pixel.fill(if stopped.held > 0 { u8::MAX } else { REACHED });
            }
        }
        png::encode(size.width, size.height, &rgb).map_err(Error::failed)
    }

    fn list(&self) -> String {
        let width = self.found.size.width.max(1) as usize;
        let mut text = "element,x,y,reached,held".to_owned();
        for watched in self.watched {
            let name = self.names.get(watched.index).map_or("", String::as_str);
            match watched.words {
                1 => _ = write!(text, ",{name}"),
                words => (0..words as usize).for_each(|at| _ = write!(text, ",{name}.{}", &"xyzw"[at..=at])),
            }
        }
        text.push('\n');
        for (element, stopped) in &self.found.elements {
            let Stopped { reached, held, .. } = stopped;
            let _ = write!(text, "{element},{},{},{reached},{held}", element % width, element / width);
            for (_, watched, values) in self.values(stopped) {
                values.iter().for_each(|&bits| _ = write!(text, ",{}", watched.kind.told(bits)));
            }
            text.push('\n');
        }
        text
    }

    fn array(&self) -> Result<Vec<u8>, Error> {
        let size = self.found.size;
        let texels = size.texels() as usize;
        let mut bits = vec![0; 2 * texels];
        for (element, stopped) in &self.found.elements {
            if *element < texels {
                (bits[*element], bits[texels + element]) = (stopped.reached, stopped.held);
            }
        }
        let mut bytes = Vec::new();
        npy::write_bits(&mut bytes, false, [2, size.height, size.width], &bits).map_err(Error::failed)?;
        Ok(bytes)
    }
}
