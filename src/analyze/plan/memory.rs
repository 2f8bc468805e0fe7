//! Blocks that fit the memory allowed.

use super::{Blocks, Plan};
use crate::analyze::intermediate::scratch_bytes;
use crate::analyze::short_time::{ShortTimeSegments, TOGETHER};
use crate::diagnostics::Keep;
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
        let bins = |segments: Segments| segments.length as u64 / 2 + 1;
        let held = |segments: Segments, count: usize| {
            16 * bins(segments) * segments.count() as u64 * count as u64
        };
        let sites = match asked.sites.len() {
            0 => self.axes.n_sites.min(3),
            count => count,
        };
        let ShortTimeSegments { time, space } = self.short_time;
        // A record, and for each of the frames transformed together the scratch of a record.
        let frame = |segments: Segments| 8 * segments.length as u64 + 64 * bins(segments);
        let worked_on = 8 * self.axes.n_times as u64 + TOGETHER as u64 * frame(time);
        let at_once = self.threads.min(sites) as u64;
        let times = asked.times.len();
        let across = held(space, times) + times.min(1) as u64 * TOGETHER as u64 * frame(space);
        held(time, sites) + at_once * worked_on + across
    }

    /// Bytes of the maps, of which there are none without figures.
    fn map_bytes(&self) -> u64 {
        let (axes, results) = (&self.axes, self.request.results);
        let (nt, nx) = (axes.n_times, axes.n_sites);
        let [nf, nk, both] =
            [&axes.frequency, &axes.wavenumber, &axes.wavenumber_signed].map(Vec::len);
        let maps = [
            (true, (nt, nx), Keep::Extreme),
            (results.temporal, (nf, nx), Keep::Largest),
            (results.spatial, (nt, nk), Keep::Largest),
            (results.spacetime, (nf, both), Keep::Largest),
            (results.flux_surrogate, (nt, nk), Keep::Extreme),
        ];
        let made = maps.iter().filter(|map| self.request.maps && map.0);
        made.map(|&(_, shape, keep)| keep.bytes(shape, self.map_limit(shape, keep)))
            .sum()
    }

    /// Samples of the longest front windows whose scratch is held beside that of whole records.
    /// Longer windows replace it.
    pub(in crate::analyze) fn front_samples(n_times: usize) -> usize {
        n_times / 16
    }

    /// Samples of the longest front windows that are held beside the scratch of whole records.
    fn front_beside(&self) -> Option<usize> {
        let nt = self.axes.n_times;
        // Segments of Welch's method are shorter than records: freeing their scratch gains little.
        let samples = match self.request.welch {
            None => Plan::front_samples(nt),
            Some(_) => nt,
        };
        self.request.results.temporal.then_some(samples)
    }

    /// Chooses tiles and blocks, whether the field streams through, and whether the intermediate
    /// matrix of the space-time transform is held in memory. The survey of the samples takes
    /// `surveyed` bytes per thread.
    pub(super) fn fit_into_memory(&mut self, surveyed: u64, time_major: bool) -> Result<()> {
        let need = Need::of(self);
        let allowed = self.memory_allowed;
        let results = need.vectors(surveyed) + self.short_time_bytes();
        // Mapped pages of the field count as memory, so a large field is read piece by piece.
        let mapped = 8 * need.nt * need.nx;
        let piece = (piece_bytes(self.threads) as u64).max(8 * need.nx);
        let pieces = mapped.min(need.threads * piece);
        let blocks = pieces + need.smallest_blocks();
        // Fine maps where they take little of what there is.
        self.has_fine_maps = true;
        let fine = self.map_bytes();
        self.has_fine_maps = fine <= allowed / FINE_SHARE && results + fine + blocks <= allowed;
        let vectors = results + self.map_bytes();
        // What moved is found once the passes have let go of theirs.
        let answers = self.request.results.answer;
        let answer = |tile: u64| u64::from(answers) * need.answer(tile, 0);
        let least = vectors + blocks.max(pieces + answer(1) + need.per_site(true));
        if allowed < least {
            return Err(Error::Memory {
                what: "the smallest block of this field",
                needed: least,
                allowed,
            });
        }
        let mut free = allowed - least;
        let intermediate = self.between_rows() as u64 * need.intermediate_row;
        let in_memory = !need.spacetime || intermediate <= free.min(allowed / 2);
        let held = u64::from(need.spacetime && in_memory) * intermediate;
        free -= held;
        let streams = mapped > free.min(allowed / 4) || vectors + mapped + answer(1) > allowed;

        let fixed = vectors + held + if streams { pieces } else { mapped };
        let spare = allowed - fixed;
        let across = streams && !time_major;
        let [columns, rows] = self.fit_tiles(&need, in_memory, across, spare);
        let tiles = columns.max(rows);
        let [records, snapshots] =
            self.fit_blocks(&need, streams, across, in_memory, spare - tiles);
        let both = columns + rows + records + snapshots;
        self.interleaved = !streams && in_memory && fixed + both <= allowed;
        self.memory_needed = match self.interleaved {
            true => fixed + both,
            false => fixed + tiles + records.max(snapshots),
        };
        let base = vectors
            + match streams {
                true => pieces + need.nt * 8 * self.blocks.sites as u64,
                false => mapped,
            };
        while self.tiles.sites > 1 && base + answer(self.tiles.sites as u64) > allowed {
            self.tiles.sites = self.tiles.sites.div_ceil(2);
        }
        let tile = self.tiles.sites as u64;
        let left = allowed.saturating_sub(base + answer(tile));
        self.answer_bytes = left.min(allowed / ANSWER_SHARE);
        if answers {
            let answer = need.answer(tile, self.answer_bytes);
            self.memory_needed = self.memory_needed.max((base + answer).min(allowed));
        }
        self.tiles.ahead = streams.then_some(self.blocks.sites);
        let shape = (self.between_rows(), self.axes.n_sites);
        let scratch = scratch_bytes(shape, self.tiles.sites, need.complex);
        self.scratch_file = u64::from(!in_memory) * scratch;
        Ok(())
    }

    /// Halves the tiles until each takes at most half of the `spare` bytes. Snapshots that are read
    /// `across` the records of a file, piece by piece, take a third of it. Returns the bytes of tiles of
    /// records and of snapshots.
    fn fit_tiles(&mut self, need: &Need, in_memory: bool, across: bool, spare: u64) -> [u64; 2] {
        let tiles = &mut self.tiles;
        let columns = |sites: usize| need.column_tile(sites as u64, in_memory);
        let rows = |times: usize| need.row_tile(times as u64, in_memory);
        while tiles.sites > 1 && columns(tiles.sites) > spare / 2 {
            tiles.sites /= 2;
        }
        while tiles.times > 1 && rows(tiles.times) > spare / 2 {
            tiles.times /= 2;
        }
        while across && (tiles.times as u64) < need.nt && rows(2 * tiles.times) <= spare / 3 {
            tiles.times *= 2;
        }
        [columns(tiles.sites), rows(tiles.times)]
    }

    /// Chooses the blocks that `spare` bytes hold. Returns the bytes of blocks of records (or of
    /// frequencies) and of snapshots.
    fn fit_blocks(
        &mut self,
        need: &Need,
        streams: bool,
        across: bool,
        in_memory: bool,
        spare: u64,
    ) -> [u64; 2] {
        let (per_site, per_time) = (need.per_site(streams), need.per_time());
        let per_frequency = need.per_frequency();
        let [nt, nx, nf] = [need.nt, need.nx, need.nf].map(|n| n as usize);
        let block = |bytes: u64, per: u64, tile: usize, least: usize, all: usize| -> usize {
            let fit = usize::try_from(bytes / per.max(1)).unwrap_or(usize::MAX);
            match fit >= all {
                true => all,
                false => (fit / tile * tile).max(least),
            }
        };
        // In the cache if there is room, at least a tile if that fits at all.
        let cached = |per: u64, tile: usize, least: usize, all: usize| -> usize {
            let bytes = (BLOCK_BYTES * need.threads).max(per * tile.max(4) as u64);
            block(bytes.min(spare), per, tile, least, all)
        };
        let sites = block(spare, per_site, self.tiles.sites, 1, nx);
        // Every pass over the field takes the same number of sites.
        let each = nx.div_ceil(nx.div_ceil(sites));
        let together = ComplexTransform::<f64>::TOGETHER;
        let least_times = need.least_times() as usize;
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
            u64::from(need.spacetime) * blocks.frequencies as u64 * per_frequency;
        if !in_memory {
            // Whole blocks, which are read together.
            let block = blocks.frequencies as u64 * need.segments * need.intermediate_row;
            let more = SCRATCH_BYTES.min(spare).saturating_sub(from_records) / block;
            let more = more.min(need.nf.div_ceil(blocks.frequencies as u64) - 1);
            blocks.scratch = blocks.frequencies * (1 + more as usize);
            from_records += more * block;
        }
        self.blocks = blocks;
        let records = from_records.max(blocks.sites as u64 * per_site);
        [records, blocks.times as u64 * per_time]
    }
}

