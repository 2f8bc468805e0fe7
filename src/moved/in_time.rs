//! What moved in wavenumber in time, while the wave is inside.

use std::ops::Range;

use rayon::prelude::*;

use super::along_x::median;
use super::profile::{Grid, Profile, Row, add};
use super::{Evidence, Movement, Place, Reason};

/// Times at which the energy inside is looked at, and snapshots of a group that are transformed, at most.
const LOOKED_AT: usize = 1024;
const SNAPSHOTS: usize = 64;
/// Groups at most; steady records are halves.
const GROUPS: usize = 32;
/// Parts of a group that errors are found from, and those of a random wave, whose shorter parts follow each other.
const PARTS: usize = 8;
const OF_RANDOM: usize = 4;
/// Part of the energy that is inside while the wave is.
const INSIDE: f64 = 0.9;
/// Energy at the ends of the array, over that of an even spread, from which on the wave is longer than the array.
const AT_ENDS: f64 = 0.3;
/// Ratio of the energies inside from which on energy enters or leaves meanwhile; of what moves in a steady record, which may be
/// louder at times.
const ENTERS: f64 = 1.25;
const COMES: f64 = 25.0;
/// Part of the energy of a box by which it swings where waves stand: they must be averaged over a period.
const SWINGS: f64 = 0.1;
/// Share of the energy in the top tenth of the wavenumber axis from which on waves fold.
pub(crate) const FOLDED: f64 = 0.01;

/// Spatial snapshots by time.
pub(crate) trait Profiles: Sync {
    /// Energy inside, noise subtracted.
    fn energy(&self, time: usize) -> f64;
    /// Energy at the outer tenth of the sites over that of an even spread.
    fn at_ends(&self, time: usize) -> f64;
    /// Energies of the bins of k from 0, both signs as one, noise subtracted.
    fn powers(&self, time: usize) -> Vec<f64>;
}

/// What is followed in time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Motion {
    /// It has entered, and leaves.
    Transient,
    /// Its realisations are random.
    Steady,
    /// Of a run: no realisation of noise, and its bodies are all there is.
    Run,
    /// Of a periodic box: all of it is inside from the first time to the last.
    Box,
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
    /// Samples of a period of the motion; of a pulse, of half its energy.
    pub period: f64,
    pub motion: Motion,
    /// Whether all of it is inside at all of these times.
    pub is_inside: bool,
    /// Whether the wave is shorter than two distances of the sites, by its speed.
    pub is_short: bool,
    /// Share of the energy that amplitudes which differ from site to site spread over all wavenumbers.
    pub uneven: f64,
    pub tolerance: f64,
    /// Whether frequencies along x are told to stay.
    pub stays_along_x: bool,
    pub place: &'a dyn Fn(Range<usize>) -> Place,
}

