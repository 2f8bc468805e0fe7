//! What a flux says.

use std::f64::consts::LN_10;

use serde_json::json;

use super::{Flux, FluxBand, Known, NoFlux};
use crate::measure::counted;
use crate::numeric::sorted;
use crate::sheet::{
    BLUE, Chart, Describe, PlotRow, Role, Series, Sheet, Units, VERMILLION, confidence, percent,
    with_half, with_range, with_unit,
};
use crate::unit::{compose, label};

const DEFINITIONS: &str = "\
    Flux P(f, x): Mass per length times group velocity times the mean square velocity of a wave, per unit of frequency. Waves towards \
        +x and towards -x are told apart by their phases along x; the net flux is the difference of both.
    Attenuation: Loss of amplitude per length: 1 Np is 8.686 dB.
    Loss factor: Attenuation times group velocity over πf, the share of its energy that a wave loses in a radian; 1/Q.
    Interval: By the jackknife over groups of sites, and of frequencies or shots.
    Linear waves: The flux is that of waves whose speed does not depend on their amplitude, of one branch at each frequency.";

/// Decibels of a neper.
const DECIBELS: f64 = 20.0 / LN_10;
/// Share of the power without a flux that is said at once.
const SAID: f64 = 0.1;
/// Metric prefixes of thousands, from the least on.
const PREFIXES: [&str; 11] = ["a", "f", "p", "n", "µ", "m", "", "k", "M", "G", "T"];

impl NoFlux {
    const ALL: [(NoFlux, &str); 6] = [
        (
            NoFlux::NoWave,
            "no wave stands above what one wave each way leaves (noise, waves that have not passed all sites)",
        ),
        (
            NoFlux::Ends,
            "the waves do not pass all sites as one wave each way (they begin, end, grow or are cut within the array)",
        ),
        (NoFlux::SeveralWaves, "there is not one wave each way"),
        (NoFlux::Evanescent, "the wave decays within its length"),
        (
            NoFlux::Directions,
            "the array is too short to tell both directions apart (`--towards plus-x` where nothing comes back)",
        ),
        (
            NoFlux::Velocity,
            "the wavenumbers do not tell the group velocity (`--group-velocity` or `--dispersion` state it)",
        ),
    ];
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
    /// `1 / loss factor`.
    pub fn quality_factor(&self) -> Known {
        let Known { value, half } = self.loss_factor;
        Known {
            value: 1.0 / value,
            half: half / (value * value),
        }
    }
}

impl Describe for Flux {
    /// Variables: `frequency`, `from`, `to` (bands), `position` (sites); `flux_plus`, `flux_minus`, `flux_net` (bands, sites), their
    /// totals `total_plus` and others (sites); `wavenumber`, `group_velocity`, `attenuation` in Np, `attenuation_decibels`,
    /// `loss_factor`, `quality_factor` (bands). Halves of their intervals have `_half` behind the name.
    fn describe(&self) -> Sheet<'_> {
        let words = self.units(true);
        let mut sheet = Sheet {
            needs_sites_in_step: true,
            about: "flux of energy of waves both ways, and their loss".into(),
            answer: self.answer(),
            note: format!("Intervals: {}.", confidence(self.alpha)),
            ..Sheet::of("flux", "Flux of energy", DEFINITIONS)
        };
        let factors = self.bands.iter().map(|band| band.loss_factor.value);
        let factors = sorted(factors.filter(|value| value.is_finite()));
        if let Some(last) = factors.len().checked_sub(1) {
            let [low, middle, high] = [last / 4, last / 2, last - last / 4].map(|n| factors[n]);
            let text = with_range(low, middle, high);
            sheet.fact(
                "loss factor",
                format!("{text}, median and quartiles of the bands"),
            );
        }
        let stated = percent(self.stated);
        sheet.fact(
            "stated",
            format!("{stated} of the power of all samples is of bands with a flux"),
        );
        for (reason, why) in NoFlux::ALL {
            let without: Vec<_> = self
                .bands
                .iter()
                .filter(|b| b.reason == Some(reason))
                .collect();
            if let (Some(first), Some(last)) = (without.first(), without.last()) {
                let [from, to] = [first.from, last.to].map(|f| with_unit(f, &words.frequency));
                let count = without.len();
                sheet.fact(
                    "without a flux",
                    format!("{} within {from} to {to}: {why}", counted(count, "band")),
                );
            }
        }
        sheet
            .warnings
            .extend_from_slice(&self.scan.analysis.warnings);
        sheet.numbers(json!({
            "time_unit": words.time,
            "space_unit": words.space,
            "power_unit": self.power_unit,
            "independence": self.scan.independence,
            "alpha": self.alpha,
            "stated_share": self.stated,
            "loss_decibels": self.loss,
            "total_plus": [self.total[0].first(), self.total[0].last()],
            "total_minus": [self.total[1].first(), self.total[1].last()],
            "bands": self.bands,
        }));
        self.variables(&mut sheet);
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        let words = self.units(true);
        let last = self.positions.len() - 1;
        let enters = if self.is_backward() { last } else { 0 };
        let series = |name: &str, colour, of: &dyn Fn(usize) -> Known| {
            let points = self.bands.iter().map(|band| band.frequency).enumerate();
            let points = points.map(|(b, f)| [f, of(b).value, of(b).half]);
            Series::with_errors(name, colour, points)
        };
        let flux = |name: &str, colour, way: usize| {
            let [value, half] = self.density[way].each_ref().map(|map| map.column(enters));
            series(name, colour, &|b| Known {
                value: value[b],
                half: half[b],
            })
        };
        let both = vec![
            flux("towards +x", BLUE, 0),
            flux("towards −x", VERMILLION, 1),
        ];
        let loss = vec![series("loss factor", BLUE, &|b| self.bands[b].loss_factor)];
        let frequency = words.label(Role::Frequency);
        let unit = label("flux", &compose(&[&self.power_unit], &[&words.frequency]));
        let title = format!("flux at site {enters}");
        let map = self.scan.map().map(|map| PlotRow::of([map]).high(1.4));
        let charts = [
            Chart::of(title, frequency.clone(), unit, both).about_zero(),
            Chart::of("loss factor", frequency, String::from("loss factor"), loss).about_zero(),
        ];
        map.into_iter()
            .chain(charts.map(|chart| PlotRow::of([chart])))
            .collect()
    }
}

