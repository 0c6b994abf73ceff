//! Mode 0: elements of up to 256 bytes, as differences to the element before them.
//!
//! The input is a header, blocks of up to 256 elements, and a tail with the element before the first and, in version 1,
//! a mode per channel of four bytes. In a block, all elements' first bytes come first, then all second bytes, and so on,
//! each in groups of 16; a group's bytes are stored in 0 to 8 bits, with an escape value for those that need more.

use super::{MAX_STRIDE, Problem};

/// Elements per group.
const GROUP: usize = 16;
/// Maximum number of elements per block.
const BLOCK: usize = 256;

/// The bits per byte of a group, by its header's two bits.
type Widths = [u32; 4];

const WIDTHS_OF_VERSION_0: Widths = [0, 2, 4, 8];
const WIDTHS_OF_CONTROL: [Widths; 2] = [[0, 1, 2, 4], [1, 2, 4, 8]];

const CUT: Problem = "the data ends too early";

/// Takes `count` bytes off the start of `data`.
fn take<'a>(data: &mut &'a [u8], count: usize) -> Result<&'a [u8], Problem> {
    let (taken, rest) = data.split_at_checked(count).ok_or(CUT)?;
    *data = rest;
    Ok(taken)
}

/// Appends `count` elements of `stride` bytes.
pub(super) fn decode(input: &[u8], count: usize, stride: usize, out: &mut Vec<u8>) -> Result<(), Problem> {
    let has_modes = match input.first() {
        Some(0xa0) => false,
        Some(0xa1) => true,
        _ => return Err("the data does not start with 0xa0 or 0xa1"),
    };
    let (modes, padded) = if has_modes { (stride / 4, 24) } else { (0, 32) };
    let tail = stride + modes;
    let end = input.len().checked_sub(tail.max(padded)).filter(|&end| end > 0).ok_or(CUT)?;
    let mut data = input.get(1..end).unwrap_or_default();
    let (first, modes) = input.get(input.len() - tail..).unwrap_or_default().split_at_checked(stride).ok_or(CUT)?;
    let mut previous = [0; MAX_STRIDE];
    let previous = previous.get_mut(..stride).ok_or(CUT)?;
    previous.copy_from_slice(first);

    let most = (8192 / stride / GROUP * GROUP).min(BLOCK);
    let mut left = count;
    let mut columns = vec![0; BLOCK * stride];
    while left > 0 {
        let elements = left.min(most);
        let controls = if has_modes { Some(take(&mut data, stride / 4)?) } else { None };
        for (k, column) in columns.chunks_exact_mut(BLOCK).enumerate() {
            let control = controls.map(|controls| controls.get(k / 4).map_or(0, |byte| byte >> (2 * (k % 4)) & 3));
            read_column(&mut data, control, elements, column)?;
        }
        let start = out.len();
        out.resize(start + elements * stride, 0);
        let block = out.get_mut(start..).unwrap_or_default();
        for channel in 0..stride / 4 {
            let mode = modes.get(channel).copied().unwrap_or_default();
            add_channel(block, stride, channel, mode, &columns, previous)?;
        }
        left -= elements;
    }
    if data.is_empty() { Ok(()) } else { Err("there is more data than elements") }
}

/// Reads one byte of each element in a block.
fn read_column(data: &mut &[u8], control: Option<u8>, elements: usize, column: &mut [u8]) -> Result<(), Problem> {
    let widths = match control {
        None => &WIDTHS_OF_VERSION_0,
        Some(2) => {
            column.fill(0);
            return Ok(());
        }
        Some(3) => {
            let bytes = take(data, elements)?;
            column.get_mut(..elements).ok_or(CUT)?.copy_from_slice(bytes);
            return Ok(());
        }
        Some(control) => WIDTHS_OF_CONTROL.get(usize::from(control)).unwrap_or(&WIDTHS_OF_VERSION_0),
    };
    let groups = elements.div_ceil(GROUP);
    let headers = take(data, groups.div_ceil(4))?;
    for (i, group) in column.chunks_exact_mut(GROUP).take(groups).enumerate() {
        let header = headers.get(i / 4).map_or(0, |byte| byte >> (2 * (i % 4)) & 3);
        read_group(data, widths.get(usize::from(header)).copied().unwrap_or_default(), group)?;
    }
    Ok(())
}

/// Reads 16 bytes that are stored in `width` bits each.
fn read_group(data: &mut &[u8], width: u32, group: &mut [u8]) -> Result<(), Problem> {
    match width {
        0 => group.fill(0),
        8 => group.copy_from_slice(take(data, GROUP)?),
        _ => {
            let packed = take(data, GROUP * width as usize / 8)?;
            let per_byte = 8 / width as usize;
            let escape = ((1_u32 << width) - 1) as u8;
            for (i, byte) in group.iter_mut().enumerate() {
                let place = i % per_byte;
                // Single bits start at the lowest, pairs and quadruples at the highest.
                let shift = if width == 1 { place } else { 8 - width as usize * (place + 1) };
                let value = packed.get(i / per_byte).map_or(0, |byte| byte >> shift & escape);
                *byte = if value == escape { take(data, 1)?.first().copied().unwrap_or_default() } else { value };
            }
        }
    }
    Ok(())
}

/// Makes one channel of a block's elements from their differences. `previous` is the element before the block, and
/// becomes its last.
fn add_channel(
    block: &mut [u8],
    stride: usize,
    channel: usize,
    mode: u8,
    columns: &[u8],
    previous: &mut [u8],
) -> Result<(), Problem> {
    let at = 4 * channel;
    let Some(last) = previous.get_mut(at..).and_then(|rest| rest.first_chunk_mut::<4>()) else { return Ok(()) };
    let columns = columns.get(at * BLOCK..).unwrap_or_default();
    for (i, element) in block.chunks_exact_mut(stride).enumerate() {
        let delta: [u8; 4] = std::array::from_fn(|k| columns.get(k * BLOCK + i).copied().unwrap_or_default());
        *last = match mode {
            0 => std::array::from_fn(|k| last[k].wrapping_add(unzigzag8(delta[k]))),
            1 => add_pairs(*last, delta),
            _ if mode & 15 == 2 => {
                // The text rotates to the left, as encoders do.
                let turned = u32::from_le_bytes(delta).rotate_right(u32::from(mode >> 4));
                (u32::from_le_bytes(*last) ^ turned).to_le_bytes()
            }
            _ => return Err("a channel has an unknown mode"),
        };
        if let Some(place) = element.get_mut(at..at + 4) {
            place.copy_from_slice(last);
        }
    }
    Ok(())
}

fn add_pairs(last: [u8; 4], delta: [u8; 4]) -> [u8; 4] {
    let pairs = |[a, b, c, d]: [u8; 4]| [u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d])];
    let ([a, b], [d, e]) = (pairs(last), pairs(delta));
    let unzigzag = |v: u16| (v >> 1) ^ (v & 1).wrapping_neg();
    let [[a, b], [c, d]] = [a.wrapping_add(unzigzag(d)), b.wrapping_add(unzigzag(e))].map(u16::to_le_bytes);
    [a, b, c, d]
}

fn unzigzag8(v: u8) -> u8 {
    (v >> 1) ^ (v & 1).wrapping_neg()
}
