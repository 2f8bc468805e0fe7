//! Records without arrivals: one window, the record, in segments.

use num_complex::Complex;

use super::along_x::Options;
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
/// The first bin that is resolved: Hann's window spreads a mean over those below.
const FIRST: usize = 2;
/// Degrees of freedom of a bin of their mean: half-overlapping segments under Hann's window count 0.9 each but for the ends.
const DEGREES: f64 = 2.0 * 0.91 * SEGMENTS as f64;
/// Relative error of the floor, which is not quite white: energy above three errors of it is no noise.
const UNEVEN: f64 = 0.02;
/// Relative standard error of the lower quartile of so many values is this part of their own over the root of their number; what
/// neighbours share under Hann's window leaves two of three bins.
const OF_QUARTILE: f64 = 1.36;
const APART: f64 = 2.0 / 3.0;
/// Share of the energy in the first bin that is resolved from which on frequencies are not: Hann's window spreads into it what is
/// slower. Bins of an axis that has frequencies at all.
const MOST_LOW: f64 = 0.5;
const AXIS: usize = 16;
/// Likeness of what passes neighbours in neighbouring bins from which on one wave passes both, and part of the record that its way
/// along the array may take.
const ONE_WAVE: f64 = 0.5;
const LONGEST: f64 = 0.4;

/// Segments of records.
struct Segments {
    transform: RecordTransform<f64>,
    samples: usize,
    length: usize,
    grid: Grid,
}

/// What a record holds.
struct Seen {
    /// Powers of each segment on the grid.
    parts: Vec<Vec<f64>>,
    /// White floor of a segment, in a bin that counts twice.
    floor: f64,
    /// Energy in the first bin that is resolved, and in all of them.
    low: f64,
    all: f64,
    /// Spectrum of the segment in the middle.
    middle: Vec<Complex<f32>>,
}

impl Segments {
    fn new(samples: usize, dt: f64) -> Segments {
        let length = 2 * samples / (SEGMENTS + 1);
        let transform = RecordTransform::new(&Window::Hann.samples(length), length);
        Segments {
            grid: Grid::new(transform.bins(), 1.0 / (length as f64 * dt)),
            transform,
            samples,
            length,
        }
    }

    fn of(&self, record: &[f64]) -> Seen {
        let mut scratch = RecordScratch::default();
        let spectra = (0..SEGMENTS).map(|i| {
            let start = i * (record.len() - self.length) / (SEGMENTS - 1);
            let segment = &record[start..start + self.length];
            let (bins, _) = self
                .transform
                .transform(std::iter::once(segment), &mut scratch);
            bins.to_vec()
        });
        let spectra: Vec<Vec<Complex<f64>>> = spectra.collect();
        let power = |spectrum: &[Complex<f64>], m: usize| match m < FIRST {
            true => 0.0,
            false => spectrum[m].norm_sqr() * fold(m, self.length),
        };
        let bins = spectra[0].len();
        let parts = spectra.iter();
        let parts = parts.map(|of| self.grid.sums((0..bins).map(|m| power(of, m))));
        let sum = |m: usize| spectra.iter().map(|of| power(of, m)).sum();
        let mut sums: Vec<f64> = (FIRST..bins).map(sum).collect();
        let (low, all) = (sums.first().copied().unwrap_or(0.0), sums.iter().sum());
        // The last bin may count once.
        sums.pop();
        let quartile = sums.len() / 4;
        let quartile = match sums.is_empty() {
            true => 0.0,
            false => *sums.select_nth_unstable_by(quartile, f64::total_cmp).1,
        };
        let middle = spectra[SEGMENTS / 2].iter();
        Seen {
            parts: parts.collect(),
            floor: quartile / chi_square_quantile(0.25, DEGREES) * DEGREES / SEGMENTS as f64,
            low,
            all,
            middle: middle
                .map(|x| Complex::new(x.re as f32, x.im as f32))
                .collect(),
        }
    }

    /// Samples by which a wave passes a site later than the one before it in a group: by the phase between them over frequency;
    /// 0 where no wave passes both.
    fn delay(&self, groups: &[Vec<usize>], seen: &[Option<Seen>]) -> f64 {
        let mut both = vec![Complex::<f64>::default(); self.transform.bins()];
        let mut each = vec![0.0; both.len()];
        for pair in groups.iter().flat_map(|group| group.windows(2)) {
            let [Some(a), Some(b)] = [&seen[pair[0]], &seen[pair[1]]] else {
                continue;
            };
            let scale = (a.all * b.all).sqrt();
            for (m, (x, y)) in a.middle.iter().zip(&b.middle).enumerate() {
                let product = x * y.conj();
                both[m] += Complex::new(f64::from(product.re), f64::from(product.im)) / scale;
                each[m] += f64::from(x.norm() * y.norm()) / scale;
            }
        }
        let (both, each) = (&both[FIRST..], &each[FIRST..]);
        let scale = std::f64::consts::TAU / self.length as f64;
        let turn = |bins: usize, delay: f64| {
            let turns = both[bins.min(both.len())..].iter().zip(both);
            let turn: Complex<f64> = turns.map(|(x, y)| x * y.conj()).sum();
            turn * Complex::from_polar(1.0, -scale * bins as f64 * delay)
        };
        let all: f64 = each.windows(2).map(|x| x[0] * x[1]).sum();
        if turn(1, 0.0).norm() <= ONE_WAVE * ONE_WAVE * all {
            return 0.0;
        }
        // By bins ever further apart, then by the phases themselves.
        let mut delay = 0.0;
        for bins in [1, 2, 4] {
            delay += turn(bins, delay).arg() / (scale * bins as f64);
        }
        let mut sums = [0.0; 2];
        for (m, x) in both.iter().enumerate() {
            let frequency = scale * (m + FIRST) as f64;
            let left = (x * Complex::from_polar(1.0, -frequency * delay)).arg();
            sums[0] += x.norm() * frequency * left;
            sums[1] += x.norm() * frequency * frequency;
        }
        delay + sums[0] / sums[1]
    }

