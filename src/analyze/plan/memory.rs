//! Blocks that fit the memory allowed.

use super::{Blocks, Plan};
use crate::analyze::arrays::keep;
use crate::analyze::intermediate::scratch_bytes;
use crate::analyze::short_time::TOGETHER;
use crate::error::{Error, Result};
use crate::numeric::lanes::WIDTH;
use crate::prepare::piece_bytes;
use crate::transform::{ComplexTransform, RecordTransform, Segments};

/// Bytes of a block of profiles or frequencies, a thread: it is written while it is in the cache,
/// and its memory is used again. Blocks of sites are as large as they can be, since the field is
/// read once for each.
const BLOCK_BYTES: u64 = 2 << 20;

/// Bytes that are read at once from a scratch file, in one piece of each stripe.
const SCRATCH_BYTES: u64 = 128 << 20;

/// Times of the smallest block: the flux surrogate differentiates over three neighbours.
const LEAST_TIMES: usize = 4;

/// Fine maps take at most one part in so many of the memory allowed.
const FINE_SHARE: u64 = 16;

/// Bytes of the answer for a sample of a record that a thread looks at, for a site, and for a bin of a site that is compared.
const ANSWER_SAMPLE: u64 = 200;
const ANSWER_SITE: u64 = 500;
const ANSWER_BIN: u64 = 8 * 14;
/// Its spectra take at most one part in so many of the memory allowed, beside what the allocator keeps of the passes.
const ANSWER_SHARE: u64 = 16;
/// Bins that are kept apart in spectra of windows.
const FINE_BINS: u64 = 512;

/// Bytes a bin of eight spectra that are measured, sums of leaves included.
const MEASURED: u64 = 64 + 16;

impl Plan {
    /// Short-time spectra are held, and once more while they are written; threads make them record by
    /// record.
    fn short_time_bytes(&self) -> u64 {
        if !self.request.results.short_time {
            return 0;
        }
        let asked = &self.request.short_time;
        let sites = match asked.sites.len() {
            0 => self.axes.n_sites.min(3),
            count => count,
        };
        let of = |segments: Segments, count: usize| {
            let (samples, bins) = (segments.length as u64, segments.length as u64 / 2 + 1);
            let held = 16 * bins * segments.count() as u64 * count as u64;
            // A record, and for each of the frames transformed together the scratch of a record.
            let frames = TOGETHER as u64 * (8 * samples + 64 * bins);
            held + self.threads.min(count) as u64 * (8 * segments.record as u64 + frames)
        };
        let [time, space] = self.short_time;
        of(time, sites) + of(space, asked.times.len())
    }

    fn map_bytes(&self) -> u64 {
        let bytes = |(array, shape)| keep(array).bytes(shape, self.map_limit(array, shape));
        self.mapped().map(bytes).sum()
    }

