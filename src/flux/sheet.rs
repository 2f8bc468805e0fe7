//! What a flux says.

use std::f64::consts::LN_10;

use ndarray::Array2;
use serde_json::json;

use super::{Flux, FluxBand, Known, NoFlux};
use crate::numeric::sorted;
use crate::sheet::{
    BLUE, Band, Chart, Describe, Look, PlotRow, Role, Series, Sheet, Table, Units, VERMILLION,
    confidence, number, percent, with_half, with_unit,
};
use crate::unit::{compose, label};

const DEFINITIONS: &str = "\
    Flux P(f, x): Mass per length times group velocity times the square of the velocity that a wave has, per unit of frequency. Waves \
        towards +x and towards -x are told apart by their phases along x; the net flux is the difference of both.
    Attenuation: Loss of amplitude per length: 1 Np is 8.686 dB.
    Loss factor: Attenuation times group velocity over πf: the share of its energy that a wave loses in a radian. The quality factor is \
        its inverse.
    Interval: By the jackknife over groups of sites and of frequencies, with the random spread of powers.
    Linear waves: The flux is that of waves whose speed does not depend on their amplitude, and of one branch at each frequency.";

/// Decibels of a neper.
const DECIBELS: f64 = 20.0 / LN_10;
/// Share of the power without a flux above which it is said.
const MUCH: f64 = 0.1;
const WAYS: [&str; 3] = ["plus", "minus", "net"];
/// Metric prefixes of thousands, from the least on.
const PREFIXES: [&str; 11] = ["a", "f", "p", "n", "µ", "m", "", "k", "M", "G", "T"];

impl NoFlux {
    const ALL: [NoFlux; 6] = [
        NoFlux::NoWave,
        NoFlux::SeveralWaves,
        NoFlux::Evanescent,
        NoFlux::Directions,
        NoFlux::Velocity,
        NoFlux::Amplitude,
    ];

    /// Why, and what can be done.
    fn words(self) -> [&'static str; 2] {
        match self {
            NoFlux::NoWave => ["no wave stands above the noise", ""],
            NoFlux::SeveralWaves => ["there is not one wave each way", ""],
            NoFlux::Evanescent => ["the wave decays within its length", ""],
            NoFlux::Amplitude => ["the wavenumber changes with the amplitude", ""],
            NoFlux::Directions => [
                "the array is too short to tell both directions apart",
                "state `--towards plus-x` or `minus-x` if waves go one way",
            ],
            NoFlux::Velocity => [
                "the wavenumbers do not tell the group velocity",
                "state it (`--group-velocity`), or the law that it follows from (`--dispersion`)",
            ],
        }
    }
}

impl Known {
    fn times(self, factor: f64) -> Known {
        Known {
            value: factor * self.value,
            half: factor.abs() * self.half,
        }
    }

    fn words(self, unit: &str) -> String {
        with_half(self.value, self.half, unit)
    }
}

