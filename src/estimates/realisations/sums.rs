//! Sums over realisations, added in the order of their index: the same bits for any threads and any blocks of sites.

use std::ops::Range;

use super::ensemble::{PARTS, evenness};
use super::kept::SegmentPairs;
use super::records::Records;
use crate::numeric::lanes::{LaneBlock, WIDTH};
use crate::transform::Segments;

/// Samples, mean, and sum of the squares of the deviations of a piece of eight records.
type Piece = [LaneBlock; 3];

impl LaneBlock {
    /// Adds numbers to the first lanes.
    #[inline(always)]
    pub(crate) fn add(&mut self, values: impl IntoIterator<Item = f64>) {
        let lanes = self.0.iter_mut().zip(values);
        lanes.for_each(|(sum, value)| *sum += value);
    }
}

/// How large sums of a tile are, and what their records are like.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SumsShape {
    /// Blocks of the estimate.
    pub plain: usize,
    pub segments: Segments,
    /// Whether an offset is not what moves.
    pub about_mean: bool,
}

impl SumsShape {
    fn reached(self) -> usize {
        self.segments.record - self.segments.left_over()
    }

    fn piece_length(self) -> usize {
        (self.reached() / PARTS).max(1)
    }

    /// Pieces of a record whose energies are compared, and what they leave over.
    fn pieces(self) -> usize {
        self.reached() / self.piece_length() + 1
    }

    /// Numbers of the state over a range of segments of all records.
    pub fn numbers(self, range: &Range<usize>) -> usize {
        self.of_begun(self.begun(range).len())
    }

    fn of_begun(self, records: usize) -> usize {
        WIDTH * (self.plain + OF_RECORDS + records * 3 * self.pieces())
    }

    /// Bytes of a state, at most.
    pub fn bytes(self) -> u64 {
        8 * self.of_begun(2) as u64
    }

    /// Records of which a range of segments holds some, but not all.
    fn begun(self, range: &Range<usize>) -> Vec<usize> {
        let segments = self.segments.count();
        let mut ends = vec![range.start / segments, (range.end - 1) / segments];
        ends.dedup();
        ends.retain(|record| {
            range.start > record * segments || range.end < (record + 1) * segments
        });
        ends
    }
}

/// Sums over whole records: of the steadiness of each lane, and of the least steady one, in the first; and of what filled
/// samples leave, which is white power and the share of power that is lost.
const OF_RECORDS: usize = 4;

/// Sums of a tile of sites, and what their records are like.
#[derive(Debug, Clone)]
pub(crate) struct Sums {
    pub(super) shape: SumsShape,
    pub plain: Vec<LaneBlock>,
    /// Of each site, where segments with missing samples are left out; else empty. Parts have all segments.
    pub left: Vec<SegmentPairs>,
    of_records: [LaneBlock; OF_RECORDS],
    /// Pieces of the records that are not whole, by their number.
    begun: Vec<(usize, Vec<Piece>)>,
}

impl Sums {
    pub fn zeros(shape: SumsShape) -> Sums {
        Sums {
            shape,
            plain: vec![LaneBlock::default(); shape.plain],
            left: Vec::new(),
            of_records: Default::default(),
            begun: Vec::new(),
        }
    }

    /// Of a record of zeros, counted as steady.
    pub fn of_silence(shape: SumsShape) -> Sums {
        let mut sums = Sums::zeros(shape);
        sums.add_record([1.0; WIDTH]);
        sums
    }

    /// The steadiness of a site of the tile, summed over whole records; 1 for records of zeros.
    pub fn steadiness(&self, site: usize) -> f64 {
        self.of_records[0].0[site % WIDTH]
    }

    /// Sum over whole records of the steadiness of the least steady lane.
    pub fn least_steadiness(&self) -> f64 {
        self.of_records[1].0[0]
    }

    /// What filled samples leave at a site, over all records: white power, and the share of power that is lost.
    pub fn filled(&self, site: usize) -> [f64; 2] {
        [2, 3].map(|kind| self.of_records[kind].0[site % WIDTH])
    }

    pub(super) fn add_filled(&mut self, lane: usize, left: [f64; 2]) {
        let sums = self.of_records[2..].iter_mut().zip(left);
        sums.for_each(|(sum, left)| sum.0[lane] += left);
    }

    /// Adds the steadiness of a whole record of each lane.
    pub(super) fn add_record(&mut self, of_lanes: [f64; WIDTH]) {
        // A mark stays.
        let least = |a: f64, b: f64| if b < a || b.is_nan() { b } else { a };
        let [own, least_of, ..] = &mut self.of_records;
        own.add(of_lanes);
        least_of.0[0] += of_lanes.into_iter().fold(1.0, least);
    }

    fn pieces_of(&mut self, record: usize) -> &mut Vec<Piece> {
        let at = self.begun.iter().position(|(of, _)| *of == record);
        let at = at.unwrap_or_else(|| {
            let zeros = vec![Piece::default(); self.shape.pieces()];
            self.begun.push((record, zeros));
            self.begun.len() - 1
        });
        &mut self.begun[at].1
    }

