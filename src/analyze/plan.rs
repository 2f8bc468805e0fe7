//! The plan: a request held against a field, with every size settled, before anything is computed.

use std::ops::Range;

use serde::Serialize;

use super::request::{Precision, Request, Scaling, TimeRange};
use super::result::{Axes, Conventions};
use super::short_time::ShortTimeSegments;
use super::sink::LargeArray;
use crate::error::{Error, Result};
use crate::field::{Axis, Field};
use crate::prepare::{Tiles, Window};
use crate::transform::{Scale, Segments, frequencies, wavenumbers, wavenumbers_signed};

/// What will be computed, in which blocks, with which transforms; see [`plan`].
#[derive(Debug, Clone)]
pub struct Plan {
    pub(crate) times: Range<usize>,
    pub(crate) sites: Range<usize>,
    pub(crate) request: Request,
    pub(crate) segments: Segments,
    pub(crate) short_time: ShortTimeSegments,
    pub(crate) window_time: Vec<f64>,
    pub(crate) window_space: Vec<f64>,
    pub(crate) axes: Axes,
    pub(crate) conventions: Conventions,
    pub(crate) time_scale: Scale,
    pub(crate) space_scale: Scale,
    pub(crate) tiles: Tiles,
    pub(crate) blocks: Blocks,
    pub threads: usize,
    /// Bytes of working memory that the blocks will use, by estimate.
    pub memory_needed: u64,
    /// Bytes allowed.
    pub memory_allowed: u64,
    /// Bytes of scratch file for the space-time spectrum; 0 where it is held in memory.
    pub scratch_file: u64,
    /// Transforms to be made, stage by stage.
    pub stages: Vec<PlannedStage>,
    /// Large arrays to be written, with their shapes.
    pub arrays: Vec<(LargeArray, (usize, usize))>,
}

/// Sizes of the blocks that pass through memory.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Blocks {
    /// Records at once, in transforms along time.
    pub sites: usize,
    /// Profiles at once, in transforms along space.
    pub times: usize,
    /// Frequencies at once, in the second half of space-time transforms.
    pub frequencies: usize,
}

/// The transforms of one stage.
#[derive(Debug, Clone, Serialize)]
pub struct PlannedStage {
    pub stage: &'static str,
    pub transforms: u64,
    pub length: usize,
    pub bytes_read: u64,
    pub bytes_written: u64,
}

/// A [`Plan`] as data; ranges are `[first, end)`, sizes are bytes.
#[derive(Debug, Serialize)]
pub struct PlanSummary<'a> {
    times: [usize; 2],
    sites: [usize; 2],
    stages: &'a [PlannedStage],
    arrays: std::collections::BTreeMap<&'static str, [usize; 2]>,
    blocks: Blocks,
    threads: usize,
    memory_needed: u64,
    memory_allowed: u64,
    scratch_file: u64,
}

/// Records transformed together: one cache line of doubles.
const TILE_SITES: usize = 8;
/// Profiles transformed together.
const TILE_TIMES: usize = 32;
/// More threads than any machine has cores are a slip of the hand.
const MOST_THREADS: usize = 1024;

/// Bytes of a block of profiles or frequencies, a thread: it is written while it is in the cache,
/// and its memory is used again. Blocks of sites are as large as they can be, since the pieces
/// of rows they write are short.
const BLOCK_BYTES: u64 = 2 << 20;