    /// Chooses tiles and blocks, whether the field streams through, and whether the intermediate
    /// matrix of the space-time transform is held in memory. The survey of the samples takes
    /// `surveyed` bytes per thread.
    pub(super) fn fit_into_memory(&mut self, surveyed: u64, time_major: bool) -> Result<()> {
        let [nt, nx, ..] = self.counts();
        let (allowed, spacetime) = (self.memory_allowed, self.request.results.spacetime);
        let results = self.vectors(surveyed) + self.short_time_bytes();
        // Mapped pages of the field count as memory, so a large field is read piece by piece.
        let mapped = 8 * nt * nx;
        let piece = (piece_bytes(self.threads) as u64).max(8 * nx);
        let pieces = mapped.min(self.threads as u64 * piece);
        let blocks = pieces + self.smallest_blocks();
        // Fine maps where they take little of what there is.
        self.has_fine_maps = true;
        let fine = self.map_bytes();
        self.has_fine_maps = fine <= allowed / FINE_SHARE && results + fine + blocks <= allowed;
        let vectors = results + self.map_bytes();
        // What moved is found once the passes have let go of theirs.
        let least = vectors + blocks.max(pieces + self.answer(1, 0) + self.per_site(true));
        Error::beyond_memory("the smallest block of this field", least, allowed)?;
        let mut free = allowed - least;
        let intermediate = self.between_rows() as u64 * self.between_row_bytes();
        let in_memory = !spacetime || intermediate <= free.min(allowed / 2);
        let held = u64::from(spacetime && in_memory) * intermediate;
        free -= held;
        let streams =
            mapped > free.min(allowed / 4) || vectors + mapped + self.answer(1, 0) > allowed;

        let fixed = vectors + held + if streams { pieces } else { mapped };
        let spare = allowed - fixed;
        let across = streams && !time_major;
        let [columns, rows] = self.fit_tiles(in_memory, across, spare);
        let tiles = columns.max(rows);
        let [records, snapshots] = self.fit_blocks(streams, across, in_memory, spare - tiles);
        let both = columns + rows + records + snapshots;
        self.interleaved = !streams && in_memory && fixed + both <= allowed;
        self.memory_needed = match self.interleaved {
            true => fixed + both,
            false => fixed + tiles + records.max(snapshots),
        };
        let base = vectors
            + match streams {
                true => pieces + nt * 8 * self.blocks.sites as u64,
                false => mapped,
            };
        let fits = |tile| base + self.answer(tile as u64, 0) <= allowed;
        self.tiles.sites = halved_until(self.tiles.sites, fits);
        let tile = self.tiles.sites as u64;
        let left = allowed.saturating_sub(base + self.answer(tile, 0));
        self.answer_bytes = left.min(allowed / ANSWER_SHARE);
        if self.request.results.answer {
            let answer = self.answer(tile, self.answer_bytes);
            self.memory_needed = self.memory_needed.max((base + answer).min(allowed));
        }
        self.tiles.ahead = streams.then_some(self.blocks.sites);
        let shape = (self.between_rows(), self.axes.n_sites);
        let scratch = scratch_bytes(shape, self.tiles.sites, self.complex_bytes());
        self.scratch_file = u64::from(!in_memory) * scratch;
        Ok(())
    }

    /// Halves the tiles until each takes at most half of the `spare` bytes. Snapshots that are read
    /// `across` the records of a file, piece by piece, take a third of it. Returns the bytes of tiles of
    /// records and of snapshots.
    fn fit_tiles(&mut self, in_memory: bool, across: bool, spare: u64) -> [u64; 2] {
        let columns = |sites: usize| self.column_tile(sites as u64, in_memory);
        let rows = |times: usize| self.row_tile(times as u64, in_memory);
        let sites = halved_until(self.tiles.sites, |sites| columns(sites) <= spare / 2);
        let mut times = halved_until(self.tiles.times, |times| rows(times) <= spare / 2);
        while across && times < self.axes.n_times && rows(2 * times) <= spare / 3 {
            times *= 2;
        }
        let bytes = [columns(sites), rows(times)];
        (self.tiles.sites, self.tiles.times) = (sites, times);
        bytes
    }

