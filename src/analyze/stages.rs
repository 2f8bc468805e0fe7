//! The passes over a prepared field: two chains that need nothing of each other, and their times.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::between::{Between, Scratch};
use super::columns::{AlongTime, Columns};
use super::plan::Plan;
use super::result::{BandEdge, ShortTimeSpectra, Timing};
use super::rows::{self, Rows};
use super::sink::Sink;
use super::spacetime::{self, Frequencies};
use super::{Observer, short_time};
use crate::diagnostics::edge_of;
use crate::error::{Error, Result};
use crate::prepare::Prepared;
use crate::transform::Real;

/// What all passes have in common.
pub(super) struct Stages<'a> {
    pub plan: &'a Plan,
    pub prepared: &'a Prepared<'a>,
    /// By which powers are multiplied before they are stored.
    pub stored: f64,
    pub sink: &'a dyn Sink,
    pub observer: &'a dyn Observer,
}

/// What transforms along time lead to.
pub(super) struct FromRecords {
    /// Where low frequencies end; `None` where no spectra along time are wanted.
    pub edge: Option<BandEdge>,
    pub columns: Columns,
    pub spacetime: Option<Frequencies>,
    /// The error of amplitudes, and of how many.
    pub checked: Option<(f64, usize)>,
}

/// What profiles and single records lead to.
pub(super) struct FromProfiles {
    /// Where low wavenumbers end; `None` where no spectra along space are wanted.
    pub edge: Option<BandEdge>,
    pub rows: Rows,
    pub short_time: Option<ShortTimeSpectra>,
    pub short_space: Option<ShortTimeSpectra>,
}

impl Stages<'_> {
    /// All passes; side by side where there is memory for both chains, since one alone leaves threads
    /// waiting now and then.
    pub fn run<T: Real>(&self, clock: &mut Clock) -> Result<(Option<FromRecords>, FromProfiles)> {
        if !self.plan.side_by_side {
            // Profiles first: a large field was just looked at, and what the system still has of it in
            // memory goes once a scratch file is written.
            let profiles = self.profiles::<T>(clock)?;
            return Ok((self.records::<T>(clock)?, profiles));
        }
        let axes = &self.plan.axes;
        let frequencies = if self.plan.request.results.spacetime {
            axes.frequency.len()
        } else {
            0
        };
        let units = axes.n_times + axes.n_sites + frequencies;
        self.observer.stage("transforming", units as u64);
        let beside = Beside {
            observer: self.observer,
            failed: AtomicBool::new(false),
        };
        let chains = Stages {
            observer: &beside,
            ..*self
        };
        // A chain may wait for a thread, which is none of its time.
        let ((records, mut first), (profiles, mut second)) = rayon::join(
            || {
                let mut clock = Clock::new();
                let records = chains.records::<T>(&mut clock);
                (beside.noted(records), clock.timings)
            },
            || {
                let mut clock = Clock::new();
                let profiles = chains.profiles::<T>(&mut clock);
                (beside.noted(profiles), clock.timings)
            },
        );
        clock.timings.append(&mut first);
        clock.timings.append(&mut second);
        match (records, profiles) {
            // What stopped the other chain is the reason, not that it was stopped.
            (Err(Error::Cancelled), Err(error)) => Err(error),
            (records, profiles) => Ok((records?, profiles?)),
        }
    }

    /// Along time, then along space at each frequency; nothing where neither is needed.
    fn records<T: Real>(&self, clock: &mut Clock) -> Result<Option<FromRecords>> {
        let (plan, stored, sink, observer) = (self.plan, self.stored, self.sink, self.observer);
        if !plan.transforms_time() {
            return Ok(None);
        }
        let along_time = AlongTime::<T>::new(plan, self.prepared);
        clock.lap(plan, "planning along time");
        let edge = self.frequency_edge(&along_time)?;
        if edge.is_some() {
            clock.lap(plan, "frequency band edge");
        }
        let shape = (plan.between_rows(), plan.axes.n_sites);
        let mut between = match (plan.request.results.spacetime, plan.scratch_file) {
            (false, _) => None,
            (true, 0) => Some(Between::<T>::in_memory(shape)?),
            (true, _) => {
                let rows = plan.blocks.scratch * plan.segments.count();
                let scratch = Scratch::new(shape, plan.tiles.sites, rows)?;
                Some(Between::Scratch(scratch))
            }
        };
        let columns = along_time.transform_records(
            value_of(edge),
            stored,
            between.as_mut(),
            sink,
            observer,
        )?;
        clock.lap(plan, "along time");
        let site = columns.energies.iter().position(|&energy| energy > 0.0);
        let check = || site.and_then(|site| along_time.spot_check(site));
        let (spacetime, checked) = match &mut between {
            None => {
                let checked = check();
                clock.lap(plan, "spot check");
                (None, checked)
            }
            Some(between) => {
                let (seen, checked) = rayon::join(
                    || spacetime::transform_frequencies(plan, between, stored, sink, observer),
                    check,
                );
                clock.lap(plan, "space-time");
                (Some(seen?), checked)
            }
        };
        drop(between);
        Ok(Some(FromRecords {
            edge,
            columns,
            spacetime,
            checked,
        }))
    }

    /// Where low frequencies end; `None` where no spectra along time are wanted.
    fn frequency_edge<T: Real>(&self, along_time: &AlongTime<T>) -> Result<Option<BandEdge>> {
        let (plan, axes) = (self.plan, &self.plan.axes);
        if !plan.request.results.temporal {
            return Ok(None);
        }
        if let Some(value) = plan.request.band_edge_frequency {
            return Ok(Some(BandEdge::Given { value }));
        }
        let found = along_time.reference(self.observer)?;
        let place = |site| (plan.sites.start + site, axes.space.at(site));
        Ok(Some(edge_at(found, &axes.frequency, place)))
    }

    /// Where low wavenumbers end; `None` where no spectra along space are wanted.
    fn wavenumber_edge<T: Real>(&self) -> Result<Option<BandEdge>> {
        let (plan, axes) = (self.plan, &self.plan.axes);
        if !plan.request.results.spatial {
            return Ok(None);
        }
        if let Some(value) = plan.request.band_edge_wavenumber {
            return Ok(Some(BandEdge::Given { value }));
        }
        let found = rows::reference::<T>(plan, self.prepared, self.observer)?;
        let place = |time| (plan.times.start + time, axes.time.at(time));
        Ok(Some(edge_at(found, &axes.wavenumber, place)))
    }

    /// Along space at each time, and short-time spectra.
    fn profiles<T: Real>(&self, clock: &mut Clock) -> Result<FromProfiles> {
        let (plan, prepared, stored, observer) =
            (self.plan, self.prepared, self.stored, self.observer);
        let edge = self.wavenumber_edge::<T>()?;
        if edge.is_some() {
            clock.lap(plan, "wavenumber band edge");
        }
        let low = value_of(edge);
        let rows = rows::transform_profiles::<T>(plan, prepared, low, stored, self.sink, observer)?;
        clock.lap(plan, "along space");
        let (short_time, short_space) = if plan.request.results.short_time {
            let along = short_time::along_time::<T>(plan, prepared, stored, observer)?;
            let across = short_time::along_space::<T>(plan, prepared, stored, observer)?;
            clock.lap(plan, "short-time");
            (Some(along), across)
        } else {
            (None, None)
        };
        Ok(FromProfiles {
            edge,
            rows,
            short_time,
            short_space,
        })
    }
}

