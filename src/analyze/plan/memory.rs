//! Blocks that fit the memory allowed.

use super::{Blocks, Plan};
use crate::analyze::intermediate::scratch_bytes;
use crate::analyze::short_time::{ShortTimeSegments, TOGETHER};
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
        // A record, and of each of its frames that go together what a record of a tile takes.
        let frame = |segments: Segments| 8 * segments.length as u64 + 64 * bins(segments);
        let worked_on = 8 * self.axes.n_times as u64 + TOGETHER as u64 * frame(time);
        let at_once = self.threads.min(sites) as u64;
        let across = match asked.times.len() {
            0 => 0,
            count => held(space, count) + TOGETHER as u64 * frame(space),
        };
        held(time, sites) + at_once * worked_on + across
    }

    /// Samples of the longest windows at the front's passage for which there is room beside what whole
    /// records take; for longer ones that is let go of.
    pub(in crate::analyze) fn front_samples(n_times: usize) -> usize {
        n_times / 16
    }

    /// Samples of the longest windows that are held beside what whole records take.
    fn front_beside(&self) -> Option<usize> {
        let nt = self.axes.n_times;
        // Segments of Welch's method are shorter than records: to let go of them makes little room.
        let samples = match self.request.welch {
            None => Plan::front_samples(nt),
            Some(_) => nt,
        };
        self.request.results.temporal.then_some(samples)
    }

    /// Chooses tiles and blocks, whether the field streams through, and where the matrix between the
    /// halves of the space-time transform lies. A thread takes `surveyed` bytes to look at the samples.
    pub(super) fn fit_into_memory(&mut self, surveyed: u64) -> Result<()> {
        let (nt, nx) = (self.axes.n_times as u64, self.axes.n_sites as u64);
        let nf = self.axes.frequency.len() as u64;
        let (nk, nks) = (
            self.axes.wavenumber.len() as u64,
            self.axes.wavenumber_signed.len() as u64,
        );
        let threads = self.threads as u64;
        let allowed = self.memory_allowed;
        let between_row = nx * self.complex_bytes();
        let between = self.between_rows() as u64 * between_row;
        let spacetime = self.request.results.spacetime;

        let vectors = 160 * (nt + nx) + 32 * (nf + nks) + (8 << 20) + self.short_time_bytes();
        // What each thread sees of all sites in passing.
        let vectors = vectors + threads * (160 * nx + surveyed);
        // Mapped pages of the field count as memory too, so a large field is read piece by piece.
        let mapped = 8 * nt * nx;
        let piece = (piece_bytes(self.threads) as u64).max(8 * nx);
        let pieces = mapped.min(threads * piece);
        // Threads that have a tile, of so many each, of what there is.
        let at_work = |all: u64, each: u64| threads.min(all.div_ceil(each));
        // Of each of them: a tile of records, as read and as transformed, their transforms, what these
        // work with, and powers of eight sites, be they fewer; or a tile of profiles, and of eight
        // what these take.
        let segments = self.segments.count() as u64;
        let segment = self
            .request
            .welch
            .map_or(0, |_| self.segments.length as u64);
        let complex = self.complex_bytes();
        let front = self.front_beside();
        let column_tile = |sites: u64, in_memory: bool| {
            let (length, padded) = (self.segments.length, self.conventions.padded_time);
            let worked = RecordTransform::<f64>::working_bytes(length, padded, sites as usize);
            // On their way to a scratch file transforms of all segments are held.
            let on_their_way = complex * nf * (segments - 1);
            let kept = if in_memory { 0 } else { on_their_way };
            let front = front.map_or(0, |samples| front_bytes(samples, sites as usize));
            let measured = MEASURED * nf;
            at_work(nx, sites) * (sites * (8 * (nt + segment) + kept) + worked + measured + front)
        };
        let (sites, padded) = (self.axes.n_sites, self.conventions.padded_space);
        let along_space =
            MEASURED * nk + RecordTransform::<f64>::working_bytes(sites, padded, WIDTH);
        let together = ComplexTransform::<f64>::TOGETHER as u64;
        let at_each_frequency = |in_memory: bool| match (spacetime, in_memory) {
            (false, _) => 0,
            (true, true) => ComplexTransform::<f64>::working_bytes(sites, padded),
            // Rows are gathered from the stripes of a scratch file.
            (true, false) => {
                together * between_row + ComplexTransform::<f64>::working_bytes(sites, padded)
            }
        };
        let row_tile = |times: u64, in_memory: bool| {
            // A small block is shared out to all threads, eight times each.
            let at_once = times.min(WIDTH as u64);
            let profiles = at_work(nt, times) * times * 8 * (nx + nks);
            let profiles = profiles + at_work(nt, at_once) * along_space;
            profiles + at_work(nf, together) * at_each_frequency(in_memory)
        };
        // Spectra along time are written by the pass that has them in rows, where there is one.
        let per_site = |streams: bool| {
            let written = if spacetime { 0 } else { 8 * nf };
            written + if streams { 8 * nt } else { 0 }
        };
        // Of profiles and of frequencies one block is computed while another is written.
        let per_time = 8 * (2 * nx + 4 * nk);
        let per_frequency = 16 * (nks + nx) + segments * between_row;
        // The flux surrogate differentiates over three neighbouring times.
        let least_times = nt.min(4);

        // The least that any of these blocks can do with: one record, a few profiles.
        let least_tile = column_tile(1, !spacetime).max(row_tile(1, !spacetime));
        let least_block = per_site(true)
            .max(least_times * per_time)
            .max(per_frequency);
        let least = vectors + pieces + (2 * least_tile).max(least_tile + least_block);
        if allowed < least {
            return Err(Error::Memory {
                what: "the smallest block of this field",
                needed: least,
                allowed,
            });
        }
        let mut room = allowed - least;
        let in_memory = !spacetime || between <= room.min(allowed / 2);
        let held = if spacetime && in_memory { between } else { 0 };
        room -= held;
        let streams = mapped > room.min(allowed / 4);
        let per_site = per_site(streams);

        let fixed = vectors + held + if streams { pieces } else { mapped };
        let spare = allowed - fixed;
        // The tiles shrink where the records are so long that they would not fit.
        while self.tiles.sites > 1 && column_tile(self.tiles.sites as u64, in_memory) > spare / 2 {
            self.tiles.sites /= 2;
        }
        while self.tiles.times > 1 && row_tile(self.tiles.times as u64, in_memory) > spare / 2 {
            self.tiles.times /= 2;
        }
        let columns = column_tile(self.tiles.sites as u64, in_memory);
        let rows = row_tile(self.tiles.times as u64, in_memory);
        let tiles = columns.max(rows);
        let for_blocks = spare - tiles;
        let block = |bytes: u64, per: u64, tile: usize, least: usize, all: usize| -> usize {
            let fit = usize::try_from(bytes / per.max(1)).unwrap_or(usize::MAX);
            if fit >= all {
                all
            } else {
                (fit / tile * tile).max(least)
            }
        };
        // In the cache if there is room, at least a tile if that fits at all.
        let cached = |per: u64, tile: usize, least: usize, all: usize| -> usize {
            let bytes = (BLOCK_BYTES * threads).max(per * tile.max(4) as u64);
            block(bytes.min(for_blocks), per, tile, least, all)
        };
        let sites = block(for_blocks, per_site, self.tiles.sites, 1, nx as usize);
        // As many in each pass over the field.
        let each = (nx as usize).div_ceil((nx as usize).div_ceil(sites));
        let mut blocks = Blocks {
            sites: sites.min(each.next_multiple_of(self.tiles.sites)),
            times: cached(
                per_time,
                self.tiles.times,
                least_times as usize,
                nt as usize,
            ),
            frequencies: cached(
                per_frequency,
                ComplexTransform::<f64>::TOGETHER,
                1,
                nf as usize,
            ),
            scratch: 0,
        };
        // No tile is wider than its block: stripes of a scratch file are tiles.
        self.tiles.sites = self.tiles.sites.min(blocks.sites);
        let frequencies = if spacetime { blocks.frequencies } else { 0 };
        let mut from_records = frequencies as u64 * per_frequency;
        if !in_memory {
            // Whole blocks, which are read together.
            let block = blocks.frequencies as u64 * segments * between_row;
            let more = SCRATCH_BYTES.min(for_blocks).saturating_sub(from_records) / block;
            let more = more.min(nf.div_ceil(blocks.frequencies as u64) - 1);
            blocks.scratch = blocks.frequencies * (1 + more as usize);
            from_records += more * block;
        }
        let records = from_records.max(blocks.sites as u64 * per_site);
        let profiles = blocks.times as u64 * per_time;
        let both = columns + rows + records + profiles;
        self.interleaved = !streams && in_memory && fixed + both <= allowed;
        self.memory_needed = match self.interleaved {
            true => fixed + both,
            false => fixed + tiles + records.max(profiles),
        };
        self.blocks = blocks;
        self.tiles.ahead = streams.then_some(blocks.sites);
        let shape = (self.between_rows(), self.axes.n_sites);
        self.scratch_file = match in_memory {
            true => 0,
            false => scratch_bytes(shape, self.tiles.sites, complex),
        };
        Ok(())
    }
}

/// Bytes that a thread takes for windows of so many samples at so many sites.
fn front_bytes(samples: usize, sites: usize) -> u64 {
    // With zeros up to a quick length.
    let padded = samples + samples / 8 + 8;
    let worked = RecordTransform::<f64>::working_bytes(samples, padded, sites);
    worked + (MEASURED + 16) * padded as u64 / 2
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use crate::Field;
    use crate::analyze::{Request, Results, ShortTime, plan};
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

    /// By hand: spectra of 51 bins and 80 frames, held twice; of each thread that has one a record and
    /// eight frames, in three copies besides spectra and working space.
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

    /// By hand: 64 profiles of 8 sites are two tiles, the records one. Each of 8 threads works on 8 of
    /// them and takes what every thread sees of all sites; the second takes a tile besides: 32
    /// profiles as read and as spectra of 8 bins of both signs.
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
}
