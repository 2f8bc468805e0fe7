//! Random numbers from a seed, the same on every machine.

/// The next 64 random bits of a state.
///
/// Source: Steele, Lea and Flood, OOPSLA 2014 (SplitMix64).
fn next_bits(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut bits = *state;
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}

/// The next number in 0..1 of a state.
pub(crate) fn next_uniform(state: &mut u64) -> f64 {
    (next_bits(state) >> 11) as f64 / (1_u64 << 53) as f64
}

/// SplitMix64, and normal numbers by the method of Box and Muller.
#[derive(Debug, Clone)]
pub(crate) struct Random {
    state: u64,
    spare: Option<f64>,
}

impl Random {
    pub(crate) fn new(mut seed: u64) -> Random {
        // Neighbouring seeds start far apart.
        let state = next_bits(&mut seed);
        Random { state, spare: None }
    }

    /// Uniform in (0, 1].
    pub(crate) fn uniform(&mut self) -> f64 {
        ((next_bits(&mut self.state) >> 11) + 1) as f64 / (1_u64 << 53) as f64
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
        let mut state = 1234567;
        assert_eq!(next_bits(&mut state), 6457827717110365317);
        assert_eq!(next_bits(&mut state), 3203168211198807973);
    }

    #[test]
    fn val_closed_form_moments_of_normal_numbers() {
        let mut random = Random::new(7);
        let numbers: Vec<f64> = (0..200_000).map(|_| random.normal()).collect();
        // Mean and variance of each power.
        let known = [(0.0, 1.0), (1.0, 2.0), (0.0, 15.0), (3.0, 96.0)];
        for (power, (expected, variance)) in (1..).zip(known) {
            let moment = numbers.iter().map(|x| x.powi(power)).sum::<f64>() / 2e5;
            assert!((moment - expected).abs() < 4.0 * (variance / 2e5f64).sqrt());
        }
    }
}