impl Flux {
    fn units(&self, is_in_words: bool) -> Units {
        let axes = &self.scan.analysis.axes;
        let of = if is_in_words {
            Units::in_words
        } else {
            Units::of
        };
        of(&axes.time, &axes.space, None)
    }

    fn answer(&self) -> String {
        let count = |reason| self.bands.iter().filter(|b| b.reason == reason).count();
        if count(None) == 0 {
            let most = NoFlux::ALL
                .into_iter()
                .rev()
                .max_by_key(|(reason, _)| count(Some(*reason)));
            return format!("no flux can be stated: {}", most.map_or("", |(_, why)| why));
        }
        let (words, last) = (self.units(true), self.positions.len() - 1);
        let (way, [enters, leaves], [towards, other]) = match self.is_backward() {
            false => (0, [0, last], ["+x", "−x"]),
            true => (1, [last, 0], ["−x", "+x"]),
        };
        let [first, reach, back] = [(way, enters), (way, leaves), (1 - way, enters)]
            .map(|(way, site)| self.total[way][site]);
        let is_metric = matches!(&self.power_unit[..], "W" | "J") && first.value > 0.0;
        let thousands = if is_metric {
            (first.value.log10() / 3.0).floor().clamp(-6.0, 4.0)
        } else {
            0.0
        };
        let unit = format!(
            "{}{}",
            PREFIXES[(thousands + 6.0) as usize],
            self.power_unit
        );
        let factor = 1000f64.powf(-thousands);
        let returns = match back.value > back.half {
            true => format!(", {} return towards {other}", back.times(factor).words("")),
            false => String::new(),
        };
        let (first, reach) = (
            first.times(factor).words(&unit),
            reach.times(factor).words(""),
        );
        let decibels = compose(&["dB"], &[&words.space]);
        let loss = match self.loss.value < -self.loss.half {
            true => format!("{} are gained", self.loss.times(-1.0).words(&decibels)),
            false => format!("{} are lost", self.loss.words(&decibels)),
        };
        let lost = |b: usize| {
            let (density, band) = (&self.density[way][0], &self.bands[b]);
            let lost = (density[[b, enters]] - density[[b, leaves]]) * (band.to - band.from);
            (lost, band.frequency)
        };
        let all = (0..self.bands.len())
            .map(lost)
            .filter(|(lost, _)| lost.is_finite());
        let most = match all.max_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((_, f)) if self.loss.value > self.loss.half => {
                format!(", most at {}", with_unit(f, &words.frequency))
            }
            _ => String::new(),
        };
        let without = match 1.0 - self.stated {
            share if share > SAID => {
                format!("; {} of the power of all samples has none", percent(share))
            }
            _ => String::new(),
        };
        format!(
            "{first} pass site {enters} towards {towards}, {reach} reach site {leaves}{returns}: {loss}{most}{without}"
        )
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let units = self.units(false);
        let [np, db] = ["Np", "dB"].map(|unit| compose(&[unit], &[&units.space]));
        let [f, k, v] = [&units.frequency[..], &units.wavenumber, &units.velocity];
        let band = |of: fn(&FluxBand) -> f64| self.bands.iter().map(of).collect::<Vec<f64>>();
        sheet.axis(Role::Position, &units, self.positions.clone());
        sheet.axis(Role::Frequency, &units, band(|band| band.frequency));
        sheet.line("from", "frequency", f, band(|band| band.from));
        sheet.line("to", "frequency", f, band(|band| band.to));
        type Of = fn(&FluxBand) -> Known;
        let quantities: [(&str, &str, Of); 6] = [
            ("wavenumber", k, |b| b.wavenumber),
            ("group_velocity", v, |b| b.group_velocity),
            ("attenuation", &np, |b| b.attenuation),
            ("attenuation_decibels", &db, |b| {
                b.attenuation.times(DECIBELS)
            }),
            ("loss_factor", "", |b| b.loss_factor),
            ("quality_factor", "", |b| b.quality_factor()),
        ];
        let pair = |sheet: &mut Sheet, [name, dimension, unit]: [&str; 3], known: Vec<Known>| {
            let [values, halves]: [Vec<f64>; 2] = [
                known.iter().map(|known| known.value).collect(),
                known.iter().map(|known| known.half).collect(),
            ];
            sheet.line(name, dimension, unit, values);
            sheet.line(&format!("{name}_half"), dimension, unit, halves);
        };
        for (name, unit, of) in quantities {
            pair(
                sheet,
                [name, "frequency", unit],
                self.bands.iter().map(of).collect(),
            );
        }
        let density = compose(&[&self.power_unit], &[f]);
        for (way, name) in ["plus", "minus", "net"].into_iter().enumerate() {
            let total = format!("total_{name}");
            pair(
                sheet,
                [&total, "position", &self.power_unit],
                self.total[way].clone(),
            );
            for (end, values) in ["", "_half"].iter().zip(&self.density[way]) {
                sheet.plane(
                    &format!("flux_{name}{end}"),
                    ["frequency", "position"],
                    &density,
                    values,
                );
            }
        }
    }
}
