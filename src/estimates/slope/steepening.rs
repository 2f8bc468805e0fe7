//! The time at which a steepening field forms a shock.

use std::ops::Range;

use super::Work;
use super::frames::SlopeFrames;
use crate::field::Field;
use crate::numeric::{eliminated, jackknife, student_two_sided};

/// The gradient has to grow by this factor: a front is forming.
const LEAST_GROWTH: f64 = 4.0;
/// The front is followed until it is this many times as steep as at first.
const FITTED: f64 = 3.0;
/// Frames of the fit, at least.
const LEAST_FRAMES: usize = 5;
/// Samples of a front in its band, at least: the cubic through them has four numbers.
const LEAST_SAMPLES: usize = 6;
/// Bands of levels about the steepest: the widest reaches over a quarter of the field's range to both sides, each next
/// one is narrower by the root of two.
const BANDS: usize = 6;
/// The front is known to be crossed where it passes this many times its band: noise at the band's ends moves nothing.
const CROSSED: f64 = 1.5;
/// Half of the interval over the time to the shock, from which on there is no shock time to state.
const LARGEST_HALF: f64 = 0.1;

/// Where a front would become infinitely steep.
///
/// Without viscosity each level u of a front moves at a speed of its own, in Burgers' equation at `u`: the
/// distance between two levels falls along a straight line. About the steepest level the front of all snapshots together is
///
/// ```text
/// x = x_n + (a + c t) w + b w^2 + d w^3,    t_s = -(a - b^2 / 3 d) / c,
/// ```
///
/// w the level, `x_n` the place at snapshot n, by least squares of the places, which samples hold exactly. The error of the
/// cubic is the difference to that of a band wider by the root of two, that of the straight line the difference to the first
/// half of the frames as far as noise does not explain it; the error of noise is a jackknife over frames. `v = sin x`
/// with `dv/dt = -v dv/dx` has `t_s = 1 / max |dv/dx| = 1`.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Steepening {
    pub shock_time: f64,
    /// Half of its interval.
    pub half: f64,
    /// Frames of the fit.
    pub frames: usize,
    /// Largest over first gradient.
    pub growth: f64,
    /// Slope in the frame that holds the shock time, with half of the interval of its regression; NaN where the record
    /// ends before.
    pub slope_at_shock: f64,
    pub slope_half: f64,
    /// Mean of the slopes of the frames from 1.5 shock times after the first on, and their extremes; NaN where
    /// there are none.
    pub slope_after: f64,
    pub slope_after_range: [f64; 2],
}

impl Steepening {
    /// `None` for a field without a front that steepens so, and where its time is not known to a tenth.
    pub(super) fn of(frames: &SlopeFrames, work: &Work<'_>) -> Option<Steepening> {
        let gradient = &frames.gradient;
        let first = *gradient.first().filter(|first| **first > 0.0)?;
        let growth = gradient.iter().copied().fold(0.0, f64::max) / first;
        let steep = gradient.iter().position(|g| *g >= LEAST_GROWTH * first)?;
        let mut front = Front::of(work, steep)?;
        // The steepest level between the sites first, then about that of the first fit.
        front.level += front.best()?.off;
        let found = front.best()?;
        let start = work.first.time.at(0);
        let span = work.first.time.at(work.first.n_times() - 1) - start;
        let (after_start, half) = (found.time * span, found.half * span);
        let is_known = half <= LARGEST_HALF * after_start;
        let shock_time = start + after_start;
        let time = &frames.time;
        let off = |i: &usize| (time[*i] - shock_time).abs();
        let nearest = (0..time.len()).min_by(|a, b| off(a).total_cmp(&off(b)))?;
        // Of a record that ends before the shock there is none.
        let has_shock = shock_time < time[time.len() - 1] + (time[1] - time[0]);
        let at_shock = |of: &[f64]| if has_shock { of[nearest] } else { f64::NAN };
        let is_after = |(t, s): &(&f64, &f64)| **t >= start + 1.5 * after_start && s.is_finite();
        let after = time.iter().zip(&frames.slope).filter(is_after);
        let after: Vec<f64> = after.map(|p| *p.1).collect();
        let ends = |of: fn(f64, f64) -> f64| after.iter().copied().fold(f64::NAN, of);
        is_known.then(|| Steepening {
            shock_time,
            half,
            frames: found.frames,
            growth,
            slope_at_shock: at_shock(&frames.slope),
            slope_half: at_shock(&frames.half),
            slope_after: after.iter().sum::<f64>() / after.len() as f64,
            slope_after_range: [ends(f64::min), ends(f64::max)],
        })
    }
}

