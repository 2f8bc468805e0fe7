//! What moved in wavenumber in time, while the wave is inside.

use std::ops::Range;

use rayon::prelude::*;

use super::along_x::median;
use super::share::{Grid, Group, Moved};
use super::{Evidence, Movement, Place, Reason, Verdict};

/// Times at which the energy inside is looked at, and profiles of a window that are transformed, at most.
const LOOKED_AT: usize = 1024;
const PROFILES: usize = 64;
/// Windows of a run, of a transient, of a steady record, whose realisations are random.
const OF_RUN: usize = 12;
const OF_TRANSIENT: usize = 8;
const OF_STEADY: usize = 2;
/// Parts of a window that errors are found from.
const PARTS: usize = 8;
/// Part of the energy that is inside while the wave is.
const INSIDE: f64 = 0.9;
/// Energy at the ends of the array, over that of an even spread, from which on the wave is longer than the array.
const AT_ENDS: f64 = 0.3;
/// Ratio of the energies inside from which on energy enters or leaves meanwhile.
const ENTERS: f64 = 1.25;
/// The same of what moves in a steady record, which may be louder at times.
const COMES: f64 = 25.0;
/// Share of the energy in the top tenth of the wavenumber axis from which on waves fold.
pub(crate) const FOLDED: f64 = 0.01;
/// Most that an unchanged verdict may leave open.
const OPEN: f64 = 0.5;

/// Profiles by time.
pub(crate) trait Profiles: Sync {
    /// Energy inside, noise subtracted.
    fn energy(&self, time: usize) -> f64;
    /// Energy at the outer tenth of the sites over that of an even spread.
    fn at_ends(&self, time: usize) -> f64;
    /// Energies of the bins of k from 0, both signs as one, noise subtracted.
    fn powers(&self, time: usize) -> Vec<f64>;
}

/// A field or a run whose content is followed in time.
pub(crate) struct Source<'a> {
    pub profiles: &'a dyn Profiles,
    /// Times that may be compared.
    pub among: Range<usize>,
    /// Distance between bins, rad per length.
    pub step: f64,
    /// The first bin that the aperture resolves; those below are mean motion.
    pub first: usize,
    /// Bins of the unpadded aperture count so many.
    pub padding: f64,
    /// Samples of a period of the motion; of a pulse, of half its energy.
    pub period: f64,
    pub is_steady: bool,
    /// Of a run, whose motion is no realisation of noise, and whose bodies are all there is.
    pub is_run: bool,
    /// Whether the wave is shorter than two distances of the sites, by its speed.
    pub is_short: bool,
    /// Share of the energy that amplitudes which differ from site to site spread over all wavenumbers.
    pub uneven: f64,
    /// Whether what moved and came back is told.
    pub returns: bool,
    pub tolerance: f64,
    /// What moved in frequency along x.
    pub along_x: Verdict,
    pub place: &'a dyn Fn(Range<usize>) -> Place,
}

pub(crate) fn in_time(source: &Source) -> (Movement, Option<Evidence>) {
    match compare(source) {
        Ok((movement, evidence)) => (movement, Some(evidence)),
        Err(reason) => (Movement::untold(reason), None),
    }
}

