//! What is wrong with single channels: each is held against those beside it, over a part of the record.

use std::ops::Range;

use num_complex::Complex;
use rayon::prelude::*;
use serde_json::{Value, json};

use super::scan::{ChannelScan, fill};
use super::{Gaps, Window};
use crate::error::{Error, Result};
use crate::field::{Axis, Field};
use crate::numeric::student_two_sided;
use crate::observer::Observer;
use crate::sheet::{Describe, PlotRow, Sheet, Warning, number, percent, six_digits, with_half};
use crate::transform::{RecordScratch, RecordTransform};

/// Samples of a stretch of the record at most, and stretches, evenly spread.
const LENGTH: usize = 1024;
const STRETCHES: usize = 16;
/// Samples of a stretch, below which the whole record is one.
const SHORT: usize = 64;
/// Bands of the frequency axis whose levels are compared.
const BANDS: usize = 8;
/// Sites that a thread reads together.
const TILE: usize = 8;
/// Samples that are looked at, at most: fewer of each record where there are many.
const SAMPLES: usize = 1 << 20;
/// Records that are constant where they are looked at, of which the rest is read, at most.
const READ: usize = 16;
/// Power of a band over that of the strongest, below which it holds only rounding.
const ROUNDING: f64 = 1e-20;

/// How much louder or quieter than those beside it a site is that is too loud or quiet.
const LOUD: f64 = 100.0;
/// Neighbours that are too loud, quiet or noisy together, at most.
const TOGETHER: usize = 2;
/// Equal samples on an extreme that make a record look clipped.
const CLIPPED_RUN: usize = 4;
/// Energy in the top tenth of the frequency axis over that of the sites beside it; how much these may exceed
/// the median; its least share of the site's energy.
const NOISY: f64 = 30.0;
const NOISY_ALIKE: f64 = 10.0;
const NOISY_SHARE: f64 = 1e-4;
/// Sites on each side that a noisy one is held against.
const BESIDE: usize = 2;

/// Pairs of neighbours on each side that a pair is held against.
const PAIRS: usize = 4;
/// Coherence of a pair, and likeness of the phases of those beside it, from which on its phase is compared.
const COHERENT: f64 = 0.5;
const ALIKE: f64 = 0.8;
/// Part of the cross-correlation with those beside it that lies at no delay, above which a pair is like them; and that lies at another
/// delay, or has the other sign, from which on it is late, or reversed.
const SAME: f64 = 0.5;
const OTHER: f64 = 0.8;
/// Amplitude over that of the sites about it, below which a site may be at a node of standing waves.
const NODE: f64 = 0.5;

/// Sites on each side of a step of the gain, and how much bands and sites may differ, as a part of the step's logarithm; the least step; the
/// probability by which chance makes one anywhere.
const SIDE: usize = 4;
const UNEVEN: f64 = 0.3;
const LEAST: f64 = 1.5;
const CHANCE: f64 = 1e-3;
/// Standard deviation of a normal variable over the median magnitude of the difference of two, `1 / (0.6745 sqrt 2)`; and of the
/// difference of the medians of two times four of them over theirs, by their order statistics.
const OF_MAGNITUDES: f64 = 1.0484;
const OF_MEDIANS: f64 = 0.7725;

const LEAVE_OUT: &str =
    "check the sensors; leave the sites out of spectra along time with `--without-sites`";
const SCALE: &str = "scale the records before energies of sites are compared";

/// What there is to say about the channels of a field.
#[derive(Debug, Clone, Default)]
pub(crate) struct Channels {
    pub warnings: Vec<Warning>,
    /// Whether gains step along x.
    pub has_steps: bool,
}

/// A result, with what is wrong with the channels of its field.
#[derive(Debug, Clone)]
pub struct Examined<D> {
    pub found: D,
    pub channels: Vec<Warning>,
}

impl<D: Describe> Describe for Examined<D> {
    fn describe(&self) -> Sheet<'_> {
        let mut sheet = self.found.describe();
        for warning in &self.channels {
            if sheet.warnings.iter().all(|own| own.code != warning.code) {
                sheet.warnings.push(warning.clone());
            }
        }
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        self.found.pictures()
    }
}

/// What there is to say about single channels: gaps, dead, quiet, saturated, loud and noisy ones, those that are reversed in sign or late,
/// and gains that step along x. Sixteen stretches of the record are looked at, 1024 samples each. None of a simulated run.
///
/// # Errors
/// [`Error::Cancelled`].
pub fn channel_findings(field: &Field, observer: &dyn Observer) -> Result<Vec<Warning>> {
    let all = (0..field.n_times(), 0..field.n_sites());
    Ok(channels(field, all, (&[], None), observer)?.warnings)
}