/// Below which 90 % of the energy of a reference spectrum lies, given with its index; `place` is that in the
/// file, and its coordinate.
fn edge_at(
    found: Option<(usize, Vec<f64>)>,
    axis: &[f64],
    place: impl Fn(usize) -> (usize, f64),
) -> BandEdge {
    let Some((row, spectrum)) = found else {
        return BandEdge::Undefined;
    };
    let (index, at) = place(row);
    BandEdge::Reference {
        value: edge_of(&spectrum, axis).unwrap_or(f64::NAN),
        index,
        at,
    }
}

/// NaN, below which nothing lies, where there is no edge.
fn value_of(edge: Option<BandEdge>) -> f64 {
    edge.map_or(f64::NAN, |edge| edge.value())
}

/// An observer of chains side by side: stages have no names, since several go on, and a chain that
/// fails stops the other.
struct Beside<'a> {
    observer: &'a dyn Observer,
    failed: AtomicBool,
}

impl Beside<'_> {
    fn noted<R>(&self, result: Result<R>) -> Result<R> {
        if result.is_err() {
            self.failed.store(true, Ordering::Relaxed);
        }
        result
    }
}

impl Observer for Beside<'_> {
    fn advance(&self, units: u64) {
        self.observer.advance(units);
    }

    fn cancelled(&self) -> bool {
        self.failed.load(Ordering::Relaxed) || self.observer.cancelled()
    }
}

/// Times the stages.
pub(super) struct Clock {
    since: Instant,
    pub timings: Vec<Timing>,
}

impl Clock {
    pub fn new() -> Self {
        Clock {
            since: Instant::now(),
            timings: Vec::new(),
        }
    }

    /// Ends `stage`; its traffic is that of the plan.
    pub fn lap(&mut self, plan: &Plan, stage: &'static str) {
        let planned = plan.stages.iter().find(|s| s.stage == stage);
        self.timings.push(Timing {
            stage,
            seconds: self.since.elapsed().as_secs_f64(),
            bytes_read: planned.map_or(0, |s| s.bytes_read),
            bytes_written: planned.map_or(0, |s| s.bytes_written),
            transforms: planned.map_or(0, |s| s.transforms),
            transform_length: planned.map_or(0, |s| s.length),
        });
        self.since = Instant::now();
    }
}