/// What the tiles and blocks of a plan need, in bytes.
struct Need {
    nt: u64,
    nx: u64,
    nf: u64,
    /// Wavenumbers of one sign, and of both.
    nk: u64,
    nks: u64,
    threads: u64,
    /// Bytes of a complex number.
    complex: u64,
    spacetime: bool,
    segments: u64,
    /// Samples of a segment of Welch's method; 0 without.
    welch: u64,
    /// Samples of a segment, and padded.
    time: [usize; 2],
    /// Sites, and padded.
    space: [usize; 2],
    /// Samples of the longest windows at the front's passage.
    front: Option<usize>,
    /// A row of the intermediate matrix.
    intermediate_row: u64,
}

impl Need {
    fn of(plan: &Plan) -> Need {
        let complex = plan.complex_bytes();
        let nx = plan.axes.n_sites as u64;
        Need {
            nt: plan.axes.n_times as u64,
            nx,
            nf: plan.axes.frequency.len() as u64,
            nk: plan.axes.wavenumber.len() as u64,
            nks: plan.axes.wavenumber_signed.len() as u64,
            threads: plan.threads as u64,
            complex,
            spacetime: plan.request.results.spacetime,
            segments: plan.segments.count() as u64,
            welch: plan.request.welch.map_or(0, |welch| welch.segment as u64),
            time: [plan.segments.length, plan.conventions.padded_time],
            space: [plan.axes.n_sites, plan.conventions.padded_space],
            front: plan.front_beside(),
            intermediate_row: nx * complex,
        }
    }