/// Of a range, but for these sites of the file; with what is known of its whole records.
pub(crate) fn channels(
    field: &Field,
    (times, sites): (Range<usize>, Range<usize>),
    (left_out, known): (&[usize], Option<&[ChannelScan]>),
    observer: &dyn Observer,
) -> Result<Channels> {
    if field.struck.is_some() || times.len() < 2 || sites.is_empty() {
        return Ok(Channels::default());
    }
    Look::new(field, times, sites, (left_out, known), observer).map(|look| look.channels())
}

/// Sites of a finding, by index in the file.
pub(crate) struct Sites<'a> {
    pub indices: Vec<usize>,
    pub space: &'a Axis,
}

impl Sites<'_> {
    /// Says this of them: `sites 3, 7 at 0.3, 0.7 m: constant`.
    pub fn warning(&self, code: &'static str, what: &str, advice: &str, numbers: Value) -> Warning {
        let positions: Vec<f64> = self.indices.iter().map(|j| self.space.at(*j)).collect();
        let noun = match self.indices.len() {
            1 => "site",
            _ => "sites",
        };
        // Sites in a row as `20-39`.
        let runs: Vec<&[usize]> = self.indices.chunk_by(|a, b| a + 1 == *b).collect();
        let ends = |run: &&[usize], word: &dyn Fn(usize) -> String| match run {
            [only] => word(*only),
            [first, .., last] => format!("{}-{}", word(*first), word(*last)),
            [] => String::new(),
        };
        let indices = some(runs.iter().map(|run| ends(run, &|j| j.to_string())));
        let is_counted = self.space.unit.is_none() && self.space.step == 1.0;
        let at = match is_counted {
            true => String::new(),
            false => {
                let position = |j: usize| six_digits(self.space.at(j));
                let positions = some(runs.iter().map(|run| ends(run, &position)));
                format!(" at {positions} {}", self.space.space_unit())
            }
        };
        let mut all = json!({"sites": self.indices, "positions": positions});
        if let (Value::Object(all), Value::Object(more)) = (&mut all, numbers) {
            all.extend(more);
        }
        Warning::new(format!("{noun} {indices}{at}: {what}"), advice).coded(code, all)
    }
}

/// The first few.
pub(crate) fn some(words: impl ExactSizeIterator<Item = String>) -> String {
    let more = if words.len() > 8 { ", ..." } else { "" };
    format!("{}{more}", words.take(8).collect::<Vec<_>>().join(", "))
}

/// One record.
#[derive(Debug, Clone)]
struct Record {
    scan: ChannelScan,
    /// Root mean square of the motion; powers over that of all bins: of the top tenth of the axis, and of bands.
    level: f64,
    top: f64,
    bands: [f64; BANDS],
    /// Cross-spectrum with the next record, both of unit power; empty without motion.
    next: Vec<Complex<f64>>,
}

/// What a part of each record holds.
struct Look<'a> {
    field: &'a Field,
    sites: Range<usize>,
    left_out: &'a [usize],
    records: Vec<Record>,
    /// Samples of the stretches, and of all of them.
    length: usize,
    samples: usize,
    /// Whether these are all samples.
    is_whole: bool,
}

