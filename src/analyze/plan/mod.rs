//! The plan: a request held against a field, with every size settled, before anything is computed.

mod checks;
mod memory;

use std::ops::Range;

use serde::Serialize;

use super::arrays::keep;
use super::axes::Axes;
use super::dispersion::{self, DispersionCurve};
use super::request::Request;
use super::result::Conventions;
use super::{display, short_time};
use crate::arrays::{LargeArray, Precision};
use crate::diagnostics::{Bins, MAP_LIMIT};
use crate::error::{Error, Result};
use crate::field::{Axis, Field, Quantity};
use crate::prepare::{Tiles, survey_bytes};
use crate::transform::{
    Real, RecordTransform, Scale, Segments, frequencies, wavenumbers, wavenumbers_signed,
};
use checks::{
    check_axes, check_references, direction_band, padded, segments, site_range, time_range,
};

pub(super) use checks::checked_window;

/// What will be computed, in which blocks, with which transforms; see [`plan`].
#[derive(Debug, Clone)]
pub struct Plan {
    pub(crate) times: Range<usize>,
    pub(crate) sites: Range<usize>,
    pub(crate) request: Request,
    pub(crate) segments: Segments,
    /// Of short-time spectra along time and along space.
    pub(super) short_time: [Segments; 2],
    pub(crate) window_time: Vec<f64>,
    pub(crate) window_space: Vec<f64>,
    pub(crate) axes: Axes,
    pub(crate) conventions: Conventions,
    /// The flux surrogate was requested for a field that is not a velocity.
    pub(crate) flux_refused: bool,
    pub(crate) direction_band: (f64, f64),
    pub(crate) dispersion: Vec<DispersionCurve>,
    pub(crate) time_scale: Scale,
    pub(crate) space_scale: Scale,
    pub(crate) tiles: Tiles,
    pub(crate) blocks: Blocks,
    /// Whether maps are collected in cells so fine that parts of them can be shown.
    pub(crate) has_fine_maps: bool,
    /// Whether passes over records and over profiles go at the same time.
    pub(crate) interleaved: bool,
    pub threads: usize,
    /// Bytes of working memory that the blocks will use, by estimate.
    pub memory_needed: u64,
    /// Of it, what spectra of front windows may take.
    pub(super) answer_bytes: u64,
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
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct Blocks {
    /// Records at once, in transforms along time.
    pub sites: usize,
    /// Profiles at once, in transforms along space.
    pub times: usize,
    /// Frequencies at once, in the second half of space-time transforms.
    pub frequencies: usize,
    /// Frequencies that are read at once from a scratch file; 0 without one.
    pub scratch: usize,
}

/// The transforms of one stage.
#[derive(Debug, Clone, Default, Serialize)]
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

/// Settles `request` for `field`.
///
/// Reads samples only where the range of times depends on them, as in
/// [`TimeRange::UntilArrival`](super::TimeRange::UntilArrival).
///
/// # Errors
/// [`crate::Error::Request`] names the option that does not fit; [`crate::Error::Memory`] where not even the
/// smallest blocks fit the memory allowed.
pub fn plan(field: &Field, request: &Request) -> Result<Plan> {
    field.check_axes()?;
    let sites = site_range(field, request)?;
    let times = time_range(field, request, &sites)?;
    let (n_times, n_sites) = (times.len(), sites.len());

    let segments = segments(request, n_times)?;
    let padded_time = padded("pad-time", request.pad_time, segments.length)?;
    let padded_space = padded("pad-space", request.pad_space, n_sites)?;
    check_references(field, request, &times, &sites)?;
    let short_time = short_time::segments(request, n_times, n_sites)?;
    let window_time = checked_window("window-time", request.window_time, segments.length)?;
    let window_space = checked_window("window-space", request.window_space, n_sites)?;
    // What is loaded already counts where the memory was stated; what is free is beside it.
    let loaded = request.memory.map_or(0, |_| field.loaded_bytes());
    let memory_allowed = match request.memory {
        Some(stated) => stated.saturating_sub(loaded),
        None => crate::system::memory::half_of_free_memory(),
    };
    check_axes(padded_time, padded_space, memory_allowed)?;
    let axes = Axes {
        frequency: frequencies(padded_time, field.time.step),
        wavenumber: wavenumbers(padded_space, field.space.step),
        wavenumber_signed: wavenumbers_signed(padded_space, field.space.step),
        time: shifted(&field.time, times.start),
        n_times,
        space: shifted(&field.space, sites.start),
        n_sites,
    };
    display::check(request, &axes)?;
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
    let direction_band = direction_band(request.direction_band, &axes.frequency)?;
    let (scaling, dt, dx) = (request.scaling, axes.time.step, axes.space.step);
    let time_scale = Scale::along_time(scaling, &window_time, n_times, padded_time, dt);
    let space_scale = Scale::along_space(scaling, &window_space, padded_space, dx);
    let dispersion = dispersion::curves(field, request, &axes)?;
    let kinetic = field.quantity == Quantity::Velocity;
    let mut request = request.clone();
    let flux_refused = request.results.flux_surrogate && !kinetic;
    request.results.flux_surrogate &= kinetic;
    let arrays = LargeArray::OF_ANALYSES.into_iter();
    let arrays = arrays.filter(|array| request.results.has(*array));
    let arrays = arrays.map(|array| (array, axes.shape(array))).collect();
    let mut plan = Plan {
        flux_refused,
        times,
        sites,
        request,
        segments,
        short_time,
        window_time,
        window_space,
        axes,
        conventions,
        direction_band,
        dispersion,
        time_scale,
        space_scale,
        tiles: Tiles {
            sites: TILE_SITES,
            times: TILE_TIMES,
            ahead: None,
            memory: memory_allowed / 4,
        },
        blocks: Blocks::default(),
        has_fine_maps: false,
        interleaved: false,
        threads,
        memory_needed: 0,
        answer_bytes: 0,
        memory_allowed,
        scratch_file: 0,
        stages: Vec::new(),
        arrays,
    };
    plan.list_stages();
    plan.fit_into_memory(survey_bytes(field, n_sites), field.is_time_major())
        .map_err(|error| error.beside(loaded))?;
    plan.memory_needed += loaded;
    plan.memory_allowed += loaded;
    Ok(plan)
}

impl Plan {
    /// That the plan is one of this field.
    ///
    /// # Errors
    /// [`crate::Error::Request`].
    pub(super) fn check(&self, field: &Field) -> Result<()> {
        let is_inside = self.times.end <= field.n_times() && self.sites.end <= field.n_sites();
        let is_own = is_inside
            && self.axes.time == shifted(&field.time, self.times.start)
            && self.axes.space == shifted(&field.space, self.sites.start);
        let size = |times: usize, sites: usize| format!("{times} times by {sites} sites");
        let planned = size(self.axes.n_times, self.axes.n_sites);
        let expected = format!("a field with the axes of the plan, {planned}: plan this one");
        let found = size(field.n_times(), field.n_sites()) + " of " + &field.name;
        Error::require(is_own, "plan", expected, found)
    }

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

