//! Arrays of integers in npy files.

use std::io::Read;

use raystep_kernels::numbers::npy::{Header, fill};

use super::{AT_ONCE, RaysError};

/// Reads an array of `count` integers.
pub(super) fn integers(mut input: &mut dyn Read, count: u64) -> Result<Vec<u32>, RaysError> {
    const TYPES: [&str; 8] = ["|u1", "|i1", "<u2", "<i2", "<u4", "<i4", "<u8", "<i8"];
    let header = Header::read(&mut input)?;
    header.expect_type(&TYPES, "an integer type, little-endian")?;
    if header.shape != [count] {
        return Err(header.wrong_shape(format!("({count},), one for each ray")).into());
    }
    let (is_signed, stride) = (header.descr.as_bytes()[1] == b'i', usize::from(header.descr.as_bytes()[2] - b'0'));
    let mut all: Vec<u32> = Vec::new();
    let mut bytes = Vec::new();
    while (all.len() as u64) < count {
        let wanted = AT_ONCE.min((count - all.len() as u64) as usize);
        bytes.resize(wanted * stride, 0);
        let read = fill(&mut input, &mut bytes)?;
        if read < bytes.len() {
            let after = all.len() as u64 + (read / stride) as u64;
            return Err(RaysError::Truncated { after, rays: Some(count), bytes: read % stride });
        }
        for bytes in bytes.chunks_exact(stride) {
            let is_negative = is_signed && bytes[stride - 1] >= 0x80;
            let mut wide = [if is_negative { 0xff } else { 0 }; 16];
            wide[..stride].copy_from_slice(bytes);
            let value = i128::from_le_bytes(wide);
            all.push(u32::try_from(value).map_err(|_| RaysError::Stratum { index: all.len() as u64, value })?);
        }
    }
    match fill(&mut input, &mut [0])? {
        0 => Ok(all),
        _ => Err(RaysError::Extra { rays: count }),
    }
}