impl<'a> Look<'a> {
    fn new(
        field: &'a Field,
        times: Range<usize>,
        sites: Range<usize>,
        (left_out, known): (&'a [usize], Option<&[ChannelScan]>),
        observer: &dyn Observer,
    ) -> Result<Look<'a>> {
        let n = times.len();
        let most = (SAMPLES / sites.len()).clamp(1, LENGTH * STRETCHES);
        // Of a record that is looked at as a whole they overlap by half: a pulse lies in one of them.
        let is_whole = n <= most;
        let length = match (is_whole, n / 8) {
            (true, ..SHORT) => n,
            (true, eighth) => eighth,
            (false, _) => (most / STRETCHES).max(SHORT.min(most)).min(n),
        };
        let (read, hop) = match is_whole {
            true => (vec![times.clone()], length.div_ceil(2)),
            false => {
                let count = (most / length).clamp(1, STRETCHES);
                let start = |s: usize| times.start + s * (n - length) / (count - 1).max(1);
                let ranges = (0..count).map(|s| start(s)..start(s) + length);
                (ranges.collect(), length)
            }
        };
        let samples: usize = read.iter().map(Range::len).sum();
        let transform = RecordTransform::<f64>::new(&Window::Hann.samples(length), length);
        observer.stage("channels", sites.len() as u64);
        field.release_pages();
        let of_tile = |first: usize| -> Result<Vec<Record>> {
            if observer.cancelled() {
                return Err(Error::Cancelled);
            }
            let own = first..sites.end.min(first + TILE);
            // The first of the next tile, too.
            let with_next = first..sites.end.min(own.end + 1);
            let mut records = vec![Vec::with_capacity(samples); with_next.len()];
            let mut block = Vec::new();
            for times in &read {
                block.resize(with_next.len() * times.len(), 0.0);
                field.read_site_major(times.clone(), with_next.clone(), &mut block);
                // Pages that are mapped count as memory, and a fault maps many.
                field.release_pages();
                for (record, samples) in records.iter_mut().zip(block.chunks_exact(times.len())) {
                    record.extend_from_slice(samples);
                }
            }
            let spectra: Vec<_> = records
                .iter_mut()
                .map(|record| Spectra::of(record, &transform, hop))
                .collect();
            observer.advance(own.len() as u64);
            let next = |i: usize| spectra.get(i + 1).map(|next| spectra[i].with(next));
            let found = (0..own.len()).map(|i| spectra[i].record(next(i).unwrap_or_default()));
            Ok(found.collect())
        };
        let firsts: Vec<usize> = sites.clone().step_by(TILE).collect();
        let tiles: Result<Vec<Vec<Record>>> = firsts.into_par_iter().map(of_tile).collect();
        let mut look = Look {
            field,
            sites,
            left_out,
            records: tiles?.concat(),
            length,
            samples,
            is_whole,
        };
        for j in left_out.iter().filter(|j| look.sites.contains(j)) {
            let row = j - look.sites.start;
            look.records[row] = Record::NOTHING;
            if let Some(before) = row.checked_sub(1) {
                look.records[before].next.clear();
            }
        }
        if let Some(known) = known {
            let records = look.records.iter_mut().zip(known);
            records.for_each(|(record, scan)| record.scan = *scan);
        } else if !is_whole {
            // What is constant in the stretches may move between them.
            let rows = 0..look.records.len();
            let constant = rows.filter(|row| look.records[*row].scan.constant);
            let constant: Vec<usize> = constant.collect();
            for row in &constant {
                let scan = &mut look.records[*row].scan;
                scan.constant = constant.len() <= READ;
                if scan.constant {
                    let mut whole = vec![0.0; n];
                    let site = look.sites.start + row;
                    field.read_site_major(times.clone(), site..site + 1, &mut whole);
                    *scan = ChannelScan::of(&whole);
                    field.release_pages();
                }
            }
        }
        Ok(look)
    }