    /// What these sites hold, from the sample at which the part of each record begins.
    fn read(
        &self,
        prepared: &Prepared,
        groups: &[Vec<usize>],
        start: &(dyn Fn(usize) -> usize + Sync),
        observer: &dyn Observer,
    ) -> Result<Vec<Option<Seen>>> {
        let mut wanted = vec![false; prepared.n_sites()];
        groups.iter().flatten().for_each(|&j| wanted[j] = true);
        let read = prepared.each_record_of(
            |j| wanted[j],
            observer,
            |site, record, _| self.of(&record[start(site)..start(site) + self.samples]),
        )?;
        let mut read = read.into_iter();
        Ok(wanted
            .iter()
            .map(|wanted| wanted.then(|| read.next()).flatten())
            .collect())
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
    let n_times = prepared.n_times();
    let mut segments = Segments::new(n_times, options.dt);
    if segments.length < SHORTEST {
        return Ok(Answer::untold(Reason::SHORT));
    }
    let mut order: Vec<usize> = (0..onsets.len()).filter(|&j| onsets[j].is_live).collect();
    let sites = order.len();
    if options.toward_minus {
        order.reverse();
    }
    // Twice those of the segments, and what is left of them.
    let numbers = (SEGMENTS + 3) * segments.grid.upper.len();
    let groups = options.grouped(&order, sites, numbers);
    let mut seen = segments.read(prepared, &groups, &|_| 0, observer)?;
    // The same part of the wave passes all sites in segments that follow it.
    let delay = segments.delay(&groups, &seen);
    let far = order[0].abs_diff(order[sites - 1]);
    let way = (delay.abs() * far as f64).round();
    if way > (segments.length / SEGMENTS) as f64 && way < LONGEST * n_times as f64 {
        let first = if delay > 0.0 {
            order[0]
        } else {
            order[sites - 1]
        };
        let start = move |site: usize| (delay.abs() * site.abs_diff(first) as f64) as usize;
        segments = Segments::new(n_times - way as usize - 1, options.dt);
        seen = segments.read(prepared, &groups, &start, observer)?;
    }
    for onset in &mut onsets {
        (onset.arrival, onset.noise, onset.baseline) = (None, None, onset.mean);
    }
    let mut along = Answer {
        onsets,
        ..Answer::untold(Reason::NoEnergy)
    };
    let bins = segments.transform.bins();
    let flat = |m: usize| if m < FIRST { 0.0 } else { 1.0 };
    let flat = segments.grid.sums((0..bins).map(flat));
    let read = seen.iter().flatten().count() as f64;
    let sums = |of: fn(&Seen) -> f64| seen.iter().flatten().map(of).sum::<f64>();
    let (low, all, floor) = (sums(|s| s.low), sums(|s| s.all), sums(|s| s.floor));
    let taper = Window::Hann.samples(segments.length);
    let taper_energy: f64 = taper.iter().map(|w| w * w).sum();
    along.noise = 0.5 * floor / taper_energy / read * sites as f64;
    // Where the floor is all there is, it is the motion.
    let of_site = OF_QUARTILE * (2.0 / DEGREES / (APART * bins as f64)).sqrt();
    let error = |sites: f64| UNEVEN.max(of_site / sites.sqrt());
    let of_floor = floor * flat.iter().sum::<f64>() * SEGMENTS as f64 / all;
    let has_floor = options.struck.is_none() && 1.0 - of_floor > 3.0 * error(read);
    let rows = groups.iter().map(|group| {
        let row = |site: &usize| {
            // Taken, not copied: spectra of all sites are the most memory that the answer needs.
            let mut seen = seen[*site].take()?;
            let floor = if has_floor { seen.floor } else { 0.0 };
            for part in &mut seen.parts {
                part.iter_mut()
                    .zip(&flat)
                    .for_each(|(p, bins)| *p -= floor * bins);
            }
            // The floor is off alike at all frequencies, and at the sites of a group.
            let error = error(group.len() as f64) * floor * SEGMENTS as f64;
            let mut off = 0.0;
            let noise = flat.iter().map(|bins| {
                off += error * bins;
                group.len() as f64 * error * bins * (2.0 * off - error * bins)
            });
            Some(Row::new([*site; 2], seen.parts, noise.collect()))
        };
        group.iter().filter_map(row).collect()
    });
    let profile = Profile::new(rows.collect(), &segments.grid.upper, false);
    if profile.len() > 0 {
        along.period = 1.0 / profile.quantile(0, 0.5);
    }
    let is_slow = bins >= AXIS && low > MOST_LOW * all;
    if is_slow || profile.len() < 2 {
        along.frequency.reason = Some(match profile.len() {
            _ if is_slow => Reason::SHORT,
            0 => Reason::Noise { bound: 1.0 },
            _ => Reason::FewSites { sites },
        });
        return Ok(along);
    }
    let place = |rows| options.place(rows);
    let (movement, group) = profile.judge(options.tolerance, &place);
    along.along_x = Some(profile.evidence([0, group], &place));
    along.frequency = movement;
    Ok(along)
}
