//! How a measurement is read.

use ndarray::ArrayView2;

use crate::chain::Chain;
use crate::error::{Error, Result};
use crate::system::memory::available_memory;

/// Where the level of the noise comes from.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Noise {
    /// The quiet part of each channel, before the wave arrives.
    #[default]
    Quiet,
    /// Stated: the standard deviation of white noise, and that of a constant offset.
    Stated { deviation: f64, offset: f64 },
}

/// What channels may drift by, beside their noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Drift {
    /// Stated: they do not.
    None,
    /// A constant offset each.
    Constant,
    /// An offset and a slope each. A slope too small to detect in the quiet part can matter later;
    /// the errors allow for it.
    #[default]
    Linear,
}

/// Relative standard uncertainties of gains, coefficients and masses. Each factor is `exp(u z)`
/// with an independent normal z. A list of u is empty (known exactly), one value for all, or one
/// value each.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Uncertainty {
    /// Of the gain of each channel.
    pub gain: Vec<f64>,
    /// Of the coefficient of each contact, in order of x: a wall's before site 0 is the first.
    pub coefficient: Vec<f64>,
    /// Of the mass of each site.
    pub mass: Vec<f64>,
}

impl Uncertainty {
    fn check(&self, chain: &Chain) -> Result<()> {
        let sites = chain.n_sites();
        let contacts = chain.n_contacts() + usize::from(chain.has_left_wall());
        for (option, list, count) in [
            ("gain-error", &self.gain, sites),
            ("coefficient-error", &self.coefficient, contacts),
            ("mass-error", &self.mass, sites),
        ] {
            let (fits, number) = (list.len() <= 1 || list.len() == count, list.len());
            Error::require(
                fits,
                option,
                format!("one value for all, or {count}"),
                number,
            )?;
            if let Some(share) = list.iter().find(|share| !(0.0..1.0).contains(*share)) {
                let expected = "shares of 0 or more, below 1";
                return Err(Error::request(option, expected, share));
            }
        }
        Ok(())
    }
}

/// How a measurement is read.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredOptions {
    /// Sample of the record at which all contacts just touch; earlier samples only serve to
    /// estimate the noise.
    pub start: usize,
    pub noise: Noise,
    /// Estimated from quiet parts only, so not if the noise is stated.
    pub drift: Drift,
    pub uncertainty: Uncertainty,
    /// Sites whose channel is known to be dead, beside those that record nothing but zeros or gaps.
    pub missing: Vec<usize>,
    /// Repetitions with new noise, gains, coefficients and masses that errors are found from.
    pub repetitions: usize,
    pub seed: u64,
    /// Worker threads; `None`: one a core. The results do not depend on it.
    pub threads: Option<usize>,
}

impl Default for MeasuredOptions {
    fn default() -> Self {
        MeasuredOptions {
            start: 0,
            noise: Noise::Quiet,
            drift: Drift::Linear,
            uncertainty: Uncertainty::default(),
            missing: Vec::new(),
            repetitions: 48,
            seed: 1,
            threads: None,
        }
    }
}

impl MeasuredOptions {
    /// # Errors
    /// [`Error::Request`] naming what does not fit.
    pub(super) fn check(
        &self,
        record: ArrayView2<f64>,
        [t0, dt]: [f64; 2],
        chain: &Chain,
    ) -> Result<()> {
        chain.check()?;
        let has_none = chain.resonators().is_none();
        let expected = "a chain without resonators, which velocities of the bodies do not tell";
        Error::require(has_none, "resonator_mass", expected, "resonators")?;
        let ((samples, n), sites) = (record.dim(), chain.n_sites());
        let expected = format!("{sites} sites, as the chain has");
        Error::require(n == sites, "field", expected, n)?;
        let enough = samples >= self.start.saturating_add(4);
        let expected = "4 samples or more from the start of the motion on";
        let found = format!("{samples}, start {}", self.start);
        Error::require(enough, "field", expected, found)?;
        let is_step = dt > 0.0 && dt.is_finite() && t0.is_finite();
        Error::require(is_step, "dt", "a positive step of time", dt)?;
        let repetitions = self.repetitions;
        Error::require(repetitions >= 8, "repetitions", "8 or more", repetitions)?;
        if let Noise::Stated { deviation, offset } = self.noise {
            let (is_one, found) = (
                |v: f64| v >= 0.0 && v.is_finite(),
                format!("{deviation}, {offset}"),
            );
            let are = is_one(deviation) && is_one(offset);
            Error::require(are, "noise", "deviations of 0 or more", found)?;
        }
        self.uncertainty.check(chain)?;
        if let Some(site) = self.missing.iter().find(|site| **site >= n) {
            let expected = format!("sites 0 to {}", n - 1);
            return Err(Error::request("missing", expected, site));
        }
        check_memory(samples, chain)
    }
}

/// Arrays of a result, of its errors, of its half and of a batch of repetitions.
pub(super) fn check_memory(samples: usize, chain: &Chain) -> Result<()> {
    let columns = 4 * chain.n_sites() as u64 + 6 * chain.n_contacts() as u64;
    let needed = (samples as u64).saturating_mul(8 * 7 * columns);
    let what = "the measured motion with its errors";
    Error::beyond_memory(what, needed, available_memory())
}