    fn channels(&self) -> Channels {
        let mut warnings: Vec<Warning> = self.gaps().into_iter().collect();
        let space = &self.field.space;
        let mut say = |rows: &[usize], code, what: &str, advice, numbers: Value| {
            if !rows.is_empty() {
                let indices = rows.iter().map(|j| self.sites.start + j).collect();
                warnings.push(Sites { indices, space }.warning(code, what, advice, numbers));
            }
        };
        let levels: Vec<f64> = self.records.iter().map(|record| record.level).collect();
        let dead = self.dead();
        say(&dead, "dead-channels", "constant", LEAVE_OUT, json!({}));
        let run = |j: &usize| self.records[*j].scan.clipped_run;
        let clipped: Vec<usize> = (0..levels.len())
            .filter(|j| run(j) >= CLIPPED_RUN)
            .collect();
        let longest = clipped.iter().map(run).max();
        let what = format!(
            "on the extreme value for up to {} samples",
            longest.unwrap_or(0)
        );
        let advice = "lower the gain or the amplitude; clipping makes harmonics that are not there";
        let numbers = json!({"longest": longest});
        say(&clipped, "saturated-channels", &what, advice, numbers);
        let (quiet, ratio) = self.quiet(&levels).unwrap_or_default();
        let what = format!(
            "less than 1/{LOUD} as loud as both beside, down to {} of the median",
            number(ratio)
        );
        say(
            &quiet,
            "quiet-channels",
            &what,
            LEAVE_OUT,
            json!({"ratio": ratio}),
        );
        let (loud, ratio) = loud(&levels).unwrap_or_default();
        let what = format!(
            "more than {LOUD} times as loud as those beside, up to {} times the median",
            number(ratio)
        );
        let advice = "check gains and units: this energy decides spectra and directions; leave out with \
                      `--without-sites`, or scale first";
        say(
            &loud,
            "loud-channels",
            &what,
            advice,
            json!({"ratio": ratio}),
        );
        let (noisy, ratio) = self.noisy(&loud).unwrap_or_default();
        let what = format!(
            "up to {} times the energy of those beside in the top tenth below Nyquist",
            number(ratio)
        );
        say(
            &noisy,
            "noisy-channels",
            &what,
            LEAVE_OUT,
            json!({"ratio": ratio}),
        );
        let [reversed, late] = self.out_of_step();
        let rows: Vec<usize> = reversed.into_iter().map(|(j, _)| j).collect();
        let what = "reversed in sign against the others";
        say(
            &rows,
            "reversed-channels",
            what,
            "turn the sign of these records",
            json!({}),
        );
        let (rows, delays): (Vec<usize>, Vec<f64>) = late.into_iter().unzip();
        let shown: Vec<f64> = delays.iter().fold(Vec::new(), |mut shown, delay| {
            if !shown.contains(delay) {
                shown.push(*delay);
            }
            shown
        });
        let shown = some(shown.iter().map(|delay| format!("{delay:+}")));
        let what = format!("{shown} samples behind the others");
        let advice = "shift these records, or check the clock of their recorder";
        say(
            &rows,
            "late-channels",
            &what,
            advice,
            json!({"samples": delays}),
        );
        let steps = self.steps();
        let ratios: Vec<f64> = steps.iter().map(|step| step.ratio).collect();
        let errors: Vec<f64> = steps.iter().map(|step| step.error).collect();
        let said = ratios.iter().zip(&errors);
        let said = said.map(|(ratio, error)| format!("x {}", with_half(*ratio, *error, "")));
        let what = format!("from there on the gain changes along x, {}", some(said));
        let rows: Vec<usize> = steps.iter().map(|step| step.row).collect();
        let numbers = json!({"ratios": ratios, "ratio_errors": errors});
        say(&rows, "gain-steps", &what, SCALE, numbers);
        Channels {
            warnings,
            has_steps: !steps.is_empty(),
        }
    }

    fn gaps(&self) -> Option<Warning> {
        let gaps: usize = self.records.iter().map(|record| record.scan.gaps).sum();
        let with = self.records.iter().filter(|record| record.scan.gaps > 0);
        let (sites, all) = (with.count(), self.records.len());
        let share = gaps as f64 / (self.samples * all) as f64;
        let message = format!(
            "{gaps} samples at {sites} of {all} sites were not finite ({} of {})",
            percent(share),
            if self.is_whole {
                "the field"
            } else {
                "those looked at"
            }
        );
        let numbers = json!({"samples": gaps, "sites": sites, "share": share});
        let warning = Warning::new(message, "read spectra of these sites with care");
        (gaps > 0).then(|| warning.coded("gaps", numbers))
    }

    fn is_left_out(&self, j: usize) -> bool {
        self.left_out.contains(&(self.sites.start + j))
    }

    /// Constant records. Sites of nothing but zeros that reach an end of the array may be ahead of a front: none
    /// is dead if the first that moves is as quiet as a front begins.
    fn dead(&self) -> Vec<usize> {
        let n = self.records.len();
        let largest = |j: usize| match self.records[j].scan {
            scan if scan.constant => scan.largest,
            _ => self.records[j].level,
        };
        let most = (0..n).map(largest).fold(0.0, f64::max);
        let is_zero = |j: &usize| largest(*j) == 0.0;
        let is_front = |j: Option<usize>| j.is_some_and(|j| LOUD * largest(j) < most);
        let [head, tail] = [
            (0..n).find(|j| !is_zero(j)).filter(|j| is_front(Some(*j))),
            (0..n).rfind(|j| !is_zero(j)).filter(|j| is_front(Some(*j))),
        ];
        let is_ahead = |j: usize| head.is_some_and(|head| j < head) || tail.is_some_and(|t| j > t);
        let is_dead =
            |j: &usize| self.records[*j].scan.constant && !is_ahead(*j) && !self.is_left_out(*j);
        (0..n).filter(is_dead).collect()
    }

    /// Sites that move: neither constant nor left out.
    fn live(&self) -> Vec<usize> {
        let lives = |j: &usize| self.records[*j].level > 0.0 && !self.is_left_out(*j);
        (0..self.records.len()).filter(lives).collect()
    }

