//! The passes over a prepared field: two chains that need nothing of each other, and their times.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::along::FLOOR;
use super::arrays::Outputs;
use super::columns::{AlongTime, TemporalPassResult};
use super::front::{self, WindowTransforms};
use super::intermediate::Intermediate;
use super::noise::KnownNoise;
use super::plan::Plan;
use super::reference::{References, first_with_energy};
use super::result::{BandEdge, FrontWindow, ShortTimeSpectra, Timing};
use super::rows::{self, SpatialPassResult};
use super::short_time;
use super::spacetime::{self, Frequencies};
use crate::diagnostics::quantile_of;
use crate::error::{Error, Result};
use crate::estimates::SpectrumInterval;
use crate::observer::Observer;
use crate::prepare::Prepared;
use crate::transform::Real;

/// What all passes have in common.
pub(super) struct Stages<'a> {
    pub plan: &'a Plan,
    pub prepared: &'a Prepared<'a>,
    /// Rows that set band edges.
    pub references: References,
    /// Noise that is subtracted from spectra along time.
    pub noise: Option<&'a KnownNoise>,
    /// By which powers are multiplied before they are stored.
    pub stored: f64,
    pub outputs: &'a Outputs<'a>,
    pub observer: &'a dyn Observer,
}

/// What transforms along time lead to.
#[derive(Default)]
pub(super) struct FromRecords {
    /// Where low frequencies end.
    pub edge: BandEdge,
    pub front: Option<FrontWindow>,
    /// Of the spectrum of the reference site.
    pub interval: Option<SpectrumInterval>,
    /// `None` where no transforms along time are needed.
    pub columns: Option<TemporalPassResult>,
    pub spacetime: Option<Frequencies>,
    /// The error of amplitudes, and of how many.
    pub checked: Option<(f64, usize)>,
}

/// What profiles and single records lead to.
pub(super) struct FromProfiles {
    /// Where low wavenumbers end.
    pub edge: BandEdge,
    pub rows: SpatialPassResult,
    pub short_time: Option<ShortTimeSpectra>,
    pub short_space: Option<ShortTimeSpectra>,
}