/// Settles `request` for `field`.
///
/// Reads samples only where the range of times depends on them ([`TimeRange::UntilArrival`]).
///
/// # Errors
/// [`Error::Request`] names the option that does not fit; [`Error::Memory`] where not even the
/// smallest blocks fit the memory allowed.
pub fn plan(field: &Field, request: &Request) -> Result<Plan> {
    let sites = site_range(field, request)?;
    let times = time_range(field, request, &sites)?;
    let (n_times, n_sites) = (times.len(), sites.len());

    let segments = segments(request, n_times)?;
    let padded_time = padded("pad-time", request.pad_time, segments.length)?;
    let padded_space = padded("pad-space", request.pad_space, n_sites)?;
    check_references(field, request, &times, &sites)?;
    let short_time = ShortTimeSegments::settle(request, n_times, n_sites)?;
    check_window("window-time", request.window_time, segments.length)?;
    check_window("window-space", request.window_space, n_sites)?;
    let memory_allowed = request.memory.unwrap_or_else(half_of_free_memory);
    check_axes(padded_time, padded_space, memory_allowed)?;
    let window_time = request.window_time.samples(segments.length);
    let window_space = request.window_space.samples(n_sites);
    for (option, window, gains) in [
        ("window-time", &window_time, request.window_time),
        ("window-space", &window_space, request.window_space),
    ] {
        if crate::sum::sum_of_squares(window) == 0.0 {
            return Err(Error::Request {
                option,
                expected: "a window that leaves some samples".into(),
                found: format!("{gains} over {} samples, all zero", window.len()),
            });
        }
    }

    let space = shifted(&field.space, sites.start);
    let axes = Axes {
        frequency: frequencies(padded_time, field.time.step),
        wavenumber: wavenumbers(padded_space, field.space.step),
        wavenumber_signed: wavenumbers_signed(padded_space, field.space.step),
        time: shifted(&field.time, times.start),
        n_times,
        space,
        n_sites,
    };
    let conventions = Conventions {
        scaling: request.scaling,
        window_time: request.window_time.gains(segments.length),
        window_space: request.window_space.gains(n_sites),
        segment: segments.length,
        overlap: segments.length.saturating_sub(segments.hop),
        segments: segments.count(),
        padded_time,
        padded_space,
    };
    let threads = request
        .threads
        .or_else(|| std::thread::available_parallelism().ok().map(usize::from))
        .unwrap_or(1);
    let time_scale = Scale::along_time(
        request.scaling,
        &window_time,
        n_times,
        padded_time,
        axes.time.step,
    );
    let space_scale = Scale::along_space(
        request.scaling,
        &window_space,
        padded_space,
        axes.space.step,
    );
    let mut plan = Plan {
        times,
        sites,
        request: request.clone(),
        segments,
        short_time,
        window_time,
        window_space,
        axes,
        conventions,
        time_scale,
        space_scale,
        tiles: Tiles {
            sites: TILE_SITES,
            times: TILE_TIMES,
            ahead: None,
        },
        blocks: Blocks {
            sites: n_sites,
            times: n_times,
            frequencies: padded_time / 2 + 1,
        },
        threads,
        memory_needed: 0,
        memory_allowed,
        scratch_file: 0,
        stages: Vec::new(),
        arrays: Vec::new(),
    };
    plan.fit_into_memory()?;
    plan.list_work();
    Ok(plan)
}

impl Plan {
    /// Rows of the matrix between the two halves of a space-time transform.
    pub(crate) fn between_rows(&self) -> usize {
        self.axes.frequency.len() * self.segments.count()
    }

    pub(crate) fn complex_bytes(&self) -> u64 {
        match self.request.precision {
            Precision::F64 => 16,
            Precision::F32 => 8,
        }
    }

    pub(crate) fn space_scale_of(&self, scaling: Scaling) -> Scale {
        Scale::along_space(
            scaling,
            &self.window_space,
            self.conventions.padded_space,
            self.axes.space.step,
        )
    }

    /// Whether transforms along time are made at all.
    pub(crate) fn transforms_time(&self) -> bool {
        self.request.results.temporal || self.request.results.spacetime
    }

    /// Whether transforms along space of each instant are made at all.
    pub(crate) fn transforms_space(&self) -> bool {
        self.request.results.spatial || self.request.results.flux_surrogate
    }

    /// Sizes of the blocks that pass through memory.
    pub fn blocks(&self) -> Blocks {
        self.blocks
    }

