//! Sums over realisations in an order that their index alone fixes.
//!
//! The segments of a record, and the records, are the leaves of binary trees. A node of level `l` and index
//! `i` is the sum over the leaves `i 2^l` to `(i + 1) 2^l - 1`, and is made of its two halves, whatever else
//! is known. So the sum of all has the same bits however the leaves were cut into parts, blocks or threads.

use std::ops::Range;

use crate::numeric::lanes::{LaneBlock, Lanes, SimdKernel, WIDTH, widest};

/// Blocks of a piece of a record: samples, mean, and sum of the squares of the deviations.
const PIECE: usize = 3;
/// Blocks over whole records.
const OF_RECORDS: usize = 2;

/// Sums of the tiles of a result, and of how the energy of its sites is spread over their records.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sums {
    /// Plain sums; then the pieces of the record that is being summed; then two sums over whole records: of the
    /// steadiness of the least steady lane, and of each.
    blocks: Vec<LaneBlock>,
    plain: usize,
}

/// How many blocks of sums a tile has, see [`Sums::zeros`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct SumsShape {
    pub plain: usize,
    pub pieces: usize,
}

impl SumsShape {
    pub fn zeros(self) -> Sums {
        Sums::zeros(self.plain, self.pieces)
    }

    /// Numbers in all.
    pub fn numbers(self) -> usize {
        WIDTH * Sums::blocks(self.plain, self.pieces)
    }

    pub fn bytes(self) -> u64 {
        8 * self.numbers() as u64
    }

    /// Whether these numbers of sums are those over zeros.
    pub fn are_silent(self, numbers: &[f64]) -> bool {
        let (plain, others) = numbers.split_at(WIDTH * self.plain);
        let (pieces, _) = others.as_chunks::<{ WIDTH * PIECE }>();
        // The first block of a piece counts samples.
        let mut sums = plain
            .iter()
            .chain(pieces.iter().flat_map(|piece| &piece[WIDTH..]));
        sums.all(|sum| *sum == 0.0)
    }
}

impl Sums {
    /// Zeros: `plain` blocks of sums, and `pieces` pieces of records; none of both without steadiness.
    pub fn zeros(plain: usize, pieces: usize) -> Sums {
        Sums {
            blocks: vec![LaneBlock::default(); Self::blocks(plain, pieces)],
            plain,
        }
    }

    /// Blocks in all.
    pub fn blocks(plain: usize, pieces: usize) -> usize {
        plain
            + if pieces > 0 {
                PIECE * pieces + OF_RECORDS
            } else {
                0
            }
    }

    /// From the numbers of [`Self::numbers`].
    pub fn set(&mut self, numbers: &[f64]) {
        let (rows, _) = numbers.as_chunks::<WIDTH>();
        for (block, row) in self.blocks.iter_mut().zip(rows) {
            block.0 = *row;
        }
    }

    pub fn numbers(&self) -> &[f64] {
        bytemuck::cast_slice(&self.blocks)
    }

    pub fn plain(&self) -> &[LaneBlock] {
        &self.blocks[..self.plain]
    }

    pub fn plain_mut(&mut self) -> &mut [LaneBlock] {
        &mut self.blocks[..self.plain]
    }

    pub fn into_plain(mut self) -> Vec<LaneBlock> {
        self.blocks.truncate(self.plain);
        self.blocks
    }

    fn pieces_mut(&mut self) -> &mut [[LaneBlock; PIECE]] {
        self.blocks[self.plain..].as_chunks_mut().0
    }

    /// Adds a piece of the records: its mean and the squares of the deviations from it, in each lane.
    pub fn add_piece(
        &mut self,
        piece: usize,
        count: f64,
        mean: [f64; WIDTH],
        squares: [f64; WIDTH],
    ) {
        let later = [[count; WIDTH], mean, squares].map(LaneBlock);
        add_pieces(&mut self.pieces_mut()[piece..=piece], &[later]);
    }

    /// Adds what follows in the index.
    fn add(&mut self, later: &Sums) {
        let plain = self.plain;
        widest(AddBlocks {
            sums: &mut self.blocks[..plain],
            values: later.plain(),
        });
        let Some((pieces, of_records)) = later.blocks[plain..].split_last_chunk::<OF_RECORDS>()
        else {
            return;
        };
        add_pieces(self.pieces_mut(), pieces.as_chunks().0);
        let first = self.blocks.len() - OF_RECORDS;
        widest(AddBlocks {
            sums: &mut self.blocks[first..],
            values: of_records,
        });
    }

