//! What modes say.

use num_complex::Complex;
use serde_json::{Value, json};

use super::{CHANCE, ModeShapes, Modes};
use crate::sheet::{
    BLACK, BLUE, Chart, Column, Describe, GREEN, Look, PlotRow, Role, Series, Sheet, Units,
    VERMILLION, confidence, extent, number, percent, six_digits, with_half,
};
use crate::unit::label;

/// Of the names in [`Modes::describe`].
const DEFINITIONS: &str = "\
    Mode: A motion of all sites at one frequency, Re φ(x) exp(−2πi f t), uncorrelated with others, in order of power.
    Eigenvalue λ: Power spectral density of a mode, integrated over x. Those of a frequency sum up to that of the field.
    Coherent: With all sites at the same level, an eigenvalue is above what unrelated records have by chance.
    Interval: By chi-square, for the effective number of realisations. It holds for eigenvalues that are well apart.
    Wave: A coherent mode in step with |φ(x)| exp(ikx) to 0.9 of its energy, over half a wavelength; a standing wave reaches \
        0.72.";

/// Eigenvalues that are drawn.
const SHOWN: [usize; 3] = [BLUE, VERMILLION, GREEN];
/// Chosen frequencies whose first mode is drawn.
const FREQUENCIES: usize = 4;

impl Describe for Modes {
    /// Variables: `frequency` (nf), `position` (n); `eigenvalues` (nf, modes), `total` (nf), `interval` (nf, 2), the
    /// factors of the ends, NaN where none can be stated; `mode_frequency` (c), `mode_real`, `mode_imag` (c, kept
    /// modes, n).
    fn describe(&self) -> Sheet<'_> {
        let words = self.words();
        let interval = match self.interval(1) {
            Some([low, high]) => {
                let share = confidence(self.alpha);
                format!("{share} of an eigenvalue from {low:.3} to {high:.3} of it, by chi-square")
            }
            None => format!("none can be stated: {}", self.independence.why_none()),
        };
        let mut sheet = Sheet {
            needs_sites_in_step: true,
            about: "motions of all sites at one frequency, by their power".into(),
            answer: self.answer(),
            note: format!("Interval: {interval}."),
            ..Sheet::of("modes", "Modes that are coherent along x", DEFINITIONS)
        };
        if let Some(count) = self.coherent_frequencies() {
            let (of, chance) = (self.inside().len(), percent(CHANCE));
            let text = format!(
                "at {count} of {of} frequencies; {chance} of fields of unrelated records have any"
            );
            sheet.fact("coherent", text);
        }
        sheet.fact("interval", interval);
        for shapes in &self.chosen {
            let modes = (0..shapes.waves.len()).map(|n| self.mode_in_words(shapes, n));
            let text = modes.collect::<Vec<_>>().join("; ");
            sheet.fact(format!("f = {}", number(shapes.frequency)), text);
        }
        self.independence.describe(&mut sheet, self.segment);
        let chosen = |shapes: &ModeShapes| -> Value {
            let kept = 0..shapes.modes.nrows();
            let eigenvalues: Vec<f64> = kept.map(|n| self.eigenvalues[[shapes.bin, n]]).collect();
            json!({
                "frequency": shapes.frequency,
                "bin": shapes.bin,
                "eigenvalues": eigenvalues,
                "total": self.total[shapes.bin],
                "above_noise": self.above_noise(shapes.bin),
                "is_coherent": shapes.is_coherent,
                "waves": shapes.waves,
            })
        };
        sheet.numbers(json!({
            "time_unit": words.time,
            "space_unit": words.space,
            "alpha": self.alpha,
            "interval": self.interval(1),
            "leading_share": self.leading_share_of_all(),
            "coherent_frequencies": self.coherent_frequencies(),
            "chosen": self.chosen.iter().map(chosen).collect::<Vec<_>>(),
        }));
        self.variables(&mut sheet);
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        let shapes = self.chosen.iter().take(FREQUENCIES);
        let shapes = shapes.filter_map(|shapes| self.shape_chart(shapes));
        PlotRow::grid(2, [self.eigenvalue_chart()].into_iter().chain(shapes))
    }
}

impl Modes {
    fn words(&self) -> Units {
        Units::in_words(&self.time, &self.space, self.unit.as_deref())
    }

    /// Share of the power at a frequency that a mode holds.
    fn share(&self, bin: usize, n: usize) -> String {
        percent(self.eigenvalues[[bin, n]] / self.total[bin])
    }

    /// How many modes there are, in words.
    fn answer(&self) -> String {
        let Some(shapes) = self.chosen.first() else {
            return "nothing moves: no power at any frequency".into();
        };
        // A bin is as wide as its distance from the next.
        let half = 0.5 * self.frequency[1];
        let at = with_half(shapes.frequency, half, &self.words().frequency);
        // Louder sites that are not related may come first.
        let first = shapes.is_coherent.iter().position(|is| *is).unwrap_or(0);
        let count = match self.above_noise(shapes.bin) {
            Some(count) => count.to_string(),
            None => format!("cannot be told, {}", self.independence.why_none()),
        };
        let (number, share) = (first + 1, self.share(shapes.bin, first));
        format!("coherent modes at {at}: {count}; number {number} by power holds {share} of it")
    }