fn compare(source: &Source) -> Result<(Movement, Evidence), Reason> {
    let period = match source.period.is_finite() {
        true => source.period.max(1.0),
        false => 1.0,
    };
    let range = match source.is_steady {
        true => source.among.clone(),
        // Half a window from entering and leaving.
        false => without_ends(inside(source).ok_or(Reason::NoEnergy)?, period as usize),
    };
    let most = match (source.is_run, source.is_steady) {
        (true, _) => OF_RUN,
        (false, false) => OF_TRANSIENT,
        (false, true) => OF_STEADY,
    };
    let count = ((range.len() as f64 / period) as usize).min(most);
    if count < 2 || range.len() < 4 {
        return Err(Reason::LeavesEarly);
    }
    let is_long = !source.is_steady && !source.is_run && {
        let times = evenly(range.clone(), PROFILES);
        let at_ends: f64 = times.iter().map(|&n| source.profiles.at_ends(n)).sum();
        at_ends > AT_ENDS * times.len() as f64
    };
    // What differs along x differs in time while it enters.
    if is_long && source.along_x != Verdict::Unchanged {
        return Err(Reason::NeverInside);
    }
    let sample = source.profiles.powers(range.start);
    let grid = Grid::new(sample.len(), source.step);
    let mut waves = Waves::default();
    let mut totals = Vec::with_capacity(count);
    let window = |i: usize| {
        range.start + i * range.len() / count..range.start + (i + 1) * range.len() / count
    };
    let groups: Vec<Group> = (0..count)
        .map(|i| {
            let times = evenly(window(i), PROFILES);
            let profiles = times.par_iter().map(|&n| source.profiles.powers(n));
            let profiles: Vec<Vec<f64>> = profiles.collect();
            let size = times.len().div_ceil(PARTS);
            let parts: Vec<Vec<f64>> = profiles
                .chunks(size)
                .map(|profiles| {
                    let mut sum = vec![0.0; grid.upper.len()];
                    for powers in profiles {
                        waves.add(powers, source);
                        let moving = powers.iter().copied().enumerate();
                        let moving = moving.map(|(m, p)| if m < source.first { 0.0 } else { p });
                        for (sum, p) in sum.iter_mut().zip(grid.sums(moving)) {
                            *sum += p;
                        }
                    }
                    sum
                })
                .collect();
            let window = window(i);
            totals.push((waves.mean + waves.moving, times.len() as f64));
            Group::of_parts(&parts, 1, [window.start, window.end - 1], false)
        })
        .collect();
    if groups
        .iter()
        .any(|group| group.energy.is_nan() || group.energy <= 0.0)
    {
        return Err(Reason::NoEnergy);
    }
    // Sums go on from window to window.
    let mut before = 0.0;
    let inside = totals
        .iter()
        .map(|&(sum, times)| (sum - std::mem::replace(&mut before, sum)) / times);
    let inside: Vec<f64> = inside.collect();
    let ratio = inside[count - 1] / inside[0];
    if !source.is_steady && !(1.0 / ENTERS..ENTERS).contains(&ratio) {
        return Err(Reason::Enters);
    }
    if waves.are_long() {
        return Err(Reason::LongWaves);
    }
    let moving = groups[count - 1].energy / groups[0].energy;
    if source.is_steady && !source.is_run && !(1.0 / COMES..COMES).contains(&moving) {
        return Err(Reason::Enters);
    }
    let place = |group: &Group| (source.place)(group.rows[0]..group.rows[1] + 1);
    let between = |a: usize, b: usize| {
        Movement::between(
            &groups[a],
            &groups[b],
            &grid.upper,
            source.tolerance,
            &place,
        )
    };
    let last = groups.len() - 1;
    let mut movement = between(0, last);
    let mut compared = [0, last];
    if movement.verdict == Verdict::Unchanged && source.returns {
        // What comes back has moved meanwhile.
        let farthest = (1..last).max_by(|&a, &b| {
            let most = |b: usize| Moved::between(&groups[0], &groups[b]).most();
            most(a).total_cmp(&most(b))
        });
        let meanwhile = farthest.map(|b| (b, between(0, b)));
        if let Some((b, meanwhile)) = meanwhile.filter(|(_, m)| m.verdict != Verdict::Unchanged) {
            movement = Movement {
                returns: true,
                ..meanwhile
            };
            compared = [0, b];
        }
    }
    let evidence = Evidence::new(&grid.upper, &groups, compared, &place);
    let [a, b] = compared;
    // What falls below the first wavenumber that is resolved is not lost.
    let kept =
        (inside[b] / inside[a] - groups[b].energy / groups[a].energy) > 0.5 * movement.most();
    if movement.transfer == Some(false) && kept {
        movement.transfer = None;
    }
    if movement.verdict == Verdict::Unchanged {
        let bound = movement.bound;
        let movement = match bound > OPEN {
            true => movement.but_untold(Reason::Errors { bound }),
            false => movement,
        };
        return Ok((movement, evidence));
    }
    if is_long {
        return Ok((movement.but_untold(Reason::NeverInside), evidence));
    }
    let top = waves.top / waves.moving;
    if !source.is_run && (source.is_short || top > FOLDED) {
        // All that gains spread may lie there.
        let reason = match source.is_short || top > FOLDED + source.uneven {
            true => Reason::Folded,
            false => Reason::Uneven,
        };
        return Ok((movement.but_untold(reason), evidence));
    }
    let beside = [(a + 1, b), (a, b.saturating_sub(1))];
    for (a, b) in beside.into_iter().filter(|(a, b)| a < b) {
        let moved = Moved::between(&groups[a], &groups[b]);
        if !moved.agrees(movement.verdict, source.tolerance) {
            let (up, down) = (moved.up.share, moved.down.share);
            return Ok((
                movement.but_untold(Reason::Neighbours { up, down }),
                evidence,
            ));
        }
    }
    Ok((movement, evidence))
}

