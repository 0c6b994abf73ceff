//! The elements that stop, in words and as files.

use std::fmt::Write as _;
use std::path::Path;

use raystep_kernels::export::npy;
use raystep_kernels::interpret::Stopped;
use raystep_lab::png;
use raystep_lab::stops::Told;

use crate::commands::extension;
use crate::error::Error;

/// Elements that are named.
const MOST_NAMED: usize = 5;
/// A pixel of the mask that only comes to the line.
const REACHED: u8 = 90;

/// The summary, and the first elements.
pub(super) fn words(told: &Told<'_>) -> String {
    let mut text = format!("{}\n  {}\n", told.head(), told.of.text_of(told.at).trim());
    for (element, stopped) in told.found.held().take(MOST_NAMED) {
        let _ = writeln!(text, "  {}{}", told.name_of(*element), told.element(stopped));
    }
    let count = told.found.held().count();
    if count > MOST_NAMED {
        let _ = writeln!(text, "  and {} more", count - MOST_NAMED);
    }
    text
}

/// The elements as a file of this name.
pub(super) fn file(told: &Told<'_>, path: &Path) -> Result<Vec<u8>, Error> {
    match extension(path).as_str() {
        "png" => mask(told),
        "csv" => Ok(list(told).into_bytes()),
        _ => array(told),
    }
}

fn mask(told: &Told<'_>) -> Result<Vec<u8>, Error> {
    if !told.is_image() {
        return Err(Error::usage("-o: the elements of the kernel are not the pixels of an image: choose .csv or .npy"));
    }
    let size = told.found.size;
    let mut rgb = vec![0; 3 * size.texels() as usize];
    for (element, stopped) in &told.found.elements {
        if let Some(pixel) = rgb.get_mut(3 * element..3 * element + 3) {
            pixel.fill(if stopped.held > 0 { u8::MAX } else { REACHED });
        }
    }
    png::encode(size.width, size.height, &rgb).map_err(Error::failed)
}

fn list(told: &Told<'_>) -> String {
    let width = told.found.size.width.max(1) as usize;
    let mut text = "element,x,y,reached,held".to_owned();
    for watched in told.watched {
        let name = told.names.get(watched.index).map_or("", String::as_str);
        match watched.words {
            1 => _ = write!(text, ",{name}"),
            words => (0..words as usize).for_each(|at| _ = write!(text, ",{name}.{}", &"xyzw"[at..=at])),
        }
    }
    text.push('\n');
    for (element, stopped) in &told.found.elements {
        let Stopped { reached, held, .. } = stopped;
        let _ = write!(text, "{element},{},{},{reached},{held}", element % width, element / width);
        for (_, watched, values) in told.values(stopped) {
            values.iter().for_each(|&bits| _ = write!(text, ",{}", watched.kind.told(bits)));
        }
        text.push('\n');
    }
    text
}

fn array(told: &Told<'_>) -> Result<Vec<u8>, Error> {
    let size = told.found.size;
    let texels = size.texels() as usize;
    let mut bits = vec![0; 2 * texels];
    for (element, stopped) in &told.found.elements {
        if *element < texels {
            (bits[*element], bits[texels + element]) = (stopped.reached, stopped.held);
        }
    }
    let mut bytes = Vec::new();
    npy::write_bits(&mut bytes, false, [2, size.height, size.width], &bits).map_err(Error::failed)?;
    Ok(bytes)
}
