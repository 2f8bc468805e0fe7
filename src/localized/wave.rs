//! A localized wave and quantities derived from it.

use super::family::Family;
use super::series::{Series, largest};
use crate::numeric::find_root;

/// The property that alternates from contact to contact or from site to site.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Alternation {
    /// Unit masses; contact coefficients 1 and kappa >= 1.
    #[default]
    Stiffness,
    /// Unit coefficients; masses 1 and mu <= 1.
    Mass,
}

/// A ratio, named by the property that alternates.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ratio {
    /// Stiff over soft contact coefficient.
    Kappa(f64),
    /// Light over heavy mass.
    MassRatio(f64),
}

impl Ratio {
    pub fn value(self) -> f64 {
        match self {
            Ratio::Kappa(value) | Ratio::MassRatio(value) => value,
        }
    }
}

impl Alternation {
    /// Masses of the two sites of a cell.
    pub(super) fn masses(self, ratio: f64) -> [f64; 2] {
        match self {
            Alternation::Stiffness => [1.0, 1.0],
            Alternation::Mass => [1.0, ratio],
        }
    }

    /// Coefficients of the two contacts of a cell.
    pub(super) fn coefficients(self, ratio: f64) -> [f64; 2] {
        match self {
            Alternation::Stiffness => [1.0, ratio],
            Alternation::Mass => [1.0, 1.0],
        }
    }

    /// Names a value.
    pub fn ratio(self, value: f64) -> Ratio {
        match self {
            Alternation::Stiffness => Ratio::Kappa(value),
            Alternation::Mass => Ratio::MassRatio(value),
        }
    }
}

/// Error estimates of a localized wave.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Convergence {
    /// Relative change of the ratio when the resolution is raised.
    pub resolution_change: f64,
    /// Relative change of the ratio when the period is extended.
    pub period_change: f64,
    /// Largest residual of the integrated equations, relative to the largest overlap.
    pub residual: f64,
    /// Newton steps, all grids together.
    pub iterations: usize,
    /// Largest amplitude in the last tenth of the spectrum, relative to the largest.
    pub spectral_tail: f64,
    /// Largest force in the outer twentieth of the period on each side, relative to the peak.
    pub tail: f64,
    /// Grid points per period.
    pub points: usize,
    pub period: f64,
}

impl Convergence {
    /// Estimated relative error of the ratio.
    pub fn error(&self) -> f64 {
        self.resolution_change
            .max(self.period_change)
            .max(f64::EPSILON)
    }
}

/// A wave sampled at uniform times about its centre, at its two contacts and two sites.
///
/// Contact 0 is soft in a stiffness dimer and before the light site in a mass dimer. Time 0 is the
/// centre of the pulse at each contact; for both sites it is that of contact 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshot {
    /// In units of the time that the wave takes over a cell.
    pub time: Vec<f64>,
    pub overlap: [Vec<f64>; 2],
    /// `psi = F^{1/p}`.
    pub psi: [Vec<f64>; 2],
    pub force: [Vec<f64>; 2],
    pub velocity: [Vec<f64>; 2],
    /// As [`Wave::slow_part`].
    pub slow: Vec<f64>,
    /// As [`Wave::fast_part`].
    pub fast: Vec<f64>,
}

/// A localized wave at unit cell time: it travels over two contacts in the time 1.
///
/// A cell is site 0, contact 0 (soft, in a stiffness dimer), site 1 (light, in a mass dimer),
/// contact 1. In cell n, contact 0 has the overlap `overlap[0](t - n)`, contact 1 has
/// `overlap[1](t - n - 1/2)`, and site i has the velocity `velocity[i](t - n)`. Other amplitudes
/// follow from x(t) by scaling: `A x(A^{(p-1)/2} t)`.
#[derive(Debug, Clone)]
pub struct Wave {
    pub alternation: Alternation,
    pub exponent: f64,
    /// Number of maxima of the fast part; 1 for the homogeneous chain. For exponents near 1, where
    /// the slow part masks the maxima, the order of the Hertz wave from which this one was
    /// continued.
    pub order: usize,
    /// kappa or mu.
    pub ratio: f64,
    pub overlap: [Series; 2],
    pub force: [Series; 2],
    pub velocity: [Series; 2],
    pub convergence: Convergence,
}