    /// A record is complete: its pieces become its steadiness, about the mean of the record or about 0.
    fn complete(&mut self, about_mean: bool) {
        let plain = self.plain;
        let blocks = &mut self.blocks[plain..];
        let Some((pieces, [least, steadiness])) = blocks.split_last_chunk_mut::<OF_RECORDS>()
        else {
            return;
        };
        let mut of_lanes = [1.0; WIDTH];
        let pieces: &mut [[LaneBlock; PIECE]] = pieces.as_chunks_mut().0;
        for (lane, own) in of_lanes.iter_mut().enumerate() {
            let of = |piece: &[LaneBlock; PIECE], what: usize| piece[what].0[lane];
            let all: f64 = pieces.iter().map(|piece| of(piece, 0)).sum();
            let weighted = pieces.iter().map(|piece| of(piece, 0) * of(piece, 1));
            let mean = if about_mean && all > 0.0 {
                weighted.sum::<f64>() / all
            } else {
                0.0
            };
            // The last piece is what the others, which are equally long, leave over.
            let equal = &pieces[..pieces.len().saturating_sub(1)];
            let energies = equal
                .iter()
                .map(|piece| of(piece, 2) + of(piece, 0) * (of(piece, 1) - mean).powi(2));
            let (mut sum, mut squares) = (0.0, 0.0);
            for energy in energies {
                sum += energy;
                squares += energy * energy;
            }
            if squares > 0.0 || squares.is_nan() {
                *own = sum * sum / (equal.len() as f64 * squares);
            }
            steadiness.0[lane] += *own;
        }
        least.0[0] += of_lanes
            .iter()
            .fold(1.0, |least: f64, one| match one.is_nan() {
                true => *one,
                // A mark stays.
                false if least.is_nan() => least,
                false => least.min(*one),
            });
        pieces.fill([LaneBlock::default(); PIECE]);
    }

    /// Zeros as the sums of so many whole records of zeros.
    pub fn of_silence(mut self, records: usize) -> Sums {
        (0..records).for_each(|_| self.complete(true));
        self
    }

    /// Sums of the steadiness of whole records, of each lane; 1 for records of zeros.
    pub fn steadiness(&self) -> [f64; WIDTH] {
        self.blocks.last().map_or([0.0; WIDTH], |block| block.0)
    }

    /// Sum over whole records of the steadiness of the least steady lane.
    pub fn least_steadiness(&self) -> f64 {
        let blocks = self.blocks[self.plain..].last_chunk::<OF_RECORDS>();
        blocks.map_or(0.0, |[least, _]| least.0[0])
    }

    /// Multiplies the samples by a power of two; plain sums are those of their squares.
    pub fn rescale(&mut self, factor: f64) {
        let squared = factor * factor;
        let scale = |block: &mut LaneBlock, by: f64| block.0.iter_mut().for_each(|v| *v *= by);
        self.plain_mut()
            .iter_mut()
            .for_each(|block| scale(block, squared));
        for [_, mean, squares] in self.pieces_mut() {
            scale(mean, factor);
            scale(squares, squared);
        }
    }

    /// All but the plain sums.
    fn clear_pieces(&mut self) {
        self.blocks[self.plain..].fill(LaneBlock::default());
    }
}

/// Adds numbers to others.
struct AddBlocks<'a> {
    sums: &'a mut [LaneBlock],
    values: &'a [LaneBlock],
}

impl SimdKernel for AddBlocks<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for (sum, value) in self.sums.iter_mut().zip(self.values) {
            (L::load(sum) + L::load(value)).store(sum);
        }
    }
}

/// Means and squares of joined pieces, by the parallel-axis theorem.
fn add_pieces(pieces: &mut [[LaneBlock; PIECE]], later: &[[LaneBlock; PIECE]]) {
    for (piece, later) in pieces.iter_mut().zip(later) {
        let (here, there) = (piece[0].0[0], later[0].0[0]);
        if there == 0.0 {
            continue;
        }
        if here == 0.0 {
            *piece = *later;
            continue;
        }
        let all = here + there;
        for lane in 0..WIDTH {
            let apart = later[1].0[lane] - piece[1].0[lane];
            piece[0].0[lane] = all;
            piece[1].0[lane] += apart * (there / all);
            piece[2].0[lane] += later[2].0[lane] + apart * apart * (here * (there / all));
        }
    }
}

/// A node of a tree.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TreeNode {
    /// The record whose segments are the leaves; `None` where records are.
    pub record: Option<usize>,
    pub level: u32,
    pub index: usize,
    pub sums: Sums,
}

