//! Abscissa values at which dimers carry localized waves.

use std::ops::Range;

use serde::Serialize;

use super::chains::Pattern;
use crate::Result;
use crate::chain::{Chain, Law};
use crate::localized::{Alternation, Family};
use crate::numeric::find_root;
use crate::sheet::extent;

/// The highest order that is marked.
const LAST: usize = 19;

/// Bound of the relative error of estimated ratios.
const ESTIMATED: f64 = 0.5;

/// A value of the key at which the dimer carries a localized wave.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LocalizedMark {
    pub order: usize,
    /// kappa of stiffness dimers, mu of mass dimers.
    pub ratio: f64,
    pub value: f64,
}

/// Localized ratios that are known; `None` where no wave was found.
#[derive(Debug, Default)]
pub(super) struct Waves(Vec<(Family, usize, Option<f64>)>);

impl Waves {
    /// The orders of a family that may lie between two ratios, with their ratios.
    fn between(&mut self, family: Family, range: &Range<f64>) -> Vec<(usize, Option<f64>)> {
        let Ok(search) = family.search(LAST) else {
            return Vec::new();
        };
        let within = |order: &usize| {
            let estimate = search.estimate(*order).unwrap_or(1.0);
            let near = estimate * (1.0 - ESTIMATED)..=estimate * (1.0 + ESTIMATED);
            *order == 1 || (*near.start() <= range.end && *near.end() >= range.start)
        };
        let of = |order| {
            let mut known = self.0.iter();
            if let Some(wave) = known.find(|w| (w.0, w.1) == (family, order)) {
                return (order, wave.2);
            }
            let ratio = search.wave(order).ok().map(|wave| wave.ratio);
            self.0.push((family, order, ratio));
            (order, ratio)
        };
        (1..=LAST).filter(within).map(of).collect()
    }
}

/// The values at which the ratio of `chain(value)` crosses a localized ratio, and the orders in
/// range whose wave could not be resolved. Both are empty for chains other than dimers of Hertz or
/// power-law contacts.
pub(super) fn localized_marks(
    values: &[f64],
    waves: &mut Waves,
    chain: impl Fn(f64) -> Result<(Chain, Pattern)>,
) -> Result<(Vec<LocalizedMark>, Vec<usize>)> {
    let ratio_at = |value: f64| -> Result<Option<(Family, f64)>> {
        let (chain, pattern) = chain(value)?;
        Ok(ratio_of(&chain, &pattern))
    };
    let ratios = values.iter().map(|value| ratio_at(*value));
    let ratios = ratios.collect::<Result<Vec<_>>>()?;
    let known = || ratios.iter().flatten();
    // A homogeneous chain belongs to both families.
    let Some((family, _)) = known().find(|(_, ratio)| *ratio != 1.0) else {
        return Ok((Vec::new(), Vec::new()));
    };
    let range = extent(known().map(|(_, ratio)| *ratio));
    let (mut marks, mut unresolved) = (Vec::new(), Vec::new());
    for (order, ratio) in waves.between(*family, &range) {
        let Some(ratio) = ratio else {
            unresolved.push(order);
            continue;
        };
        let off = |found: Option<(_, f64)>| found.map_or(f64::NAN, |(_, found)| found - ratio);
        let at = |value: f64| off(ratio_at(value).ok().flatten());
        for i in 0..values.len() {
            let (here, next) = (off(ratios[i]), ratios.get(i + 1).copied().flatten());
            let value = match () {
                () if here == 0.0 => values[i],
                () if here * off(next) < 0.0 => find_root(values[i], values[i + 1], at),
                () => continue,
            };
            marks.push(LocalizedMark {
                order,
                ratio,
                value,
            });
        }
    }
    Ok((marks, unresolved))
}

/// The family of a dimer and its ratio; `None` for other chains.
fn ratio_of(chain: &Chain, pattern: &Pattern) -> Option<(Family, f64)> {
    let exponent = match chain.law.only()? {
        Law::Hertz => 1.5,
        Law::Power { exponent } if *exponent > 1.0 => *exponent,
        _ => return None,
    };
    if chain.is_pressed() || chain.on_site.ground.is_some() || chain.on_site.resonators.is_some() {
        return None;
    }
    let (alternation, ratio) = match pattern.alternating()? {
        [[a, b], [m, n]] if m == n => (Alternation::Stiffness, a.max(b) / a.min(b)),
        [[a, b], [m, n]] if a == b => (Alternation::Mass, m.min(n) / m.max(n)),
        _ => return None,
    };
    let family = Family {
        alternation,
        exponent,
    };
    Some((family, ratio))
}