/// Least squares of the place by four numbers: the rows of the normal equations, with their right-hand sides.
type Normal = [[f64; 5]; 4];

/// A front of all fields.
struct Front<'a> {
    work: &'a Work<'a>,
    /// That about which the bands lie.
    level: f64,
    /// Half of the range of the first snapshot, negative for a front that rises along x.
    size: f64,
}

/// What a band gives, in units of the record's length.
struct Found {
    time: f64,
    half: f64,
    frames: usize,
    /// The steepest level less that of the front.
    off: f64,
}

impl<'a> Front<'a> {
    /// The steepest place of a frame.
    fn of(work: &'a Work<'a>, frame: usize) -> Option<Self> {
        let (level, size) = (0.0, 1.0);
        let mut front = Front { work, level, size };
        let row = front.row(work.first, work.times(frame).start);
        let steeper = |a: &&[f64], b: &&[f64]| (a[1] - a[0]).abs().total_cmp(&(b[1] - b[0]).abs());
        let steps = row.windows(2);
        let known = steps.filter(|s| s.iter().all(|v| v.is_finite()));
        let step = known.max_by(steeper)?;
        let whole = front.row(work.first, 0);
        let ends = |of: fn(f64, f64) -> f64| whole.iter().copied().fold(f64::NAN, of);
        front.level = 0.5 * (step[0] + step[1]);
        front.size = (step[0] - step[1]).signum() * 0.5 * (ends(f64::max) - ends(f64::min));
        Some(front)
    }

    /// A snapshot in units of the front.
    fn row(&self, field: &Field, n: usize) -> Vec<f64> {
        let mut row = vec![0.0; field.n_sites()];
        field.read_time_major(n..n + 1, 0..field.n_sites(), &mut row);
        let values = row.iter_mut();
        values.for_each(|v| *v = (*v - self.level) / self.size);
        row
    }

    /// Of each band the frames until the front is too steep.
    fn bands(&self) -> Vec<Vec<Normal>> {
        let mut bands = vec![Vec::new(); BANDS];
        let mut open = [true; BANDS];
        for frame in 0..self.work.frames() {
            let mut sums = [Normal::default(); BANDS];
            let of = |field| self.work.times(frame).map(move |n| (field, n));
            for (field, n) in self.work.fields.iter().flat_map(of) {
                let row = self.row(field, n);
                let time = n as f64 / (field.n_times() - 1) as f64;
                for (b, sums) in sums.iter_mut().enumerate().filter(|(b, _)| open[*b]) {
                    add_front(sums, &row, band(b), time);
                }
            }
            let width = |sums: &Normal| (sums[0][4] / sums[0][0]).abs();
            // The front may be between the ends of a ring, and seen again.
            let seen = |(_, sums): &(usize, Normal)| sums[0][0] > 0.0;
            for (b, sums) in sums.into_iter().enumerate().filter(seen) {
                let first = bands[b].first().map_or(0.0, width);
                open[b] &= FITTED * width(&sums) >= first;
                if open[b] {
                    bands[b].push(sums);
                }
            }
            if open == [false; BANDS] {
                break;
            }
        }
        bands
    }