impl FluxBand {
    /// Names, units and values of what a band says beside the flux.
    fn quantities(units: &Units) -> [(&'static str, String, fn(&FluxBand) -> Known); 6] {
        let per = |word: &str| compose(&[word], &[&units.space]);
        [
            ("wavenumber", units.wavenumber.clone(), |b| b.wavenumber),
            ("group_velocity", units.velocity.clone(), |b| {
                b.group_velocity
            }),
            ("attenuation", per("Np"), |b| b.attenuation),
            ("attenuation_decibels", per("dB"), |b| {
                b.attenuation.times(DECIBELS)
            }),
            ("loss_factor", String::new(), |b| b.loss_factor),
            ("quality_factor", String::new(), |b| b.quality_factor),
        ]
    }
}

impl Describe for Flux {
    /// Variables: `frequency`, `from`, `to` (bands), `position` (sites); `flux_plus`, `flux_minus`, `flux_net` (bands, sites), their
    /// totals `total_plus` and others (sites); `wavenumber`, `group_velocity`, `attenuation`, `attenuation_decibels`, `loss_factor`,
    /// `quality_factor` (bands). Halves of their intervals have `_half` behind the name.
    fn describe(&self) -> Sheet<'_> {
        let words = self.units(true);
        let interval = confidence(self.alpha);
        let mut sheet = Sheet {
            needs_sites_in_step: true,
            about: "flux of energy of waves both ways, and their loss".into(),
            answer: self.answer(),
            note: format!("Intervals: {interval}."),
            ..Sheet::of("flux", "Flux of energy", DEFINITIONS)
        };
        for (name, unit, of) in &FluxBand::quantities(&words)[1..] {
            let values = self.bands.iter().map(|band| of(band).value);
            let values = sorted(values.filter(|value| value.is_finite()));
            if let Some(last) = values.len().checked_sub(1) {
                let at = |part: f64| number(values[(part * last as f64).round() as usize]);
                let [low, middle, high] = [0.25, 0.5, 0.75].map(at);
                let text = format!("{middle} {unit}").trim_end().to_owned();
                sheet.fact(
                    name.replace('_', " "),
                    format!("{text} (half of the bands: {low} to {high})"),
                );
            }
        }
        let text = format!(
            "{} of the power of all samples is of bands with a flux",
            percent(self.stated)
        );
        sheet.fact("stated", text);
        for reason in NoFlux::ALL {
            let without: Vec<_> = self
                .bands
                .iter()
                .filter(|b| b.reason == Some(reason))
                .collect();
            if let [first, .., last] | [first @ last] = &without[..] {
                let [why, advice] = reason.words();
                let (count, of) = (without.len(), self.bands.len());
                let ends = [first.from, last.to].map(|f| with_unit(f, &words.frequency));
                let text = format!(
                    "at {count} of {of} bands, within {} to {}: {why}",
                    ends[0], ends[1]
                );
                match self.stated < 1.0 - MUCH && !advice.is_empty() {
                    true => sheet.warn(format!("no flux is stated {text}"), advice),
                    false => sheet.fact("without a flux", text),
                }
            }
        }
        sheet
            .warnings
            .extend_from_slice(&self.scan.analysis.warnings);
        self.table(&mut sheet, &words);
        let bands = self.bands.iter().map(|band| {
            json!({
                "from": band.from,
                "to": band.to,
                "frequency": band.frequency,
                "reason": band.reason,
                "wavenumber": band.wavenumber,
                "group_velocity": band.group_velocity,
                "attenuation": band.attenuation,
                "loss_factor": band.loss_factor,
                "quality_factor": band.quality_factor,
            })
        });
        let ends = |way: usize| [self.total[way].first(), self.total[way].last()];
        sheet.numbers(json!({
            "time_unit": words.time,
            "space_unit": words.space,
            "power_unit": self.power_unit,
            "is_transient": self.is_transient,
            "independence": self.scan.independence,
            "alpha": self.alpha,
            "stated_share": self.stated,
            "loss_decibels": self.loss,
            "total_plus": ends(0),
            "total_minus": ends(1),
            "total_net": ends(2),
            "bands": bands.collect::<Vec<_>>(),
        }));
        self.variables(&mut sheet);
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        let words = self.units(true);
        let frequency = words.label(Role::Frequency);
        let site = if self.is_backward() {
            self.n_sites - 1
        } else {
            0
        };
        let flux = |name, colour, way: usize| {
            let values = [&self.density[way], &self.density_half[way]].map(|map| map.column(site));
            let known = values[0].iter().zip(values[1]);
            let known = known.map(|(value, half)| Known {
                value: *value,
                half: *half,
            });
            self.series(name, colour, known)
        };
        let both = vec![
            flux("towards +x", BLUE, 0),
            flux("towards −x", VERMILLION, 1),
        ];
        let unit = label("flux", &self.density_unit(&words));
        let title = format!("flux at site {site}");
        let flux = Chart::of(title, frequency.clone(), unit, both).about_zero();
        let loss = self.series(
            "loss factor",
            BLUE,
            self.bands.iter().map(|band| band.loss_factor),
        );
        let loss = Chart::of(
            "loss factor",
            frequency,
            String::from("loss factor"),
            vec![loss],
        );
        let map = self.scan.map().map(|map| PlotRow::of([map]).high(1.4));
        map.into_iter()
            .chain([PlotRow::of([flux]), PlotRow::of([loss])])
            .collect()
    }
}

impl Flux {
    fn units(&self, is_in_words: bool) -> Units {
        let of = if is_in_words {
            Units::in_words
        } else {
            Units::of
        };
        of(&self.time, &self.space, self.unit.as_deref())
    }

    fn density_unit(&self, units: &Units) -> String {
        compose(&[&self.power_unit], &[&units.frequency])
    }

    /// Values by frequency with their intervals as an area.
    fn series(&self, name: &str, colour: usize, known: impl Iterator<Item = Known>) -> Series {
        let known: Vec<Known> = known.collect();
        let points = self
            .bands
            .iter()
            .zip(&known)
            .map(|(band, known)| (band.frequency, known.value));
        Series {
            band: Some(Band {
                label: confidence(self.alpha),
                ends: known
                    .iter()
                    .map(|k| (k.value - k.half, k.value + k.half))
                    .collect(),
            }),
            ..Series::line(name, colour, points.collect())
        }
        .with(Look::Line)
    }

    /// A power (energy) with a metric prefix, where its unit takes one: its factor and its unit.
    fn prefixed(&self, value: f64) -> (f64, String) {
        let takes = matches!(&self.power_unit[..], "W" | "J") && value.abs() > 0.0;
        let power = if takes {
            (value.abs().log10() / 3.0).floor().clamp(-6.0, 4.0)
        } else {
            0.0
        };
        let prefix = PREFIXES[(power + 6.0) as usize];
        (1000f64.powf(-power), format!("{prefix}{}", self.power_unit))
    }