impl Stages<'_> {
    /// All passes. The two chains of passes run concurrently if memory allows, since one alone
    /// leaves threads idle at times.
    pub fn run<T: Real>(&self, clock: &mut Clock) -> Result<(FromRecords, FromProfiles)> {
        if !self.plan.interleaved {
            // Snapshots first: the page cache still holds part of a large field after the survey,
            // and loses it when a spill file is written.
            let profiles = self.profiles::<T>(clock)?;
            return Ok((self.records::<T>(clock)?, profiles));
        }
        let axes = &self.plan.axes;
        let is_made = usize::from(self.plan.request.results.spacetime);
        let units = axes.n_times + axes.n_sites + is_made * axes.frequency.len();
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
            || beside.timed(|clock| chains.records::<T>(clock)),
            || beside.timed(|clock| chains.profiles::<T>(clock)),
        );
        clock.timings.append(&mut first);
        clock.timings.append(&mut second);
        match (records, profiles) {
            // What stopped the other chain is the reason, not that it was stopped.
            (Err(Error::Cancelled), Err(error)) => Err(error),
            (records, profiles) => Ok((records?, profiles?)),
        }
    }

    /// The prepared record of a site.
    pub fn record(&self, site: usize) -> Vec<f64> {
        let mut record = vec![0.0; self.plan.axes.n_times];
        self.prepared.record(site, &mut record);
        record
    }

    /// Along time, then along space at each frequency; nothing where neither is needed.
    fn records<T: Real>(&self, clock: &mut Clock) -> Result<FromRecords> {
        let (plan, mut found) = (self.plan, FromRecords::default());
        if !plan.transforms_time() {
            return Ok(found);
        }
        let mut along_time = AlongTime::<T>::new(self);
        clock.lap(plan, "planning along time");
        if plan.request.results.temporal {
            self.look_at_reference(&along_time, &mut found);
            clock.lap(plan, "frequency band edge");
        }
        along_time.edge = found.edge.value();
        let passage = |of: FrontWindow| WindowTransforms::new(plan, of.samples, along_time.edge);
        along_time.passage = found.front.map(passage);
        let is_kept = plan.request.results.spacetime;
        let mut between = is_kept.then(|| Intermediate::new(plan)).transpose()?;
        let columns = along_time.transform_records(between.as_mut())?;
        clock.lap(plan, "along time");
        // Of a node there is rounding alone.
        let site = first_with_energy(&columns.energies, FLOOR);
        let ends = match between {
            None => "spot check",
            Some(_) => "space-time",
        };
        let (spacetime, checked) = rayon::join(
            || between.map(|of| spacetime::transform_frequencies(self, of)),
            || site.and_then(|site| along_time.spot_check(site)),
        );
        clock.lap(plan, ends);
        found.columns = Some(columns);
        found.spacetime = spacetime.transpose()?;
        found.checked = checked;
        Ok(found)
    }

    /// Where low frequencies end, how long windows at the front's passage are, and how well the spectrum is
    /// known.
    fn look_at_reference<T: Real>(&self, along_time: &AlongTime<T>, found: &mut FromRecords) {
        let (plan, site) = (self.plan, self.references.site);
        let reference = site.and_then(|site| Some((site, along_time.reference(site)?)));
        let record = reference.as_ref().map(|(_, (record, _))| &record[..]);
        found.front = front::window_of(plan, record);
        found.interval = record.and_then(|record| {
            SpectrumInterval::of_record(record, &plan.window_time, plan.segments)
        });
        let bin = 1.0 / (plan.segments.length as f64 * plan.axes.time.step);
        found.edge = edge(plan.request.band_edge_frequency, bin, || {
            let (site, (_, spectrum)) = reference?;
            let quantile = quantile_of(&spectrum, &plan.frequency_bins(), EDGE)?;
            Some((quantile, plan.place(site)))
        });
    }

    /// Where low wavenumbers end.
    fn wavenumber_edge<T: Real>(&self) -> BandEdge {
        let (plan, axes) = (self.plan, &self.plan.axes);
        let bin = std::f64::consts::TAU / (axes.n_sites as f64 * axes.space.step);
        edge(plan.request.band_edge_wavenumber, bin, || {
            let time = self.references.time?;
            let spectrum = rows::reference::<T>(plan, self.prepared, time);
            let quantile = quantile_of(&spectrum, &plan.wavenumber_bins(), EDGE)?;
            Some((quantile, (plan.times.start + time, axes.time.at(time))))
        })
    }

    /// Along space at each time, and short-time spectra.
    fn profiles<T: Real>(&self, clock: &mut Clock) -> Result<FromProfiles> {
        let (plan, results) = (self.plan, self.plan.request.results);
        let mut edge = BandEdge::default();
        if results.spatial {
            edge = self.wavenumber_edge::<T>();
            clock.lap(plan, "wavenumber band edge");
        }
        let rows = rows::transform_profiles::<T>(self, edge.value())?;
        clock.lap(plan, "along space");
        let (mut short_time, mut short_space) = (None, None);
        if results.short_time {
            short_time = Some(short_time::along_time::<T>(self)?);
            short_space = short_time::along_space::<T>(self)?;
            clock.lap(plan, "short-time");
        }
        Ok(FromProfiles {
            edge,
            rows,
            short_time,
            short_space,
        })
    }
}

/// The share of the reference's energy below the band edge.
const EDGE: f64 = 0.9;

/// Bins from 0 within which an edge is not resolved.
const RESOLVED: f64 = 3.0;

/// As it is given, else where the quantile of a reference is, with its index in the file and its coordinate; `bin` is the
/// distance between bins of the record without padding.
fn edge(
    given: Option<f64>,
    bin: f64,
    found: impl FnOnce() -> Option<(f64, (usize, f64))>,
) -> BandEdge {
    if let Some(value) = given {
        return BandEdge::Given { value };
    }
    match found() {
        None => BandEdge::Undefined,
        Some((value, (index, at))) if value <= RESOLVED * bin => BandEdge::Unresolved {
            value,
            index,
            at,
            bin,
        },
        Some((value, (index, at))) => BandEdge::Reference { value, index, at },
    }
}

/// An observer of concurrent chains of passes: stages have no names, since several run at once. A
/// chain that fails cancels the other.
struct Beside<'a> {
    observer: &'a dyn Observer,
    failed: AtomicBool,
}

impl Beside<'_> {
    /// A chain, and the times of its stages.
    fn timed<R>(&self, chain: impl FnOnce(&mut Clock) -> Result<R>) -> (Result<R>, Vec<Timing>) {
        let mut clock = Clock::new();
        let result = chain(&mut clock);
        if result.is_err() {
            self.failed.store(true, Ordering::Relaxed);
        }
        (result, clock.timings)
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
        let planned = planned.cloned().unwrap_or_default();
        self.timings.push(Timing {
            stage,
            seconds: self.since.elapsed().as_secs_f64(),
            bytes_read: planned.bytes_read,
            bytes_written: planned.bytes_written,
            transforms: planned.transforms,
            transform_length: planned.length,
        });
        self.since = Instant::now();
    }
}