    /// The band with the smallest interval.
    fn best(&self) -> Option<Found> {
        let bands = self.bands();
        let found = bands.windows(2).zip(1..).filter_map(|(pair, b)| {
            let [wide, narrow] = [&pair[0], &pair[1]];
            let n = narrow.len();
            if n < LEAST_FRAMES || wide.len() < LEAST_FRAMES {
                return None;
            }
            // The time, and what a wider band and half of the frames make of it.
            let times = |without: usize| {
                let time = shock(narrow, without)?.0;
                let of_half = shock(&narrow[..n.div_ceil(2)], without)?.0;
                Some([time, time - shock(wide, without)?.0, time - of_half])
            };
            let all = times(usize::MAX)?;
            let each: Vec<[f64; 3]> = (0..n).map(times).collect::<Option<_>>()?;
            let error = |i: usize| jackknife(&each.iter().map(|one| one[i]).collect::<Vec<f64>>());
            let line = (all[2].powi(2) - error(2).powi(2)).max(0.0);
            // Four numbers are fitted.
            let noise = student_two_sided(self.work.request.alpha, (n - 4) as f64) * error(0);
            Some(Found {
                time: all[0],
                half: (noise * noise + all[1] * all[1] + line).sqrt(),
                frames: n,
                off: shock(narrow, usize::MAX)?.1 * band(b) * self.size,
            })
        });
        found.min_by(|a, b| a.half.total_cmp(&b.half))
    }
}

/// The level to which band `b` reaches.
fn band(b: usize) -> f64 {
    0.5f64.powf(1.0 + 0.5 * b as f64)
}

/// Adds the samples of the front of a snapshot that lie within `band` of its level.
fn add_front(sums: &mut Normal, row: &[f64], band: f64, time: f64) {
    let Some(front) = fastest(row, CROSSED * band) else {
        return;
    };
    let samples = front
        .map(|j| (j as f64, row[j] / band))
        .filter(|(_, w)| w.abs() <= 1.0);
    let columns = samples.map(|(x, w)| [w, w * time, w * w, w * w * w, x]);
    let columns: Vec<[f64; 5]> = columns.collect();
    if columns.len() < LEAST_SAMPLES {
        return;
    }
    let mean = |c: usize| columns.iter().map(|row| row[c]).sum::<f64>() / columns.len() as f64;
    let means: [f64; 5] = std::array::from_fn(mean);
    for row in &columns {
        for (a, sums) in sums.iter_mut().enumerate() {
            for (b, sum) in sums.iter_mut().enumerate() {
                *sum += (row[a] - means[a]) * (row[b] - means[b]);
            }
        }
    }
}

/// Sites between the last above `level` and the first below `-level`, where they are fewest.
fn fastest(row: &[f64], level: f64) -> Option<Range<usize>> {
    let (mut from, mut best) = (None, None::<Range<usize>>);
    for (j, v) in row.iter().enumerate() {
        if *v >= level {
            from = Some(j + 1);
        } else if *v <= -level
            && let Some(from) = from.take()
            && best.as_ref().is_none_or(|best| j - from < best.len())
        {
            best = Some(from..j);
        }
    }
    best
}

/// Shock time and steepest level, in units of the band, from all frames but one. `None` where the front is nowhere in the band
/// steepest.
fn shock(frames: &[Normal], without: usize) -> Option<(f64, f64)> {
    let mut rows = vec![vec![0.0; 5]; 4];
    for (_, frame) in frames.iter().enumerate().filter(|(i, _)| *i != without) {
        for (sum, value) in rows.iter_mut().flatten().zip(frame.iter().flatten()) {
            *sum += value;
        }
    }
    let solved = eliminated(rows, 0.0)?;
    let [a, c, b, d] = std::array::from_fn(|i| solved[i][0]);
    let steepest = -b / (3.0 * d);
    let time = -(a - b * b / (3.0 * d)) / c;
    (a * d > 0.0 && steepest.abs() <= 1.0 && time.is_finite()).then_some((time, steepest))
}
