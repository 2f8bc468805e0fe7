//! Records without arrivals: one window, the record, in segments.

use super::along_x::{AlongX, LIVE, Options, median};
use super::groups::{group_size, grouped};
use super::onset::Onset;
use super::share::{Grid, Group, Moved};
use super::{Evidence, Movement, Reason, Verdict};
use crate::error::Result;
use crate::numeric::chi_square_quantile;
use crate::observer::Observer;
use crate::prepare::{Prepared, Window};
use crate::transform::{RecordScratch, RecordTransform, fold};

/// Segments of a record, half overlapping under Hann's window, and samples of one at least.
const SEGMENTS: usize = 8;
const SHORTEST: usize = 8;
/// Degrees of freedom of a bin of their mean: half-overlapping segments under Hann's window count 0.9 each but for the ends.
const DEGREES: f64 = 2.0 * 0.91 * SEGMENTS as f64;
/// Share of a group's energy above its white floor from which on the floor is noise and the rest is not, and errors of the
/// floor that it exceeds.
const ABOVE_FLOOR: f64 = 0.05;
const SURELY: f64 = 4.0;
/// Relative standard error of the lower quartile of so many values is this part of their own over the root of their number; what
/// neighbours share under Hann's window leaves two of three bins.
const OF_QUARTILE: f64 = 1.36;
const APART: f64 = 2.0 / 3.0;
/// Most that an unchanged verdict may leave open.
const OPEN: f64 = 0.35;
/// Groups from which on shares must follow x, and by what correlation.
const ORDERED: usize = 6;
const IN_ORDER: f64 = 0.7;
/// The bound of a share of two errors, over the share.
const NEARLY: f64 = 2.0;
/// Lines that move by less than so many bins have not moved.
const BINS: usize = 2;
/// Share of the energy in the first bin that is resolved from which on frequencies are not: Hann's window spreads into it what is
/// slower. Bins of an axis that has frequencies at all.
const MOST_LOW: f64 = 0.5;
const AXIS: usize = 16;

