//! Records without arrivals: one window, the record, in segments.

use num_complex::Complex;

use super::along_x::Options;
use super::onset::Onset;
use super::profile::{Profile, Row};
use super::windows::Windows;
use super::{Answer, Reason};
use crate::error::Result;
use crate::numeric::chi_square_quantile;
use crate::observer::Observer;
use crate::prepare::{Prepared, Window};
use crate::transform::RecordScratch;

/// Segments of a record, half overlapping under Hann's window, and samples of one at least.
const SEGMENTS: usize = 8;
const SHORTEST: usize = 8;
/// The first bin that is resolved: Hann's window spreads a mean over those below.
const FIRST: usize = 2;
/// Degrees of freedom of a bin of their mean: half-overlapping segments under Hann's window count 0.9 each but for the ends.
const DEGREES: f64 = 2.0 * 0.91 * SEGMENTS as f64;
/// Relative standard error of the lower quartile of so many values is this part of their own over the root of their number; what
/// neighbours share under Hann's window leaves two of three bins.
const OF_QUARTILE: f64 = 1.36;
const APART: f64 = 2.0 / 3.0;
/// Likeness of what passes neighbours in neighbouring bins from which on one wave passes both, and part of the record that its way
/// along the array may take.
const ONE_WAVE: f64 = 0.5;
const LONGEST: f64 = 0.4;

/// Of the segments of records of so many samples.
fn windows(samples: usize, dt: f64) -> Windows {
    let length = 2 * samples / (SEGMENTS + 1);
    Windows::new(&Window::Hann.samples(length), length, FIRST, dt)
}

/// What a record holds.
struct Seen {
    /// Energies of each segment on the grid.
    parts: Vec<Vec<f64>>,
    /// White floor: the power of a bin of a segment.
    floor: f64,
    /// Spectrum of the segment in the middle.
    middle: Vec<Complex<f32>>,
}

impl Seen {
    fn energy(&self) -> f64 {
        self.parts.iter().flatten().sum()
    }

    fn of(record: &[f64], windows: &Windows) -> Seen {
        let mut scratch = RecordScratch::default();
        let spectra = (0..SEGMENTS).map(|i| {
            let start = i * (record.len() - windows.samples) / (SEGMENTS - 1);
            windows.bins(&record[start..start + windows.samples], &mut scratch)
        });
        let spectra: Vec<Vec<Complex<f64>>> = spectra.collect();
        let parts = spectra.iter();
        let parts = parts.map(|of| windows.energies(|m| of[m].norm_sqr()));
        let sum = |m: usize| spectra.iter().map(|of| of[m].norm_sqr()).sum();
        // The last bin may be real, as the first is.
        let mut sums: Vec<f64> = (FIRST..spectra[0].len() - 1).map(sum).collect();
        let quarter = sums.len() / 4;
        let (_, quartile, _) = sums.select_nth_unstable_by(quarter, f64::total_cmp);
        let narrow = |x: &Complex<f64>| Complex::new(x.re as f32, x.im as f32);
        Seen {
            parts: parts.collect(),
            floor: *quartile / chi_square_quantile(0.25, DEGREES) * DEGREES / SEGMENTS as f64,
            middle: spectra[SEGMENTS / 2].iter().map(narrow).collect(),
        }
    }

