//! Simulated velocities with noise, drift and gains of their own, and how far what is found from them
//! is off in stated errors.

use ndarray::{Array2, ArrayView2};
use wavecascade::budget::measured::{MeasuredMotion, MeasuredOptions, from_velocities};
use wavecascade::chain::{Accuracy, Chain, Run, Simulation};
use wavecascade::observer::Silent;

/// Stiffness ratios of a localized and of a dispersive chain.
pub const LOCALIZED: f64 = 4.9272;
pub const DISPERSIVE: f64 = 2.398;

/// A striker of unit speed on a dimer.
pub fn simulated(sites: usize, ratio: f64, end: f64, samples: usize) -> Run {
    let mut simulation = Simulation::impact(Chain::dimer(sites, ratio), 1.0, end, samples);
    simulation.accuracy = Accuracy::LocalError(1e-10);
    simulation.estimate_error = false;
    simulation.run(&Silent).unwrap()
}

pub fn step(run: &Run) -> f64 {
    run.time[1]
}

/// Random numbers: SplitMix64 (G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014), normal ones of variance 1 by the method of Box and
/// Muller.
pub struct Normal(pub u64);

impl Normal {
    /// Above 0, up to 1.
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (((bits ^ (bits >> 31)) >> 11) + 1) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    pub fn draw(&mut self) -> f64 {
        let (a, b) = (self.uniform(), self.uniform());
        (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }
}

#[derive(Debug, Clone, Copy, Default)]
pub struct Spoilt {
    pub noise: f64,
    /// Deviations over channels of an offset, and of what a linear drift gathers by the end.
    pub offset: f64,
    pub drift: f64,
    /// Relative deviation of the gains of the channels.
    pub gain: f64,
}

impl Spoilt {
    pub fn by(noise: f64) -> Spoilt {
        Spoilt {
            noise,
            ..Spoilt::default()
        }
    }

    pub fn of(self, run: &Run, seed: u64) -> Array2<f64> {
        let mut random = Normal(seed.wrapping_mul(0x1234_5678_9abc_def1));
        let mut record = run.velocity.clone();
        let last = (record.nrows() - 1) as f64;
        for mut column in record.columns_mut() {
            let (offset, drift) = (self.offset * random.draw(), self.drift * random.draw());
            // Drawn only where it is used, so that other records keep their noise.
            let gain = match self.gain > 0.0 {
                true => 1.0 + self.gain * random.draw(),
                false => 1.0,
            };
            for (i, v) in column.iter_mut().enumerate() {
                *v = gain * *v + offset + drift * i as f64 / last + self.noise * random.draw();
            }
        }
        record
    }
}

pub fn measure(run: &Run, record: ArrayView2<f64>, options: &MeasuredOptions) -> MeasuredMotion {
    from_velocities(record, [0.0, step(run)], &run.chain, options).unwrap()
}

/// Share of places at which the error is within three stated ones, and the root mean square of the
/// stated errors over that of the true ones.
pub fn coverage(found: &Array2<f64>, truth: &Array2<f64>, stated: &Array2<f64>) -> [f64; 2] {
    let (mut within, mut count, mut off, mut said) = (0usize, 0usize, 0.0, 0.0);
    // Rounding is no error of the measurement.
    let floor = 1e-13 * truth.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    assert_eq!(found.dim(), truth.dim());
    assert_eq!(found.dim(), stated.dim());
    for ((found, truth), stated) in found.iter().zip(truth).zip(stated) {
        // Undefined where a filter reaches an end: all three, or it counts as wrong.
        if found.is_nan() && truth.is_nan() && stated.is_nan() {
            continue;
        }
        count += 1;
        let error = (found - truth).abs();
        within += usize::from(error <= 3.0 * stated + floor);
        off += error * error;
        said += stated * stated;
    }
    [within as f64 / count as f64, f64::sqrt(said / off)]
}
