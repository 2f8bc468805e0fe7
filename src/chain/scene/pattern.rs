//! Values along the chain: a cell, its taper, its randomness.

use super::check::Check;
use crate::error::Result;
use crate::numeric::next_uniform;

/// Masses or coefficients: a cell that repeats, times what grows geometrically from 1 to the taper, times random numbers that are
/// uniform in 1 -+ the spread, the same on every machine for a seed.
pub(super) fn along(
    check: Check,
    cell: &[f64],
    n: usize,
    what: &str,
    seed: u64,
) -> Result<Vec<f64>> {
    let scene = check.scene;
    let (taper, spread) = match what {
        "mass" => (scene.mass_taper, scene.mass_spread),
        _ => (scene.coefficient_taper, scene.coefficient_spread),
    };
    let key = format!("{what}_taper");
    let rate = taper.unwrap_or(1.0).ln() / n.saturating_sub(1).max(1) as f64;
    let mut state = seed;
    let values = cell.iter().cycle().take(n).enumerate();
    let values = values.map(|(j, value)| {
        let tapered = value * (rate * j as f64).exp();
        check.positive(&key, tapered * random_factor(spread, &mut state))
    });
    values.collect()
}

/// Uniform in 1 -+ the spread.
pub(super) fn random_factor(spread: Option<f64>, state: &mut u64) -> f64 {
    1.0 + spread.unwrap_or(0.0) * (2.0 * next_uniform(state) - 1.0)
}
