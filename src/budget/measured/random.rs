//! Normal numbers from a seed, the same on every machine.

use crate::numeric::split_mix;

/// SplitMix64, and normal numbers by the method of Box and Muller.
#[derive(Debug, Clone)]
pub(super) struct Random {
    state: u64,
    spare: Option<f64>,
}

impl Random {
    pub(super) fn new(seed: u64) -> Random {
        // Neighbouring seeds start far apart.
        Random {
            state: split_mix(seed).1,
            spare: None,
        }
    }

    /// Uniform in (0, 1].
    fn uniform(&mut self) -> f64 {
        let (state, bits) = split_mix(self.state);
        self.state = state;
        ((bits >> 11) + 1) as f64 / (1_u64 << 53) as f64
    }

    /// Of mean 0 and variance 1.
    pub(super) fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        let (sine, cosine) = (std::f64::consts::TAU * self.uniform()).sin_cos();
        self.spare = Some(radius * sine);
        radius * cosine
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_closed_form_moments_of_normal_numbers() {
        let mut random = Random::new(7);
        let count = 200_000;
        let mut moments = [0.0; 4];
        for _ in 0..count {
            let x = random.normal();
            for (power, moment) in (1..).zip(&mut moments) {
                *moment += x.powi(power) / f64::from(count);
            }
        }
        // Four standard errors of each.
        for (moment, (expected, variance)) in
            moments
                .iter()
                .zip([(0.0, 1.0), (1.0, 2.0), (0.0, 15.0), (3.0, 96.0f64)])
        {
            assert!((moment - expected).abs() < 4.0 * (variance / f64::from(count)).sqrt());
        }
    }
}
