//! Records without arrivals: one window, the record, in segments.

use num_complex::Complex;

use super::along_x::{LIVE, Options, group_size, grouped, median};
use super::onset::Onset;
use super::profile::{Grid, Profile, Row};
use super::{Answer, Reason};
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
/// Share of the energy in the first bin that is resolved from which on frequencies are not: Hann's window spreads into it what is
/// slower. Bins of an axis that has frequencies at all.
const MOST_LOW: f64 = 0.5;
const AXIS: usize = 16;
/// Correlation of neighbours from which on one wave passes both, and part of the record that its way along the array may take.
const ONE_WAVE: f64 = 0.5;
const LONGEST: f64 = 0.4;

/// Segments of records.
struct Segments {
    transform: RecordTransform<f64>,
    length: usize,
    grid: Grid,
}

/// What a record holds.
struct Seen {
    /// Powers of each segment on the grid.
    parts: Vec<Vec<f64>>,
    /// White floor, in a bin that counts twice.
    floor: f64,
    mean: f64,
    /// Energy in the first bin that is resolved, and in all of them.
    low: f64,
    all: f64,
    /// Spectrum of the segment in the middle.
    middle: Vec<Complex<f32>>,
}

/// Hann's window spreads a mean over two bins.
const FIRST: usize = 2;

impl Segments {
    fn new(n_times: usize, dt: f64) -> Segments {
        let length = 2 * n_times / (SEGMENTS + 1);
        let transform = RecordTransform::new(&Window::Hann.samples(length), length);
        Segments {
            grid: Grid::new(transform.bins(), 1.0 / (length as f64 * dt)),
            transform,
            length,
        }
    }

    /// Of a part of a record.
    fn of(&self, record: &[f64]) -> Seen {
        let length = self.length;
        let mut scratch = RecordScratch::default();
        let mut bins = vec![0.0; self.transform.bins()];
        let (mut low, mut middle) = (0.0, Vec::new());
        let segment = |i: usize| {
            let start = i * (record.len() - length) / (SEGMENTS - 1);
            let segment = &record[start..start + length];
            let mean = segment.iter().sum::<f64>() / length as f64;
            let segment: Vec<f64> = segment.iter().map(|v| v - mean).collect();
            let (spectrum, _) = self
                .transform
                .transform(std::iter::once(&segment[..]), &mut scratch);
            if i == SEGMENTS / 2 {
                let kept = spectrum.iter();
                middle = kept
                    .map(|x| Complex::new(x.re as f32, x.im as f32))
                    .collect();
            }
            let powers = spectrum.iter().enumerate();
            let mut powers: Vec<f64> = powers
                .map(|(m, x)| x.norm_sqr() * fold(m, length))
                .collect();
            low += powers.get(FIRST).copied().unwrap_or(0.0);
            let still = FIRST.min(powers.len());
            powers[..still].fill(0.0);
            bins.iter_mut().zip(&powers).for_each(|(sum, p)| *sum += p);
            self.grid.sums(powers.into_iter())
        };
        let parts: Vec<Vec<f64>> = (0..SEGMENTS).map(segment).collect();
        // The floor of a bin that counts twice, from the lower quartile of bins.
        let inside = bins.len().saturating_sub(1);
        let mut inner = bins[FIRST.min(inside)..inside].to_vec();
        let floor = match inner.len() {
            0 => 0.0,
            n => {
                let quartile = *inner.select_nth_unstable_by(n / 4, f64::total_cmp).1;
                quartile / (chi_square_quantile(0.25, DEGREES) / DEGREES) / SEGMENTS as f64
            }
        };
        Seen {
            parts,
            floor,
            mean: record.iter().sum::<f64>() / record.len() as f64,
            low,
            all: bins.iter().sum(),
            middle,
        }
    }