    fn answer(&self) -> String {
        let stated = self
            .bands
            .iter()
            .filter(|band| band.reason.is_none())
            .count();
        if stated == 0 {
            let count = |reason: &NoFlux| {
                self.bands
                    .iter()
                    .filter(|b| b.reason == Some(*reason))
                    .count()
            };
            let most = NoFlux::ALL
                .into_iter()
                .rev()
                .max_by_key(count)
                .unwrap_or(NoFlux::NoWave);
            return format!("no flux can be stated: {}", most.words()[0]);
        }
        let words = self.units(true);
        let (way, towards, other) = match self.is_backward() {
            false => (0, "+x", "−x"),
            true => (1, "−x", "+x"),
        };
        let last = self.n_sites - 1;
        // The sites where these waves enter and leave.
        let [begin, end] = if self.is_backward() {
            [last, 0]
        } else {
            [0, last]
        };
        let total = &self.total[way];
        let (factor, unit) = self.prefixed(total[begin].value);
        let [first, reach] = [begin, end].map(|site| total[site].times(factor));
        let mut text = format!(
            "{} pass site {begin} towards {towards}, {} reach site {end}",
            first.words(&unit),
            reach.words("")
        );
        let back = self.total[1 - way][begin];
        if back.value > back.half {
            text += &format!(", {} return towards {other}", back.times(factor).words(""));
        }
        text += &format!(
            ": {} are lost",
            self.loss.words(&compose(&["dB"], &[&words.space]))
        );
        let lost = |band: &usize| {
            let lost = self.density[way][[*band, begin]] - self.density[way][[*band, end]];
            lost * (self.bands[*band].to - self.bands[*band].from)
        };
        let all = (0..self.bands.len()).filter(|band| lost(band).is_finite());
        let most = all.max_by(|a, b| lost(a).total_cmp(&lost(b)));
        if let Some(most) = most.filter(|_| self.loss.value > self.loss.half) {
            text += &format!(
                ", most at {}",
                with_unit(self.bands[most].frequency, &words.frequency)
            );
        }
        text
    }

    fn table(&self, sheet: &mut Sheet, words: &Units) {
        let site = if self.is_backward() {
            self.n_sites - 1
        } else {
            0
        };
        let quantities = FluxBand::quantities(words);
        let density = self.density_unit(words);
        let head = [
            format!("f [{}]", words.frequency),
            format!("towards +x [{density}]"),
            format!("towards −x [{density}]"),
            format!("group velocity [{}]", words.velocity),
            format!("[{}]", quantities[3].1),
            "loss factor".into(),
            "Q".into(),
        ];
        let shown = |known: Known| match known.value.is_finite() {
            true => known.words(""),
            false => "-".into(),
        };
        let row = |(b, band): (usize, &FluxBand)| {
            let flux = |way: usize| Known {
                value: self.density[way][[b, site]],
                half: self.density_half[way][[b, site]],
            };
            let cells = [flux(0), flux(1)].into_iter().map(shown);
            let others = [1, 3, 4, 5].map(|n: usize| shown(quantities[n].2(band)));
            std::iter::once(number(band.frequency))
                .chain(cells)
                .chain(others)
                .collect()
        };
        let head = head.each_ref().map(String::as_str);
        let rows = self
            .bands
            .iter()
            .enumerate()
            .filter(|(_, band)| band.reason.is_none());
        let title = format!("By frequency, at site {site}");
        sheet.tables.push(Table::of(title, &head, rows.map(row)));
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let units = self.units(false);
        let density = self.density_unit(&units);
        let bands = |of: fn(&FluxBand) -> f64| self.bands.iter().map(of).collect::<Vec<f64>>();
        sheet.axis(Role::Frequency, &units, bands(|band| band.frequency));
        sheet.line(
            "from",
            "frequency",
            &units.frequency,
            bands(|band| band.from),
        );
        sheet.line("to", "frequency", &units.frequency, bands(|band| band.to));
        let positions: Vec<f64> = (0..self.n_sites).map(|j| self.space.at(j)).collect();
        sheet.axis(Role::Position, &units, positions);
        for (name, unit, of) in FluxBand::quantities(&units) {
            let known: Vec<Known> = self.bands.iter().map(of).collect();
            pair(sheet, name, "frequency", &unit, &known);
        }
        for (way, name) in WAYS.iter().enumerate() {
            let plane = |sheet: &mut Sheet<'a>, name: &str, values: &'a Array2<f64>| {
                sheet.plane(name, ["frequency", "position"], &density, values);
            };
            plane(sheet, &format!("flux_{name}"), &self.density[way]);
            plane(sheet, &format!("flux_{name}_half"), &self.density_half[way]);
            pair(
                sheet,
                &format!("total_{name}"),
                "position",
                &self.power_unit,
                &self.total[way],
            );
        }
    }
}

/// Adds an array and the halves of its intervals.
fn pair(sheet: &mut Sheet, name: &str, dimension: &str, unit: &str, known: &[Known]) {
    let values: Vec<f64> = known.iter().map(|known| known.value).collect();
    let halves: Vec<f64> = known.iter().map(|known| known.half).collect();
    sheet.line(name, dimension, unit, values);
    sheet.line(&format!("{name}_half"), dimension, unit, halves);
}
