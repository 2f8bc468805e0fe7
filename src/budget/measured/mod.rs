//! Budgets of a measured chain from its velocities, masses and contact law, with standard errors.
//!
//! The record is `g_j v_j + b_j + s_j t + noise` at each site j: gain, offset and slope.
//! Displacements are integrals of the velocities from t0 on, when all contacts just touch (or carry
//! their static force); with them come overlaps, forces, fluxes and energies, from which a
//! [`Motion`] for every budget is made. A site is at rest until the wave arrives. Before that its
//! channel records noise and drift. Both, and the stated uncertainties of gains, coefficients and
//! masses ([`Uncertainty`]), are propagated to all results: to [`MeasuredMotion::errors`], and by
//! [`MeasuredMotion::run`] to every number over wavenumbers, frequencies and scales.
//! [`from_field`] refuses a measurement that is all below noise; a warning names contacts whose force is.
//!
//! [`MeasuredReport::energy`] is the energy put into the chain: the median over the record of total
//! energy plus losses, less the bias that noise adds to squares. The largest energy over time would
//! be biased by its noise.

mod derive;
mod drift;
mod estimate;
mod missing;
mod momentum;
mod noise;
mod options;
mod quiet;
mod repetitions;
mod report;
mod spectral;

use std::collections::BTreeSet;

use ndarray::{Array1, Array2, ArrayView2, s};

use super::motion::Motion;
use crate::chain::Chain;
use crate::error::{Error, Result};
use crate::field::{Field, Quantity};
use derive::Derived;
pub use derive::MotionArrays;
pub use momentum::{Factor, Momentum, SiteMomentum};
use noise::Channels;
pub use noise::SiteNoise;
pub use options::{Drift, MeasuredOptions, Noise, Uncertainty};
use repetitions::Measurement;
pub use report::{ContactEstimate, Estimate, Lack, MeasuredReport, MeasuredWarning, MissingSite};

/// A measured motion of a chain.
#[derive(Debug, Clone)]
pub struct MeasuredMotion {
    pub time: Array1<f64>,
    /// From the static state, `(time, site)`.
    pub displacement: Array2<f64>,
    pub values: MotionArrays,
    /// Standard errors of all these.
    pub errors: MotionArrays,
    pub report: MeasuredReport,
    /// What losses took by the end.
    lost: f64,
    measurement: Measurement,
}

impl MeasuredMotion {
    /// The motion that budgets are made from.
    pub fn motion(&self) -> Motion<'_> {
        let (x, v) = (&self.displacement, &self.values.velocity);
        derive::motion(&self.measurement.chain, self.time.view(), x, v)
    }
}

/// The motion of `chain` that a field of velocities `(time, site)` is the record of, in units in
/// which the chain's masses and coefficients are stated.
///
/// # Errors
/// As [`from_velocities`]; [`Error::Request`] for a field of another quantity.
pub fn from_field(
    field: &Field,
    chain: &Chain,
    options: &MeasuredOptions,
) -> Result<MeasuredMotion> {
    let are_velocities = field.quantity == Quantity::Velocity;
    let expected = "velocities, which displacements are the integrals of";
    let found = format!("{:?}", field.quantity).to_lowercase();
    Error::require(are_velocities, "quantity", expected, found)?;
    let (samples, n) = (field.n_times(), field.n_sites());
    options::check_memory(samples, chain)?;
    let mut values = vec![0.0; samples * n];
    field.read_time_major(0..samples, 0..n, &mut values);
    let record = ArrayView2::from_shape((samples, n), &values)
        .map_err(|error| Error::request("field", "times by sites", error))?;
    from_velocities(record, [field.time.origin, field.time.step], chain, options)
}