    /// Sites far quieter than both beside them, while most are alike; the least part of these. A node of a
    /// standing wave is quiet, too: there the sites beside it cancel.
    fn quiet(&self, levels: &[f64]) -> Option<(Vec<usize>, f64)> {
        let live = self.live();
        let level = |i: usize| levels[live[i]];
        if !are_alike(live.iter().map(|&j| levels[j]), LOUD) {
            return None;
        }
        let median = median(live.iter().map(|&j| levels[j]))?;
        let stands_out = |from: usize, end: usize| {
            let (Some(before), true) = (from.checked_sub(1), end < live.len()) else {
                return false;
            };
            let most = (from..end).map(level).fold(0.0, f64::max);
            let is_quiet = LOUD * most < level(before).min(level(end));
            is_quiet && !self.is_node(live[before], live[end])
        };
        let rows = outstanding(live.len(), |i| LOUD * level(i) < median, stands_out);
        let rows: Vec<usize> = rows.into_iter().map(|i| live[i]).collect();
        let least = rows.iter().map(|&j| levels[j]).reduce(f64::min)?;
        Some((rows, least / median))
    }

    /// Whether the records of two sites are opposite: the sum of the phases of the pairs between them.
    fn is_node(&self, a: usize, b: usize) -> bool {
        let mut product: Vec<Complex<f64>> = Vec::new();
        for pair in &self.records[a..b] {
            match product.is_empty() {
                true => product.clone_from(&pair.next),
                false => product
                    .iter_mut()
                    .zip(&pair.next)
                    .for_each(|(p, z)| *p *= z),
            }
        }
        let all: f64 = product.iter().map(|z| z.norm()).sum();
        product.iter().map(|z| z.re).sum::<f64>() < -SAME * all
    }

    /// Sites with far more energy in the top tenth of the frequency axis than those beside them, while these are
    /// alike; over that of those beside them. Not those that are `loud` anyway, nor those at an end of the array, where
    /// motion that is driven there may die away from one site to the next.
    fn noisy(&self, loud: &[usize]) -> Option<(Vec<usize>, f64)> {
        let live = self.live();
        let top = |i: usize| self.records[live[i]].top_power();
        let median = median((0..live.len()).map(top)).filter(|median| *median > 0.0)?;
        let is_high = |i: usize| {
            let row = &self.records[live[i]];
            row.top_power() > NOISY * median
                && row.top > NOISY_SHARE
                // The ends of gaps leak.
                && row.scan.gaps == 0
                && !loud.contains(&live[i])
        };
        let beside = |from: usize, end: usize| {
            let before = (0..from).rev().take(BESIDE);
            before.chain((end..live.len()).take(BESIDE))
        };
        let stands_out = |from: usize, end: usize| {
            let least = (from..end).map(top).fold(f64::INFINITY, f64::min);
            let beside = |i: usize| NOISY * top(i) < least && top(i) < NOISY_ALIKE * median;
            from > 0
                && end < live.len()
                && live.len() > 2 * BESIDE + TOGETHER
                && self::both(from, end, live.len(), beside)
        };
        let found = outstanding(live.len(), is_high, stands_out);
        let most_beside = |i: usize| beside(i, i + 1).map(top).fold(0.0, f64::max);
        let ratio = found
            .iter()
            .map(|&i| top(i) / most_beside(i).max(f64::MIN_POSITIVE))
            .reduce(f64::max)?;
        Some((found.into_iter().map(|i| live[i]).collect(), ratio))
    }

    /// Sites whose sign, and whose delay in samples, are not those of most others: where the phase between two neighbours is not that of
    /// the pairs beside them, while these are alike.
    fn out_of_step(&self) -> [Vec<(usize, f64)>; 2] {
        let n = self.records.len();
        let (mut signs, mut delays) = (vec![1.0; n], vec![0.0; n]);
        for row in 1..n {
            let [sign, delay] = self.against_those_beside(row - 1).unwrap_or([1.0, 0.0]);
            signs[row] = signs[row - 1] * sign;
            delays[row] = delays[row - 1] + delay;
        }
        // Of two halves the first is right.
        let usual = |values: &[f64]| {
            let runs = values.chunk_by(|a, b| a == b);
            let mut counts: Vec<(f64, usize)> = Vec::new();
            for run in runs {
                match counts.iter_mut().find(|(value, _)| *value == run[0]) {
                    Some((_, count)) => *count += run.len(),
                    None => counts.push((run[0], run.len())),
                }
            }
            let most = counts.iter().map(|(_, count)| *count).max();
            let first = counts.iter().find(|(_, count)| Some(*count) == most);
            first.map_or(0.0, |(value, _)| *value)
        };
        [(signs, true), (delays, false)].map(|(values, is_sign)| {
            let usual = usual(&values);
            let apart = values.into_iter().enumerate();
            let apart = apart.filter(|(_, value)| *value != usual);
            let less = |value: f64| if is_sign { value } else { value - usual };
            apart.map(|(row, value)| (row, less(value))).collect()
        })
    }

