//! The passes over a prepared field: two chains that need nothing of each other, and their times.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::between::{Between, Scratch};
use super::columns::{AlongTime, Columns};
use super::plan::Plan;
use super::result::{ShortTimeSpectra, Timing};
use super::rows::{self, Rows};
use super::sink::Sink;
use super::spacetime::{self, Frequencies};
use super::{Observer, short_time};
use crate::error::{Error, Result};
use crate::prepare::Prepared;
use crate::transform::Real;

/// What all passes have in common.
pub(super) struct Stages<'a> {
    pub plan: &'a Plan,
    pub prepared: &'a Prepared<'a>,
    /// By which powers are multiplied before they are stored.
    pub stored: f64,
    pub frequency_edge: f64,
    pub wavenumber_edge: f64,
    pub sink: &'a dyn Sink,
    pub observer: &'a dyn Observer,
}

/// What transforms along time lead to.
pub(super) struct FromRecords {
    pub columns: Columns,
    pub spacetime: Option<Frequencies>,
    /// The error of amplitudes, and of how many.
    pub checked: Option<(f64, usize)>,
}

/// What profiles and single records lead to.
pub(super) struct FromProfiles {
    pub rows: Rows,
    pub short_time: Option<ShortTimeSpectra>,
    pub short_space: Option<ShortTimeSpectra>,
}

impl Stages<'_> {
    /// All passes; side by side where there is memory for both chains, since one alone leaves threads
    /// waiting now and then.
    pub fn run<T: Real>(
        &self,
        along_time: Option<&AlongTime<T>>,
        clock: &mut Clock,
    ) -> Result<(Option<FromRecords>, FromProfiles)> {
        if !self.plan.side_by_side {
            // Profiles first: a large field was just looked at, and what the system still has of it in
            // memory goes once a scratch file is written.
            let profiles = self.profiles::<T>(clock)?;
            let records = along_time.map(|along_time| self.records(along_time, clock));
            return Ok((records.transpose()?, profiles));
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
                let records = along_time.map(|along_time| chains.records(along_time, &mut clock));
                (beside.noted(records.transpose()), clock.timings)
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

    /// Along time, then along space at each frequency.
    fn records<T: Real>(
        &self,
        along_time: &AlongTime<T>,
        clock: &mut Clock,
    ) -> Result<FromRecords> {
        let (plan, stored, sink, observer) = (self.plan, self.stored, self.sink, self.observer);
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
        let edge = self.frequency_edge;
        let columns =
            along_time.transform_records(edge, stored, between.as_mut(), sink, observer)?;
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
        Ok(FromRecords {
            columns,
            spacetime,
            checked,
        })
    }

    /// Along space at each time, and short-time spectra.
    fn profiles<T: Real>(&self, clock: &mut Clock) -> Result<FromProfiles> {
        let (plan, prepared, stored, observer) =
            (self.plan, self.prepared, self.stored, self.observer);
        let edge = self.wavenumber_edge;
        let rows =
            rows::transform_profiles::<T>(plan, prepared, edge, stored, self.sink, observer)?;
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
            rows,
            short_time,
            short_space,
        })
    }
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
