//! What modes say.

use num_complex::Complex;
use serde_json::{Value, json};

use super::{CHANCE, ModeShapes, ModeWave, Modes};
use crate::estimates::realisations::REALISATIONS;
use crate::measure::cycles_per;
use crate::sheet::{
    BLACK, BLUE, Chart, Column, Describe, GREEN, Look, PlotRow, SKY, Series, Sheet, Table, Units,
    VERMILLION, confidence, extent, number, percent, six_digits, with_half,
};
use crate::unit::{compose, label, square};

/// Of the names in [`Modes::describe`].
const DEFINITIONS: [[&str; 2]; 6] = [
    [
        "Mode",
        "A motion of all sites at one frequency, Re φ(x) exp(−2πi f t), uncorrelated with others, in order of power.",
    ],
    [
        "Eigenvalue λ",
        "Power spectral density of a mode, integrated over x. Those of a frequency sum up to that of the field.",
    ],
    [
        "Coherent",
        "With all sites at the same level, an eigenvalue is above what unrelated records have by chance.",
    ],
    [
        "Interval",
        "By chi-square, for the effective number of realisations. It holds for eigenvalues that are well apart.",
    ],
    [
        "Wave",
        "A coherent mode in step with |φ(x)| exp(ikx) to 0.9 of its energy, over half a wavelength; a standing wave reaches 0.72.",
    ],
    REALISATIONS,
];

/// Eigenvalues that are drawn.
const SHOWN: [usize; 3] = [BLUE, VERMILLION, GREEN];
/// Chosen frequencies whose first mode is drawn.
const FREQUENCIES: usize = 4;
/// Ordinates of a logarithmic chart reach this far below the largest.
const DEEPEST: f64 = 1e-9;

impl Describe for Modes {
    /// Variables: `frequency` (nf), `position` (n); `eigenvalues` (nf, modes), `total` (nf), `interval` (nf, 2), the
    /// factors of the ends, NaN where none can be stated; `mode_frequency` (c), `mode_real`, `mode_imag` (c, kept
    /// modes, n).
    fn describe(&self) -> Sheet<'_> {
        let (time_unit, space_unit) = self.units();
        let interval = match self.interval(1) {
            Some([low, high]) => format!("from {low:.3} to {high:.3} of it, by chi-square"),
            None => "none can be stated: too few independent realisations".into(),
        };
        let confidence = confidence(self.alpha);
        let mut sheet = Sheet {
            needs_sites_in_step: true,
            about: format!("positions in {space_unit}, times in {time_unit}"),
            answer: self.answer(),
            note: format!("The {confidence} interval of an eigenvalue: {interval}."),
            ..Sheet::of("modes", "Modes that are coherent along x", &DEFINITIONS)
        };
        sheet.numbers(json!({ "time_unit": time_unit, "space_unit": space_unit }));
        if let Some(count) = self.coherent_frequencies() {
            let (of, chance) = (self.inside().len(), percent(CHANCE));
            let text = format!(
                "at {count} of {of} frequencies; {chance} of fields of unrelated records have any"
            );
            sheet.fact("coherent", text);
        }
        if !self.chosen.is_empty() {
            let share = percent(self.leading_share_of_all());
            let text = format!("hold {share} of the power of all frequencies");
            sheet.fact("first modes", text);
        }
        let text = format!("{confidence} of an eigenvalue {interval}");
        sheet.fact("interval", text);
        for shapes in &self.chosen {
            let (share, wave) = (self.share(shapes.bin, 0), self.wave_in_words(shapes));
            let text = format!("the first mode holds {share} of the power{wave}");
            sheet.fact(format!("f = {}", number(shapes.frequency)), text);
        }
        let rows = [("interval of an eigenvalue", interval)];
        self.independence.describe(&mut sheet, self.segment, rows);
        sheet.tables.push(self.table());
        sheet.warnings.extend(self.independence.alone("record"));
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
        let charts = [self.eigenvalue_chart(), self.share_chart()].into_iter();
        PlotRow::grid(2, charts.chain(shapes))
    }
}

