//! Decompresses buffer views of KHR_meshopt_compression and of EXT_meshopt_compression, which is the same without the
//! newer form of attributes and the filter of colours.
//!
//! Written from the text of the extensions (Kapoulkine et al., Khronos Group); Appendix A describes the streams, B the
//! filters. A stream is as long as the file says, has a header byte and ends with a block of fixed size, and everything
//! between must be used up.

mod attributes;
mod filters;
mod indices;

use super::LoadError;
use super::at;
use super::budget::Budget;
use super::json::Meshopt;

/// Largest size of an element.
const MAX_STRIDE: usize = 256;

/// Why a stream cannot be decompressed.
type Problem = &'static str;

/// Decompresses `input` as `json`, at `path`, says.
pub(super) fn decode(json: &Meshopt, input: &[u8], budget: &Budget, path: &str) -> Result<Vec<u8>, LoadError> {
    let wrong = |problem: Problem| at(path, format!("cannot be decompressed: {problem}"));
    let count = json.count.need(|| format!("{path}.count"))?.0;
    let stride = json.byte_stride.need(|| format!("{path}.byteStride"))?.index();
    let mode = json.mode.need(|| format!("{path}.mode"))?.as_str();
    let filter = json.filter.get(|| format!("{path}.filter"))?.map_or("NONE", String::as_str);
    let (right_stride, right_mode) = match mode {
        "ATTRIBUTES" => (stride.is_multiple_of(4) && (4..=MAX_STRIDE).contains(&stride), true),
        "TRIANGLES" | "INDICES" => (stride == 2 || stride == 4, true),
        _ => (true, false),
    };
    if !right_mode {
        return Err(at(format!("{path}.mode"), format!("is {mode:?}; expected ATTRIBUTES, TRIANGLES or INDICES")));
    }
    if !right_stride {
        return Err(at(format!("{path}.byteStride"), format!("is {stride}, which {mode} does not allow")));
    }
    // Whatever the mode, an element that is not in the input takes part in a run that is: this bounds the time as well.
    let bytes = count.saturating_mul(stride as u64);
    let mut out = budget.vec(bytes, path)?;
    let Ok(count) = usize::try_from(count) else { return Err(wrong("there are too many elements")) };
    match mode {
        "ATTRIBUTES" => {
            attributes::decode(input, count, stride, &mut out).map_err(wrong)?;
            filters::apply(filter, stride, &mut out).map_err(wrong)?;
        }
        "TRIANGLES" => indices::triangles(input, count, stride, &mut out).map_err(wrong)?,
        _ => indices::sequence(input, count, stride, &mut out).map_err(wrong)?,
    }
    Ok(out)
}
