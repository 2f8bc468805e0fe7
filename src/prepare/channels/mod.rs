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
use crate::sheet::{Describe, PlotRow, Sheet, Warning, number, percent, six_digits, with_half};
use faults::{CLIPPED_RUN, LOUD, loud};
use look::Look;

const LEAVE_OUT: &str =
    "check the sensors; `analyze` leaves sites out of spectra along time (`--without-sites`)";
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
        let is_apart = |w: &Warning| ["reversed-channels", "late-channels"].contains(&w.code);
        if sheet.needs_sites_in_step && self.channels.iter().any(is_apart) {
            sheet.answer =
                "waves along x are not told: sites are out of step with the others".into();
        }
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
/// and gains that step along x. Sixteen stretches of the record are looked at, of 1024 samples or, of
/// many sites, fewer. None of a simulated run.
///
/// # Errors
/// [`crate::Error::Cancelled`].
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
    if field.struck.is_some() || times.is_empty() || sites.is_empty() {
        let gaps = known.and_then(|scans| gaps(scans, times.len(), true));
        return Ok(Channels {
            warnings: gaps.into_iter().collect(),
            has_steps: false,
        });
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

impl Look<'_> {
    fn channels(&self) -> Channels {
        let scans: Vec<ChannelScan> = self.records.iter().map(|record| record.scan).collect();
        let gaps = gaps(&scans, self.samples, self.is_whole);
        let mut warnings: Vec<Warning> = gaps.into_iter().collect();
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
        let advice = "check gains and units, and scale first: this energy decides spectra and directions; `analyze` leaves \
                      sites out of spectra along time (`--without-sites`)";
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

    fn is_left_out(&self, j: usize) -> bool {
        self.left_out.contains(&(self.sites.start + j))
    }
}

/// Samples that are not finite, of so many of each record: all, or those that are looked at.
fn gaps(scans: &[ChannelScan], samples: usize, are_all: bool) -> Option<Warning> {
    let gaps: usize = scans.iter().map(|scan| scan.gaps).sum();
    let sites = scans.iter().filter(|scan| scan.gaps > 0).count();
    let share = gaps as f64 / (samples * scans.len()) as f64;
    let message = format!(
        "{gaps} samples at {sites} of {} sites were not finite ({} of {})",
        scans.len(),
        percent(share),
        if are_all {
            "the field"
        } else {
            "those looked at"
        }
    );
    let numbers = json!({"samples": gaps, "sites": sites, "share": share});
    let warning = Warning::new(message, "read spectra of these sites with care");
    (gaps > 0).then(|| warning.coded("gaps", numbers))
}
