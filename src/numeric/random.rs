//! Random numbers from a seed, the same on every machine.

/// The next state and 64 random bits.
///
/// Source: Steele, Lea and Flood, OOPSLA 2014 (SplitMix64).
pub(crate) fn split_mix(state: u64) -> (u64, u64) {
    let state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut bits = state;
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (state, bits ^ (bits >> 31))
}

/// A number in 0..1 from 64 random bits.
pub(crate) fn unit_interval(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

/// The next number in 0..1 of a state.
pub(crate) fn next_uniform(state: &mut u64) -> f64 {
    let (next, bits) = split_mix(*state);
    *state = next;
    unit_interval(bits)
}

/// SplitMix64, and normal numbers by the method of Box and Muller.
#[derive(Debug, Clone)]
pub(crate) struct Random {
    state: u64,
    spare: Option<f64>,
}

impl Random {
    pub(crate) fn new(seed: u64) -> Random {
        // Neighbouring seeds start far apart.
        Random {
            state: split_mix(seed).1,
            spare: None,
        }
    }

    /// Uniform in (0, 1].
    pub(crate) fn uniform(&mut self) -> f64 {
        let (state, bits) = split_mix(self.state);
        self.state = state;
        ((bits >> 11) + 1) as f64 / (1_u64 << 53) as f64
    }

    /// Of mean 0 and variance 1.
    pub(crate) fn normal(&mut self) -> f64 {
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

    /// First outputs for seed 1234567 of the authors' C code (prng.di.unimi.it/splitmix64.c).
    #[test]
    fn val_splitmix_first_outputs() {
        let (state, first) = split_mix(1234567);
        let (_, second) = split_mix(state);
        assert_eq!(first, 6457827717110365317);
        assert_eq!(second, 3203168211198807973);
    }

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