    /// The plan as data, for programs.
    pub fn describe(&self) -> PlanSummary<'_> {
        PlanSummary {
            times: [self.times.start, self.times.end],
            sites: [self.sites.start, self.sites.end],
            stages: &self.stages,
            arrays: self
                .arrays
                .iter()
                .map(|&(array, (rows, columns))| (array.name(), [rows, columns]))
                .collect(),
            blocks: self.blocks,
            threads: self.threads,
            memory_needed: self.memory_needed,
            memory_allowed: self.memory_allowed,
            scratch_file: self.scratch_file,
        }
    }

    fn fit_into_memory(&mut self) -> Result<()> {
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

        let vectors = 160 * (nt + nx) + 32 * (nf + nks) + (8 << 20);
        // Of each thread: a tile of records and its spectra, or a tile of profiles.
        let segments = self.segments.count() as u64;
        let column_tile = |sites: u64| threads * sites * (8 * nt + (16 * segments + 32) * nf);
        let row_tile = |times: u64| threads * times * 8 * (nx + nks);
        // Spectra along time are written by the pass that has them in rows, where there is one.
        let per_site = |in_memory: bool, streams: bool| {
            let written = match (spacetime, in_memory) {
                (false, _) => 8 * nf,
                (true, true) => 0,
                (true, false) => between / nx,
            };
            written + if streams { 8 * nt } else { 0 }
        };
        let per_time = 8 * (nx + 3 * nk);
        let per_frequency = 8 * (nks + nx) + segments * between_row;
        // The flux surrogate differentiates over three neighbouring times.
        let least_times = nt.min(4);

        // The least that any of these blocks can do with: one record, a few profiles.
        let least_tile = column_tile(1).max(row_tile(1));
        let least_block = per_site(!spacetime, true)
            .max(least_times * per_time)
            .max(per_frequency);
        let least = vectors + (2 * least_tile).max(least_tile + least_block);
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
        // Mapped pages of the field count as memory too, so a large field is read piece by piece.
        let mapped = 8 * nt * nx;
        let streams = mapped > room.min(allowed / 4);
        let per_site = per_site(in_memory, streams);

        let fixed = vectors + held + if streams { 0 } else { mapped };
        let spare = allowed - fixed;
        // The tiles shrink where the records are so long that they would not fit.
        while self.tiles.sites > 1 && column_tile(self.tiles.sites as u64) > spare / 2 {
            self.tiles.sites /= 2;
        }
        while self.tiles.times > 1 && row_tile(self.tiles.times as u64) > spare / 2 {
            self.tiles.times /= 2;
        }
        let tiles = column_tile(self.tiles.sites as u64).max(row_tile(self.tiles.times as u64));
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
        let blocks = Blocks {
            sites: block(for_blocks, per_site, self.tiles.sites, 1, nx as usize),
            times: cached(
                per_time,
                self.tiles.times,
                least_times as usize,
                nt as usize,
            ),
            frequencies: cached(per_frequency, 1, 1, nf as usize),
        };
        self.memory_needed = fixed
            + tiles
            + (blocks.sites as u64 * per_site)
                .max(blocks.times as u64 * per_time)
                .max(if spacetime {
                    blocks.frequencies as u64 * per_frequency
                } else {
                    0
                });
        self.blocks = blocks;
        self.tiles.ahead = streams.then_some(blocks.sites);
        self.scratch_file = if in_memory { 0 } else { between };
        Ok(())
    }

    fn list_work(&mut self) {
        let (nt, nx) = (self.axes.n_times, self.axes.n_sites);
        let (nf, nk) = (self.axes.frequency.len(), self.axes.wavenumber.len());
        let nks = self.axes.wavenumber_signed.len();
        let results = self.request.results;
        let item = self.complex_bytes() / 2;
        let field_bytes = 8 * (nt * nx) as u64;
        let between = self.between_rows() as u64 * nx as u64 * self.complex_bytes();
        if results.temporal {
            self.arrays.push((LargeArray::TemporalSpectrum, (nf, nx)));
        }
        if results.spatial {
            self.arrays.push((LargeArray::SpatialSpectrum, (nt, nk)));
        }
        if results.spacetime {
            self.arrays.push((LargeArray::SpacetimeSpectrum, (nf, nks)));
        }
        if results.flux_surrogate {
            self.arrays
                .push((LargeArray::KineticFluxSurrogate, (nt, nk)));
        }
        let size =
            |(_, (rows, columns)): &(LargeArray, (usize, usize))| (rows * columns) as u64 * item;
        let bytes_of = |wanted: &[LargeArray]| -> u64 {
            let chosen = self.arrays.iter().filter(|a| wanted.contains(&a.0));
            chosen.map(size).sum()
        };
        let mut stages = Vec::new();
        if self.transforms_time() {
            stages.push(PlannedStage {
                stage: "along time",
                transforms: (nx * self.segments.count()) as u64,
                length: self.conventions.padded_time,
                bytes_read: field_bytes,
                bytes_written: if results.spacetime {
                    between
                } else {
                    bytes_of(&[LargeArray::TemporalSpectrum])
                },
            });
        }
        stages.push(PlannedStage {
            stage: "along space",
            transforms: if self.transforms_space() {
                nt as u64
            } else {
                0
            },
            length: if self.transforms_space() {
                self.conventions.padded_space
            } else {
                0
            },
            bytes_read: field_bytes,
            bytes_written: bytes_of(&[
                LargeArray::SpatialSpectrum,
                LargeArray::KineticFluxSurrogate,
            ]),
        });
        if results.spacetime {
            stages.push(PlannedStage {
                stage: "space-time",
                transforms: self.between_rows() as u64,
                length: self.conventions.padded_space,
                bytes_read: between,
                bytes_written: bytes_of(&[
                    LargeArray::SpacetimeSpectrum,
                    LargeArray::TemporalSpectrum,
                ]),
            });
        }
        self.stages = stages;
    }
}

