//! What a flux says.

use std::collections::BTreeSet;
use std::f64::consts::LN_10;

use serde_json::json;

use super::{Flux, FluxBand, Known, NoFlux};
use crate::field::Axis;
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
    Interval: By the jackknife over groups of sites, and of frequencies or shots, the larger one.
    Linear waves: The flux is that of waves whose speed does not depend on their amplitude, of one branch at each frequency.";

/// Decibels of a neper.
const DECIBELS: f64 = 20.0 / LN_10;
/// Share of the power without a flux that is said at once.
const SAID: f64 = 0.1;
/// Metric prefixes of thousands, from the least on.
const PREFIXES: [&str; 11] = ["a", "f", "p", "n", "µ", "m", "", "k", "M", "G", "T"];

impl NoFlux {
    fn why(self) -> &'static str {
        match self {
            NoFlux::NoWave => "no wave stands above what one wave each way leaves",
            NoFlux::Ends => "the waves begin, end, grow or are cut within the array",
            NoFlux::SeveralWaves => "there is not one wave each way",
            NoFlux::Evanescent => "the wave decays within its length",
            NoFlux::Directions => "both ways look the same at the sites (`--towards`)",
            NoFlux::Velocity => "the waves do not tell their group velocity (`--group-velocity`)",
        }
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

    /// Flux per unit of frequency.
    fn density(&self, way: usize, site: usize) -> Known {
        self.flux[way][site].times(1.0 / (self.to - self.from))
    }
}

