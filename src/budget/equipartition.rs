//! Energy by normal mode, its spectral entropy, and when it is shared evenly.
//!
//! With the energies `E_k` of the chain's modes about its static state, `p_k = E_k / sum E`, the spectral entropy is
//! `S = - sum p ln p`, and normalized `eta(t) = (ln N - S(t)) / (ln N - S(0))`: 1 where the energy is as at the start, 0
//! where every mode has as much. Modes in equilibrium have independent energies of exponential distribution, whose
//! mean entropy is `1/2 + 1/3 + ... + 1/N`, near `ln N - 0.4228`.
//!
//! Source: R. Livi, M. Pettini, S. Ruffo, M. Sparpaglione, A. Vulpiani, Phys. Rev. A 31, 1039 (1985); J. De Luca,
//! A. J. Lichtenberg, M. A. Lieberman, Chaos 5, 283 (1995).

use super::Task;
use super::motion::Motion;
use super::waiting::Waiting;
use crate::arrays::LargeArray;
use crate::error::Result;

/// Energy by normal mode of the linearized chain; the energies themselves are
/// [`LargeArray::MODE_ENERGY`].
#[derive(Debug, Clone, PartialEq)]
pub struct ModeBudget {
    /// Angular frequencies, rising; modes of frequency 0 are left out.
    pub frequency: Vec<f64>,
    /// `S` at each sample; NaN where the modes have no energy.
    pub entropy: Vec<f64>,
    /// `eta` at each sample; NaN where all of the energy is evenly shared at the start.
    pub normalized_entropy: Vec<f64>,
    /// Energy of all modes at each sample.
    pub energy: Vec<f64>,
    /// Mean entropy of as many modes in equilibrium; NaN for a driven chain, which has none.
    pub equilibrium: f64,
    /// The time of the first sample at which the entropy is no less, of a chain that starts below; `None` where it never is.
    pub equipartition: Option<f64>,
}

impl ModeBudget {
    /// Modes that share the energy as evenly as they do at sample i, `exp(S)`.
    pub fn effective_modes(&self, i: usize) -> f64 {
        self.entropy[i].exp()
    }
}

/// # Errors
/// As [`crate::chain::Chain::normal_modes`]; errors of the sink; [`crate::Error::Cancelled`].
pub(super) fn pass(task: &Task) -> Result<ModeBudget> {
    let (motion, observer) = (task.motion, task.observer);
    let modes = motion.chain.normal_modes()?;
    let (n, free, samples) = (modes.frequency.len(), modes.free, motion.samples());
    observer.stage("modes", samples as u64);
    let mut waiting = Waiting::new(task.sink);
    waiting.reserve(LargeArray::MODE_ENERGY, (samples, n - free), None)?;
    let mut found = ModeBudget {
        frequency: modes.frequency[free..].to_vec(),
        entropy: Vec::with_capacity(samples),
        normalized_entropy: Vec::with_capacity(samples),
        energy: Vec::with_capacity(samples),
        equilibrium: match motion.drive {
            Some(_) => f64::NAN,
            None => (2..=n - free).map(|k| 1.0 / k as f64).sum(),
        },
        equipartition: None,
    };
    waiting.each_sample(
        samples,
        observer,
        vec![0.0; n],
        || (),
        |(), i, row| {
            let at = motion.at(i);
            let [y, w] = at.resonators;
            modes.energies(&modes.places(at.x, y), &modes.places(at.v, w), row);
        },
        |waiting, i, row| {
            found.add(i, motion, &row[free..]);
            waiting.push(LargeArray::MODE_ENERGY, &row[free..]);
        },
    )?;
    Ok(found)
}

impl ModeBudget {
    fn add(&mut self, i: usize, motion: &Motion, energies: &[f64]) {
        let all = crate::numeric::sum(energies);
        let shares = energies.iter().map(|energy| energy / all);
        let terms = shares.filter(|share| *share > 0.0);
        let entropy: f64 = terms.map(|share| -share * share.ln()).sum();
        let entropy = if all > 0.0 { entropy } else { f64::NAN };
        let most = (energies.len() as f64).ln();
        let first = self.entropy.first().copied().unwrap_or(entropy);
        self.energy.push(all);
        self.entropy.push(entropy);
        self.normalized_entropy
            .push((most - entropy) / (most - first));
        let starts_below = first < self.equilibrium;
        if starts_below && self.equipartition.is_none() && entropy >= self.equilibrium {
            self.equipartition = Some(motion.time[i]);
        }
    }
}
