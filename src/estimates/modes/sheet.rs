//! What modes say.

use num_complex::Complex;
use serde_json::{Value, json};

use super::{ModeShapes, Modes};
use crate::estimates::realisations::REALISATIONS;
use crate::measure::cycles_per;
use crate::sheet::{
    BLACK, BLUE, Chart, Column, Describe, GREEN, Look, PlotRow, SKY, Series, Sheet, Table, Units,
    VERMILLION, extent, number, percent, six_digits, with_half,
};
use crate::unit::{compose, label, square};

const DEFINITIONS: [[&str; 2]; 5] = [
    [
        "Mode",
        "A motion of all sites at one frequency, Re φ(x) exp(−2πi f t), that is uncorrelated with the others. \
         Modes are ordered by their power.",
    ],
    [
        "Eigenvalue λ",
        "Power spectral density of a mode, integrated over x. The eigenvalues of a frequency sum up to that of \
         the field.",
    ],
    [
        "Interval",
        "By chi-square, for the effective number of realisations. It holds for eigenvalues that are well apart.",
    ],
    [
        "Wave",
        "A mode in step with |φ(x)| exp(ikx) to 0.9 of its energy, over at least half a wavelength. A standing \
         wave reaches 0.72.",
    ],
    REALISATIONS,
];