    /// Samples by which a wave passes a site later than the one before it, in the order of groups: where the records of neighbours,
    /// one shifted, are most alike; 0 where no wave passes both.
    fn delay(&self, groups: &[Vec<usize>], seen: &[Option<Seen>], most: f64) -> f64 {
        let mut both = vec![Complex::<f64>::default(); self.transform.bins()];
        let mut each = 0.0;
        let pairs = groups.iter().flat_map(|group| group.windows(2));
        for pair in pairs {
            let [Some(a), Some(b)] = [pair[0], pair[1]].map(|j| seen[j].as_ref()) else {
                continue;
            };
            let wide = |x: &Complex<f32>| Complex::new(f64::from(x.re), f64::from(x.im));
            let size = |of: &Seen| of.middle.iter().map(|x| wide(x).norm_sqr()).sum::<f64>();
            let scale = (size(a) * size(b)).sqrt();
            if scale > 0.0 {
                each += 1.0;
                for ((sum, x), y) in both.iter_mut().zip(&a.middle).zip(&b.middle) {
                    *sum += wide(x) * wide(y).conj() / scale;
                }
            }
        }
        let alike = |delay: f64| {
            let turn =
                Complex::from_polar(1.0, -std::f64::consts::TAU * delay / self.length as f64);
            let mut phase = Complex::new(1.0, 0.0);
            let terms = both.iter().map(|x| {
                let term = (x * phase).re;
                phase *= turn;
                term
            });
            terms.sum::<f64>() / each
        };
        let steps = (4.0 * most) as i32;
        let delays = (-steps..=steps).map(|n| 0.25 * f64::from(n));
        let best = delays.map(|delay| (alike(delay), delay));
        let best = best.max_by(|(a, c), (b, d)| a.total_cmp(b).then(d.abs().total_cmp(&c.abs())));
        best.filter(|(alike, _)| *alike > ONE_WAVE)
            .map_or(0.0, |(_, delay)| delay)
    }
}