    /// Sign and delay of a pair of neighbours against the pairs beside it; `None` where it is like them, or it cannot be told.
    fn against_those_beside(&self, row: usize) -> Option<[f64; 2]> {
        let n = self.records.len();
        let own = &self.records[row].next;
        let size = |z: &[Complex<f64>]| z.iter().map(|z| z.norm()).sum::<f64>();
        let level = |j: usize| self.records[j].level;
        // One site alone is in the next pair, too.
        let before = row.saturating_sub(PAIRS + 1)..row.saturating_sub(1);
        let near = [before, (row + 2).min(n - 1)..(row + PAIRS + 2).min(n - 1)];
        let about = median((near[0].start..near[1].end + 1).map(level))?;
        let is_node = level(row).min(level(row + 1)) < NODE * about;
        if size(own) < COHERENT || is_node {
            return None;
        }
        // The sum of those on each side, and how alike they are.
        let sides = near.map(|pairs| {
            let pairs = pairs.map(|pair| &self.records[pair].next);
            let pairs: Vec<_> = pairs.filter(|next| size(next) > COHERENT).collect();
            let sum = |m: usize| pairs.iter().map(|z| z[m]).sum::<Complex<f64>>();
            let sum: Vec<Complex<f64>> = (0..own.len()).map(sum).collect();
            let alike = size(&sum) / pairs.iter().map(|z| size(z)).sum::<f64>();
            (sum, if pairs.len() < PAIRS / 2 { 0.0 } else { alike })
        });
        let [(before, some), (after, others)] = sides;
        let both = before.iter().zip(&after).map(|(a, b)| a.conj() * b);
        let both: Vec<Complex<f64>> = both.collect();
        let are_alike = both.iter().map(|z| z.re).sum::<f64>() > ALIKE * size(&both);
        if !are_alike || some.min(others) < ALIKE {
            return None;
        }
        let usual: Vec<Complex<f64>> = before.iter().zip(&after).map(|(a, b)| a + b).collect();
        let turned = own.iter().zip(&usual);
        let turned =
            turned.map(|(z, usual)| z * usual.conj() / usual.norm().max(f64::MIN_POSITIVE));
        let turned: Vec<Complex<f64>> = turned.collect();
        let all = size(&turned);
        // The cross-correlation at a delay, of what is left of the phase.
        let at = |delay: isize| {
            let angle = std::f64::consts::TAU * delay as f64 / self.length as f64;
            let terms = turned.iter().enumerate();
            let terms = terms.map(|(m, z)| (z * Complex::cis(angle * m as f64)).re);
            terms.sum::<f64>() / all
        };
        if at(0) > SAME {
            return None;
        }
        // Of a narrow band, a record that is late by half a period looks reversed: then neither is said.
        let most = (self.length / 4) as isize;
        let apart: Vec<(isize, f64)> = (-most..=most).map(|delay| (delay, at(delay))).collect();
        let (delay, peak) = apart.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let least = apart.iter().fold(0.0, |least: f64, of| least.min(of.1));
        match (peak > OTHER, at(0) < -OTHER) {
            (true, _) if least > -SAME => Some([1.0, delay as f64]),
            (_, true) if peak < SAME => Some([-1.0, 0.0]),
            _ => None,
        }
    }

