//! The fraction of the energy passed above a frequency.

use crate::arrays::Nowhere;
use crate::budget::{self, BudgetRequest, Motion, Views};
use crate::chain::{EndTime, Record, Simulation};
use crate::observer::{CancelOnly, Observer, Silent};
use crate::{Error, Result};

/// Samples of a run for power-flow spectra.
const SAMPLES: usize = 8192;

/// Duration of the force record of the first contact, in contact times.
const FIRST: f64 = 200.0;

/// Bytes that such a run may take; longer chains have fewer samples.
const MEMORY: u64 = 512 << 20;

/// `1 - sum_{f <= edge} P_j(f) df / W_j` for every contact j. P is the power-flow spectrum of the
/// record from 0 to `end` (`budget::FrequencyFlow`), W the energy passed. P can be negative in a
/// bin, so a share can be negative too. NaN where nothing passed.
pub(super) fn high_shares(
    simulation: &Simulation,
    end: f64,
    edge: f64,
    observer: &dyn Observer,
) -> Result<Vec<f64>> {
    let flow = flow(simulation, end, Some(edge), observer)?;
    let passed = |j: usize| flow.passed(j);
    Ok((0..flow.high.len())
        .map(|j| flow.high[j] / passed(j))
        .collect())
}

/// The frequency below which 90 % of the spectral energy of the first contact's force lies. Its
/// resolution is the inverse of [`FIRST`] contact times.
pub(super) fn default_edge(simulation: &Simulation) -> Result<f64> {
    let end = FIRST * simulation.contact_time(simulation.speed());
    Ok(flow(simulation, end, None, &Silent)?.edge)
}

fn flow(
    simulation: &Simulation,
    end: f64,
    edge: Option<f64>,
    observer: &dyn Observer,
) -> Result<budget::FrequencyFlow> {
    let mut sampled = simulation.clone();
    sampled.end_time = EndTime::At(end);
    sampled.record = Record {
        displacement: true,
        force: false,
        energy: false,
    };
    sampled.samples = SAMPLES;
    sampled.estimate_error = false;
    sampled.memory = None;
    while sampled.bytes() > MEMORY && sampled.samples > 512 {
        sampled.samples /= 2;
    }
    let run = sampled.run(&CancelOnly(observer))?;
    let motion = Motion::of(&run)?;
    let request = BudgetRequest {
        views: Views {
            wavenumber: false,
            frequency: true,
            scale: false,
        },
        band_edge_frequency: edge,
        ..BudgetRequest::default()
    };
    let quiet = CancelOnly(observer);
    let found = budget::run(&motion, &request, &Nowhere, &quiet)?;
    let missing = || Error::request("band-edge-frequency", "a power flow", "none");
    found.frequency.ok_or_else(missing)
}
