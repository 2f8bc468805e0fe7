//! Sums over realisations, added in the order of their index: the same bits for any threads and any blocks of sites.

use super::kept::SegmentPairs;
use crate::numeric::lanes::{LaneBlock, WIDTH};

/// Samples, mean, and sum of the squares of the deviations of a piece of eight records.
type Piece = [LaneBlock; 3];

/// How many blocks of sums a tile has: plain ones, and three for each piece of a record; no steadiness without pieces.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SumsShape {
    pub plain: usize,
    pub pieces: usize,
}

impl SumsShape {
    /// Numbers of the state over a range of realisations, which begins or ends within so many records.
    pub fn numbers(self, begun: usize) -> usize {
        WIDTH * (self.plain + 4 + begun * 3 * self.pieces)
    }

    /// Bytes of a state, at most.
    pub fn bytes(self) -> u64 {
        8 * self.numbers(2) as u64
    }
}

/// Sums of a tile of sites, and how the energy of its sites is spread over their records.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Sums {
    pub plain: Vec<LaneBlock>,
    /// Of each site, where segments with missing samples are left out; else empty. Parts have all segments.
    pub left: Vec<SegmentPairs>,
    /// Sums over whole records: of the steadiness of each lane, and of the least steady lane, in the first.
    steadiness: [LaneBlock; 2],
    /// What filled samples leave, over all records: white power, and the share of power that is lost.
    pub filled: [LaneBlock; 2],
    /// Pieces of the records that are not whole, by their number.
    begun: Vec<(usize, Vec<Piece>)>,
    /// Pieces of a record.
    pieces: usize,
}

impl Sums {
    pub fn zeros(shape: SumsShape) -> Sums {
        Sums {
            plain: vec![LaneBlock::default(); shape.plain],
            left: Vec::new(),
            steadiness: Default::default(),
            filled: Default::default(),
            begun: Vec::new(),
            pieces: shape.pieces,
        }
    }

    /// Of a record of zeros, counted as steady.
    pub fn of_silence(shape: SumsShape) -> Sums {
        Sums {
            steadiness: [LaneBlock([1.0; WIDTH]); 2],
            ..Sums::zeros(shape)
        }
    }

    /// Sums of the steadiness of whole records, of each lane; 1 for records of zeros.
    pub fn steadiness(&self) -> [f64; WIDTH] {
        self.steadiness[0].0
    }

    /// Sum over whole records of the steadiness of the least steady lane.
    pub fn least_steadiness(&self) -> f64 {
        self.steadiness[1].0[0]
    }

    fn pieces_of(&mut self, record: usize) -> &mut Vec<Piece> {
        let at = self.begun.iter().position(|(of, _)| *of == record);
        let at = at.unwrap_or_else(|| {
            let zeros = vec![Piece::default(); self.pieces];
            self.begun.push((record, zeros));
            self.begun.len() - 1
        });
        &mut self.begun[at].1
    }

    /// Adds a piece of the records: its mean and the squares of the deviations from it, in each lane.
    pub fn add_piece(
        &mut self,
        (record, piece): (usize, usize),
        count: f64,
        mean: [f64; WIDTH],
        squares: [f64; WIDTH],
    ) {
        let later = [[count; WIDTH], mean, squares].map(LaneBlock);
        join(&mut self.pieces_of(record)[piece], &later);
    }

    /// Records of so many samples are whole: their pieces become their steadiness, about the mean of the record or about 0.
    pub fn close(&mut self, samples: usize, about_mean: bool) {
        let count = |(_, pieces): &(usize, Vec<Piece>)| -> f64 {
            pieces.iter().map(|piece| piece[0].0[0]).sum()
        };
        let is_whole = |begun: &mut (usize, Vec<Piece>)| count(begun) >= samples as f64;
        let whole: Vec<_> = self.begun.extract_if(.., is_whole).collect();
        for (_, pieces) in whole {
            let of = |lane| steadiness(&pieces, lane, about_mean);
            self.add_record(std::array::from_fn(of));
        }
    }

    /// Adds the steadiness of a whole record of each lane.
    pub fn add_record(&mut self, of_lanes: [f64; WIDTH]) {
        // A mark stays.
        let least = |least: f64, one: &f64| match one.is_nan() || least.is_nan() {
            true => f64::NAN,
            false => least.min(*one),
        };
        let [own, least_of] = &mut self.steadiness;
        own.0.iter_mut().zip(of_lanes).for_each(|(a, b)| *a += b);
        least_of.0[0] += of_lanes.iter().fold(1.0, least);
    }

    /// Adds the sums over realisations that follow, of records of so many samples.
    pub fn merge(&mut self, later: Sums, samples: usize, about_mean: bool) {
        let sums = self.plain.iter_mut().chain(&mut self.steadiness);
        let added = later.plain.iter().chain(&later.steadiness);
        let lanes = sums.chain(&mut self.filled).flat_map(|sum| &mut sum.0);
        let added = added.chain(&later.filled).flat_map(|value| &value.0);
        lanes.zip(added).for_each(|(sum, value)| *sum += value);
        for (record, pieces) in later.begun {
            let own = self.pieces_of(record);
            own.iter_mut().zip(&pieces).for_each(|(a, b)| join(a, b));
        }
        self.close(samples, about_mean);
    }

    /// The state, as numbers, of which these records are begun.
    pub fn write(&mut self, begun: &[usize], out: &mut Vec<f64>) {
        out.extend_from_slice(bytemuck::cast_slice(&self.plain));
        out.extend_from_slice(bytemuck::cast_slice(&self.steadiness));
        out.extend_from_slice(bytemuck::cast_slice(&self.filled));
        for record in begun {
            let pieces = self.pieces_of(*record).iter();
            out.extend(pieces.flatten().flat_map(|block| block.0));
        }
    }

    /// From the numbers of [`Self::write`].
    pub fn read(shape: SumsShape, begun: &[usize], numbers: &[f64]) -> Sums {
        let mut sums = Sums::zeros(shape);
        let rows = numbers.as_chunks::<WIDTH>().0.iter();
        let mut blocks = rows.map(|row| LaneBlock(*row));
        let whole = sums.plain.iter_mut().chain(&mut sums.steadiness);
        let whole = whole.chain(&mut sums.filled);
        whole.zip(&mut blocks).for_each(|(to, block)| *to = block);
        for record in begun {
            let pieces = sums.pieces_of(*record).iter_mut();
            let to = pieces.flatten();
            to.zip(&mut blocks).for_each(|(to, block)| *to = block);
        }
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
    super::ensemble::evenness(&equal.iter().map(energy).collect::<Vec<f64>>())
}