/// # Errors
/// [`crate::Error::Cancelled`].
pub(super) fn along_x(
    prepared: &Prepared,
    options: &Options,
    mut onsets: Vec<Onset>,
    observer: &dyn Observer,
) -> Result<Answer> {
    let (n_times, n_sites) = (prepared.n_times(), prepared.n_sites());
    let short = Reason::ShortRecord {
        whole: 0,
        sites: n_sites,
    };
    let mut segments = Segments::new(n_times, options.dt);
    if segments.length < SHORTEST {
        return Ok(Answer::untold(short));
    }
    let sites: Vec<usize> = (0..n_sites).filter(|&j| onsets[j].is_live).collect();
    let mut order = sites.clone();
    if options.toward_minus {
        order.reverse();
    }
    let size = group_size(sites.len(), options.struck.is_some());
    // Twice those of the segments, and what is left of them.
    let numbers = (SEGMENTS + 3) * segments.grid.upper.len();
    let groups = grouped(&order, size, options.most_groups(numbers));
    let mut wanted = vec![false; n_sites];
    groups.iter().flatten().for_each(|&j| wanted[j] = true);
    // From the sample at which the part of each record begins.
    let read = |segments: &Segments, start: &(dyn Fn(usize) -> usize + Sync), samples: usize| {
        let read = prepared.each_record_of(
            |j| wanted[j],
            observer,
            |site, record, _| {
                let start = start(site);
                (site, segments.of(&record[start..start + samples]))
            },
        )?;
        let mut seen: Vec<Option<Seen>> = (0..n_sites).map(|_| None).collect();
        for (site, one) in read {
            seen[site] = Some(one);
        }
        Ok::<_, crate::Error>(seen)
    };
    let mut seen = read(&segments, &|_| 0, n_times)?;
    // The same part of the wave passes all sites in segments that follow it.
    let far = order
        .first()
        .zip(order.last())
        .map_or(0, |(a, b)| a.abs_diff(*b));
    let most = LONGEST * n_times as f64 / far.max(1) as f64;
    let delay = segments.delay(&groups, &seen, most);
    let way = (delay.abs() * far as f64).round() as usize;
    if way > segments.length / SEGMENTS {
        let first = if delay > 0.0 {
            order[0]
        } else {
            order[order.len() - 1]
        };
        let start = move |site: usize| (delay.abs() * site.abs_diff(first) as f64) as usize;
        let samples = n_times - way - 1;
        segments = Segments::new(samples, options.dt);
        seen = read(&segments, &start, samples)?;
    }
    let grid = &segments.grid;
    // Without arrivals, and with means in place of what is quiet.
    for (onset, seen) in onsets.iter_mut().zip(&seen) {
        (onset.arrival, onset.noise) = (None, None);
        onset.baseline = seen.as_ref().map_or(onset.baseline, |seen| seen.mean);
    }
    let mut along = Answer {
        onsets,
        ..Answer::untold(Reason::NoEnergy)
    };
    let bins = segments.transform.bins();
    let flat = grid.sums((0..bins).map(|m| if m < FIRST { 0.0 } else { 1.0 }));
    let all_flat: f64 = flat.iter().sum();
    // Constant records have no energy.
    let mut energies: Vec<f64> = seen.iter().flatten().map(|seen| seen.all).collect();
    let typical = median(&mut energies);
    let moves = |site: &&usize| {
        seen[**site]
            .as_ref()
            .is_some_and(|s| s.all > LIVE * LIVE * typical)
    };
    // Of the floor of a site.
    let floor_error = OF_QUARTILE * (2.0 / DEGREES / (APART * bins as f64).max(1.0)).sqrt();
    let above = |group: &[usize]| {
        let sum = |of: fn(&Seen) -> f64| {
            group
                .iter()
                .filter_map(|&site| seen[site].as_ref())
                .map(of)
                .sum::<f64>()
        };
        let rest = 1.0 - sum(|seen| seen.floor) * all_flat * SEGMENTS as f64 / sum(|seen| seen.all);
        rest > ABOVE_FLOOR.max(SURELY * floor_error / (group.len() as f64).sqrt())
    };
    let groups = groups
        .iter()
        .map(|group| group.iter().filter(moves).copied().collect());
    let groups: Vec<Vec<usize>> = groups
        .filter(|group: &Vec<usize>| !group.is_empty())
        .collect();
    let count = groups.iter().filter(|group| above(group)).count();
    let has_floor = options.struck.is_none() && 2 * count > groups.len();
    let kept: Vec<&Vec<usize>> = groups.iter().filter(|g| !has_floor || above(g)).collect();
    let sums = |of: fn(&Seen) -> f64| seen.iter().flatten().map(of).sum::<f64>();
    let hann = Window::Hann.samples(segments.length);
    let taper_energy: f64 = hann.iter().map(|w| w * w).sum();
    let read = seen.iter().flatten().count() as f64;
    along.noise = 0.5 * sums(|seen| seen.floor) / taper_energy / read * sites.len() as f64;
    let is_slow = bins >= AXIS && sums(|seen| seen.low) > MOST_LOW * sums(|seen| seen.all);
    let rows = kept.iter().map(|group| {
        let error = floor_error / (group.len() as f64).sqrt();
        let row = |site: &usize| {
            // Taken, not copied: spectra of all sites are the most memory that the answer needs.
            let Seen {
                mut parts, floor, ..
            } = seen[*site].take()?;
            let floor = if has_floor { floor } else { 0.0 };
            let less = |part: &mut Vec<f64>, by: f64| {
                let bins = part.iter_mut().zip(&flat);
                bins.for_each(|(p, bins)| *p -= by * bins);
            };
            parts.iter_mut().for_each(|part| less(part, floor));
            let mut again = Vec::new();
            if has_floor {
                let sum = (0..flat.len()).map(|m| parts.iter().map(|part| part[m]).sum());
                let sum: Vec<f64> = sum.collect();
                // The floor as large and as small as it may be.
                again = vec![sum; 2];
                less(&mut again[0], error * floor * SEGMENTS as f64);
                less(&mut again[1], -error * floor * SEGMENTS as f64);
            }
            Some(Row::new([*site; 2], parts, again))
        };
        group.iter().filter_map(row).collect()
    });
    let profile = Profile::new(rows.collect(), &grid.upper, false);
    if profile.len() > 0 {
        along.period = 1.0 / profile.quantile(0, 0.5);
    }
    along.frequency.reason = match (is_slow, kept.len()) {
        (true, _) => Some(short),
        (_, 0) if !groups.is_empty() => Some(Reason::Noise { bound: 1.0 }),
        (_, 0) => Some(Reason::NoEnergy),
        _ => Some(Reason::FewSites { sites: sites.len() }),
    };
    if is_slow || profile.len() < 2 {
        return Ok(along);
    }
    let place = |rows| options.place(rows);
    let judged = profile.judge(options.tolerance, &place);
    along.along_x = Some(profile.evidence([0, judged.group], &place));
    along.frequency = judged.movement;
    Ok(along)
}