/// # Errors
/// [`crate::Error::Cancelled`].
pub(super) fn along_x(
    prepared: &Prepared,
    options: &Options,
    onsets: &[Onset],
    live: &[bool],
    observer: &dyn Observer,
) -> Result<AlongX> {
    let (n_times, n_sites) = (prepared.n_times(), prepared.n_sites());
    let length = 2 * n_times / (SEGMENTS + 1);
    let untold = |reason| AlongX {
        arrivals: vec![None; n_sites],
        ..AlongX::untold(reason)
    };
    if length < SHORTEST {
        return Ok(untold(Reason::ShortRecord { times: n_times }));
    }
    let taper = Window::Hann.samples(length);
    let taper_energy: f64 = taper.iter().map(|w| w * w).sum();
    let transform = RecordTransform::<f64>::new(&taper, length);
    let step = 1.0 / (length as f64 * options.dt);
    let grid = Grid::new(transform.bins(), step);
    // Hann's window spreads a mean over two bins.
    let first = 2;
    let sites: Vec<usize> = (0..n_sites).filter(|j| live[*j]).collect();
    let mut order = sites.clone();
    if options.toward_minus {
        order.reverse();
    }
    let size = group_size(sites.len(), options.struck.is_some());
    let numbers = SEGMENTS * grid.upper.len();
    let groups = grouped(&order, size, options.most_groups(numbers));
    let mut wanted = vec![false; n_sites];
    groups.iter().flatten().for_each(|&j| wanted[j] = true);
    let read = prepared.each_record_of(
        |j| wanted[j],
        observer,
        |site, record, _| {
            let mut scratch = RecordScratch::default();
            let mut bins = vec![0.0; transform.bins()];
            let mut low = 0.0;
            let hop = (n_times - length) / (SEGMENTS - 1);
            let parts: Vec<Vec<f64>> = (0..SEGMENTS)
                .map(|i| {
                    let segment = &record[i * hop..i * hop + length];
                    let mean = segment.iter().sum::<f64>() / length as f64;
                    let segment: Vec<f64> = segment.iter().map(|v| v - mean).collect();
                    let (spectrum, _) =
                        transform.transform(std::iter::once(&segment[..]), &mut scratch);
                    let powers = spectrum.iter().enumerate();
                    let powers = powers.map(|(m, x)| x.norm_sqr() * fold(m, length));
                    let mut powers: Vec<f64> = powers.collect();
                    low += powers.get(first).copied().unwrap_or(0.0);
                    powers[..first].fill(0.0);
                    bins.iter_mut().zip(&powers).for_each(|(sum, p)| *sum += p);
                    grid.sums(powers.into_iter())
                })
                .collect();
            // The floor of a bin that counts once, from the lower quartile of bins.
            let inside = bins.len().saturating_sub(1);
            let mut inner = bins[first.min(inside)..inside].to_vec();
            let floor = match inner.len() {
                0 => 0.0,
                n => {
                    let quartile = *inner.select_nth_unstable_by(n / 4, f64::total_cmp).1;
                    quartile / (chi_square_quantile(0.25, DEGREES) / DEGREES) / SEGMENTS as f64
                }
            };
            let mean = record.iter().sum::<f64>() / record.len() as f64;
            let all = bins.iter().sum::<f64>();
            let seen = Seen {
                parts,
                floor,
                mean,
                low,
                all,
            };
            (site, seen)
        },
    )?;
    let mut seen: Vec<Option<Seen>> = (0..n_sites).map(|_| None).collect();
    for (site, one) in read {
        seen[site] = Some(one);
    }
    let levels = (0..n_sites).map(|j| {
        let mean = seen[j]
            .as_ref()
            .map_or(onsets[j].baseline, |seen| seen.mean);
        [mean, 0.0]
    });
    let levels: Vec<[f64; 2]> = levels.collect();
    let flat = grid.sums((0..transform.bins()).map(|m| if m < first { 0.0 } else { 1.0 }));
    let energy = |site: &usize| -> f64 {
        let parts = seen[*site].as_ref().map(|seen| &seen.parts);
        parts.into_iter().flatten().flatten().sum()
    };
    // Constant records have none.
    let mut energies: Vec<f64> = groups.iter().flatten().map(energy).collect();
    let typical = median(&mut energies);
    let has_motion = |site: &&usize| energy(site) > LIVE * LIVE * typical;
    let sums = groups.iter().map(|group| {
        let members: Vec<&usize> = group.iter().filter(has_motion).collect();
        let seen = members.iter().filter_map(|j| seen[**j].as_ref());
        let mut parts = vec![vec![0.0; grid.upper.len()]; SEGMENTS];
        let mut floor = 0.0;
        for Seen {
            parts: of_site,
            floor: level,
            ..
        } in seen
        {
            floor += level;
            for (part, of_site) in parts.iter_mut().zip(of_site) {
                part.iter_mut().zip(of_site).for_each(|(sum, p)| *sum += p);
            }
        }
        let all: f64 = parts.iter().flatten().sum();
        let noise = floor * flat.iter().sum::<f64>() * SEGMENTS as f64;
        let share = 1.0 - noise / all;
        (
            members.len(),
            [group[0], group[group.len() - 1]],
            parts,
            floor,
            share,
        )
    });
    let sums: Vec<_> = sums.filter(|(members, ..)| *members > 0).collect();
    let bins = flat.iter().sum::<f64>();
    // Of the floor of a site.
    let floor_error = OF_QUARTILE * (2.0 / DEGREES / (APART * bins).max(1.0)).sqrt();
    let is_above = |(members, .., share): &(usize, [usize; 2], Vec<Vec<f64>>, f64, f64)| {
        *share > ABOVE_FLOOR.max(SURELY * floor_error / (*members as f64).sqrt())
    };
    let above = sums.iter().filter(|group| is_above(group)).count();
    let has_floor = options.struck.is_none() && 2 * above > sums.len();
    let mut left_out = 0;
    let mut told = Vec::new();
    for group in sums {
        let is_above = is_above(&group);
        let (members, rows, mut parts, floor, share) = group;
        if has_floor {
            if !is_above {
                left_out += 1;
                continue;
            }
            for part in &mut parts {
                part.iter_mut()
                    .zip(&flat)
                    .for_each(|(p, bins)| *p -= floor * bins);
            }
        }
        let mut group = Group::of_parts(&parts, members, rows, true);
        if has_floor && share < 1.0 {
            let error = floor_error / (members as f64).sqrt() * (1.0 - share) / share;
            group.add_floor_error(&flat, error);
        }
        told.push(group);
    }
    told.retain(|group| group.energy > 0.0 && group.energy.is_finite());
    let mut along = untold(match (told.is_empty(), left_out) {
        (true, 0) => Reason::NoEnergy,
        (true, _) => Reason::Noise,
        _ => Reason::FewSites { sites: sites.len() },
    });
    along.levels = levels;
    let of_sites = || seen.iter().flatten();
    let floor: f64 = of_sites().map(|seen| seen.floor).sum();
    along.noise = 0.5 * floor / taper_energy / of_sites().count() as f64 * sites.len() as f64;
    if let Some(group) = told.first() {
        along.median = group.quantile(&grid, 0.5);
    }
    let (low, all) = of_sites().fold((0.0, 0.0), |(low, all), s| (low + s.low, all + s.all));
    if transform.bins() >= AXIS && low > MOST_LOW * all {
        along.movement = Movement::untold(Reason::Resolution);
        return Ok(along);
    }
    if told.len() < 2 {
        return Ok(along);
    }
    let place = |group: &Group| options.place(group);
    let last = told.len() - 1;
    along.movement = between(&told, &grid, options);
    along.evidence = Some(Evidence::new(&grid.upper, &told, [0, last], &place));
    Ok(along)
}