    /// The intervals of the frequency axis.
    pub(crate) fn frequency_bins(&self) -> Bins<'_> {
        let padded = self.conventions.padded_time;
        let step = 1.0 / (padded as f64 * self.axes.time.step);
        Bins::new(&self.axes.frequency, padded, step)
    }

    /// The intervals of the wavenumber axis.
    pub(crate) fn wavenumber_bins(&self) -> Bins<'_> {
        let padded = self.conventions.padded_space;
        let step = std::f64::consts::TAU / (padded as f64 * self.axes.space.step);
        Bins::new(&self.axes.wavenumber, padded, step)
    }

    /// By how much records (or segments) become longer by zeros.
    pub(crate) fn padding_time(&self) -> f64 {
        self.conventions.padded_time as f64 / self.segments.length as f64
    }

    /// By how much profiles become longer by zeros.
    pub(crate) fn padding_space(&self) -> f64 {
        self.conventions.padded_space as f64 / self.axes.n_sites as f64
    }

    /// Index in the file and coordinate of a site of the range analyzed.
    pub(super) fn place(&self, site: usize) -> (usize, f64) {
        (self.sites.start + site, self.axes.space.at(site))
    }

    /// The transform of profiles.
    pub(crate) fn profile_transform<T: Real>(&self) -> RecordTransform<T> {
        RecordTransform::new(&self.window_space, self.conventions.padded_space)
    }

    /// Whether transforms along time are made at all.
    pub(crate) fn transforms_time(&self) -> bool {
        self.request.results.temporal || self.request.results.spacetime
    }

    /// Whether transforms along space of each instant are made at all.
    pub(crate) fn transforms_space(&self) -> bool {
        self.request.results.spatial || self.request.results.flux_surrogate
    }

    /// Whether a site of the range analyzed, counted from its first, is left out on request.
    pub fn is_left_out(&self, row: usize) -> bool {
        let site = self.sites.start + row;
        self.request.without_sites.contains(&site)
    }

    /// Whether the field is read piece by piece, and its pages are released.
    pub fn streams(&self) -> bool {
        self.tiles.ahead.is_some()
    }

    /// Sizes of the blocks that pass through memory.
    pub fn blocks(&self) -> Blocks {
        self.blocks
    }

    /// The plan as data, for programs.
    pub fn describe(&self) -> PlanSummary<'_> {
        let arrays = self.arrays.iter();
        let arrays = arrays.map(|&(array, (rows, columns))| (array.name(), [rows, columns]));
        PlanSummary {
            times: [self.times.start, self.times.end],
            sites: [self.sites.start, self.sites.end],
            stages: &self.stages,
            arrays: arrays.collect(),
            blocks: self.blocks,
            threads: self.threads,
            memory_needed: self.memory_needed,
            memory_allowed: self.memory_allowed,
            scratch_file: self.scratch_file,
        }
    }

    /// Arrays of which there are maps, with their shapes; none without figures.
    pub(super) fn mapped(&self) -> impl Iterator<Item = (LargeArray, (usize, usize))> {
        let samples = LargeArray::SAMPLES;
        let arrays = self.arrays.iter().copied();
        let all = arrays.chain([(samples, self.axes.shape(samples))]);
        all.filter(|_| self.request.maps)
    }

    pub(super) fn map_limit(&self, array: LargeArray, shape: (usize, usize)) -> (usize, usize) {
        match self.has_fine_maps {
            true => keep(array).fine_limit(shape),
            false => MAP_LIMIT,
        }
    }

    /// The transforms of each stage.
    fn list_stages(&mut self) {
        let (nt, nx) = (self.axes.n_times, self.axes.n_sites);
        let item = self.complex_bytes() / 2;
        let bytes_of = |chosen: LargeArray| {
            let arrays = self.arrays.iter().filter(|(array, _)| *array == chosen);
            arrays
                .map(|(_, (rows, columns))| (rows * columns) as u64 * item)
                .sum::<u64>()
        };
        let field_bytes = 8 * (nt * nx) as u64;
        let between = self.between_rows() as u64 * nx as u64 * self.complex_bytes();
        let temporal = bytes_of(LargeArray::TEMPORAL_SPECTRUM);
        let spatial =
            bytes_of(LargeArray::SPATIAL_SPECTRUM) + bytes_of(LargeArray::KINETIC_FLUX_SURROGATE);
        let spacetime = self.request.results.spacetime;
        let [time, space] = [self.conventions.padded_time, self.conventions.padded_space];
        let stage = |stage, transforms: usize, length, bytes: [u64; 2]| PlannedStage {
            stage,
            transforms: transforms as u64,
            length,
            bytes_read: bytes[0],
            bytes_written: bytes[1],
        };
        let mut stages = Vec::new();
        if self.transforms_time() {
            let records = nx * self.segments.count();
            let bytes = [field_bytes, if spacetime { between } else { temporal }];
            stages.push(stage("along time", records, time, bytes));
        }
        let is_made = usize::from(self.transforms_space());
        let bytes = [field_bytes, spatial];
        stages.push(stage("along space", is_made * nt, is_made * space, bytes));
        if spacetime {
            let written = bytes_of(LargeArray::SPACETIME_SPECTRUM) + temporal;
            let bytes = [between, written];
            stages.push(stage("space-time", self.between_rows(), space, bytes));
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