/// The same from velocities at times `t0 + n dt`.
///
/// # Errors
/// [`Error::Request`] for a record that does not fit the chain, that has no quiet part in any
/// channel, or in which nothing moves; [`Error::NonFinite`] for channels with gaps;
/// [`Error::Unresolved`] where noise leaves nothing of all forces or of the energy;
/// [`Error::Memory`]; [`Error::Failed`].
pub fn from_velocities(
    record: ArrayView2<f64>,
    [t0, dt]: [f64; 2],
    chain: &Chain,
    options: &MeasuredOptions,
) -> Result<MeasuredMotion> {
    options.check(record, [t0, dt], chain)?;
    let (record, missing, channels) = channels(record, chain, options)?;
    crate::system::threads::in_pool(options.threads, || {
        let mut velocity = record.slice(s![options.start.., ..]).to_owned();
        for (j, site) in channels.sites.iter().enumerate() {
            let still = site.rest_samples.saturating_sub(options.start);
            for (i, v) in velocity.column_mut(j).iter_mut().enumerate() {
                *v = match i < still || missing[j] {
                    true => 0.0,
                    false => *v - site.offset - site.slope * i as f64,
                };
            }
        }
        let measurement = Measurement {
            chain: chain.clone(),
            dt,
            channels,
            missing,
            options: options.clone(),
        };
        let mut derived = Derived::of(chain, dt, velocity, &measurement.missing);
        let (errors, fits, given) = measurement.errors(&derived);
        let momentum = Momentum::of(&derived, &errors, &fits);
        let report = report::of(&derived, &errors, &measurement, momentum, given)?;
        // Nobody reads it any more.
        derived.values.unbalanced = Array2::default((0, 0));
        let last = derived.given.len() - 1;
        let first = t0 + dt * options.start as f64;
        Ok(MeasuredMotion {
            time: (0..=last).map(|i| first + dt * i as f64).collect(),
            lost: derived.given[last] - derived.values.energy[[last, 0]],
            displacement: derived.displacement,
            values: derived.values,
            errors,
            report,
            measurement,
        })
    })
}

/// The record without gaps, the dead channels, and the noise and drift of the others.
fn channels(
    record: ArrayView2<f64>,
    chain: &Chain,
    options: &MeasuredOptions,
) -> Result<(Array2<f64>, Vec<bool>, Channels)> {
    let n = record.ncols();
    let all = |j: usize, is: fn(&f64) -> bool| record.column(j).iter().all(is);
    let silent: Vec<bool> = (0..n).map(|j| all(j, |v| *v == 0.0)).collect();
    let dead = |j: usize| {
        // A channel of zeros is dead if a later channel records the wave.
        let passed = silent[j] && silent[j + 1..].contains(&false);
        passed || options.missing.contains(&j) || all(j, |v| v.is_nan())
    };
    let mut missing: Vec<bool> = (0..n).map(dead).collect();
    let mut record = record.to_owned();
    for j in (0..n).filter(|j| missing[*j]) {
        record.column_mut(j).fill(0.0);
    }
    let broken = record.indexed_iter().filter(|(_, v)| !v.is_finite());
    let broken: Vec<(usize, usize)> = broken.map(|(at, _)| at).collect();
    if let Some(&first) = broken.first() {
        let sites: BTreeSet<usize> = broken.iter().map(|(_, site)| *site).collect();
        return Err(Error::NonFinite {
            name: "the velocities".into(),
            count: broken.len() as u64,
            first,
            sites: sites.len(),
            n_sites: n,
        });
    }
    let mut channels = Channels::of(record.view(), &missing, options)?;
    // If others record noise, a channel of zeros is not a site at rest.
    let is_noisy = |j: usize| !silent[j] && channels.sites[j].deviation > 0.0;
    let is_late = |j: usize| silent[j] && !missing[j];
    if (0..n).any(is_noisy) && (0..n).any(is_late) {
        missing = (0..n).map(|j| missing[j] || silent[j]).collect();
        channels = Channels::of(record.view(), &missing, options)?;
    }
    missing::check(chain, &missing)?;
    let is_reached = |j: usize| !missing[j] && channels.sites[j].arrival.is_some();
    let is_any = options.noise != Noise::Quiet || (0..n).any(is_reached);
    let expected = "a wave above the noise of at least one channel";
    let found = "none that chance does not explain";
    Error::require(is_any, "field", expected, found)?;
    Ok((record, missing, channels))
}