/// What a record holds.
struct Seen {
    /// Powers of each segment on the grid.
    parts: Vec<Vec<f64>>,
    /// White floor, in a bin that counts once.
    floor: f64,
    mean: f64,
    /// Energy in the first bin that is resolved, and in all of them.
    low: f64,
    all: f64,
}

/// From the first group to the last, the same for the groups beside.
fn between(groups: &[Group], grid: &Grid, options: &Options) -> Movement {
    let tolerance = options.tolerance;
    let place = |group: &Group| options.place(group);
    let last = groups.len() - 1;
    let (a, b) = (&groups[0], &groups[last]);
    let mut movement = Movement::between(a, b, &grid.upper, tolerance, &place);
    if movement.verdict == Verdict::Unchanged {
        let bound = movement.bound;
        // A share that is nearly told is not told to be none.
        let nearly = movement.most() > tolerance && bound < NEARLY * movement.most();
        return match bound > OPEN || nearly {
            true => movement.but_untold(Reason::Errors { bound }),
            false => movement,
        };
    }
    // A line that moves by less than a bin leaves its bin all the same.
    let moves = |sign: f64| {
        let bins = 0..grid.upper.len() - BINS;
        let most = bins.map(|m| match sign > 0.0 {
            true => a.cumulative[m] - b.cumulative[m + BINS],
            false => b.cumulative[m] - a.cumulative[m + BINS],
        });
        most.fold(0.0, f64::max) > 0.5 * tolerance
    };
    if !(moves(1.0) || moves(-1.0)) {
        (movement.verdict, movement.transfer) = (Verdict::Unchanged, None);
        return movement;
    }
    // What moves along x is seen on the way; records that do not follow each other differ without an order.
    let bound = movement.bound;
    let at = match movement.up >= movement.down {
        true => Moved::between(a, b).up.at,
        false => Moved::between(a, b).down.at,
    };
    let on_the_way: Vec<f64> = groups.iter().map(|group| group.cumulative[at]).collect();
    if groups.len() >= ORDERED && order(&on_the_way).abs() < IN_ORDER {
        return movement.but_untold(Reason::Errors { bound });
    }
    let beside = [(1, last), (0, last - 1)];
    for (a, b) in beside.into_iter().filter(|(a, b)| a < b) {
        let moved = Moved::between(&groups[a], &groups[b]);
        if !moved.agrees(movement.verdict, tolerance) {
            let (up, down) = (moved.up.share, moved.down.share);
            return movement.but_untold(Reason::Neighbours { up, down });
        }
    }
    movement
}

/// Correlation of values with their index.
fn order(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let (middle, mean) = (0.5 * (n - 1.0), values.iter().sum::<f64>() / n);
    let [ii, vv, iv] = values
        .iter()
        .enumerate()
        .fold([0.0; 3], |[ii, vv, iv], (i, v)| {
            let (i, v) = (i as f64 - middle, v - mean);
            [ii + i * i, vv + v * v, iv + i * v]
        });
    iv / (ii * vv).sqrt()
}