    /// Number of threads with a tile of `each` of `all` items.
    fn at_work(&self, all: u64, each: u64) -> u64 {
        self.threads.min(all.div_ceil(each))
    }

    /// Vectors as long as an axis, of the result and of each thread.
    fn vectors(&self, surveyed: u64) -> u64 {
        let result = 160 * (self.nt + self.nx) + 40 * (self.nf + self.nks) + (4 << 20);
        result + self.threads * (160 * self.nx + surveyed)
    }

    /// Tiles of records, one a thread: as read and as transformed, their transforms, scratch, and
    /// powers of eight sites, even if there are fewer.
    fn column_tile(&self, sites: u64, in_memory: bool) -> u64 {
        let [length, padded] = self.time;
        let scratch = RecordTransform::<f64>::working_bytes(length, padded, sites as usize);
        // Transforms of all segments are held until they are written to a scratch file.
        let waiting = u64::from(!in_memory) * self.complex * self.nf * (self.segments - 1);
        let front = |samples| front_bytes(samples, sites as usize);
        let front = self.front.map_or(0, front);
        let measured = MEASURED * self.nf;
        let tile = sites * (8 * (self.nt + self.welch) + waiting) + scratch + measured + front;
        self.at_work(self.nx, sites) * tile
    }

    /// Tiles of snapshots and of frequencies, one a thread.
    fn row_tile(&self, times: u64, in_memory: bool) -> u64 {
        let [sites, padded] = self.space;
        // A small block is divided among all threads, eight snapshots each.
        let at_once = times.min(WIDTH as u64);
        let scratch = RecordTransform::<f64>::working_bytes(sites, padded, WIDTH);
        let snapshots = self.at_work(self.nt, times) * times * 8 * (self.nx + self.nks)
            + self.at_work(self.nt, at_once) * (MEASURED * self.nk + scratch);
        if !self.spacetime {
            return snapshots;
        }
        let together = ComplexTransform::<f64>::TOGETHER as u64;
        // Rows are gathered from the stripes of a scratch file.
        let gathered = u64::from(!in_memory) * together * self.intermediate_row;
        let scratch = ComplexTransform::<f64>::working_bytes(sites, padded);
        snapshots + self.at_work(self.nf, together) * (gathered + scratch)
    }

    /// Of a block of records. Spectra along time are written by the pass that has them in rows, where
    /// there is one.
    fn per_site(&self, streams: bool) -> u64 {
        8 * (u64::from(!self.spacetime) * self.nf + u64::from(streams) * self.nt)
    }

    /// Of blocks of snapshots: one is computed while another is written.
    fn per_time(&self) -> u64 {
        8 * (2 * self.nx + 4 * self.nk)
    }

    /// Of blocks of frequencies: one is computed while another is written.
    fn per_frequency(&self) -> u64 {
        16 * (self.nks + self.nx) + self.segments * self.intermediate_row
    }

    /// Of the answer: tiles of records and the scratch of one a thread, what is known of each site, and the spectra of windows
    /// at some sites, in `spectra` bytes or those of the fewest sites.
    fn answer(&self, tile: u64, spectra: u64) -> u64 {
        let records = self.at_work(self.nx, tile) * (8 * tile + ANSWER_SAMPLE) * self.nt;
        let of = |sites: u64| self.nx.min(sites) * ANSWER_BIN * self.nt.min(2 * FINE_BINS);
        records + ANSWER_SITE * self.nx + of(320).min(spectra.max(of(32)))
    }

