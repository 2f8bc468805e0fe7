//! Where on an abscissa dimers carry localized waves.

use serde::Serialize;

use super::chains::between_bodies;
use crate::Result;
use crate::chain::{Chain, Law, root_between};
use crate::localized::{Alternation, Family};

/// The highest order that is marked.
const LAST: usize = 12;

/// Estimates of ratios are at most this far off.
const ESTIMATED: f64 = 0.5;

/// A value of the key at which the dimer carries a localized wave.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LocalizedMark {
    pub order: usize,
    /// kappa of stiffness dimers, mu of mass dimers.
    pub ratio: f64,
    pub value: f64,
}

/// The localized ratios that `chain(value)` passes between neighbouring values; none for chains that
/// are no dimers of Hertz contacts or of a power law, and none where the theory finds no wave.
pub(super) fn localized_marks(
    values: &[f64],
    chain: impl Fn(f64) -> Result<Chain>,
) -> Result<Vec<LocalizedMark>> {
    let ratios: Result<Vec<Option<(Family, f64)>>> =
        values.iter().map(|v| Ok(ratio_of(&chain(*v)?))).collect();
    let ratios = ratios?;
    let known: Vec<(Family, f64)> = ratios.iter().copied().flatten().collect();
    // A uniform chain among dimers is of either family.
    let dimers = known.iter().filter(|(_, ratio)| *ratio != 1.0);
    let Some(family) = dimers.map(|(family, _)| *family).next() else {
        return Ok(Vec::new());
    };
    let (low, high) = known
        .iter()
        .fold((f64::INFINITY, 0.0f64), |(low, high), (_, r)| {
            (low.min(*r), high.max(*r))
        });
    let Ok(search) = family.search(LAST) else {
        return Ok(Vec::new());
    };
    let mut marks = Vec::new();
    for order in 1..=LAST {
        let near = search.estimate(order).unwrap_or(1.0);
        let outside = near * (1.0 - ESTIMATED) > high || near * (1.0 + ESTIMATED) < low;
        if order > 1 && outside {
            continue;
        }
        let Ok(wave) = search.wave(order) else {
            continue;
        };
        for i in 0..values.len() {
            let Some((_, here)) = ratios[i] else { continue };
            if here == wave.ratio {
                marks.push(mark(order, wave.ratio, values[i]));
                continue;
            }
            let next = ratios.get(i + 1).copied().flatten();
            let Some((_, next)) = next else { continue };
            if (here - wave.ratio) * (next - wave.ratio) < 0.0 {
                let off = |value: f64| {
                    let found = chain(value).ok().and_then(|c| ratio_of(&c));
                    found.map_or(f64::NAN, |(_, ratio)| ratio - wave.ratio)
                };
                let value = root_between(values[i], values[i + 1], off);
                marks.push(mark(order, wave.ratio, value));
            }
        }
    }
    Ok(marks)
}

fn mark(order: usize, ratio: f64, value: f64) -> LocalizedMark {
    LocalizedMark {
        order,
        ratio,
        value,
    }
}

/// The family of a dimer and its ratio; `None` for other chains.
fn ratio_of(chain: &Chain) -> Option<(Family, f64)> {
    let exponent = match chain.law {
        Law::Hertz => 1.5,
        Law::Power { exponent } => exponent,
        Law::Spring { .. } => return None,
    };
    if chain.precompression != 0.0 {
        return None;
    }
    let bodies = chain.mass.get(1..).unwrap_or_default();
    let coefficients = alternating(between_bodies(chain))?;
    let masses = alternating(bodies)?;
    let (alternation, ratio) = match (coefficients, masses) {
        ([a, b], [m, n]) if m == n => (Alternation::Stiffness, a.max(b) / a.min(b)),
        ([a, b], [m, n]) if a == b => (Alternation::Mass, m.min(n) / m.max(n)),
        _ => return None,
    };
    let family = Family {
        alternation,
        exponent,
    };
    Some((family, ratio))
}

/// The two values that alternate.
fn alternating(values: &[f64]) -> Option<[f64; 2]> {
    let first = *values.first()?;
    let second = values.get(1).copied().unwrap_or(first);
    let pair = [first, second];
    let same = values.iter().enumerate().all(|(j, v)| *v == pair[j % 2]);
    same.then_some(pair)
}
