//! Times and texts.

use super::property::Stamp;
use super::samples::Texts;
use crate::container::{Block, Decoder};
use crate::rows::Pieces;
use crate::{Bytes, Error, Result};

/// Texts of a channel that are listed; longer ones are only named.
const MOST_TEXT: u64 = 1 << 20;

/// The times of a channel, read as nanoseconds since 1970.
pub(super) struct Times {
    pub path: String,
    pub file: Bytes,
    pub pieces: Pieces,
}

impl Decoder for Times {
    fn read(&self, block: Block, out: &mut [u8]) -> Result<()> {
        let bytes = (*self.file).as_ref();
        let mut out = out.chunks_exact_mut(8);
        for run in self.pieces.runs(block[0].clone()) {
            for (i, out) in (0..run.count).zip(&mut out) {
                let from = (run.start + i * run.step) as usize;
                let stamp = Stamp::read(run.order, &bytes[from..]);
                let nanoseconds = stamp.nanoseconds().ok_or_else(|| {
                    let place = format!("variable {}", self.path);
                    let found = format!("{} s since 1904", stamp.seconds);
                    Error::damaged(place, "times from 1677 to 2262", found)
                })?;
                out.copy_from_slice(&nanoseconds.to_ne_bytes());
            }
        }
        Ok(())
    }
}

/// The texts of a channel; none if they are long.
pub(super) fn texts(bytes: &[u8], chunks: &[Texts]) -> Result<Option<Vec<String>>> {
    if chunks.iter().map(|chunk| chunk.bytes).sum::<u64>() > MOST_TEXT {
        return Ok(None);
    }
    let mut texts = Vec::new();
    for chunk in chunks {
        let all = &bytes[chunk.start as usize..][..chunk.bytes as usize];
        let (ends, characters) = all.split_at(4 * chunk.count as usize);
        let mut from = 0;
        for end in ends.chunks_exact(4) {
            let to = chunk.order.unsigned(end) as usize;
            let Some(text) = characters.get(from..to) else {
                let expected = format!("texts of {} bytes", characters.len());
                let place = format!("the texts at byte {}", chunk.start);
                return Err(Error::damaged(place, expected, format!("{from} to {to}")));
            };
            texts.push(String::from_utf8_lossy(text).into_owned());
            from = to;
        }
    }
    Ok(Some(texts))
}