    /// Chooses the blocks that `spare` bytes hold. Returns the bytes of blocks of records (or of
    /// frequencies) and of snapshots.
    fn fit_blocks(&mut self, streams: bool, across: bool, in_memory: bool, spare: u64) -> [u64; 2] {
        let (per_site, per_time) = (self.per_site(streams), self.per_time());
        let per_frequency = self.per_frequency();
        let [nt, nx, nf, ..] = self.counts().map(|n| n as usize);
        let block = |bytes: u64, per: u64, tile: usize, least: usize, all: usize| -> usize {
            let fit = usize::try_from(bytes / per.max(1)).unwrap_or(usize::MAX);
            match fit >= all {
                true => all,
                false => (fit / tile * tile).max(least),
            }
        };
        // In the cache if there is room, at least a tile if that fits at all.
        let cached = |per: u64, tile: usize, least: usize, all: usize| -> usize {
            let bytes = (BLOCK_BYTES * self.threads as u64).max(per * tile.max(4) as u64);
            block(bytes.min(spare), per, tile, least, all)
        };
        let sites = block(spare, per_site, self.tiles.sites, 1, nx);
        // Every pass over the field takes the same number of sites.
        let each = nx.div_ceil(nx.div_ceil(sites));
        let together = ComplexTransform::<f64>::TOGETHER;
        let least_times = nt.min(LEAST_TIMES);
        let times = match across {
            true => block(spare, per_time, WIDTH, least_times, nt),
            false => cached(per_time, self.tiles.times, least_times, nt),
        };
        let mut blocks = Blocks {
            sites: sites.min(each.next_multiple_of(self.tiles.sites)),
            times,
            frequencies: cached(per_frequency, together, 1, nf),
            scratch: 0,
        };
        // No tile is wider than its block: stripes of a scratch file are tiles.
        self.tiles.sites = self.tiles.sites.min(blocks.sites);
        let mut from_records =
            u64::from(self.request.results.spacetime) * blocks.frequencies as u64 * per_frequency;
        if !in_memory {
            // Whole blocks, which are read together.
            let rows = blocks.frequencies * self.segments.count();
            let block = rows as u64 * self.between_row_bytes();
            let more = SCRATCH_BYTES.min(spare).saturating_sub(from_records) / block;
            let more = more.min(nf.div_ceil(blocks.frequencies) as u64 - 1);
            blocks.scratch = blocks.frequencies * (1 + more as usize);
            from_records += more * block;
        }
        self.blocks = blocks;
        let records = from_records.max(blocks.sites as u64 * per_site);
        [records, blocks.times as u64 * per_time]
    }
}

/// Half of a tile, or half of that, until it `fits`, if it ever does.
fn halved_until(mut tile: usize, fits: impl Fn(usize) -> bool) -> usize {
    while tile > 1 && !fits(tile) {
        tile = tile.div_ceil(2);
    }
    tile
}

/// What tiles and blocks need, in bytes.
impl Plan {
    /// Times, sites, frequencies, and wavenumbers of one sign and of both.
    fn counts(&self) -> [u64; 5] {
        let axes = &self.axes;
        let bins = [&axes.frequency, &axes.wavenumber, &axes.wavenumber_signed];
        let [nf, nk, nks] = bins.map(Vec::len);
        [axes.n_times, axes.n_sites, nf, nk, nks].map(|n| n as u64)
    }

    /// A row of the intermediate matrix.
    fn between_row_bytes(&self) -> u64 {
        self.axes.n_sites as u64 * self.complex_bytes()
    }

    /// Number of threads with a tile of `each` of `all` items.
    fn at_work(&self, all: u64, each: u64) -> u64 {
        (self.threads as u64).min(all.div_ceil(each))
    }

    /// Vectors as long as an axis, of the result and of each thread.
    fn vectors(&self, surveyed: u64) -> u64 {
        let [nt, nx, nf, _, nks] = self.counts();
        let result = 160 * (nt + nx) + 40 * (nf + nks) + (4 << 20);
        result + self.threads as u64 * (160 * nx + surveyed)
    }

    /// Tiles of records, one a thread: as read and as transformed, their transforms, scratch, and
    /// powers of eight sites, even if there are fewer.
    fn column_tile(&self, sites: u64, in_memory: bool) -> u64 {
        let [nt, nx, nf, ..] = self.counts();
        let (segments, padded) = (self.segments, self.conventions.padded_time);
        // Windows at the front may be longer than segments.
        let longest = match self.request.results.temporal {
            true => nt as usize,
            false => segments.length,
        };
        let scratch = (longest, padded.max(longest), sites as usize);
        let scratch = RecordTransform::<f64>::working_bytes(scratch.0, scratch.1, scratch.2);
        // Transforms of all segments are held until they are written to a scratch file.
        let further = segments.count() as u64 - 1;
        let waiting = u64::from(!in_memory) * self.complex_bytes() * nf * further;
        let welch = self.request.welch.map_or(0, |welch| welch.segment as u64);
        let tile = sites * (8 * (nt + 2 * welch) + waiting) + scratch + MEASURED * nf;
        self.at_work(nx, sites) * tile
    }

