//! What a flux says.

use std::f64::consts::LN_10;

use serde_json::json;

use super::{Flux, FluxBand, Known, NoFlux};
use crate::numeric::sorted;
use crate::sheet::{
    BLUE, Band, Chart, Describe, PlotRow, Role, Series, Sheet, Units, VERMILLION, confidence,
    number, percent, with_half, with_unit,
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
/// Metric prefixes of thousands, from the least on.
const PREFIXES: [&str; 11] = ["a", "f", "p", "n", "µ", "m", "", "k", "M", "G", "T"];

impl NoFlux {
    const ALL: [(NoFlux, &str); 5] = [
        (NoFlux::NoWave, "no wave stands above the noise"),
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
    fn words(self, factor: f64, unit: &str) -> String {
        with_half(factor * self.value, factor * self.half, unit)
    }

    fn ends(self) -> (f64, f64) {
        (self.value - self.half, self.value + self.half)
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
        let mut quartiles = |name: &str, unit: &str, of: fn(&FluxBand) -> f64| {
            let values = sorted(self.bands.iter().map(of).filter(|value| value.is_finite()));
            let last = values.len().saturating_sub(1) as f64;
            let at = |part: f64| number(values[(part * last).round() as usize]);
            if !values.is_empty() {
                let [low, middle, high] = [0.25, 0.5, 0.75].map(at);
                let text = format!(
                    "{} (half of the bands: {low} to {high})",
                    with_unit_of(&middle, unit)
                );
                sheet.fact(name, text);
            }
        };
        quartiles("group velocity", &words.velocity, |b| {
            b.group_velocity.value
        });
        quartiles("loss factor", "", |b| b.loss_factor.value);
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
                    format!("{count} bands within {from} to {to}: {why}"),
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
        let enters = if self.is_backward() {
            self.scan.analysis.axes.n_sites - 1
        } else {
            0
        };
        let series = |name: &str, colour, of: &dyn Fn(usize) -> Known| {
            let known: Vec<Known> = (0..self.bands.len()).map(of).collect();
            let points = self
                .bands
                .iter()
                .zip(&known)
                .map(|(b, known)| (b.frequency, known.value));
            Series {
                band: Some(Band {
                    label: confidence(self.alpha),
                    ends: known.iter().map(|known| known.ends()).collect(),
                }),
                ..Series::line(name, colour, points.collect())
            }
        };
        let flux = |name: &str, colour, way: usize| {
            let [value, half] = &self.density[way];
            series(name, colour, &|b| Known {
                value: value[[b, enters]],
                half: half[[b, enters]],
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
            Chart::of("loss factor", frequency, String::from("loss factor"), loss),
        ];
        map.into_iter()
            .chain(charts.map(|chart| PlotRow::of([chart])))
            .collect()
    }
}

fn with_unit_of(text: &str, unit: &str) -> String {
    format!("{text} {unit}").trim_end().into()
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
        let (words, last) = (self.units(true), self.scan.analysis.axes.n_sites - 1);
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
            true => format!(", {} return towards {other}", back.words(factor, "")),
            false => String::new(),
        };
        let (first, reach) = (first.words(factor, &unit), reach.words(factor, ""));
        let loss = self.loss.words(1.0, &compose(&["dB"], &[&words.space]));
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
        format!(
            "{first} pass site {enters} towards {towards}, {reach} reach site {leaves}{returns}: {loss} are lost{most}"
        )
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let (units, axes) = (self.units(false), &self.scan.analysis.axes);
        let [np, db] = ["Np", "dB"].map(|unit| compose(&[unit], &[&units.space]));
        let [f, k, v] = [&units.frequency[..], &units.wavenumber, &units.velocity];
        sheet.axis(Role::Position, &units, axes.positions());
        sheet.columns(
            "frequency",
            &self.bands,
            &[
                ("frequency", f, |b| b.frequency),
                ("from", f, |b| b.from),
                ("to", f, |b| b.to),
                ("wavenumber", k, |b| b.wavenumber.value),
                ("wavenumber_half", k, |b| b.wavenumber.half),
                ("group_velocity", v, |b| b.group_velocity.value),
                ("group_velocity_half", v, |b| b.group_velocity.half),
                ("attenuation", &np, |b| b.attenuation.value),
                ("attenuation_half", &np, |b| b.attenuation.half),
                ("attenuation_decibels", &db, |b| {
                    DECIBELS * b.attenuation.value
                }),
                ("attenuation_decibels_half", &db, |b| {
                    DECIBELS * b.attenuation.half
                }),
                ("loss_factor", "", |b| b.loss_factor.value),
                ("loss_factor_half", "", |b| b.loss_factor.half),
                ("quality_factor", "", |b| 1.0 / b.loss_factor.value),
                ("quality_factor_half", "", |b| {
                    b.loss_factor.half / b.loss_factor.value.powi(2)
                }),
            ],
        );
        let density = compose(&[&self.power_unit], &[f]);
        for (way, name) in ["plus", "minus", "net"].into_iter().enumerate() {
            let total =
                |of: fn(&Known) -> f64| self.total[way].iter().map(of).collect::<Vec<f64>>();
            let totals = [total(|known| known.value), total(|known| known.half)];
            for ((end, values), total) in ["", "_half"].iter().zip(&self.density[way]).zip(totals) {
                sheet.plane(
                    &format!("flux_{name}{end}"),
                    ["frequency", "position"],
                    &density,
                    values,
                );
                sheet.line(
                    &format!("total_{name}{end}"),
                    "position",
                    &self.power_unit,
                    total,
                );
            }
        }
    }
}
