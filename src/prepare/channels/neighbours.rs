//! Channels out of step with the others, by the phases between neighbours.

use num_complex::Complex;

use super::look::Look;
use crate::numeric::median;

/// Pairs of neighbours on each side that a pair is held against.
const PAIRS: usize = 4;
/// Coherence of a pair, and likeness of the phases of those beside it, from which on its phase is compared.
const COHERENT: f64 = 0.5;
const ALIKE: f64 = 0.8;
/// Part of the cross-correlation with those beside it that lies at no delay, above which a pair is like them; and that lies at another
/// delay, or has the other sign, from which on it is late, or reversed.
pub(super) const SAME: f64 = 0.5;
const OTHER: f64 = 0.8;
/// Amplitude over that of the sites about it, below which a site may be at a node of standing waves.
const NODE: f64 = 0.5;

impl Look<'_> {
    /// Sites whose sign, and whose delay in samples, are not those of most others: where the phase between two neighbours is not that of
    /// the pairs beside them, while these are alike.
    pub fn out_of_step(&self) -> [(Vec<usize>, Vec<f64>); 2] {
        let n = self.records.len();
        let (mut signs, mut delays) = (vec![1.0; n], vec![0.0; n]);
        for row in 1..n {
            let [sign, delay] = self.against_those_beside(row - 1).unwrap_or([1.0, 0.0]);
            signs[row] = signs[row - 1] * sign;
            delays[row] = delays[row - 1] + delay;
        }
        let usual = |values: &[f64]| {
            let runs = values.chunk_by(|a, b| a == b).map(|run| run[0]);
            let count = |value: &f64| values.iter().filter(|v| *v == value).count();
            // Of two halves the first is right.
            runs.rev().max_by_key(count).unwrap_or(0.0)
        };
        let apart = |values: Vec<f64>, less: f64, usual: f64| {
            let apart = values.into_iter().enumerate();
            let apart = apart.filter(|(_, value)| *value != usual);
            apart.map(|(row, value)| (row, value - less)).unzip()
        };
        let [sign, delay] = [usual(&signs), usual(&delays)];
        [apart(signs, 0.0, sign), apart(delays, delay, delay)]
    }

    /// Sign and delay of a pair of neighbours against the pairs beside it; `None` where it is like them, or it cannot be told.
    fn against_those_beside(&self, row: usize) -> Option<[f64; 2]> {
        let n = self.records.len();
        let own = &self.records[row].next;
        let size = |z: &[Complex<f64>]| z.iter().map(|z| z.norm()).sum::<f64>();
        let level = |j: usize| self.records[j].level;
        // One site alone is in the next pair, too.
        let before = row.saturating_sub(PAIRS + 1)..row.saturating_sub(1);
        let near = [before, (row + 2).min(n - 1)..(row + PAIRS + 2).min(n - 1)];
        let about = median((near[0].start..near[1].end + 1).map(level))?;
        let is_node = level(row).min(level(row + 1)) < NODE * about;
        if size(own) < COHERENT || is_node {
            return None;
        }
        // The sum of those on each side, and how alike they are.
        let sides = near.map(|pairs| {
            let pairs = pairs.map(|pair| &self.records[pair].next);
            let pairs: Vec<_> = pairs.filter(|next| size(next) > COHERENT).collect();
            let sum = |m: usize| pairs.iter().map(|z| z[m]).sum::<Complex<f64>>();
            let sum: Vec<Complex<f64>> = (0..own.len()).map(sum).collect();
            let alike = size(&sum) / pairs.iter().map(|z| size(z)).sum::<f64>();
            (sum, if pairs.len() < PAIRS / 2 { 0.0 } else { alike })
        });
        let [(before, some), (after, others)] = sides;
        let both = before.iter().zip(&after).map(|(a, b)| a.conj() * b);
        let both: Vec<Complex<f64>> = both.collect();
        let are_alike = both.iter().map(|z| z.re).sum::<f64>() > ALIKE * size(&both);
        if !are_alike || some.min(others) < ALIKE {
            return None;
        }
        let usual: Vec<Complex<f64>> = before.iter().zip(&after).map(|(a, b)| a + b).collect();
        let rotated = own.iter().zip(&usual);
        let rotated =
            rotated.map(|(z, usual)| z * usual.conj() / usual.norm().max(f64::MIN_POSITIVE));
        let rotated: Vec<Complex<f64>> = rotated.collect();
        let all = size(&rotated);
        // The cross-correlation at a delay, of what is left of the phase.
        let at = |delay: isize| {
            let angle = std::f64::consts::TAU * delay as f64 / self.length as f64;
            let terms = rotated.iter().enumerate();
            let terms = terms.map(|(m, z)| (z * Complex::cis(angle * m as f64)).re);
            terms.sum::<f64>() / all
        };
        if at(0) > SAME {
            return None;
        }
        // Of a narrow band, a record that is late by half a period looks reversed: then neither is said.
        let most = (self.length / 4) as isize;
        let apart: Vec<(isize, f64)> = (-most..=most).map(|delay| (delay, at(delay))).collect();
        let (delay, peak) = apart.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let least = apart.iter().fold(0.0, |least: f64, of| least.min(of.1));
        match (peak > OTHER, at(0) < -OTHER) {
            (true, _) if least > -SAME => Some([1.0, delay as f64]),
            (_, true) if peak < SAME => Some([-1.0, 0.0]),
            _ => None,
        }
    }
}