/// Complete nodes of a contiguous range of leaves, at most two of a level.
#[derive(Debug, Default)]
struct Tree {
    nodes: Vec<(u32, usize, Sums)>,
    /// Sums that are no longer used.
    free: Vec<Sums>,
}

impl Tree {
    /// The leaf `at`, which follows the last one: empty, or its sibling's sums to add it to, if it `is_one`
    /// number in each cell. (A sum of several has other bits if they are added one by one.) If it is empty, which is
    /// also returned, the plain sums hold anything.
    fn open(&mut self, at: usize, is_one: bool, zeros: impl FnOnce() -> Sums) -> (&mut Sums, bool) {
        let is_sibling = match self.nodes.last() {
            Some((0, before, _)) => is_one && before % 2 == 0 && before + 1 == at,
            _ => false,
        };
        if !is_sibling {
            let mut sums = self.free.pop().unwrap_or_else(zeros);
            sums.clear_pieces();
            self.nodes.push((0, at, sums));
        }
        let last = self.nodes.len() - 1;
        let (level, index, sums) = &mut self.nodes[last];
        if is_sibling {
            (*level, *index) = (1, at / 2);
        }
        (sums, !is_sibling)
    }

    /// Adds a node, which follows the last one.
    fn push(&mut self, level: u32, index: usize, sums: Sums) {
        self.nodes.push((level, index, sums));
        self.join();
    }

    /// Joins siblings.
    fn join(&mut self) {
        while let [.., before, last] = &mut self.nodes[..] {
            if before.0 != last.0 || before.1 % 2 != 0 || before.1 + 1 != last.1 {
                return;
            }
            before.2.add(&last.2);
            (before.0, before.1) = (before.0 + 1, before.1 / 2);
            self.free.extend(self.nodes.pop().map(|(_, _, sums)| sums));
        }
    }

    /// The sum of all; the tree is empty then.
    fn total(&mut self) -> Option<Sums> {
        let (_, _, mut total) = self.nodes.pop()?;
        while let Some((_, _, mut before)) = self.nodes.pop() {
            before.add(&total);
            self.free.push(total);
            total = before;
        }
        Some(total)
    }
}

/// Level and index of the complete nodes of a range of leaves, in order.
pub(crate) fn nodes_within(leaves: Range<usize>) -> impl Iterator<Item = (u32, usize)> {
    let mut at = leaves.start;
    std::iter::from_fn(move || {
        let level = at
            .trailing_zeros()
            .min(leaves.end.checked_sub(at)?.checked_ilog2()?);
        let index = at >> level;
        at += 1 << level;
        Some((level, index))
    })
}

/// The largest number of sums that a tree over so many leaves holds at once.
pub(crate) fn held_at_once(leaves: usize) -> u64 {
    match leaves {
        0 | 1 => 1,
        _ => u64::from(leaves.ilog2()) + 2,
    }
}

/// The sums of one tile over the segments of one record.
#[derive(Debug, Default)]
pub(crate) struct SegmentTree(Tree);

impl SegmentTree {
    /// The sums to add a segment to, which `is_one` number in each cell or several; [`Self::close`] follows.
    pub fn open(
        &mut self,
        segment: usize,
        is_one: bool,
        zeros: impl FnOnce() -> Sums,
    ) -> &mut Sums {
        let (sums, is_empty) = self.0.open(segment, is_one, zeros);
        if is_empty {
            sums.plain_mut().fill(LaneBlock::default());
        }
        sums
    }

    /// The same; where it returns true, the plain sums hold anything and are to be written, not added to.
    pub fn open_unwritten(
        &mut self,
        segment: usize,
        is_one: bool,
        zeros: impl FnOnce() -> Sums,
    ) -> (&mut Sums, bool) {
        self.0.open(segment, is_one, zeros)
    }

    pub fn close(&mut self) {
        self.0.join();
    }

    /// Adds a node whose leaves are known, which follows the last one.
    pub fn push(&mut self, level: u32, index: usize, sums: Sums) {
        self.0.push(level, index, sums);
    }

    /// The sums of the segment that was opened last.
    pub fn current(&mut self) -> Option<&mut Sums> {
        self.0.nodes.last_mut().map(|(_, _, sums)| sums)
    }
}

/// The sums of one tile over segments and records.
#[derive(Debug, Default)]
pub(crate) struct RecordTree {
    records: Tree,
    /// Of records that are not whole, in order.
    loose: Vec<TreeNode>,
    /// The record that is being combined, and its segments.
    open: (usize, SegmentTree),
}