    /// Steps of the gain between live sites: all bands alike.
    fn steps(&self) -> Vec<GainStep> {
        let live = self.live();
        if live.len() < 2 * SIDE {
            return Vec::new();
        }
        let of = |i: usize, band: usize| self.records[live[i]].log_power(band);
        let size = |i: usize| self.records[live[i]].level.ln();
        // Gains that differ from site to site differ beside a step, too: its standard error is that of two medians of four.
        let jumps = (1..live.len()).map(|i| (size(i) - size(i - 1)).abs());
        let error = OF_MEDIANS * OF_MAGNITUDES * median(jumps).unwrap_or(0.0);
        let surely = student_two_sided(CHANCE / live.len() as f64, (live.len() - 2) as f64);
        let least = LEAST.ln().max(surely * error);
        let step = |i: usize, of: &dyn Fn(usize) -> f64| {
            let side = |sites: Range<usize>| {
                let sizes = sorted(sites.map(of));
                // One of them may be loud by itself.
                let spread = (sizes[SIDE - 1] - sizes[1]).min(sizes[SIDE - 2] - sizes[0]);
                (0.5 * (sizes[1] + sizes[2]), spread)
            };
            let (before, after) = (side(i - SIDE..i), side(i..i + SIDE));
            (after.0 - before.0, before.1.max(after.1))
        };
        let is_step = |i: &usize| {
            let (all, _) = step(*i, &size);
            let is_like = |band: usize| {
                let (one, spread) = step(*i, &|i| of(i, band));
                spread < UNEVEN * all.abs().max(LEAST.ln())
                    && (one - all).abs() < UNEVEN * all.abs()
            };
            all.abs() > least && (0..BANDS).all(is_like)
        };
        // Places beside a step see it, too: it is where the means of both sides differ most.
        let apart = |i: usize| {
            let sum = |sites: Range<usize>| sites.map(size).sum::<f64>();
            (sum(i..i + SIDE) - sum(i - SIDE..i)).abs()
        };
        let last = live.len() - SIDE;
        let most = |i: usize| {
            let near = (i + 1).saturating_sub(SIDE).max(SIDE)..=(i + SIDE - 1).min(last);
            let most = near.max_by(|a, b| apart(*a).total_cmp(&apart(*b)));
            most.unwrap_or(i)
        };
        let mut found: Vec<usize> = (SIDE..=last).filter(is_step).map(most).collect();
        found.dedup();
        let is_largest = |i: &&usize| most(**i) == **i;
        let found = found.iter().filter(is_largest).map(|&i| {
            let ratio = step(i, &size).0.exp();
            GainStep {
                row: live[i],
                ratio,
                error: ratio * (1.96 * error).exp_m1(),
            }
        });
        found.collect()
    }
}

/// A row from which on records are larger or smaller.
struct GainStep {
    row: usize,
    /// Amplitudes from it on over those before, and half of the 95 % interval.
    ratio: f64,
    error: f64,
}

impl Record {
    /// Of a site that is left out.
    const NOTHING: Record = Record {
        scan: ChannelScan::NOTHING,
        level: 0.0,
        top: 0.0,
        bands: [0.0; BANDS],
        next: Vec::new(),
    };

    fn top_power(&self) -> f64 {
        self.top * self.level * self.level
    }

    /// Half of the logarithm of the power in a band, that of an amplitude.
    fn log_power(&self, band: usize) -> f64 {
        let most = self.bands.iter().fold(0.0, |m: f64, b| m.max(*b));
        self.level.ln() + 0.5 * self.bands[band].max(ROUNDING * most).ln()
    }
}

/// The transforms of the stretches of a record over its largest magnitude.
struct Spectra {
    scan: ChannelScan,
    /// `[stretch * bins + bin]`; empty without motion.
    spectra: Vec<Complex<f64>>,
    /// Sum over the stretches, of each bin.
    powers: Vec<f64>,
    /// Root mean square from the mean, over the largest magnitude.
    level: f64,
}

impl Spectra {
    fn of(record: &mut [f64], transform: &RecordTransform<f64>, hop: usize) -> Spectra {
        let scan = ChannelScan::of(record);
        let (bins, length) = (transform.bins(), transform.padded());
        let (mut spectra, mut powers, mut level) = (Vec::new(), vec![0.0; bins], 0.0);
        if !scan.constant && scan.largest > 0.0 {
            // Lines across gaps leak less than zeros into what is held against the neighbours.
            let mut gaps = Vec::new();
            if scan.gaps > 0 {
                fill(record, 0, Gaps::Interpolate, &mut gaps);
                gaps.iter().for_each(|gap| record[gap.time] = gap.value);
            }
            let count = record.len() as f64;
            let mean = record.iter().map(|v| v / scan.largest).sum::<f64>() / count;
            let squares = record.iter().map(|v| (v / scan.largest - mean).powi(2));
            level = (squares.sum::<f64>() / count).sqrt();
            let mut scratch = RecordScratch::default();
            for start in (0..=record.len() - length).step_by(hop) {
                let stretch = &record[start..start + length];
                let mean = stretch.iter().sum::<f64>() / length as f64;
                let moving = stretch.iter().map(|v| (v - mean) / scan.largest);
                let moving: Vec<f64> = moving.collect();
                let (found, _) = transform.transform(std::iter::once(&*moving), &mut scratch);
                let own = powers.iter_mut().zip(found);
                own.for_each(|(power, x)| *power += x.norm_sqr());
                spectra.extend_from_slice(found);
            }
        }
        Spectra {
            scan,
            level,
            spectra,
            powers,
        }
    }

