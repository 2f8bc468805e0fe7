//! Sizes of the sums of a tile, and of what is made of them.

use super::lines::{LINE_BLOCKS, Line};
use crate::estimates::Tapers;
use crate::estimates::realisations::{Grid, Realisations, SumsShape, TOGETHER};

/// Bytes of a site, and of a bin, beside the spectra.
const OF_SITE: u64 = 256;
const OF_BIN: u64 = 64;

/// Whether there is a test for lines.
pub(super) fn tests_lines(realisations: &Realisations) -> bool {
    realisations.tapers() > 1
}

/// Blocks of the sums of a tile: of each taper, and of lines.
pub(super) fn shape(realisations: &Realisations) -> SumsShape {
    let of_lines = match tests_lines(realisations) {
        true => LINE_BLOCKS,
        false => 0,
    };
    SumsShape {
        plain: realisations.bins() * (realisations.tapers() + of_lines),
        pieces: realisations.pieces(),
    }
}

/// Bytes of the result and of the averages that it is made of, with lines.
pub(super) fn result_bytes(grid: &Grid, realisations: &Realisations, tapers: &Tapers) -> u64 {
    let bins = realisations.bins() as u64;
    let sites = (grid.sites as u64).saturating_add(TOGETHER as u64 - 1);
    // Spectrum, shape, lines; spectrum, degrees, ends of two intervals, statistic.
    let (blocks, arrays) = match tests_lines(realisations) {
        true => (2 + LINE_BLOCKS as u64, 6),
        false => (2, 5),
    };
    let of_site = bins * (8 * (arrays + blocks) + bytes_of_lines(tapers)) + OF_SITE;
    of_site.saturating_mul(sites).saturating_add(OF_BIN * bins)
}

/// Bytes of the lines of a cell, if there is one in every band of the tapers: a list that grows to twice of what it
/// holds, and what it was before.
fn bytes_of_lines(tapers: &Tapers) -> u64 {
    match tapers {
        Tapers::Slepian { nw, .. } => 3 * size_of::<Line>() as u64 / (nw.ceil() as u64 + 1),
        Tapers::Window(_) => 0,
    }
}
