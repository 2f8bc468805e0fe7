//! Samples that do not lie in the file as a regular block.

use super::pieces::{Pieces, Run};
use super::property::Stamp;
use super::samples::Texts;
use super::scale::Scaling;
use crate::{Block, ByteOrder, Bytes, Decoder, Error, Result, Sample};

/// Texts of a channel that are listed; longer ones are only named.
const MOST_TEXT: u64 = 1 << 20;

/// Where the samples of a variable come from.
#[derive(Debug)]
pub(super) enum Source {
    Channels(Channels),
    /// Values of the only dimension.
    Held(Vec<f64>),
    None,
}

/// The samples of the channels of a variable.
#[derive(Debug)]
pub(super) struct Channels {
    /// For messages.
    pub path: String,
    pub channels: Vec<OneChannel>,
    pub stored: Stored,
    /// Whether time is the first of two dimensions.
    pub is_time_first: bool,
}

/// The samples of a channel.
#[derive(Debug)]
pub(super) struct OneChannel {
    pub pieces: Pieces,
    /// The type of those that are scaled.
    pub sample: Sample,
    pub scaling: Scaling,
}

/// What is stored, and what it is decoded to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stored {
    /// Numbers, as they are.
    Number(Sample),
    /// Numbers of any type, to scaled `f64`.
    Scaled,
    /// Times, to nanoseconds in `i64`.
    Time,
}

pub(super) struct TdmsDecoder {
    pub bytes: Bytes,
    pub sources: Vec<Source>,
}

impl Decoder for TdmsDecoder {
    fn read(&self, variable: usize, block: Block, out: &mut [u8]) -> Result<()> {
        match &self.sources[variable] {
            Source::Channels(channels) => channels.read((*self.bytes).as_ref(), block, out),
            Source::Held(values) => {
                let values = &values[block[0].start as usize..block[0].end as usize];
                for (one, value) in out.chunks_exact_mut(8).zip(values) {
                    one.copy_from_slice(&value.to_ne_bytes());
                }
                Ok(())
            }
            Source::None => Ok(()),
        }
    }
}

impl Stored {
    /// Bytes of a decoded sample.
    fn bytes(self) -> usize {
        match self {
            Stored::Number(sample) => sample.bytes(),
            Stored::Scaled | Stored::Time => 8,
        }
    }
}

impl Channels {
    fn read(&self, bytes: &[u8], block: Block, out: &mut [u8]) -> Result<()> {
        let (channels, times) = match block {
            [times, channels] if self.is_time_first => (channels.clone(), times.clone()),
            [channels, times] => (channels.clone(), times.clone()),
            _ => (0..1, block[0].clone()),
        };
        let size = self.stored.bytes();
        let (n_channels, n_times) = (channels.end - channels.start, times.end - times.start);
        // From one channel to the next, and from one time to the next.
        let (across, along) = match self.is_time_first {
            true => (size, size * n_channels as usize),
            false => (size * n_times as usize, size),
        };
        for (place, channel) in channels.enumerate() {
            let channel = &self.channels[channel as usize];
            let mut at = place * across;
            for run in channel.pieces.runs(times.clone()) {
                self.copy(bytes, run, channel, &mut out[at..], along)?;
                at += run.count as usize * along;
            }
        }
        Ok(())
    }

    /// Decodes a run to every `along`-th byte of `out`.
    fn copy(
        &self,
        bytes: &[u8],
        run: Run,
        channel: &OneChannel,
        out: &mut [u8],
        along: usize,
    ) -> Result<()> {
        let size = self.stored.bytes();
        let stored = match self.stored {
            Stored::Number(sample) => sample.bytes(),
            Stored::Scaled => channel.sample.bytes(),
            Stored::Time => Stamp::BYTES as usize,
        };
        let (start, step, count) = (run.start as usize, run.step as usize, run.count as usize);
        let is_native = run.order == ByteOrder::NATIVE;
        let is_copy = matches!(self.stored, Stored::Number(_)) && (is_native || size == 1);
        if is_copy && step == size && along == size {
            out[..count * size].copy_from_slice(&bytes[start..][..count * size]);
            return Ok(());
        }
        for i in 0..count {
            let from = &bytes[start + i * step..][..stored];
            let to = &mut out[i * along..][..size];
            match self.stored {
                Stored::Number(_) => {
                    to.copy_from_slice(from);
                    if !is_native {
                        to.reverse();
                    }
                }
                Stored::Scaled => {
                    let scaled = channel
                        .scaling
                        .apply(channel.sample.to_f64(run.order, from));
                    to.copy_from_slice(&scaled.to_ne_bytes());
                }
                Stored::Time => {
                    let stamp = Stamp::read(run.order, from);
                    let nanoseconds = stamp.nanoseconds().ok_or_else(|| {
                        let place = format!("variable {}", self.path);
                        let found = format!("{} s since 1904", stamp.seconds);
                        Error::damaged(place, "times from 1677 to 2262", found)
                    })?;
                    to.copy_from_slice(&nanoseconds.to_ne_bytes());
                }
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
            let to = Sample::U32.to_f64(chunk.order, end) as usize;
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
