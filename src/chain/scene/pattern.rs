//! Values along the chain: a cell, its taper, its randomness.

use super::EndsTyped;
use super::check::Check;
use crate::chain::Pattern;
use crate::error::Result;

/// That there is something to repeat, and in a ring that it repeats as a whole.
pub(super) fn check_cell<T>(check: Check, key: &str, cell: &[T]) -> Result<()> {
    if cell.is_empty() {
        return Err(check.fault(key, "at least one value", "an empty list"));
    }
    let sites = check.scene.sites.unwrap_or(0);
    let is_ring = matches!(check.scene.ends, Some(EndsTyped::Periodic));
    if is_ring && !sites.is_multiple_of(cell.len()) {
        let expected = format!("a cell that fits into the {sites} sites of the ring");
        return Err(check.fault(key, expected, format!("{} values", cell.len())));
    }
    Ok(())
}

/// A pattern with the taper and the randomness of `what` (mass or coefficient).
pub(super) fn along(
    check: Check,
    cell: Pattern,
    n: usize,
    what: &str,
    seed: u64,
) -> Result<Vec<f64>> {
    let scene = check.scene;
    let (taper, spread) = match what {
        "mass" => (scene.mass_taper, scene.mass_spread),
        _ => (scene.coefficient_taper, scene.coefficient_spread),
    };
    let (taper_key, spread_key) = (format!("{what}_taper"), format!("{what}_spread"));
    let last = check.positive(&taper_key, taper.unwrap_or(1.0))?;
    let spread = check.not_negative(&spread_key, spread.unwrap_or(0.0))?;
    if spread >= 1.0 {
        return Err(check.fault(&spread_key, "a spread below 1", spread));
    }
    let taper = Pattern::Tapered { first: 1.0, last };
    let random = Pattern::Random {
        mean: 1.0,
        spread,
        seed,
    };
    let values = |pattern: Pattern, key: &str| {
        let values = pattern.values(n);
        values.map_err(|error| check.named(error, key))
    };
    let (cell, taper, random) = (
        values(cell, what)?,
        values(taper, &taper_key)?,
        values(random, &spread_key)?,
    );
    let product = |((cell, taper), random): ((f64, f64), f64)| cell * taper * random;
    let all = cell.into_iter().zip(taper).zip(random).map(product);
    all.map(|value| check.positive(&taper_key, value)).collect()
}