impl Wave {
    /// Builds the wave from `psi = F^{1/p}` and F at both contacts.
    pub(super) fn new(
        Family {
            alternation,
            exponent,
        }: Family,
        ratio: f64,
        psi: [Series; 2],
        force: [Series; 2],
        convergence: Convergence,
    ) -> Wave {
        let [[before, after], masses] = [[0.5, -0.5], alternation.masses(ratio)];
        let pushed = [
            force[1].shifted(before).minus(&force[0]),
            force[0].minus(&force[1].shifted(after)),
        ];
        let coefficients = alternation.coefficients(ratio);
        let wave = Wave {
            alternation,
            exponent,
            order: 0,
            ratio,
            velocity: [0, 1].map(|i| pushed[i].scaled(1.0 / masses[i]).integral()),
            overlap: [0, 1].map(|i| psi[i].scaled(coefficients[i].powf(-1.0 / exponent))),
            force,
            convergence,
        };
        Wave {
            order: wave.maxima_of_fast_part(),
            ..wave
        }
    }

    pub(super) fn family(&self) -> Family {
        let (alternation, exponent) = (self.alternation, self.exponent);
        Family {
            alternation,
            exponent,
        }
    }

    /// kappa or mu, named.
    pub fn ratio(&self) -> Ratio {
        self.alternation.ratio(self.ratio)
    }

    pub fn masses(&self) -> [f64; 2] {
        self.alternation.masses(self.ratio)
    }

    pub fn coefficients(&self) -> [f64; 2] {
        self.alternation.coefficients(self.ratio)
    }

    /// `psi = F^{1/p}` at a contact, also where it is below 0.
    pub(super) fn psi(&self, contact: usize, time: f64) -> f64 {
        let scale = self.coefficients()[contact].powf(1.0 / self.exponent);
        scale * self.overlap[contact].value(time)
    }

    /// The slow part at time t: `psi` of a stiff contact without inertia,
    /// `[(F_0(t+h) + F_0(t-h))/2]^{1/p}`, or the mean of the overlaps on both sides of the light
    /// site.
    pub fn slow_part(&self, time: f64) -> f64 {
        match self.alternation {
            Alternation::Stiffness => {
                let [ahead, behind] = [0.5, -0.5].map(|h| self.force[0].value(time + h));
                (0.5 * (ahead + behind)).max(0.0).powf(1.0 / self.exponent)
            }
            Alternation::Mass => {
                0.5 * (self.overlap[0].value(time + 0.25) + self.overlap[1].value(time - 0.25))
            }
        }
    }

    /// The fast part at time t: `psi_1` minus the slow part in a stiffness dimer, the difference of
    /// the overlaps on both sides of the light site in a mass dimer.
    pub fn fast_part(&self, time: f64) -> f64 {
        match self.alternation {
            Alternation::Stiffness => self.psi(1, time) - self.slow_part(time),
            Alternation::Mass => {
                self.overlap[0].value(time + 0.25) - self.overlap[1].value(time - 0.25)
            }
        }
    }

    /// Counts rises followed by falls, both above the noise, where the force is above rounding.
    /// (Elsewhere, the root of rounding errors is noise.)
    fn maxima_of_fast_part(&self) -> usize {
        let end = 0.5 * self.overlap[0].period();
        let noise = (1e3 * self.convergence.spectral_tail).max(1e-12);
        let least = noise * Wave::peak(&self.force[0]).1;
        let values: Vec<f64> = (-COUNTING..=COUNTING)
            .map(|j| end * f64::from(j) / f64::from(COUNTING))
            .filter(|t| self.force[0].value(t.abs() - 0.5) > least)
            .map(|t| self.fast_part(t))
            .collect();
        let noise = 1e-5 * largest(&values);
        let (mut extreme, mut rising, mut maxima) = (f64::INFINITY, false, 0);
        for value in values {
            let beyond = if rising {
                value - extreme
            } else {
                extreme - value
            };
            if beyond > 0.0 {
                extreme = value;
            } else if beyond < -noise {
                maxima += usize::from(rising);
                (rising, extreme) = (!rising, value);
            }
        }
        maxima
    }