    /// Tiles of snapshots and of frequencies, one a thread.
    fn row_tile(&self, times: u64, in_memory: bool) -> u64 {
        let [nt, nx, nf, nk, nks] = self.counts();
        let (sites, padded) = (self.axes.n_sites, self.conventions.padded_space);
        // A small block is divided among all threads, eight snapshots each.
        let at_once = times.min(WIDTH as u64);
        let scratch = RecordTransform::<f64>::working_bytes(sites, padded, WIDTH);
        let snapshots = self.at_work(nt, times) * times * 8 * (nx + nks)
            + self.at_work(nt, at_once) * (MEASURED * nk + scratch);
        if !self.request.results.spacetime {
            return snapshots;
        }
        let together = ComplexTransform::<f64>::TOGETHER as u64;
        // Rows are gathered from the stripes of a scratch file.
        let gathered = u64::from(!in_memory) * together * self.between_row_bytes();
        let scratch = ComplexTransform::<f64>::working_bytes(sites, padded);
        snapshots + self.at_work(nf, together) * (gathered + scratch)
    }

    /// Of a block of records. Spectra along time are written by the pass that has them in rows, where
    /// there is one.
    fn per_site(&self, streams: bool) -> u64 {
        let [nt, _, nf, ..] = self.counts();
        let is_written = !self.request.results.spacetime;
        8 * (u64::from(is_written) * nf + u64::from(streams) * nt)
    }

    /// Of blocks of snapshots: one is computed while another is written.
    fn per_time(&self) -> u64 {
        let [_, nx, _, nk, _] = self.counts();
        8 * (2 * nx + 4 * nk)
    }

    /// Of blocks of frequencies: one is computed while another is written.
    fn per_frequency(&self) -> u64 {
        let [_, nx, .., nks] = self.counts();
        16 * (nks + nx) + self.segments.count() as u64 * self.between_row_bytes()
    }

    /// Of the answer: tiles of records and the scratch of one a thread, what is known of each site, and the spectra of windows
    /// at some sites, in `spectra` bytes or those of the fewest sites. 0 where it is not wanted.
    fn answer(&self, tile: u64, spectra: u64) -> u64 {
        let [nt, nx, ..] = self.counts();
        let records = self.at_work(nx, tile) * (8 * tile + ANSWER_SAMPLE) * nt;
        let of = |sites: u64| nx.min(sites) * ANSWER_BIN * nt.min(2 * FINE_BINS);
        let all = records + ANSWER_SITE * nx + of(320).min(spectra.max(of(32)));
        u64::from(self.request.results.answer) * all
    }

    /// One record and a few snapshots, in tiles and blocks.
    fn smallest_blocks(&self) -> u64 {
        let in_memory = !self.request.results.spacetime;
        let [records, snapshots] = [self.column_tile(1, in_memory), self.row_tile(1, in_memory)];
        let tile = records.max(snapshots);
        let times = self.axes.n_times.min(LEAST_TIMES) as u64 * self.per_time();
        let block = self.per_site(true).max(times).max(self.per_frequency());
        (2 * tile).max(tile + block)
    }
}

#[cfg(test)]
mod tests {
    use ndarray::{Array2, ShapeBuilder};

    use crate::Field;
    use crate::analyze::{Request, plan};

    /// Snapshots of a field larger than memory: where they are rows, a few at a time; across records, as
    /// many as fit, since each piece of a record costs a read.
    #[test]
    fn snapshots_across_records_are_read_in_long_pieces() {
        let [rows, across] = [false, true].map(|fortran| {
            let shape = (8192, 500);
            let field = Field::from_array(Array2::zeros(shape.set_f(fortran)));
            let allowed = (60 << 20) + 8 * 8192 * 500;
            let request = Request {
                threads: Some(2),
                memory: Some(allowed),
                ..Request::default()
            };
            let planned = plan(&field, &request).unwrap();
            assert!(planned.streams() && planned.memory_needed <= allowed);
            [planned.tiles.times, planned.blocks.times]
        });
        assert!(across[0] >= 8 * rows[0], "{across:?} {rows:?}");
        assert!(across[1] >= across[0], "{across:?}");
    }
}