fn shifted(axis: &Axis, by: usize) -> Axis {
    Axis {
        origin: axis.at(by),
        ..axis.clone()
    }
}

fn site_range(field: &Field, request: &Request) -> Result<Range<usize>> {
    let all = 0..field.n_sites();
    let range = request.sites.clone().unwrap_or(all.clone());
    if range.is_empty() || range.end > all.end {
        return Err(Error::Request {
            option: "sites",
            expected: format!("a range of sites within 0:{}", all.end),
            found: format!("{}:{}", range.start, range.end),
        });
    }
    Ok(range)
}

fn time_range(field: &Field, request: &Request, sites: &Range<usize>) -> Result<Range<usize>> {
    let n = field.n_times();
    let axis = &field.time;
    match request.times {
        TimeRange::All if n > 0 => Ok(0..n),
        TimeRange::All => Err(Error::Request {
            option: "field",
            expected: "at least one time".into(),
            found: "none".into(),
        }),
        TimeRange::Interval { from, to } => {
            // Ends of the interval that fall on a sample up to rounding belong to it.
            let slack = 1e-9 * axis.step;
            let first = ((from - axis.origin - slack) / axis.step).ceil().max(0.0);
            let last = ((to - axis.origin + slack) / axis.step).floor();
            let last = last.min(n as f64 - 1.0);
            if !(last >= 0.0 && first <= last) {
                return Err(Error::Request {
                    option: "times",
                    expected: format!(
                        "an interval that holds times from {} to {}, {} apart",
                        rounded(axis.origin),
                        rounded(axis.at(n.saturating_sub(1))),
                        axis.step
                    ),
                    found: format!("{from}:{to}"),
                });
            }
            Ok(first as usize..last as usize + 1)
        }
        TimeRange::UntilArrival { threshold } => until_arrival(field, sites, threshold),
    }
}

/// Times before `|v|` at the last site exceeds `threshold` of the field's largest `|v|`.
fn until_arrival(field: &Field, sites: &Range<usize>, threshold: f64) -> Result<Range<usize>> {
    if !(threshold > 0.0 && threshold < 1.0) {
        return Err(Error::Request {
            option: "arrival-threshold",
            expected: "a share of the largest amplitude between 0 and 1".into(),
            found: threshold.to_string(),
        });
    }
    let n = field.n_times();
    let last = sites.len() - 1;
    let mut largest = 0.0f64;
    let mut at_last = Vec::with_capacity(n);
    let mut block = Vec::new();
    let times = ((1 << 20) / sites.len()).max(1);
    for start in (0..n).step_by(times) {
        let piece = start..(start + times).min(n);
        block.resize(piece.len() * sites.len(), 0.0);
        field.read_time_major(piece, sites.clone(), &mut block);
        field.release_pages();
        let finite = block.iter().filter(|v| v.is_finite());
        largest = finite.fold(largest, |m, v| m.max(v.abs()));
        at_last.extend(
            block
                .chunks_exact(sites.len())
                .map(|profile| profile[last].abs()),
        );
    }
    let arrival = at_last.iter().position(|&v| v > threshold * largest);
    match arrival {
        Some(0) => Err(Error::Request {
            option: "until-arrival",
            expected: "a last site that is quiet at the first time".into(),
            found: format!("|v| = {:e} there at once", at_last[0]),
        }),
        Some(end) => Ok(0..end),
        None => Ok(0..n),
    }
}

