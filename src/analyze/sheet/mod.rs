//! What an analysis says.
//!
//! Its large arrays and maps, which come in blocks, are not in its sheet.

mod answer;
mod numbers;
mod tables;
mod variables;

use super::{Analysis, Scaling};
use crate::field::Axis;
use crate::measure::digits;
use crate::sheet::{Describe, PlotRow, Sheet, error_size, name_of, percent};

#[cfg(feature = "figures")]
pub(crate) use answer::{Words, both};

const DEFINITIONS: [[&str; 2]; 10] = [
    [
        "Moved share",
        "The largest difference of two cumulative spectra: the share of energy that lies above a frequency at one \
         place and below it at the other (up), or the reverse (down).",
    ],
    [
        "Front, tail",
        "The front is the energy in a window of ten widths of the pulse that begins at, or a little before, each \
         arrival; the tail is what follows.",
    ],
    [
        "Launch",
        "Of a struck chain, the way to the second half of the bodies that its front reaches; what moves is told over \
         that half.",
    ],
    [
        "Frequency and wavenumber",
        "f counts cycles, k counts rad; k a / π = 1 is the Nyquist wavenumber of sites spaced a apart.",
    ],
    [
        "Direction",
        "Waves exp(i (k x − ω t)): for f > 0, k > 0 travels towards +x.",
    ],
    [
        "Centroid, median, 90 %",
        "The mean of f (or k) weighted by energy, every bin counted; where the cumulative energy reaches 50 % and \
         90 %, read off at the ends of bins, each of which stands for half a bin to both sides.",
    ],
    [
        "Effective bandwidth",
        "exp(− ∫ p ln p df) of the spectrum p of unit integral: the width of a flat spectrum of the same entropy.",
    ],
    [
        "Parseval residual",
        "Energy in the transform domain over energy of the prepared samples, less 1.",
    ],
    [
        "Flux surrogate",
        "Π_K(k, t) = − d/dt of the kinetic energy in wavenumbers up to k.",
    ],
    [
        "Undefined",
        "A site or time with less than a millionth of the largest energy, or less than the noise where that is \
         known, has no centroid: a gap in the curves.",
    ],
];

impl Describe for Analysis {
    /// Variables: all arrays but those of the [`Sink`](crate::arrays::Sink), under the names of the manual.
    fn describe(&self) -> Sheet<'_> {
        let mut sheet = self.words();
        variables::add(self, &mut sheet);
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        Vec::new()
    }
}

impl Analysis {
    /// The sheet without variables.
    pub fn words(&self) -> Sheet<'static> {
        let axes = &self.axes;
        let unit = self.unit.as_ref().map(|unit| format!(" in {unit}"));
        let mut sheet = Sheet {
            name: "analyze",
            version: 4,
            title: "Analysis".into(),
            about: format!(
                "{}{}, {} times by {} sites",
                name_of(&self.quantity).replace('-', " "),
                unit.unwrap_or_default(),
                axes.n_times,
                axes.n_sites
            ),
            definitions: self.definitions(),
            ..Sheet::default()
        };
        // It is not known which axis is time.
        let guessed = self.warnings.iter().find(|of| of.code == "wide-array");
        match answer::describe(self) {
            _ if guessed.is_some() => {
                sheet.answer = guessed.map(|of| of.message.clone()).unwrap_or_default()
            }
            Some((verdict, facts)) => (sheet.answer, sheet.facts) = (verdict, facts),
            None if self.has_energy() => sheet.answer = "what moves was not requested".into(),
            None => sheet.answer = "what moves cannot be told: nothing moves".into(),
        }
        let field = format!(
            "{} times x {} sites{}{}",
            axes.n_times,
            axes.n_sites,
            step("dt", &axes.time, "time counts samples"),
            step("dx", &axes.space, "x counts sites")
        );
        sheet.fact("field", field);
        let checks = self.checks();
        if !checks.is_empty() {
            sheet.fact("checks", checks);
        }
        // What the answer says is said once.
        if self.answer.is_none() {
            self.directions(&mut sheet);
        }
        let transforms: u64 = self.timings.iter().map(|of| of.transforms).sum();
        let seconds = self.seconds;
        let computation = format!("{transforms} transforms in {seconds:.3} s");
        sheet.detail("computation", computation);
        sheet.warnings.clone_from(&self.warnings);
        sheet.numbers(numbers::of(self));
        sheet.tables = tables::of(self);
        sheet
    }

    fn has_energy(&self) -> bool {
        self.headline_space.last.is_some() || self.headline_time.last.is_some()
    }

    fn definitions(&self) -> Vec<[&'static str; 2]> {
        let scaling = match self.conventions.scaling {
            Scaling::Energy => {
                "Energy spectral density of a transient: its integral is the sum of squares times the sample spacing."
            }
            Scaling::Density => "Power spectral density: its integral is the mean square.",
            Scaling::Spectrum => "Power spectrum: a sine of amplitude A peaks at A²/2.",
        };
        let mut definitions = DEFINITIONS.to_vec();
        definitions.insert(3, ["Spectra", scaling]);
        definitions
    }

    /// How exact the transforms are.
    fn checks(&self) -> String {
        let of = &self.accuracy;
        let energy = "energy in the transforms agrees with that of the samples";
        let amplitudes = "amplitudes agree with direct sums";
        let checks = [(energy, of.parseval), (amplitudes, of.spot_check)].into_iter();
        let said =
            checks.filter_map(|(what, error)| Some(format!("{what} to {}", error_size(error?))));
        said.collect::<Vec<String>>().join("; ")
    }

    /// The shares of the energy that travel each way.
    fn directions(&self, sheet: &mut Sheet) {
        let Some(direction) = self.direction.filter(|d| d.undirected.is_finite()) else {
            return;
        };
        let (from, to) = direction.band;
        let text = format!(
            "{} of the energy towards +x, {} towards -x, {} undirected, from {} to {} {}",
            percent(direction.toward_plus_x),
            percent(direction.toward_minus_x),
            percent(direction.undirected),
            digits(from),
            digits(to),
            self.axes.frequency_unit()
        );
        sheet.detail("directions", text);
    }
}

/// `, dt 0.01 s`; of an axis that counts, that it does: `, no dt: time counts samples`.
fn step(name: &str, axis: &Axis, counts: &str) -> String {
    let step = digits(axis.step);
    match &axis.unit {
        None if axis.step == 1.0 => format!(", no {name}: {counts}"),
        None => format!(", {name} {step} (no unit stated)"),
        Some(unit) => format!(", {name} {step} {unit}"),
    }
}