/// # Errors
/// Why it cannot be told.
pub(crate) fn in_time(source: &Source) -> Result<(Movement, Evidence), Reason> {
    let may_fold = matches!(source.motion, Motion::Transient | Motion::Steady);
    let folds = may_fold && source.is_short;
    let leaves = Reason::Aperture { folds };
    let is_box = source.motion == Motion::Box;
    let period = match source.period.is_finite() && (!is_box || swings(source)) {
        true => source.period.max(1.0),
        false => 1.0,
    };
    let range = match source.is_inside || is_box {
        true => source.among.clone(),
        false => inside(source, period).ok_or(Reason::NoEnergy)?,
    };
    let is_random = source.motion == Motion::Steady;
    let most = if is_random { 2 } else { GROUPS };
    let is_transient = source.motion == Motion::Transient;
    let count = ((range.len() as f64 / period) as usize).min(most);
    if count < 2 || range.len() < 4 {
        return Err(if is_transient {
            leaves
        } else {
            Reason::ShortRecord
        });
    }
    let is_long = is_transient && {
        let times = evenly(range.clone(), SNAPSHOTS);
        let at_ends: f64 = times.iter().map(|&n| source.profiles.at_ends(n)).sum();
        at_ends > AT_ENDS * times.len() as f64
    };
    // What differs along x differs in time while it enters.
    if is_long && !source.stays_along_x {
        return Err(leaves);
    }
    let bins = source.profiles.powers(range.start).len();
    let grid = Grid::new(bins, source.step);
    let mut all = vec![0.0; bins];
    let parts = if is_random { OF_RANDOM } else { PARTS };
    let mut inside = Vec::with_capacity(count);
    let groups = (0..count).map(|i| {
        let [start, end] = [i, i + 1].map(|i| range.start + i * range.len() / count);
        let times = evenly(start..end, SNAPSHOTS);
        let powers = times.par_iter().map(|&n| source.profiles.powers(n));
        let powers: Vec<Vec<f64>> = powers.collect();
        inside.push(powers.iter().flatten().sum::<f64>() / times.len() as f64);
        powers.iter().for_each(|powers| add(&mut all, powers));
        let rows = powers.chunks(times.len().div_ceil(parts)).map(|part| {
            let mut sum = vec![0.0; bins];
            part.iter().for_each(|powers| add(&mut sum, powers));
            sum[..source.first].fill(0.0);
            let energies = grid.sums(sum.into_iter());
            Row::new([start, end - 1], vec![energies], Vec::new())
        });
        rows.collect()
    });
    let groups: Vec<Vec<Row>> = groups.collect();
    let profile = Profile::new(groups, &grid.upper, false);
    if profile.len() < count {
        return Err(Reason::NoEnergy);
    }
    let sum = |bins: Range<usize>| all[bins].iter().sum::<f64>();
    let of_all = inside[count - 1] / inside[0];
    let of_moving = profile.energy(count - 1) / profile.energy(0);
    let within = |ratio: f64, most: f64| (1.0 / most..most).contains(&ratio);
    let moving = sum(source.first..bins);
    let enters = is_transient && !within(of_all, ENTERS);
    // Most waves are longer than the array.
    let are_long = !is_box && sum(0..source.first) > moving;
    if enters || are_long || (is_random && !within(of_moving, COMES)) {
        return Err(leaves);
    }
    let place = |rows: [usize; 2]| (source.place)(rows[0]..rows[1] + 1);
    let (mut movement, group) = profile.judge(source.tolerance, &place);
    // What falls below the first wavenumber that is resolved is not lost.
    let kept = inside[group] / inside[0] - movement.energy_ratio > 0.5 * movement.most().share;
    if movement.transfer == Some(false) && kept {
        movement.transfer = None;
    }
    let evidence = profile.evidence([0, group], &place);
    let top = sum(source.first.max(9 * bins / 10)..bins) / moving;
    // All that gains spread may lie there.
    let folds = folds || (may_fold && top > FOLDED + source.uneven);
    if movement.moves() && (is_long || folds) {
        movement = movement.but_untold(Reason::Aperture { folds });
    }
    Ok((movement, evidence))
}

/// Energies inside at times of the record, spread evenly.
fn energies(source: &Source) -> Vec<f64> {
    let times = evenly(source.among.clone(), LOOKED_AT);
    let energies = times.par_iter().map(|&n| source.profiles.energy(n));
    energies.collect()
}

/// Whether the energy of a box swings, as that of velocities does where waves stand.
fn swings(source: &Source) -> bool {
    let energies = energies(source);
    let bends = energies.windows(3);
    let bends = bends.filter(|e| (e[1] - e[0]) * (e[2] - e[1]) < 0.0);
    let most = energies.iter().copied().fold(0.0, f64::max);
    let least = energies.iter().copied().fold(most, f64::min);
    bends.count() > 2 && most - least > SWINGS * most
}

/// At most `count` of `range`, spread evenly.
fn evenly(range: Range<usize>, count: usize) -> Vec<usize> {
    let count = count.min(range.len());
    let middle = |i: usize| range.start + (2 * i + 1) * range.len() / (2 * count);
    (0..count).map(middle).collect()
}

/// Times while the energy inside is above nine tenths of its usual largest value: from the first on, to the first at which it has
/// left, averaged over a period; half a group from entering and leaving where more than half is left.
fn inside(source: &Source, period: f64) -> Option<Range<usize>> {
    let energies = energies(source);
    let stride = source.among.len() as f64 / energies.len().max(1) as f64;
    let w = ((period / stride).round() as usize).clamp(1, (energies.len() / 4).max(1));
    let smooth = energies
        .windows(w)
        .map(|e| e.iter().sum::<f64>() / w as f64);
    let smooth: Vec<f64> = smooth.collect();
    let largest = smooth.iter().copied().fold(0.0, f64::max);
    let usual = median(smooth.iter().copied().filter(|e| *e > 0.5 * largest));
    let enough = |e: &f64| usual > 0.0 && *e >= INSIDE * usual;
    let start = smooth.iter().position(enough)?;
    let length = smooth[start..].iter().take_while(|e| enough(e)).count();
    let times = evenly(source.among.clone(), LOOKED_AT);
    let at = |i: usize| times.get(i).copied().unwrap_or(source.among.end);
    let (start, end) = (at(start), at(start + length + w - 1));
    let by = (period as usize).min((end - start) / 4);
    Some(start + by..end - by)
}
