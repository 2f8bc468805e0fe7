//! Steim-1 and Steim-2: differences of integers in frames of 16 words.

use crate::ByteOrder;

/// Bytes of a frame.
pub(super) const FRAME: usize = 64;

/// How differences are packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Steim {
    One,
    Two,
}

impl Steim {
    /// Most differences in one of the 15 words of a frame.
    pub(super) fn most_in_word(self) -> usize {
        match self {
            Steim::One => 4,
            Steim::Two => 7,
        }
    }
}

/// The `count` integers in `frames`, or what is wrong with them: expected and found.
pub(super) fn decode(
    steim: Steim,
    order: ByteOrder,
    frames: &[u8],
    count: usize,
) -> Result<Vec<i32>, (String, String)> {
    let mut samples = Vec::new();
    if samples.try_reserve_exact(count).is_err() {
        return Err(("fewer samples".into(), count.to_string()));
    }
    let mut ends = [0; 2];
    for (place, frame) in frames.chunks_exact(FRAME).enumerate() {
        if samples.len() == count {
            break;
        }
        let codes = word(order, frame).cast_unsigned();
        let words = frame.chunks_exact(4).enumerate().skip(1);
        for (i, bytes) in words {
            let code = (codes >> (30 - 2 * i)) & 3;
            if place == 0 && i <= 2 {
                ends[i - 1] = word(order, bytes);
                continue;
            }
            let room = count - samples.len();
            let add = |difference| samples.push(difference);
            unpack(steim, order, code, bytes)?.take(room).for_each(add);
        }
    }
    if samples.len() < count {
        return Err((format!("{count} samples"), samples.len().to_string()));
    }
    // The first difference is to a record that may be missing.
    let [mut sample, last] = ends;
    for (i, difference) in samples.iter_mut().enumerate() {
        if i > 0 {
            sample = sample.wrapping_add(*difference);
        }
        *difference = sample;
    }
    if count > 0 && sample != last {
        return Err((format!("the last sample {last}"), sample.to_string()));
    }
    Ok(samples)
}

/// The differences in a word, as its code says.
fn unpack(
    steim: Steim,
    order: ByteOrder,
    code: u32,
    bytes: &[u8],
) -> Result<impl Iterator<Item = i32>, (String, String)> {
    let all = word(order, bytes);
    let bits = all.cast_unsigned() >> 30;
    let (count, width) = match (steim, code) {
        (_, 0) => (0, 32),
        (_, 1) => (4, 8),
        (Steim::One, 2) => (2, 16),
        (Steim::One, _) => (1, 32),
        (Steim::Two, 2) if bits == 1 => (1, 30),
        (Steim::Two, 2) if bits == 2 => (2, 15),
        (Steim::Two, 2) if bits == 3 => (3, 10),
        (Steim::Two, 3) if bits == 0 => (5, 6),
        (Steim::Two, 3) if bits == 1 => (6, 5),
        (Steim::Two, 3) if bits == 2 => (7, 4),
        _ => {
            let found = format!("{code} and {bits}");
            return Err(("a code of differences".into(), found));
        }
    };
    // Bytes and halves come in the order of the file, fields of bits in that of the number.
    let in_file = match order {
        _ if width == 8 => word(ByteOrder::Big, bytes),
        ByteOrder::Big => all,
        ByteOrder::Little if width == 16 => all.rotate_left(16),
        ByteOrder::Little => all,
    };
    let difference = move |i: u32| (in_file << (32 - width * (count - i))) >> (32 - width);
    Ok((0..count).map(difference))
}

fn word(order: ByteOrder, bytes: &[u8]) -> i32 {
    order.unsigned(&bytes[..4]) as u32 as i32
}