impl Describe for Flux {
    /// Variables: `frequency`, `from`, `to` (bands), `position` (sites); `flux_plus`, `flux_minus`, `flux_net` (bands, sites), their
    /// totals `total_plus` and others (sites); `wavenumber`, `group_velocity`, `attenuation` in Np, `attenuation_decibels`,
    /// `loss_factor`, `quality_factor` (bands). Halves of their intervals have `_half` behind the name.
    fn describe(&self) -> Sheet<'_> {
        let words = self.units(Units::in_words);
        let mut sheet = Sheet {
            needs_sites_in_step: true,
            about: "flux of energy of waves both ways, and their loss".into(),
            answer: self.answer(&words),
            note: format!("Intervals: {}.", confidence(self.alpha)),
            warnings: self.scan.analysis.warnings.clone(),
            ..Sheet::of("flux", "Flux of energy", DEFINITIONS)
        };
        let factors = self.bands.iter().map(|band| band.loss_factor.value);
        let factors = sorted(factors.filter(|value| value.is_finite()));
        if let Some(last) = factors.len().checked_sub(1) {
            let [low, middle, high] = [last / 4, last / 2, last - last / 4].map(|n| factors[n]);
            let range = with_range(low, middle, high) + ", median and quartiles of the bands";
            sheet.fact("loss factor", range);
        }
        let text = percent(self.stated) + " of the power of all samples is of bands with a flux";
        sheet.fact("stated", text);
        for reason in self.reasons() {
            let without = self.bands.iter().filter(|band| band.reason == Some(reason));
            let bands: Vec<&FluxBand> = without.collect();
            let (from, to) = (bands[0].from, bands[bands.len() - 1].to);
            let [from, to] = [from, to].map(|f| with_unit(f, &words.frequency));
            let (count, why) = (counted(bands.len(), "band"), reason.why());
            let text = format!("{count} within {from} to {to}: {why}");
            sheet.fact("without a flux", text);
        }
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
        let (words, (_, [enters, _])) = (self.units(Units::in_words), self.larger());
        type Of<'a> = &'a dyn Fn(&FluxBand) -> Known;
        let chart = |title: String, y: String, series: &[(&str, usize, Of<'_>)]| {
            let series = series.iter().map(|(name, colour, of)| {
                let points = self.bands.iter().map(|band| (band.frequency, of(band)));
                Series::with_errors(*name, *colour, points.map(|(f, y)| [f, y.value, y.half]))
            });
            let frequency = words.label(Role::Frequency);
            PlotRow::of([Chart::of(title, frequency, y, series.collect()).about_zero()])
        };
        let unit = label("flux", &compose(&[&self.power_unit], &[&words.frequency]));
        let ways: [(&str, usize, Of<'_>); 2] = [
            ("towards +x", BLUE, &|band| band.density(0, enters)),
            ("towards −x", VERMILLION, &|band| band.density(1, enters)),
        ];
        let map = self.scan.map().map(|map| PlotRow::of([map]).high(1.4));
        let flux = chart(format!("flux at site {enters}"), unit, &ways);
        let name = "loss factor";
        let factor: (&str, usize, Of<'_>) = (name, BLUE, &|band| band.loss_factor);
        let factors = chart(name.into(), name.into(), &[factor]);
        map.into_iter().chain([flux, factors]).collect()
    }
}

impl Flux {
    fn units(&self, of: fn(&Axis, &Axis, Option<&str>) -> Units) -> Units {
        let axes = &self.scan.analysis.axes;
        of(&axes.time, &axes.space, None)
    }

    /// Those of bands without a flux.
    fn reasons(&self) -> BTreeSet<NoFlux> {
        self.bands.iter().filter_map(|band| band.reason).collect()
    }

    fn answer(&self, words: &Units) -> String {
        let count = |reason| self.bands.iter().filter(|b| b.reason == reason).count();
        if count(None) == 0 {
            let reasons = self.reasons().into_iter().rev();
            let most = reasons.max_by_key(|reason| count(Some(*reason)));
            let why = most.unwrap_or(NoFlux::NoWave).why();
            return format!("no flux can be stated: {why}");
        }
        let (way, [enters, leaves]) = self.larger();
        let [towards, other] = [["+x", "−x"], ["−x", "+x"]][way];
        let back = self.total[1 - way][enters];
        let [first, reach] = [enters, leaves].map(|site| self.total[way][site]);
        let thousands = match &self.power_unit[..] {
            "W" | "J" if first.value > 0.0 => (first.value.log10() / 3.0).floor().clamp(-6.0, 4.0),
            _ => 0.0,
        };
        let (prefix, unit) = (PREFIXES[(thousands + 6.0) as usize], &self.power_unit);
        let said = |known: Known, unit: &str| {
            let known = known.times(1000f64.powf(-thousands));
            with_half(known.value, known.half, unit)
        };
        let (first, reach) = (said(first, &format!("{prefix}{unit}")), said(reach, ""));
        let passes = format!("{first} pass site {enters} towards {towards}");
        let mut text = format!("{passes}, {reach} reach site {leaves}");
        if back.value > back.half {
            text += &format!(", {} return towards {other}", said(back, ""));
        }
        let Known { value, half } = self.loss;
        let (value, verb) = match value < -half {
            true => (-value, "gained"),
            false => (value, "lost"),
        };
        let decibels = with_half(value, half, &compose(&["dB"], &[&words.space]));
        text += &format!(": {decibels} are {verb}");
        let lost = |band: &FluxBand| band.flux[way][enters].value - band.flux[way][leaves].value;
        let stated = self.bands.iter().filter(|band| band.reason.is_none());
        let most = stated.max_by(|a, b| lost(a).total_cmp(&lost(b)));
        if let Some(most) = most.filter(|_| self.loss.value > half) {
            text += &format!(", most at {}", with_unit(most.frequency, &words.frequency));
        }
        if 1.0 - self.stated > SAID {
            let share = percent(1.0 - self.stated);
            text += &format!("; {share} of the power of all samples has none");
        }
        text
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let (units, sites) = (self.units(Units::of), self.positions.len());
        let [np, db] = ["Np", "dB"].map(|unit| compose(&[unit], &[&units.space]));
        let f = &units.frequency[..];
        let line = |of: fn(&FluxBand) -> f64| self.bands.iter().map(of).collect::<Vec<f64>>();
        sheet.axis(Role::Position, &units, &self.positions);
        sheet.axis(Role::Frequency, &units, line(|b| b.frequency));
        sheet.line("from", "frequency", f, line(|b| b.from));
        sheet.line("to", "frequency", f, line(|b| b.to));
        let mut add = |name: &str, dimensions: &[(&str, usize)], unit: &str, all: Vec<Known>| {
            let parts: [fn(&Known) -> f64; 2] = [|known| known.value, |known| known.half];
            for (end, of) in ["", "_half"].into_iter().zip(parts) {
                let values: Vec<f64> = all.iter().map(of).collect();
                sheet.variable(&format!("{name}{end}"), dimensions, unit, values);
            }
        };
        let bands = ("frequency", self.bands.len());
        let mut of_bands = |name: &str, unit: &str, of: fn(&FluxBand) -> Known| {
            add(name, &[bands], unit, self.bands.iter().map(of).collect());
        };
        of_bands("wavenumber", &units.wavenumber, |b| b.wavenumber);
        of_bands("group_velocity", &units.velocity, |b| b.group_velocity);
        of_bands("attenuation", &np, |b| b.attenuation);
        let decibels = |b: &FluxBand| b.attenuation.times(DECIBELS);
        of_bands("attenuation_decibels", &db, decibels);
        of_bands("loss_factor", "", |b| b.loss_factor);
        of_bands("quality_factor", "", FluxBand::quality_factor);
        let density = compose(&[&self.power_unit], &[f]);
        let axes = [bands, ("position", sites)];
        for (way, name) in ["plus", "minus", "net"].into_iter().enumerate() {
            let of_band = |band: &'a FluxBand| (0..sites).map(move |site| band.density(way, site));
            let all = self.bands.iter().flat_map(of_band).collect();
            let (flux, total) = (format!("flux_{name}"), format!("total_{name}"));
            add(&flux, &axes, &density, all);
            let totals = self.total[way].clone();
            add(&total, &axes[1..], &self.power_unit, totals);
        }
    }
}
