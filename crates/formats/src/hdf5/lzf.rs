//! LZF, the fast compression of h5py (filter 32000).

use hdf5_reader::error::{Error, Result};

/// Unpacks bytes. What comes out is at most 88 times as long, as three bytes stand for at most 264.
pub(super) fn unpack(packed: &[u8]) -> Result<Vec<u8>> {
    let short = || Error::DecompressionError("LZF data end too early".into());
    let mut out = Vec::with_capacity(2 * packed.len());
    let mut rest = packed.iter();
    while let Some(&control) = rest.next() {
        let control = usize::from(control);
        if control < 32 {
            let literal = rest.as_slice().get(..=control).ok_or_else(short)?;
            out.extend_from_slice(literal);
            rest = rest.as_slice()[control + 1..].iter();
            continue;
        }
        let mut next = || rest.next().map(|&byte| usize::from(byte)).ok_or_else(short);
        let mut len = control >> 5;
        if len == 7 {
            len += next()?;
        }
        let distance = ((control & 31) << 8) + next()? + 1;
        let from = out.len().checked_sub(distance).ok_or_else(|| {
            Error::DecompressionError("LZF data refer to what is before them".into())
        })?;
        // Byte by byte: the copy may overlap what it writes.
        for i in from..from + len + 2 {
            out.push(out[i]);
        }
    }
    Ok(out)
}