impl RecordTree {
    /// Takes the sums of a record, of all its segments or of a range.
    pub fn take(
        &mut self,
        segments: &mut SegmentTree,
        record: usize,
        is_whole: bool,
        about_mean: bool,
    ) {
        if is_whole && let Some(mut total) = segments.0.total() {
            total.complete(about_mean);
            self.records.push(0, record, total);
            segments.0.free.append(&mut self.records.free);
            return;
        }
        let nodes = segments.0.nodes.drain(..);
        self.loose
            .extend(nodes.map(|(level, index, sums)| TreeNode {
                record: Some(record),
                level,
                index,
                sums,
            }));
    }

    /// All nodes.
    pub fn into_nodes(mut self) -> Vec<TreeNode> {
        let (record, mut segments) = std::mem::take(&mut self.open);
        self.take(&mut segments, record, false, false);
        let whole = self.records.nodes.into_iter();
        let whole = whole.map(|(level, index, sums)| TreeNode {
            record: None,
            level,
            index,
            sums,
        });
        self.loose.into_iter().chain(whole).collect()
    }

    /// Adds a node of a partial result, in order of the realisations.
    pub fn push(&mut self, node: TreeNode, segments: usize, about_mean: bool) {
        let end = (node.index + 1) << node.level;
        match node.record {
            None => self.records.push(node.level, node.index, node.sums),
            Some(record) => {
                let (_, mut tree) = std::mem::take(&mut self.open);
                tree.0.push(node.level, node.index, node.sums);
                if end == segments {
                    let is_whole = matches!(tree.0.nodes.first(), Some((_, 0, _)));
                    self.take(&mut tree, record, is_whole, about_mean);
                }
                tree.0.free.clear();
                self.open = (record, tree);
            }
        }
        self.records.free.clear();
    }

    /// All sums.
    pub fn sums_mut(&mut self) -> impl Iterator<Item = &mut Sums> {
        let of_segments = self.open.1.0.nodes.iter_mut();
        let nodes = self.records.nodes.iter_mut().chain(of_segments);
        let loose = self.loose.iter_mut().map(|node| &mut node.sums);
        nodes.map(|(_, _, sums)| sums).chain(loose)
    }

    /// Nodes that are held.
    pub fn count(&self) -> usize {
        self.records.nodes.len() + self.loose.len() + self.open.1.0.nodes.len()
    }

    /// Of the sums of all records.
    pub fn of_total(total: Sums) -> RecordTree {
        let mut tree = RecordTree::default();
        tree.records.push(0, 0, total);
        tree
    }

    /// The sum of all records.
    pub fn total(&mut self) -> Option<Sums> {
        self.records.total()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn leaf(at: usize) -> Sums {
        let mut sums = Sums::zeros(1, 3);
        let value = 0.1 + (at as f64 * 0.7).sin();
        sums.plain_mut()[0] = LaneBlock([value; WIDTH]);
        sums.add_piece(at / 5 % 2, 3.0, [value; WIDTH], [value * value; WIDTH]);
        sums
    }

    /// Ranges of three records of eleven segments, cut anywhere.
    #[test]
    fn regress_cuts_do_not_move_a_bit() {
        const SEGMENTS: usize = 11;
        let part = |range: std::ops::Range<usize>| {
            let mut tree = RecordTree::default();
            let mut segments = SegmentTree::default();
            let mut at = range.start;
            while at < range.end {
                let record = at / SEGMENTS;
                let from = at;
                let end = range.end.min((record + 1) * SEGMENTS);
                for one in from..end {
                    let value = leaf(one);
                    let sums = segments.open(one % SEGMENTS, true, || Sums::zeros(1, 3));
                    sums.add(&value);
                    segments.close();
                }
                tree.take(&mut segments, record, end - from == SEGMENTS, true);
                at = end;
            }
            tree
        };
        let whole = part(0..33).total().unwrap();
        assert!(whole.steadiness()[0] > 1.0);
        for cuts in [vec![5], vec![11], vec![1, 2, 3, 30], vec![7, 12, 23, 32]] {
            let ends = cuts.iter().copied().chain([33]);
            let starts = [0].into_iter().chain(cuts.iter().copied());
            let mut joined = RecordTree::default();
            for (start, end) in starts.zip(ends) {
                let mut nodes = part(start..end).into_nodes();
                let first = |node: &TreeNode| match node.record {
                    Some(record) => record * SEGMENTS + (node.index << node.level),
                    None => (node.index << node.level) * SEGMENTS,
                };
                nodes.sort_by_key(first);
                for node in nodes {
                    joined.push(node, SEGMENTS, true);
                }
            }
            assert_eq!(joined.total().unwrap(), whole, "{cuts:?}");
        }
    }
}
