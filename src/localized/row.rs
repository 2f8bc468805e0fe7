//! Results for one order.

use super::angle::Angle;
use super::published::Published;
use super::wave::{Convergence, Ratio, Wave};

/// Results for one order; all numbers are at unit cell time.
#[derive(Debug, Clone, serde::Serialize)]
pub struct OrderRow {
    pub order: usize,
    pub exact: Option<Exact>,
    /// Why `exact` is missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    pub asymptotic: Option<Asymptotic>,
    /// The minimum of the leak near this order; only if simulated chains show it.
    pub direct: Option<Direct>,
    /// The largest leak between this order and the next; only if simulated chains show both minima.
    pub most_dispersive: Option<Direct>,
    /// Only if cylinders were requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<Angle>,
    /// Only for stiffness dimers of Hertz contacts.
    pub published: Option<Published>,
    pub differences: Differences,
    #[serde(skip)]
    pub wave: Option<Wave>,
}

/// Properties of the localized wave.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Exact {
    #[serde(flatten)]
    pub ratio: Ratio,
    /// Estimated relative error of the ratio.
    pub error: f64,
    /// Correct significant digits of the ratio.
    pub digits: u32,
    #[serde(flatten)]
    pub convergence: Convergence,
    /// C of `V = C F^{(p-1)/(2p)}`, sites per unit of time against the peak force in contact 0.
    pub speed_coefficient: f64,
    /// Full width at half height of the force in contact 0, in sites.
    pub width: f64,
    pub energy: f64,
    pub momentum: f64,
    /// Largest difference of the velocity of site 0 from its mirror image, relative to its peak.
    pub velocity_asymmetry: f64,
    /// The same for the force in contact 0.
    pub force_asymmetry: f64,
}

/// Ratios from the asymptotic condition.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Asymptotic {
    pub exact_profile: f64,
    /// Only for Hertz contacts, which it was fitted for.
    pub fitted_profile: Option<f64>,
}

/// An extremum of the leak of simulated chains.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Direct {
    #[serde(flatten)]
    pub ratio: Ratio,
    /// Relative error of the ratio.
    pub error: f64,
    /// Relative loss of energy per cell at that ratio.
    pub leak: f64,
    /// Only if cylinders were requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<Angle>,
}

/// Relative differences from the exact ratio. `published_estimate` is relative to our estimate on
/// the same fitted profile.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
pub struct Differences {
    pub exact_profile: Option<f64>,
    pub fitted_profile: Option<f64>,
    pub direct: Option<f64>,
    pub published_direct: Option<f64>,
    pub published_estimate: Option<f64>,
}

impl Exact {
    /// Computes the properties of a wave.
    pub fn of(wave: &Wave) -> Exact {
        let error = wave.convergence.error();
        Exact {
            ratio: wave.ratio(),
            error,
            digits: (-error.log10()).floor().max(0.0) as u32,
            convergence: wave.convergence,
            speed_coefficient: wave.speed_coefficient(),
            width: wave.width(),
            energy: wave.energy(),
            momentum: wave.momentum(),
            velocity_asymmetry: Wave::asymmetry(&wave.velocity[0]),
            force_asymmetry: Wave::asymmetry(&wave.force[0]),
        }
    }
}

impl OrderRow {
    /// Fills in the differences.
    pub(super) fn compare(&mut self) {
        let off = |value: Option<f64>, from: Option<f64>| Some(value? / from? - 1.0);
        let exact = self.exact.map(|exact| exact.ratio.value());
        let fitted = self.asymptotic.and_then(|it| it.fitted_profile);
        self.differences = Differences {
            exact_profile: off(self.asymptotic.map(|it| it.exact_profile), exact),
            fitted_profile: off(fitted, exact),
            direct: off(self.direct.map(|it| it.ratio.value()), exact),
            published_direct: off(self.published.map(|it| it.direct), exact),
            published_estimate: off(self.published.map(|it| it.estimate), fitted),
        };
    }
}
