//! What is wrong with single channels: each is held against those beside it, over a part of the record.

mod faults;
mod look;
mod neighbours;
mod steps;

use std::ops::Range;

use serde_json::{Value, json};

use super::scan::ChannelScan;
use crate::error::Result;
use crate::field::{Axis, Field};
use crate::observer::Observer;
use crate::sheet::{Describe, FigureLayout, Sheet, Warning, number, percent, six_digits};
use look::Look;

const LEAVE_OUT: &str =
    "check the sensors; `analyze` leaves sites out of spectra along time (`--without-sites`)";

/// Faults of single channels: code, words, what to do.
const FAULTS: [(&str, &str, &str); 8] = [
    ("dead-channels", "constant", LEAVE_OUT),
    (
        "saturated-channels",
        "on the extreme value for up to {} samples",
        "lower the gain or the amplitude; clipping makes harmonics that are not there",
    ),
    (
        "quiet-channels",
        "less than 1/100 as loud as both beside, down to {} of the median",
        LEAVE_OUT,
    ),
    (
        "loud-channels",
        "more than 100 times as loud as those beside, up to {} times the median",
        "check gains and units, and scale first: this energy decides spectra and directions; `analyze` leaves sites out of \
         spectra along time (`--without-sites`)",
    ),
    (
        "noisy-channels",
        "up to {} times the energy of those beside in the top tenth below Nyquist",
        LEAVE_OUT,
    ),
    (
        "reversed-channels",
        "reversed in sign against the others",
        "turn the sign of these records",
    ),
    (
        "late-channels",
        "{} samples behind the others",
        "shift these records, or check the clock of their recorder",
    ),
    (
        GAIN_STEPS,
        "from there on the gain changes along x, {}",
        "scale the records before energies of sites are compared",
    ),
];
pub(crate) const GAIN_STEPS: &str = "gain-steps";

/// Rows with a fault, what stands for `{}` in its words, and numbers.
type Found = (Vec<usize>, String, Value);

/// A result, with what is wrong with the channels of its field.
#[derive(Debug, Clone)]
pub struct Examined<D> {
    pub found: D,
    pub channels: Vec<Warning>,
}

impl<D: Describe> Describe for Examined<D> {
    fn describe(&self) -> Sheet<'_> {
        let mut sheet = self.found.describe();
        let is_apart = |w: &Warning| ["reversed-channels", "late-channels"].contains(&w.code);
        if sheet.needs_sites_in_step && self.channels.iter().any(is_apart) {
            sheet.answer =
                "waves along x are not told: sites are out of step with the others".into();
            sheet
                .facts
                .iter_mut()
                .for_each(|fact| fact.is_detail = true);
        }
        for warning in &self.channels {
            if sheet.warnings.iter().all(|own| own.code != warning.code) {
                sheet.warnings.push(warning.clone());
            }
        }
        sheet
    }

    fn figures(&self) -> Vec<FigureLayout> {
        self.found.figures()
    }
}

/// What there is to say about single channels: gaps, dead, quiet, saturated, loud and noisy ones, those that are reversed in sign or late,
/// and gains that step along x. Sixteen stretches of the record are looked at, of 1024 samples or, of
/// many sites, fewer. None of a simulated run.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn channel_findings(field: &Field, observer: &dyn Observer) -> Result<Vec<Warning>> {
    let all = (0..field.n_times(), 0..field.n_sites());
    channels(field, all, (&[], None), observer)
}

/// Of a range, but for these sites of the file; with what is known of its whole records.
pub(crate) fn channels(
    field: &Field,
    (times, sites): (Range<usize>, Range<usize>),
    (left_out, known): (&[usize], Option<&[ChannelScan]>),
    observer: &dyn Observer,
) -> Result<Vec<Warning>> {
    if field.struck.is_some() || times.is_empty() || sites.is_empty() {
        let gaps = known.and_then(|scans| gaps(scans, times.len()));
        return Ok(gaps.into_iter().collect());
    }
    Ok(Look::new(field, times, sites, (left_out, known), observer)?.warnings())
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
        let noun = if self.indices.len() == 1 {
            "site"
        } else {
            "sites"
        };
        // Sites in a row as `20-39`.
        let runs: Vec<&[usize]> = self.indices.chunk_by(|a, b| a + 1 == *b).collect();
        let ends = |run: &&[usize], word: &dyn Fn(usize) -> String| match run {
            [only] => word(*only),
            [first, .., last] => format!("{}-{}", word(*first), word(*last)),
            [] => String::new(),
        };
        let indices = some(runs.iter().map(|run| ends(run, &|j| j.to_string())));
        let mut at = String::new();
        if self.space.unit.is_some() || self.space.step != 1.0 {
            let position = |j: usize| six_digits(self.space.at(j));
            let positions = some(runs.iter().map(|run| ends(run, &position)));
            at = format!(" at {positions} {}", self.space.space_unit());
        }
        let mut all = json!({"sites": self.indices, "positions": positions});
        if let (Value::Object(all), Value::Object(more)) = (&mut all, numbers) {
            all.extend(more);
        }
        Warning::new(format!("{noun} {indices}{at}: {what}"), advice).coded(code, all)
    }
}

/// The first few.
pub(crate) fn some(words: impl Iterator<Item = String>) -> String {
    let mut words: Vec<String> = words.take(9).collect();
    words
        .iter_mut()
        .skip(8)
        .for_each(|last| *last = "...".into());
    words.join(", ")
}

impl Look<'_> {
    fn warnings(&self) -> Vec<Warning> {
        let of_ratio = |(rows, ratio)| (rows, number(ratio), json!({"ratio": ratio}));
        let [quiet, loud] = self.quiet_and_loud();
        let noisy = self.noisy(&loud.0);
        let [reversed, late] = self.out_of_step();
        let found: [Found; 8] = [
            (self.dead(), String::new(), json!({})),
            self.clipped(),
            of_ratio(quiet),
            of_ratio(loud),
            of_ratio(noisy),
            (reversed.0, String::new(), json!({})),
            (
                late.0,
                some(
                    late.1
                        .chunk_by(|a, b| a == b)
                        .map(|run| format!("{:+}", run[0])),
                ),
                json!({"samples": late.1}),
            ),
            self.steps(),
        ];
        let scans: Vec<ChannelScan> = self.records.iter().map(|record| record.scan).collect();
        let gaps = gaps(&scans, self.samples).into_iter();
        let faults = FAULTS.into_iter().zip(found);
        let faults = faults.filter(|(_, (rows, ..))| !rows.is_empty());
        let faults = faults.map(|((code, words, advice), (rows, value, numbers))| {
            let sites = Sites {
                indices: rows.iter().map(|row| self.sites.start + row).collect(),
                space: &self.field.space,
            };
            sites.warning(code, &words.replace("{}", &value), advice, numbers)
        });
        gaps.chain(faults).collect()
    }
}

/// Samples that are not finite, of so many of each record that are looked at.
fn gaps(scans: &[ChannelScan], samples: usize) -> Option<Warning> {
    let gaps: usize = scans.iter().map(|scan| scan.gaps).sum();
    let sites = scans.iter().filter(|scan| scan.gaps > 0).count();
    let share = gaps as f64 / (samples * scans.len()) as f64;
    let message = format!(
        "{gaps} samples at {sites} of {} sites were not finite ({} of those looked at)",
        scans.len(),
        percent(share),
    );
    let numbers = json!({"samples": gaps, "sites": sites, "share": share});
    let warning = Warning::new(message, "read spectra of these sites with care");
    (gaps > 0).then(|| warning.coded("gaps", numbers))
}