fn segments(request: &Request, n_times: usize) -> Result<Segments> {
    let Some(welch) = request.welch else {
        return Ok(Segments::whole(n_times));
    };
    if welch.segment == 0 || welch.segment > n_times {
        return Err(Error::Request {
            option: "segment",
            expected: format!("1 to {n_times} samples (the record)"),
            found: welch.segment.to_string(),
        });
    }
    if welch.overlap >= welch.segment {
        return Err(Error::Request {
            option: "overlap",
            expected: format!("fewer samples than a segment of {}", welch.segment),
            found: welch.overlap.to_string(),
        });
    }
    Ok(Segments {
        record: n_times,
        length: welch.segment,
        hop: welch.segment - welch.overlap,
    })
}

fn padded(option: &'static str, asked: Option<usize>, samples: usize) -> Result<usize> {
    match asked {
        Some(length) if length < samples => Err(Error::Request {
            option,
            expected: format!("at least the {samples} samples to be transformed"),
            found: length.to_string(),
        }),
        Some(length) => Ok(length),
        None => Ok(samples),
    }
}

fn check_references(
    field: &Field,
    request: &Request,
    times: &Range<usize>,
    sites: &Range<usize>,
) -> Result<()> {
    let inside = |option, sites: &Range<usize>, site: usize| {
        if sites.contains(&site) {
            return Ok(());
        }
        Err(Error::Request {
            option,
            expected: format!("a site of the range {}:{}", sites.start, sites.end),
            found: site.to_string(),
        })
    };
    if let Some(site) = request.reference_site {
        inside("reference-site", sites, site)?;
    }
    for &site in &request.short_time.sites {
        inside("short-time-sites", sites, site)?;
    }
    let (from, to) = (field.time.at(times.start), field.time.at(times.end - 1));
    let asked = request.reference_time.map(|t| ("reference-time", t));
    let followed = request.short_time.times.iter();
    for (option, t) in asked
        .into_iter()
        .chain(followed.map(|&t| ("short-time-times", t)))
    {
        let slack = 0.5 * field.time.step;
        if !(t >= from - slack && t <= to + slack) {
            return Err(Error::Request {
                option,
                expected: format!("a time from {} to {}", rounded(from), rounded(to)),
                found: t.to_string(),
            });
        }
    }
    for (option, edge) in [
        ("band-edge-frequency", request.band_edge_frequency),
        ("band-edge-wavenumber", request.band_edge_wavenumber),
    ] {
        if edge.is_some_and(|e| !(e >= 0.0 && e.is_finite())) {
            return Err(Error::Request {
                option,
                expected: "a number of at least 0".into(),
                found: edge.unwrap_or_default().to_string(),
            });
        }
    }
    if let Some((from, to)) = request.direction_band.filter(|(a, b)| a > b) {
        return Err(Error::Request {
            option: "direction-band",
            expected: "two frequencies, the lower one first".into(),
            found: format!("{from}:{to}"),
        });
    }
    if let Some(threads) = request.threads.filter(|n| !(1..=MOST_THREADS).contains(n)) {
        return Err(Error::Request {
            option: "threads",
            expected: format!("1 to {MOST_THREADS}"),
            found: threads.to_string(),
        });
    }
    Ok(())
}

/// That the window's parameter makes sense for so many samples.
pub(super) fn check_window(option: &'static str, window: Window, samples: usize) -> Result<()> {
    window.validate(samples).map_err(|error| Error::Request {
        option,
        expected: format!("{} for {samples} samples", error.expected),
        found: error.found,
    })
}

/// That the axes of padded spectra can be held, before they are.
fn check_axes(padded_time: usize, padded_space: usize, allowed: u64) -> Result<()> {
    let needed = (padded_time as u64 + 2 * (padded_space as u64)).saturating_mul(8);
    if needed > allowed {
        return Err(Error::Memory {
            what: "holding the axes of the spectra",
            needed,
            allowed,
        });
    }
    Ok(())
}

/// `x` to 12 digits, for a message: without the rounding of `origin + n step`.
fn rounded(x: f64) -> f64 {
    format!("{x:.11e}").parse().unwrap_or(x)
}

/// Half of the memory that is free now; 2 GiB where the system does not tell.
fn half_of_free_memory() -> u64 {
    const FALLBACK: u64 = 2 << 30;
    let Ok(info) = std::fs::read_to_string("/proc/meminfo") else {
        return FALLBACK;
    };
    info.lines()
        .find_map(|line| line.strip_prefix("MemAvailable:"))
        .and_then(|rest| rest.trim().strip_suffix("kB"))
        .and_then(|kib| kib.trim().parse::<u64>().ok())
        .map_or(FALLBACK, |kib| kib * 512)
}
