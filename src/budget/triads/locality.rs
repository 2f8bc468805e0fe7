//! Which triads carry a flux: those of near wavenumbers, or of far ones.

use ndarray::Array2;

use super::kernel::Grid;
use crate::budget::balance::running;

/// The flux past each wavenumber, by the disparity of the triads that carry it.
#[derive(Debug, Clone, PartialEq)]
pub struct Locality {
    /// Number of the wavenumber past which the flux is largest in magnitude, without 0 and the last.
    pub at: usize,
    /// Groups of triads by the ratio s of their largest to their smallest wavenumber, `from <= s < 2 from`, with the
    /// energy that each carried past each wavenumber. From 0: with wavenumber 0; from NaN: umklapp, whose wavenumbers
    /// add up to a full turn per site.
    pub flux: Vec<(f64, Vec<f64>)>,
}

impl Locality {
    pub(super) fn of(
        grid: &Grid,
        transfer: &Array2<f64>,
        umklapp: &Array2<f64>,
        flux: &[f64],
    ) -> Locality {
        let n = grid.components;
        let octaves = (1..).take_while(|o| 1 << o < 2 * n.max(2)).count().max(1);
        let mut gained = vec![vec![0.0; n]; octaves + 1];
        for ((k, p), energy) in transfer.indexed_iter() {
            let q = k.abs_diff(p);
            let [least, most] = [k.min(p).min(q), k.max(p).max(q)];
            let group = match least {
                0 => octaves,
                // s is 2 or more: the largest is the sum of the others.
                _ => ((most / least).max(2).ilog2() as usize - 1).min(octaves - 1),
            };
            gained[group][k] += energy;
        }
        let from = |group| match group == octaves {
            true => 0.0,
            false => f64::from(2 << group),
        };
        let groups = gained.iter().enumerate();
        let mut groups: Vec<_> = groups.map(|(i, gained)| (from(i), past(gained))).collect();
        let wrapped: Vec<f64> = umklapp.rows().into_iter().map(|row| row.sum()).collect();
        groups.push((f64::NAN, past(&wrapped)));
        let inner = 1..n.saturating_sub(1).max(2).min(n);
        let at = inner
            .max_by(|a, b| flux[*a].abs().total_cmp(&flux[*b].abs()))
            .unwrap_or(0);
        Locality { at, flux: groups }
    }

    /// Share of the largest flux that triads with a ratio below `most` carry.
    pub fn share_below(&self, most: f64) -> f64 {
        let carried = |group: &Vec<f64>| group[self.at];
        let all: f64 = self.flux.iter().map(|(_, flux)| carried(flux)).sum();
        let local = self.flux.iter();
        let local = local.filter(|(from, _)| *from > 0.0 && 2.0 * from <= most);
        local.map(|(_, flux)| carried(flux)).sum::<f64>() / all
    }
}

/// `- sum up to k`.
pub(super) fn past(gained: &[f64]) -> Vec<f64> {
    let mut past = Vec::new();
    running(&mut past, gained.iter().map(|gained| -gained));
    past
}