/// Eigenvalues that are drawn.
const SHOWN: usize = 3;
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
        let mut sheet = Sheet {
            name: "modes",
            version: 1,
            title: "Modes that are coherent along x".into(),
            about: format!("positions in {space_unit}, times in {time_unit}"),
            answer: self.answer(),
            note: match self.interval(1) {
                Some([low, high]) => format!(
                    "The {} % interval of an eigenvalue reaches from {low:.2} to {high:.2} of it, by chi-square.",
                    100.0 * (1.0 - self.alpha)
                ),
                None => "No interval can be stated: too few independent realisations.".into(),
            },
            definitions: DEFINITIONS.to_vec(),
            ..Sheet::default()
        };
        sheet.numbers(json!({ "time_unit": time_unit, "space_unit": space_unit }));
        self.facts(&mut sheet);
        let interval = match self.interval(1) {
            Some([low, high]) => format!("{} to {} of it", number(low), number(high)),
            None => "not stated: fewer than two independent realisations".into(),
        };
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
                "waves": shapes.waves,
            })
        };
        sheet.numbers(json!({
            "alpha": self.alpha,
            "interval": self.interval(1),
            "leading_share": self.leading_share_of_all(),
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
    /// How many modes there are, in words.
    fn answer(&self) -> String {
        let unit = cycles_per(&self.units().0);
        let Some(shapes) = self.chosen.first() else {
            return "no power at any frequency".into();
        };
        // A bin is as wide as its distance from the next.
        let half = match self.frequency[..] {
            [first, second, ..] => 0.5 * (second - first),
            _ => 0.0,
        };
        let at = with_half(shapes.frequency, half, &unit);
        let share = percent(self.leading_share(shapes.bin));
        let Some(count) = self.above_noise(shapes.bin) else {
            return format!(
                "the first mode at {at} holds {share}; how many there are cannot be told: {}",
                self.independence.why_none()
            );
        };
        match count {
            0 => format!(
                "no motion is coherent along x at {at}: the first mode holds {share}, as noise would"
            ),
            1 => format!("one mode at {at}, which holds {share} of the power"),
            _ => format!("{count} modes at {at}, of which the first holds {share} of the power"),
        }
    }

    fn facts(&self, sheet: &mut Sheet) {
        let share = percent(self.leading_share_of_all());
        sheet.fact(
            "first modes",
            format!("hold {share} of the power of all frequencies"),
        );
        let interval = match self.interval(1) {
            Some([low, high]) => format!(
                "{} to {} of an eigenvalue, by chi-square, with probability {}",
                number(low),
                number(high),
                percent(1.0 - self.alpha)
            ),
            None => "none can be stated".into(),
        };
        sheet.fact("interval", interval);
        let (time_unit, space_unit) = self.units();
        for shapes in &self.chosen {
            let share = percent(self.leading_share(shapes.bin));
            let wave = match shapes.waves.first().copied().flatten() {
                Some(wave) if wave.is_wave => format!(
                    "; a wave, k = {} rad/{space_unit}, {} {space_unit}/{time_unit}",
                    number(wave.wavenumber),
                    number(wave.velocity)
                ),
                _ => String::new(),
            };
            sheet.fact(
                format!("f = {}", number(shapes.frequency)),
                format!("the first mode holds {share} of the power{wave}"),
            );
        }
    }

    /// A row a mode of each chosen frequency.
    fn table(&self) -> Table {
        let (time_unit, space_unit) = self.units();
        let row = |shapes: &ModeShapes, n: usize| {
            let share = self.eigenvalues[[shapes.bin, n]] / self.total[shapes.bin];
            let wave = shapes.waves[n];
            let of_wave = |value: Option<f64>| value.map_or("-".into(), number);
            let is_wave = wave.filter(|wave| wave.is_wave);
            vec![
                number(shapes.frequency),
                (n + 1).to_string(),
                percent(share),
                of_wave(is_wave.map(|wave| wave.wavenumber)),
                of_wave(is_wave.map(|wave| wave.velocity)),
                of_wave(wave.map(|wave| wave.share)),
            ]
        };
        let rows = self.chosen.iter().flat_map(|shapes| {
            let count = shapes.modes.nrows();
            (0..count).map(move |n| row(shapes, n))
        });
        Table {
            title: "Chosen frequencies".into(),
            head: vec![
                label("frequency", &cycles_per(&time_unit)),
                "mode".into(),
                "share of the power".into(),
                label("wavenumber", &format!("rad/{space_unit}")),
                label("phase velocity", &format!("{space_unit}/{time_unit}")),
                "share in step with the wave".into(),
            ],
            rows: rows.collect(),
            ..Table::default()
        }
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let units = Units::of(&self.time, &self.space, self.unit.as_deref());
        sheet.line("frequency", "frequency", &units.frequency, &self.frequency);
        sheet.line("position", "position", &units.space, self.positions());
        let power = units.density(&units.frequency, &units.space);
        sheet.plane(
            "eigenvalues",
            ["frequency", "mode"],
            &power,
            &self.eigenvalues,
        );
        sheet.line("total", "frequency", &power, &self.total);
        let bins = self.eigenvalues.nrows();
        let ends = |bin| self.interval(bin).unwrap_or([f64::NAN; 2]);
        let intervals: Vec<f64> = (0..bins).flat_map(ends).collect();
        let axes = [("frequency", bins), ("end", 2)];
        sheet.variable("interval", &axes, "", intervals);
        let chosen: Vec<f64> = self.chosen.iter().map(|shapes| shapes.frequency).collect();
        let kept = self.chosen.first().map_or(0, |shapes| shapes.modes.nrows());
        let axes = [
            ("mode_frequency", chosen.len()),
            ("kept_mode", kept),
            ("position", self.n_sites),
        ];
        sheet.line("mode_frequency", "mode_frequency", &units.frequency, chosen);
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

    fn frequency_label(&self) -> String {
        label("frequency f", &cycles_per(&self.units().0))
    }

    fn eigenvalue_chart(&self) -> Chart {
        let unit = self.unit.as_deref().unwrap_or_default();
        let word = |axis: &crate::field::Axis| axis.unit.clone().unwrap_or_default();
        let unit = compose(&[&square(unit), &word(&self.time), &word(&self.space)], &[]);
        let inside = || (1..self.frequency.len()).map(|bin| (bin, self.frequency[bin]));
        let curve = |n: usize| -> Vec<(f64, f64)> {
            let points = inside().map(|(bin, f)| (f, self.eigenvalues[[bin, n]]));
            points.collect()
        };
        let total = inside().map(|(bin, f)| (f, self.total[bin])).collect();
        let mut series = vec![Series::line("all modes", BLACK, total).with(Look::Dashed)];
        let shown = self.eigenvalues.ncols().min(SHOWN);
        for (n, colour) in [BLUE, VERMILLION, GREEN]
            .into_iter()
            .enumerate()
            .take(shown)
        {
            series.push(Series::line(format!("mode {}", n + 1), colour, curve(n)));
        }
        if self.interval(1).is_some() {
            let percent = 100.0 * (1.0 - self.alpha);
            for end in 0..2 {
                let points = inside().filter_map(|(bin, f)| {
                    let factor = self.interval(bin)?[end];
                    Some((f, self.eigenvalues[[bin, 0]] * factor))
                });
                let name = match end {
                    0 => format!("mode 1, {percent} % interval"),
                    _ => String::new(),
                };
                series.push(Series::line(name, SKY, points.collect()).with(Look::Dashed));
            }
        }
        let values = series.iter().flat_map(|s| &s.points).map(|p| p.1);
        let y = extent(values.filter(|v| *v > 0.0));
        Chart {
            log_x: self.frequency.len() > 16,
            log_y: true,
            y: y.start.max(DEEPEST * y.end) / 1.5..1.5 * y.end,
            ..Chart::of(
                "eigenvalues",
                self.frequency_label(),
                label("eigenvalue λ", &unit),
                series,
            )
        }
    }

    fn share_chart(&self) -> Chart {
        let bins = 1..self.frequency.len();
        let points = bins.map(|bin| (self.frequency[bin], self.leading_share(bin)));
        Chart {
            log_x: self.frequency.len() > 16,
            y: 0.0..1.0,
            ..Chart::of(
                "share of the first mode",
                self.frequency_label(),
                "share of the power",
                vec![Series::line("", BLUE, points.collect())],
            )
        }
    }

    fn shape_chart(&self, shapes: &ModeShapes) -> Option<Chart> {
        let (time_unit, space_unit) = self.units();
        let mode = shapes.modes.rows().into_iter().next()?;
        let positions = self.positions();
        let points = |of: fn(&Complex<f64>) -> f64| -> Vec<(f64, f64)> {
            positions.iter().copied().zip(mode.iter().map(of)).collect()
        };
        let wave = match shapes.waves.first().copied().flatten() {
            Some(wave) if wave.is_wave => {
                format!(", k = {:.4} rad/{space_unit}", wave.wavenumber)
            }
            _ => String::new(),
        };
        let most = extent(mode.iter().map(|z| z.norm())).end;
        Some(Chart {
            y: -1.15 * most..1.15 * most,
            ..Chart::of(
                format!(
                    "mode 1 at f = {} {}{wave}",
                    six_digits(shapes.frequency),
                    cycles_per(&time_unit)
                ),
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