impl Modes {
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
        let at = with_half(shapes.frequency, half, &cycles_per(&self.units().0));
        let share = |n: usize| self.share(shapes.bin, n);
        let modes = match (self.above_noise(shapes.bin), self.coherent_frequencies()) {
            (Some(0), Some(0)) => return "no motion is coherent along x at any frequency".into(),
            (Some(0), _) => return format!("no motion is coherent along x at {at}, but at others"),
            (Some(1), _) => "one mode".into(),
            (Some(count), _) => format!("{count} modes"),
            (None, _) => {
                let (share, why) = (share(0), self.independence.why_none());
                return format!(
                    "the first mode at {at} holds {share}; how many there are cannot be told: {why}"
                );
            }
        };
        match shapes.is_coherent.iter().position(|is| *is) {
            Some(0) => format!("{modes} at {at}: the first holds {} of the power", share(0)),
            // Louder sites that are not related come first.
            Some(n) => format!("{modes} at {at}: number {} by power, {}", n + 1, share(n)),
            None => format!("{modes} at {at}"),
        }
    }

    /// The velocity of a wave with its interval, where that is known.
    fn velocity(&self, wave: &ModeWave) -> Option<String> {
        let (time_unit, space_unit) = self.units();
        let unit = format!("{space_unit}/{time_unit}");
        Some(with_half(wave.velocity, wave.velocity_half?, &unit))
    }

    /// What kind of wave the first mode is, where it is one.
    fn wave_in_words(&self, shapes: &ModeShapes) -> String {
        let wave = shapes.waves.first().copied().flatten();
        let Some(wave) = wave.filter(|wave| wave.is_wave) else {
            return String::new();
        };
        let velocity = self.velocity(&wave).map(|velocity| format!(", {velocity}"));
        let (k, unit, velocity) = (
            number(wave.wavenumber),
            self.units().1,
            velocity.unwrap_or_default(),
        );
        format!("; a wave, k = {k} rad/{unit}{velocity}")
    }

    /// A row a mode of each chosen frequency.
    fn table(&self) -> Table {
        let (time_unit, space_unit) = self.units();
        let or_dash = |text: Option<String>| text.unwrap_or("-".into());
        let row = |(shapes, n): (&ModeShapes, usize)| {
            let wave = shapes.waves[n].as_ref();
            let is_wave = wave.filter(|wave| wave.is_wave);
            vec![
                number(shapes.frequency),
                (n + 1).to_string(),
                self.share(shapes.bin, n),
                or_dash(shapes.is_coherent[n].then(|| "yes".into())),
                or_dash(is_wave.map(|wave| number(wave.wavenumber))),
                or_dash(is_wave.and_then(|wave| self.velocity(wave))),
                or_dash(wave.map(|wave| number(wave.share))),
            ]
        };
        let of_modes = |shapes| (0..self.chosen[0].waves.len()).map(move |n| (shapes, n));
        let head = [
            &label("frequency", &cycles_per(&time_unit)),
            "mode",
            "share of the power",
            "coherent",
            &label("wavenumber", &format!("rad/{space_unit}")),
            "phase velocity",
            "share in step with the wave",
        ];
        let rows = self.chosen.iter().flat_map(of_modes).map(row);
        Table::of("Chosen frequencies", &head, rows)
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let units = Units::of(&self.time, &self.space, self.unit.as_deref());
        sheet.line("frequency", "frequency", &units.frequency, &self.frequency);
        sheet.line("position", "position", &units.space, self.positions());
        let power = units.density(&units.frequency, &units.space);
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
    fn chart(&self, title: &str, y: String, series: Vec<Series>) -> Chart {
        let x = label("frequency f", &cycles_per(&self.units().0));
        Chart {
            log_x: self.frequency.len() > 16,
            ..Chart::of(title, x, y, series)
        }
    }

    fn points(&self, of: impl Fn(usize) -> f64) -> Vec<(f64, f64)> {
        let bins = 1..self.frequency.len();
        bins.map(|bin| (self.frequency[bin], of(bin))).collect()
    }

    fn eigenvalue_chart(&self) -> Chart {
        let unit = self.unit.as_deref().unwrap_or_default();
        let word = |axis: &crate::field::Axis| axis.unit.clone().unwrap_or_default();
        let unit = compose(&[&square(unit), &word(&self.time), &word(&self.space)], &[]);
        let total = self.points(|bin| self.total[bin]);
        let mut series = vec![Series::line("all modes", BLACK, total).with(Look::Dashed)];
        for (n, colour) in (0..self.eigenvalues.ncols()).zip(SHOWN) {
            let points = self.points(|bin| self.eigenvalues[[bin, n]]);
            series.push(Series::line(format!("mode {}", n + 1), colour, points));
        }
        if self.interval(1).is_some() {
            let name = format!("mode 1, {} interval", confidence(self.alpha));
            for (end, name) in [name, String::new()].into_iter().enumerate() {
                let factor = |bin| self.interval(bin).map_or(f64::NAN, |ends| ends[end]);
                let points = self.points(|bin| self.eigenvalues[[bin, 0]] * factor(bin));
                series.push(Series::line(name, SKY, points).with(Look::Dashed));
            }
        }
        let values = series.iter().flat_map(|s| &s.points).map(|p| p.1);
        let y = extent(values.filter(|v| *v > 0.0));
        Chart {
            log_y: true,
            y: y.start.max(DEEPEST * y.end) / 1.5..1.5 * y.end,
            ..self.chart("eigenvalues", label("eigenvalue λ", &unit), series)
        }
    }

    fn share_chart(&self) -> Chart {
        let points = self.points(|bin| self.leading_share(bin));
        let (series, label) = (vec![Series::line("", BLUE, points)], "share of the power");
        Chart {
            y: 0.0..1.0,
            ..self.chart("share of the first mode", label.into(), series)
        }
    }

    fn shape_chart(&self, shapes: &ModeShapes) -> Option<Chart> {
        let (time_unit, space_unit) = self.units();
        let mode = shapes.modes.rows().into_iter().next()?;
        let positions = self.positions();
        let points = |of: fn(&Complex<f64>) -> f64| -> Vec<(f64, f64)> {
            positions.iter().copied().zip(mode.iter().map(of)).collect()
        };
        let most = extent(mode.iter().map(|z| z.norm())).end;
        let (at, unit) = (six_digits(shapes.frequency), cycles_per(&time_unit));
        let wave = self.wave_in_words(shapes);
        let title = format!("mode 1 at f = {at} {unit}{wave}");
        Some(Chart {
            y: -1.15 * most..1.15 * most,
            ..Chart::of(
                title,
                label("position x", &space_unit),
                label("mode φ", &format!("1/√{space_unit}")),
                vec![
                    Series::line("real part", BLUE, points(|z| z.re)),
                    Series::line("modulus", BLACK, points(|z| z.norm())).with(Look::Dashed),
                ],
            )
        })
    }
}