    /// Samples by which a wave passes a site later than the one before it in a group: by the phase between them over frequency;
    /// 0 where no wave passes both.
    fn delay(windows: &Windows, groups: &[Vec<usize>], seen: &[Option<Seen>]) -> f64 {
        let mut both = vec![Complex::<f64>::default(); windows.transform.bins()];
        let mut each = vec![0.0; both.len()];
        for pair in groups.iter().flat_map(|group| group.windows(2)) {
            let [Some(a), Some(b)] = [&seen[pair[0]], &seen[pair[1]]] else {
                continue;
            };
            let scale = (a.energy() * b.energy()).sqrt();
            for (m, (x, y)) in a.middle.iter().zip(&b.middle).enumerate() {
                let product = x * y.conj();
                both[m] += Complex::new(f64::from(product.re), f64::from(product.im)) / scale;
                each[m] += f64::from(x.norm() * y.norm()) / scale;
            }
        }
        let (both, each) = (&both[FIRST..], &each[FIRST..]);
        let scale = std::f64::consts::TAU / windows.samples as f64;
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
        let finer =
            |delay: f64, bins: usize| delay + turn(bins, delay).arg() / (scale * bins as f64);
        let delay = [1, 2, 4].into_iter().fold(0.0, finer);
        let mut sums = [0.0; 2];
        for (m, x) in both.iter().enumerate() {
            let frequency = scale * (m + FIRST) as f64;
            let left = (x * Complex::from_polar(1.0, -frequency * delay)).arg();
            sums[0] += x.norm() * frequency * left;
            sums[1] += x.norm() * frequency * frequency;
        }
        delay + sums[0] / sums[1]
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
    let mut windows = windows(n_times, options.dt);
    if windows.samples < SHORTEST {
        return Ok(Answer::untold(Reason::ShortRecord));
    }
    let mut order: Vec<usize> = (0..onsets.len()).filter(|&j| onsets[j].is_live).collect();
    let sites = order.len();
    if options.toward_minus {
        order.reverse();
    }
    // Twice those of the segments, and what is left of them.
    let numbers = (SEGMENTS + 3) * windows.grid.upper.len();
    let groups = options.grouped(&order, sites, numbers);
    let is_read = |site: usize| groups.iter().any(|group| group.contains(&site));
    let mut seen =
        prepared.each_record_of(is_read, observer, |_, record, _| Seen::of(record, &windows))?;
    // The same part of the wave passes all sites in segments that follow it.
    let delay = Seen::delay(&windows, &groups, &seen);
    let far = order[0].abs_diff(order[sites - 1]);
    let way = (delay.abs() * far as f64).round();
    if way > (windows.samples / SEGMENTS) as f64 && way < LONGEST * n_times as f64 {
        let first = if delay > 0.0 {
            order[0]
        } else {
            order[sites - 1]
        };
        let samples = n_times - way as usize - 1;
        windows = self::windows(samples, options.dt);
        seen = prepared.each_record_of(is_read, observer, |site, record, _| {
            let start = (delay.abs() * site.abs_diff(first) as f64) as usize;
            Seen::of(&record[start..start + samples], &windows)
        })?;
    }
    for onset in &mut onsets {
        (onset.arrival, onset.noise, onset.baseline) = (None, None, onset.mean);
    }
    let mut along = Answer {
        onsets,
        ..Answer::untold(Reason::NoEnergy)
    };
    let (bins, flat) = (windows.transform.bins(), windows.energies(|_| 1.0));
    let read = seen.iter().flatten().count() as f64;
    let sums = |of: fn(&Seen) -> f64| seen.iter().flatten().map(of).sum::<f64>();
    let (all, floor) = (sums(Seen::energy), sums(|s| s.floor));
    let taper = Window::Hann.samples(windows.samples);
    let taper_energy: f64 = taper.iter().map(|w| w * w).sum();
    along.noise = floor / taper_energy / read * sites as f64;
    // Where the floor is all there is, it is the motion.
    let of_site = OF_QUARTILE * (2.0 / DEGREES / (APART * bins as f64)).sqrt();
    let error = |sites: f64| of_site / sites.sqrt();
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
            // The floor is off alike at all frequencies, and at the sites of a group: variances of cumulated errors, less those before.
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
    let profile = Profile::new(rows.collect(), &windows.grid.upper, false);
    if profile.len() > 0 {
        along.period = 1.0 / profile.quantile(0, 0.5);
    }
    if profile.len() < 2 {
        along.frequency.reason = Some(match profile.len() {
            0 => Reason::Noise { bound: 1.0 },
            _ => Reason::FewSites,
        });
        return Ok(along);
    }
    let place = |rows| options.place(rows);
    let (movement, group) = profile.judge(options.tolerance, &place);
    along.along_x = Some(profile.evidence([0, group], &place));
    along.frequency = movement;
    Ok(along)
}