/// A range less `by` at both ends, where more than half of it is left.
fn without_ends(range: Range<usize>, by: usize) -> Range<usize> {
    match 4 * by < range.len() {
        true => range.start + by..range.end - by,
        false => range,
    }
}

/// At most `count` of `range`, spread evenly.
fn evenly(range: Range<usize>, count: usize) -> Vec<usize> {
    let count = count.min(range.len());
    (0..count)
        .map(|i| range.start + (2 * i + 1) * range.len() / (2 * count))
        .collect()
}

/// Times while the energy inside is above nine tenths of its usual largest value: from the first on, to the first at which it has
/// left. A period is averaged over.
fn inside(source: &Source) -> Option<Range<usize>> {
    let times = evenly(source.among.clone(), LOOKED_AT);
    let stride = source.among.len() as f64 / times.len().max(1) as f64;
    let energies = times.par_iter().map(|&n| source.profiles.energy(n));
    let energies: Vec<f64> = energies.collect();
    let w = match source.period.is_finite() {
        true => ((source.period / stride).round() as usize).clamp(1, (times.len() / 4).max(1)),
        false => 1,
    };
    let smooth: Vec<f64> = energies
        .windows(w)
        .map(|e| e.iter().sum::<f64>() / w as f64)
        .collect();
    let largest = smooth.iter().copied().fold(0.0, f64::max);
    let mut high: Vec<f64> = smooth
        .iter()
        .copied()
        .filter(|e| *e > 0.5 * largest)
        .collect();
    let usual = median(&mut high);
    if usual.is_nan() || usual <= 0.0 {
        return None;
    }
    let enough = |e: &f64| *e >= INSIDE * usual;
    let start = smooth.iter().position(enough)?;
    let length = smooth[start..].iter().take_while(|e| enough(e)).count();
    let end = start + length + w - 1;
    let at = |i: usize| times.get(i).copied().unwrap_or(source.among.end);
    Some(at(start)..at(end))
}

/// How much of the energy lies at wavelengths near that of the aperture.
#[derive(Default)]
struct Waves {
    mean: f64,
    near: f64,
    moving: f64,
    /// In the top tenth of the axis.
    top: f64,
}

impl Waves {
    fn add(&mut self, powers: &[f64], source: &Source) {
        let first = source.first;
        // The main lobe of a bin.
        let near = (first + source.padding.ceil() as usize).min(powers.len());
        self.mean += powers[..first].iter().sum::<f64>();
        self.near += powers[first..near].iter().sum::<f64>();
        self.moving += powers[first..].iter().sum::<f64>();
        self.top += powers[first.max(9 * powers.len() / 10)..]
            .iter()
            .sum::<f64>();
    }

    fn are_long(&self) -> bool {
        self.mean > self.moving && 2.0 * self.near > self.moving
    }
}