    /// `<conj(X) Y> / sqrt(<|X|^2> <|Y|^2>)` over all bins, so that magnitudes sum to 1 of records that follow each other.
    fn with(&self, next: &Spectra) -> Vec<Complex<f64>> {
        let total = |spectra: &Spectra| spectra.powers.iter().sum::<f64>();
        let scale = (total(self) * total(next)).sqrt();
        if self.spectra.is_empty() || next.spectra.is_empty() || scale == 0.0 {
            return Vec::new();
        }
        let mut sums = vec![Complex::default(); self.powers.len()];
        let stretches = self.spectra.chunks_exact(sums.len());
        for (x, y) in stretches.zip(next.spectra.chunks_exact(sums.len())) {
            let products = x.iter().zip(y).map(|(x, y)| x.conj() * y / scale);
            sums.iter_mut().zip(products).for_each(|(sum, z)| *sum += z);
        }
        sums
    }

    fn record(&self, next: Vec<Complex<f64>>) -> Record {
        let bins = self.powers.len();
        let total: f64 = self.powers.iter().sum();
        let share = |bins: Range<usize>| match total > 0.0 {
            true => self.powers[bins].iter().sum::<f64>() / total,
            false => 0.0,
        };
        let edge = |band: usize| band * bins / BANDS;
        Record {
            scan: self.scan,
            level: self.scan.largest * self.level,
            top: share(9 * bins / 10..bins),
            bands: std::array::from_fn(|band| share(edge(band)..edge(band + 1))),
            next,
        }
    }
}

/// Whether all sites beside a run, up to two on each side, are as wanted.
fn both(from: usize, end: usize, n: usize, wanted: impl Fn(usize) -> bool) -> bool {
    let before = (0..from).rev().take(BESIDE);
    before.chain((end..n).take(BESIDE)).all(wanted)
}

/// Sites far louder than those beside them, while these are alike: one gain that is wrong; over the median.
fn loud(levels: &[f64]) -> Option<(Vec<usize>, f64)> {
    let n = levels.len();
    let moving = || levels.iter().copied().filter(|&v| v > 0.0);
    let median = median(moving())?;
    // Motion that has reached a part of the sites differs as much.
    if n < 3 || !are_alike(moving(), LOUD) {
        return None;
    }
    let stands_out = |from: usize, end: usize| {
        let least = levels[from..end]
            .iter()
            .fold(f64::INFINITY, |m, v| m.min(*v));
        let beside = [from.checked_sub(1), Some(end).filter(|&end| end < n)];
        let is_low = |j: usize| levels[j] > 0.0 && least > LOUD * levels[j];
        beside.into_iter().flatten().all(is_low)
    };
    let rows = outstanding(n, |j| levels[j] > LOUD * median, stands_out);
    let loudest = rows.iter().map(|&j| levels[j]).reduce(f64::max)?;
    Some((rows, loudest / median))
}

/// Runs of at most two candidates that stand out from those beside them, the end excluded.
fn outstanding(
    n: usize,
    is_candidate: impl Fn(usize) -> bool,
    stands_out: impl Fn(usize, usize) -> bool,
) -> Vec<usize> {
    let mut found = Vec::new();
    let mut from = 0;
    while from < n {
        let end = (from..n).find(|&j| !is_candidate(j)).unwrap_or(n);
        if (1..=TOGETHER).contains(&(end - from)) && stands_out(from, end) {
            found.extend(from..end);
        }
        from = end + 1;
    }
    found
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted
}

fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let sorted = sorted(values);
    sorted.get(sorted.len() / 2).copied()
}

/// Whether the quartiles are within a factor of the median.
fn are_alike(values: impl Iterator<Item = f64>, factor: f64) -> bool {
    let sorted = sorted(values);
    let quantile = |share: f64| sorted.get((share * sorted.len() as f64) as usize).copied();
    let (Some(low), Some(median), Some(high)) = (quantile(0.25), quantile(0.5), quantile(0.75))
    else {
        return false;
    };
    high <= factor * median && factor * low >= median
}