    /// The share of a mode, and what kind of wave it is, where it is one.
    fn mode_in_words(&self, shapes: &ModeShapes, n: usize) -> String {
        let (words, share) = (self.words(), self.share(shapes.bin, n));
        let coherent = ["", " coherent"][usize::from(shapes.is_coherent[n])];
        let wave = shapes.waves[n].filter(|wave| wave.is_wave).map(|wave| {
            let (k, unit) = (number(wave.wavenumber), &words.wavenumber);
            let velocity = wave.velocity_half.map_or(String::new(), |half| {
                format!(", {}", with_half(wave.velocity, half, &words.velocity))
            });
            format!(", a wave of k = {k} {unit}{velocity}")
        });
        format!("{share}{coherent}{}", wave.unwrap_or_default())
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let units = Units::of(&self.time, &self.space, self.unit.as_deref());
        sheet.axis(Role::Frequency, &units, &self.frequency);
        sheet.axis(Role::Position, &units, self.positions());
        let power = units.density(&[&units.frequency], &units.space);
        let axes = ["frequency", "mode"];
        sheet.plane("eigenvalues", axes, &power, &self.eigenvalues);
        sheet.line("total", "frequency", &power, &self.total);
        let bins = self.frequency.len();
        let ends = |bin| self.interval(bin).unwrap_or([f64::NAN; 2]);
        let intervals: Vec<f64> = (0..bins).flat_map(ends).collect();
        let axes = [("frequency", bins), ("end", 2)];
        sheet.variable("interval", &axes, "", intervals);
        let frequencies: Vec<f64> = self.chosen.iter().map(|shapes| shapes.frequency).collect();
        let kept = self.chosen.first().map_or(0, |shapes| shapes.waves.len());
        let axes = [
            ("mode_frequency", frequencies.len()),
            ("kept_mode", kept),
            ("position", self.n_sites),
        ];
        let name = "mode_frequency";
        sheet.line(name, name, &units.frequency, frequencies);
        // The integral of |mode|^2 over x is 1.
        let unit = match &units.space[..] {
            "" => String::new(),
            space => format!("1/√{space}"),
        };
        let parts: [Column<Complex<f64>>; 2] = [
            ("mode_real", &unit, |z| z.re),
            ("mode_imag", &unit, |z| z.im),
        ];
        for (name, unit, of) in parts {
            let shapes = self.chosen.iter().flat_map(|shapes| &shapes.modes);
            sheet.variable(name, &axes, unit, shapes.map(of).collect::<Vec<f64>>());
        }
    }

    /// Over the frequencies.
    fn points(&self, of: impl Fn(usize) -> f64) -> Vec<(f64, f64)> {
        let bins = 1..self.frequency.len();
        bins.map(|bin| (self.frequency[bin], of(bin))).collect()
    }

    fn eigenvalue_chart(&self) -> Chart {
        let total = self.points(|bin| self.total[bin]);
        let mut series = vec![Series::line("all modes", BLACK, total).with(Look::Dashed)];
        let ends = (1..self.frequency.len()).map(|bin| {
            let ends = self.interval(bin).unwrap_or([f64::NAN; 2]);
            ends.map(|end| end * self.eigenvalues[[bin, 0]]).into()
        });
        for (n, colour) in (0..self.eigenvalues.ncols()).zip(SHOWN) {
            let points = self.points(|bin| self.eigenvalues[[bin, n]]);
            series.push(Series::line(format!("mode {}", n + 1), colour, points));
        }
        let name = format!("{} interval", confidence(self.alpha));
        series[1] = series[1].clone().with_band(name, ends.collect());
        let units = Units::of(&self.time, &self.space, self.unit.as_deref());
        let unit = units.density(&[&units.frequency], &units.space);
        let name = label("eigenvalue λ", &unit);
        let frequency = self.words().label(Role::Frequency);
        Chart {
            log_x: self.frequency.len() > 16,
            ..Chart::of("eigenvalues", frequency, name, series).logarithmic()
        }
    }

    fn shape_chart(&self, shapes: &ModeShapes) -> Option<Chart> {
        let (words, positions) = (self.words(), self.positions());
        let mode = shapes.modes.rows().into_iter().next()?;
        let points = |of: fn(&Complex<f64>) -> f64| -> Vec<(f64, f64)> {
            positions.iter().copied().zip(mode.iter().map(of)).collect()
        };
        let most = extent(mode.iter().map(|z| z.norm())).end;
        let at = six_digits(shapes.frequency);
        Some(Chart {
            y: -1.15 * most..1.15 * most,
            ..Chart::of(
                format!("mode 1 at f = {at} {}", words.frequency),
                words.label(Role::Position),
                label("mode φ", &format!("1/√{}", words.space)),
                vec![
                    Series::line("real part", BLUE, points(|z| z.re)),
                    Series::line("modulus", BLACK, points(|z| z.norm())).with(Look::Dashed),
                ],
            )
        })
    }
}