    /// Adds samples of up to eight `records`, from the start of the first of these segments to that of the one behind them. A
    /// `mark` of NaN makes their steadiness NaN.
    pub fn add_samples(
        &mut self,
        (record, segments): (usize, Range<usize>),
        records: Records<'_>,
        mark: [f64; WIDTH],
        room: &mut Vec<f64>,
    ) {
        let (shape, Segments { hop, .. }) = (self.shape, self.shape.segments);
        let (length, last) = (shape.piece_length(), shape.pieces() - 1);
        let pieces = self.pieces_of(record);
        let before = segments.start * hop;
        for segment in segments {
            let first = segment * hop;
            let end = match segment + 1 == shape.segments.count() {
                true => shape.reached(),
                false => first + hop,
            };
            let [begin, behind] = [first, end - 1].map(|sample| (sample / length).min(last));
            for (piece, sums) in (begin..).zip(&mut pieces[begin..=behind]) {
                let from = first.max(piece * length);
                let to = match piece == last {
                    true => end,
                    false => end.min((piece + 1) * length),
                };
                let [means, squares] = records.mean_and_squares(from - before..to - before, room);
                let squares = std::array::from_fn(|lane| squares[lane] + mark[lane]);
                let count = (to - from) as f64;
                let later = [[count; WIDTH], means, squares].map(LaneBlock);
                join(sums, &later);
            }
        }
        self.close();
    }

    /// The pieces of whole records become their steadiness, about the mean of the record or about 0.
    fn close(&mut self) {
        let SumsShape { about_mean, .. } = self.shape;
        let samples = self.shape.reached() as f64;
        let count = |pieces: &[Piece]| pieces.iter().map(|piece| piece[0].0[0]).sum::<f64>();
        let is_whole = |begun: &mut (usize, Vec<Piece>)| count(&begun.1) >= samples;
        let whole: Vec<_> = self.begun.extract_if(.., is_whole).collect();
        for (_, pieces) in whole {
            let of = |lane| steadiness(&pieces, lane, about_mean);
            self.add_record(std::array::from_fn(of));
        }
    }

    /// Adds the sums over realisations that follow.
    pub fn merge(&mut self, later: Sums) {
        let sums = self.plain.iter_mut().chain(&mut self.of_records);
        let added = later.plain.iter().chain(&later.of_records);
        sums.zip(added).for_each(|(sum, added)| sum.add(added.0));
        for (record, pieces) in later.begun {
            let own = self.pieces_of(record);
            own.iter_mut().zip(&pieces).for_each(|(a, b)| join(a, b));
        }
        self.close();
    }

    fn blocks(&mut self) -> impl Iterator<Item = &mut LaneBlock> {
        let begun = self.begun.iter_mut().flat_map(|(_, pieces)| pieces);
        let whole = self.plain.iter_mut().chain(&mut self.of_records);
        whole.chain(begun.flatten())
    }

    /// The state, as numbers.
    pub fn write(&mut self, out: &mut Vec<f64>) {
        out.extend(self.blocks().flat_map(|block| block.0));
    }

    /// From the numbers of [`Self::write`], over a range of segments of all records.
    pub fn read(shape: SumsShape, range: &Range<usize>, numbers: &[f64]) -> Sums {
        let mut sums = Sums::zeros(shape);
        for record in shape.begun(range) {
            sums.pieces_of(record);
        }
        let rows = numbers.as_chunks().0.iter();
        sums.blocks().zip(rows).for_each(|(to, row)| to.0 = *row);
        sums
    }
}

/// Mean and squares of joined pieces, by the parallel-axis theorem.
fn join(piece: &mut Piece, later: &Piece) {
    let (here, there) = (piece[0].0[0], later[0].0[0]);
    if there == 0.0 {
        return;
    }
    let all = here + there;
    for lane in 0..WIDTH {
        let apart = later[1].0[lane] - piece[1].0[lane];
        piece[0].0[lane] = all;
        piece[1].0[lane] += apart * (there / all);
        piece[2].0[lane] += later[2].0[lane] + apart * apart * (here * (there / all));
    }
}

/// See [`Independence::steadiness`](super::Independence::steadiness).
fn steadiness(pieces: &[Piece], lane: usize, about_mean: bool) -> f64 {
    let of = |piece: &Piece, what: usize| piece[what].0[lane];
    let all: f64 = pieces.iter().map(|piece| of(piece, 0)).sum();
    let weighted = pieces.iter().map(|piece| of(piece, 0) * of(piece, 1));
    let mean = match about_mean && all > 0.0 {
        true => weighted.sum::<f64>() / all,
        false => 0.0,
    };
    // The last piece is what the others, which are equally long, leave over.
    let equal = &pieces[..pieces.len().saturating_sub(1)];
    let energy = |piece| of(piece, 2) + of(piece, 0) * (of(piece, 1) - mean).powi(2);
    evenness(&equal.iter().map(energy).collect::<Vec<f64>>())
}