    /// Times of the smallest block: the flux surrogate differentiates over three neighbours.
    fn least_times(&self) -> u64 {
        self.nt.min(4)
    }

    /// One record and a few snapshots, in tiles and blocks.
    fn smallest_blocks(&self) -> u64 {
        let in_memory = !self.spacetime;
        let [records, snapshots] = [self.column_tile(1, in_memory), self.row_tile(1, in_memory)];
        let tile = records.max(snapshots);
        let times = self.least_times() * self.per_time();
        let block = self.per_site(true).max(times).max(self.per_frequency());
        (2 * tile).max(tile + block)
    }
}

/// Bytes of scratch of one thread for windows of `samples` samples at `sites` sites.
fn front_bytes(samples: usize, sites: usize) -> u64 {
    // With zeros up to a quick length.
    let padded = samples + samples / 8 + 8;
    let worked = RecordTransform::<f64>::working_bytes(samples, padded, sites);
    worked + (MEASURED + 16) * padded as u64 / 2
}

#[cfg(test)]
mod tests {
    use ndarray::{Array2, ShapeBuilder};

    use crate::Field;
    use crate::analyze::{Request, Results, ShortTime, plan};
    use crate::field::OpenOptions;
    use crate::numeric::lanes::WIDTH;
    use crate::transform::RecordTransform;

    fn needed(threads: usize, short_time: bool) -> u64 {
        let field = Field::from_array(Array2::zeros((4096, 8)));
        let request = Request {
            results: Results {
                short_time,
                ..Results::ALL
            },
            short_time: ShortTime {
                sites: vec![0, 3, 7],
                segment: Some(100),
                hop: Some(50),
                ..Request::default().short_time
            },
            threads: Some(threads),
            memory: Some(1 << 30),
            ..Request::default()
        };
        plan(&field, &request).unwrap().memory_needed
    }

    /// By hand: spectra of 51 bins and 80 frames, held twice; for each thread at work a record and
    /// eight frames, in three copies, with spectra and scratch.
    #[test]
    fn short_time_records_of_all_threads_count() {
        let of = |threads| needed(threads, true) - needed(threads, false);
        let held = 3 * 2 * 8 * 51 * 80;
        let record = 8 * 4096 + 8 * (8 * 100 + 64 * 51);
        assert_eq!(
            [1, 2, 3, 8].map(of),
            [1, 2, 3, 3].map(|n| held + n * record)
        );
    }

    /// By hand: 64 snapshots of 8 sites are two tiles, the records one. Each of 8 threads works on
    /// 8 of them and holds the survey of all sites; the second also holds a tile: 32 snapshots as
    /// read and as spectra of 8 bins of both signs.
    #[test]
    fn tiles_of_threads_that_have_one_count() {
        let field = Field::from_array(Array2::zeros((64, 8)));
        let needed = [1, 2, 3, 8].map(|threads| {
            let request = Request {
                results: Results {
                    spatial: true,
                    ..Results::NONE
                },
                threads: Some(threads),
                memory: Some(1 << 30),
                ..Request::default()
            };
            plan(&field, &request).unwrap().memory_needed
        });
        let steps = [0, 1, 2].map(|i| needed[i + 1] - needed[i]);
        let worked = RecordTransform::<f64>::working_bytes(8, 8, WIDTH);
        assert_eq!(steps[2], 5 * steps[1]);
        assert!(steps[1] > 5 * 80 + worked);
        assert_eq!(steps[0] - steps[1], 32 * 8 * (8 + 8));
    }

    /// Snapshots of a file larger than memory: where they are rows, a few at a time; across records, as
    /// many as fit, since each piece of a record costs a read.
    #[test]
    fn snapshots_across_records_are_read_in_long_pieces() {
        let folder = tempfile::tempdir().unwrap();
        let tile = |fortran: bool| {
            let path = folder.path().join("field.npy");
            let shape = (8192, 500).set_f(fortran);
            ndarray_npy::write_npy(&path, &Array2::<f32>::zeros(shape)).unwrap();
            let field = Field::open(&path, &OpenOptions::default()).unwrap();
            let request = Request {
                threads: Some(2),
                memory: Some(60 << 20),
                ..Request::default()
            };
            let planned = plan(&field, &request).unwrap();
            assert!(planned.memory_needed <= 60 << 20);
            (planned.tiles.times, planned.blocks.times)
        };
        let (tile_of_rows, block_of_rows) = tile(false);
        let (tile_across, block_across) = tile(true);
        assert!(
            tile_across >= 8 * tile_of_rows,
            "{tile_across} of {tile_of_rows}"
        );
        assert!(
            block_across >= tile_across,
            "{block_across} of {block_of_rows}"
        );
    }
}
