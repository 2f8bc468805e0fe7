//! What combining parts takes of memory, before any of it is taken.

use std::ops::Range;

use super::NodePlace;
use crate::error::{Error, Result};
use crate::estimates::realisations::{
    Realisations, RecordTree, Sums, SumsShape, TreeNode, nodes_within,
};
use crate::system::memory::half_of_free_memory;

/// Bytes of the trees of a tile beside their sums.
const TREES: u64 = 1024;

/// Bytes that making a result takes, beside the sums of all realisations.
#[derive(Debug, Clone, Copy)]
pub(in crate::estimates) struct Finishing {
    /// The result, and what its size does not matter to.
    pub result: u64,
    /// Averages, as long as the sums are there.
    pub averages: u64,
    /// What is needed once they are not.
    pub later: u64,
}

/// The parts that are in memory.
#[derive(Debug, Clone, Copy)]
pub(super) enum Held {
    /// One after the other.
    OneByOne,
    /// All, of so many bytes.
    All(u64),
}

/// The places of the nodes of a part: those of the segments of records of which it has some, and of whole records.
pub(super) fn places(range: Range<usize>, segments: usize) -> Vec<NodePlace> {
    let of_record = |record: usize, leaves: Range<usize>| {
        nodes_within(leaves).map(move |(level, index)| NodePlace {
            record: Some(record),
            level,
            index,
        })
    };
    let mut places = Vec::new();
    let mut next = range.start;
    if !next.is_multiple_of(segments) {
        let record = next / segments;
        let first = record * segments;
        let end = range.end.min(first + segments);
        places.extend(of_record(record, next - first..end - first));
        next = end;
    }
    let whole = nodes_within(next / segments..range.end / segments);
    places.extend(whole.map(|(level, index)| NodePlace {
        record: None,
        level,
        index,
    }));
    let record = range.end / segments;
    if next < range.end && !range.end.is_multiple_of(segments) {
        places.extend(of_record(record, 0..range.end - record * segments));
    }
    places
}

/// Bytes of the sums of all tiles of a result.
fn bytes_of(tiles: &[(SumsShape, usize)]) -> u64 {
    let of = |(shape, count): &(SumsShape, usize)| shape.bytes().saturating_mul(*count as u64);
    tiles.iter().map(of).fold(0, u64::saturating_add)
}

/// Bytes that parts and their trees take.
#[derive(Debug, Clone, Copy)]
pub(super) struct Counted {
    /// Sums of all tiles: a node.
    node: u64,
    /// The most nodes in the trees while parts are added, and those that are left.
    most: u64,
    left: u64,
    /// The largest part.
    largest: u64,
    held: Held,
    /// Plans, and what trees are beside their sums.
    fixed: u64,
}

impl Counted {
    /// Of parts with these segments, in their order.
    pub fn new(
        ranges: impl Iterator<Item = [usize; 2]>,
        (realisations, tiles): (&Realisations, &[(SumsShape, usize)]),
        held: Held,
    ) -> Counted {
        let segments = realisations.segments.count();
        // The trees themselves, without sums.
        let mut tree = RecordTree::default();
        let (mut most, mut largest) = (0, 0);
        for [from, end] in ranges {
            let places = places(from..end, segments);
            largest = places.len().max(largest);
            for place in places {
                most = most.max(tree.count() + 1);
                let node = TreeNode {
                    record: place.record,
                    level: place.level,
                    index: place.index,
                    sums: Sums::zeros(0, 0),
                };
                tree.push(node, segments, false);
            }
        }
        let node = bytes_of(tiles);
        let count: u64 = tiles.iter().map(|(_, count)| *count as u64).sum();
        Counted {
            node,
            most: most as u64,
            left: tree.count() as u64,
            largest: node.saturating_mul(largest as u64),
            held,
            fixed: realisations
                .bytes()
                .saturating_add(TREES.saturating_mul(count)),
        }
    }

    /// That the result `what` of all parts fits in `memory`.
    ///
    /// # Errors
    /// [`Error::Memory`].
    pub fn check(
        &self,
        what: &'static str,
        finishing: Finishing,
        memory: Option<u64>,
    ) -> Result<()> {
        let Finishing {
            result,
            averages,
            later,
        } = finishing;
        let beside = self.node.saturating_add(averages).max(later);
        self.allow(what, result.saturating_add(beside), memory)
    }

    /// That one part of all of these fits in `memory`: the nodes that are left, and a copy of them.
    ///
    /// # Errors
    /// [`Error::Memory`].
    pub fn check_joined(&self, what: &'static str, memory: Option<u64>) -> Result<()> {
        self.allow(what, self.node.saturating_mul(2 * self.left), memory)
    }

    fn allow(&self, what: &'static str, afterwards: u64, memory: Option<u64>) -> Result<()> {
        let (part, all) = match self.held {
            Held::OneByOne => (self.largest, 0),
            Held::All(bytes) => (0, bytes),
        };
        let adding = self.node.saturating_mul(self.most).saturating_add(part);
        let needed = adding.max(afterwards).saturating_add(self.fixed);
        // What the caller holds is no longer free.
        let allowed = memory.unwrap_or_else(|| half_of_free_memory().saturating_add(all));
        allow(what, needed.saturating_add(all), allowed)
    }
}

/// # Errors
/// [`Error::Memory`], of `what`.
pub(super) fn allow(what: &'static str, needed: u64, allowed: u64) -> Result<()> {
    match needed > allowed {
        true => Err(Error::Memory {
            what,
            needed,
            allowed,
        }),
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The nodes of any part follow one another, and no two of them are siblings.
    #[test]
    fn regress_places_cover_a_part() {
        let segments = 11;
        for from in 0..33 {
            for end in from + 1..=33 {
                let places = places(from..end, segments);
                let mut next = from;
                for place in &places {
                    let range = place.range(segments).unwrap();
                    assert_eq!(range.start, next, "{from} {end}");
                    assert!(place.record.is_none() || range.len() < segments);
                    next = range.end;
                }
                assert_eq!(next, end, "{from} {end}");
                for pair in places.windows(2) {
                    let siblings = pair[0].record == pair[1].record
                        && pair[0].level == pair[1].level
                        && pair[0].index ^ 1 == pair[1].index;
                    assert!(!siblings, "{from} {end}");
                }
            }
        }
    }
}