    /// Time and value of the maximum.
    pub fn peak(series: &Series) -> (f64, f64) {
        let end = 0.5 * series.period();
        let times = (-COUNTING..=COUNTING).map(|j| end * f64::from(j) / f64::from(COUNTING));
        let coarse = times.max_by(|a, b| series.value(*a).total_cmp(&series.value(*b)));
        let mut time = coarse.unwrap_or(0.0);
        let (slope, curvature) = (series.derivative(), series.derivative().derivative());
        for _ in 0..4 {
            time -= slope.value(time) / curvature.value(time);
        }
        (time, series.value(time))
    }

    /// Largest difference of a pulse from its mirror image about its peak, relative to the peak.
    pub fn asymmetry(series: &Series) -> f64 {
        let (centre, height) = Wave::peak(series);
        let lags = (0..=COUNTING).map(|j| series.period() * f64::from(j) / f64::from(4 * COUNTING));
        let off = lags.map(|lag| series.value(centre + lag) - series.value(centre - lag));
        largest(&off.collect::<Vec<f64>>()) / height
    }

    /// Full width at half height of the force in contact 0, in sites.
    pub fn width(&self) -> f64 {
        let force = &self.force[0];
        let (centre, height) = Wave::peak(force);
        let side = |direction: f64| {
            let excess = |lag: f64| force.value(centre + direction * lag) - 0.5 * height;
            let step = 0.5 * force.period() / f64::from(COUNTING);
            let inside = (1..).take_while(|j| excess(f64::from(*j) * step) > 0.0);
            let near = inside.count() as f64 * step;
            find_root(near, near + step, excess)
        };
        2.0 * (side(1.0) + side(-1.0))
    }

    /// `C` in `V = C F^{(p-1)/(2p)}`: speed in sites against the peak force in contact 0.
    pub fn speed_coefficient(&self) -> f64 {
        let (_, height) = Wave::peak(&self.force[0]);
        2.0 / height.powf((self.exponent - 1.0) / (2.0 * self.exponent))
    }

    /// Kinetic and contact energy at unit cell time, averaged over a cell; it scales as
    /// `V^{2(p+1)/(p-1)}`.
    pub fn energy(&self) -> f64 {
        let (p, masses, coefficients) = (self.exponent, self.masses(), self.coefficients());
        let density = |t: f64, i: usize| {
            let v = self.velocity[i].value(t);
            let overlap = self.overlap[i].value(t).max(0.0);
            0.5 * masses[i] * v * v + coefficients[i] * overlap.powf(p + 1.0) / (p + 1.0)
        };
        let period = self.overlap[0].period();
        let points = (period * 100.0).ceil();
        let times = (0..points as usize).map(|j| period * (j as f64 / points - 0.5));
        let densities = times.map(|t| density(t, 0) + density(t, 1));
        period / points * densities.sum::<f64>()
    }

    /// Momentum at unit cell time; it scales as `V^{(p+1)/(p-1)}`.
    pub fn momentum(&self) -> f64 {
        let masses = self.masses();
        masses[0] * self.velocity[0].total() + masses[1] * self.velocity[1].total()
    }

    /// The wave at `2 half + 1` times over its period; it is zero outside.
    pub fn profile(&self, half: usize) -> Snapshot {
        let end = 0.5 * self.overlap[0].period();
        let time: Vec<f64> = (0..=2 * half)
            .map(|j| end * (j as f64 / half as f64 - 1.0))
            .collect();
        let values = |f: &dyn Fn(f64) -> f64| time.iter().map(|t| f(*t)).collect::<Vec<f64>>();
        let force = |i: usize, t: f64| self.force[i].value(t).max(0.0);
        Snapshot {
            overlap: [0, 1].map(|i| values(&|t| self.overlap[i].value(t))),
            psi: [0, 1].map(|i| values(&|t| force(i, t).powf(1.0 / self.exponent))),
            force: [0, 1].map(|i| values(&|t| force(i, t))),
            velocity: [0, 1].map(|i| values(&|t| self.velocity[i].value(t))),
            slow: values(&|t| self.slow_part(t)),
            fast: values(&|t| self.fast_part(t)),
            time,
        }
    }
}

/// Samples per half period for the search of extrema.
const COUNTING: i32 = 1500;
