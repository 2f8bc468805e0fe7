//! What triads say.

use ndarray::Array2;
use serde_json::json;

use super::{Triads, largest};
use crate::sheet::{
    BLUE, Chart, Colors, Describe, GREEN, Look, Mark, PURPLE, PlotRow, Role, SKY, Series, Sheet,
    VERMILLION, number, percent,
};

const DEFINITIONS: &str = "\
    Triad: Three wavenumbers k = p + q. Where the force is quadratic, energy is exchanged within each triad, and each \
        keeps its energy.
    Map: Energy that k gained with the larger partner p, both signs of k together: below the diagonal k is the sum of \
        its partners, above it their difference.
    Flux past k: Energy that triads moved from wavenumbers up to k to larger ones.
    Ratio: The largest over the smallest wavenumber of a triad, at least 2. A cascade is local if triads of small \
        ratios carry the flux.";

/// Wavenumbers whose transfers are below this share of the largest are not drawn.
const SHOWN: f64 = 2e-3;

impl Describe for Triads {
    /// Variables: `wavenumber`, `gained`, `change`, `flux` and, of a chain, `beyond` (wavenumber); `transfer` and, of a
    /// chain, `umklapp` (wavenumber, partner); `disparity` (group), the least ratio of a group of triads, 0 for those
    /// with wavenumber 0, NaN for umklapp, and `flux_of_group` (group, wavenumber).
    fn describe(&self) -> Sheet<'_> {
        let [from, to] = self.window.map(number);
        let mut sheet = Sheet {
            version: 2,
            about: format!("energy exchanged between wavenumbers from time {from} to {to}"),
            answer: self.answer(),
            note: format!(
                "Energies as shares of that at the start, {}, over {} samples. Identities hold to {:.0e}.",
                number(self.energy),
                self.samples,
                self.identities.detailed.max(self.identities.sums)
            ),
            ..Sheet::of(
                "triads",
                "Transfer between wavenumbers by triads",
                DEFINITIONS,
            )
        };
        self.facts(&mut sheet);
        let (at, unexplained) = (self.locality.at, self.largest_unexplained());
        let largest = self.flux[at].abs();
        if self.sampling_error > 0.1 * largest && largest > 0.0 {
            sheet.warn(
                format!(
                    "the samples are too far apart: their sums are uncertain by {} of the largest flux",
                    percent(self.sampling_error / largest)
                ),
                "simulate with more samples",
            );
        }
        sheet.numbers(json!({
            "units": self.units,
            "law": self.law,
            "window": self.window,
            "samples": self.samples,
            "energy": self.energy,
            "largest_flux": {
                "wavenumber": self.wavenumber[at],
                "flux": self.flux[at],
                "error": self.flux_error(),
                "resolved": self.is_resolved(),
                "share_within_4": self.locality.share_below(4.0),
                "share_within_8": self.locality.share_below(8.0),
            },
            "share_beyond": self.share_beyond(),
            "is_quadratic": self.is_quadratic(),
            "unexplained": unexplained,
            "identities": self.identities,
        }));
        self.variables(&mut sheet);
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        vec![
            PlotRow::of([self.map()]).high(1.3),
            PlotRow::of([self.change_chart(), self.flux_chart()]),
        ]
    }
}

impl Triads {
    /// The largest change of energy of a wavenumber for other reasons.
    fn largest_unexplained(&self) -> f64 {
        largest(&self.unexplained())
    }

    fn is_told(&self) -> bool {
        self.is_quadratic() && self.is_resolved()
    }

    fn of_energy(&self, energy: f64) -> String {
        percent(energy.abs() / self.energy)
    }

    /// Which way energy goes among the wavenumbers, in words.
    fn answer(&self) -> String {
        if !self.is_quadratic() {
            return "no triads can be stated: the law has no useful quadratic expansion at these amplitudes".into();
        }
        if !self.is_resolved() {
            return "no flux is resolved: the largest is not ten times its error".into();
        }
        let at = self.locality.at;
        let is_up = self.flux[at] > 0.0;
        let way = if is_up { "larger" } else { "smaller" };
        format!(
            "{} of the energy passes {} towards {way} wavenumbers",
            self.of_energy(self.flux[at]),
            self.units.at_wavenumber(self.wavenumber[at])
        )
    }

    /// The triads that carry the flux, and what is not of triads.
    fn facts(&self, sheet: &mut Sheet) {
        if self.is_told() {
            let [four, eight] = [4.0, 8.0].map(|factor| percent(self.locality.share_below(factor)));
            let text = format!(
                "triads whose wavenumbers are within a factor of 4 carry {four} of it, within 8 {eight}"
            );
            sheet.fact("locality", text);
        }
        let [error, unexplained] =
            [self.flux_error(), self.largest_unexplained()].map(|energy| self.of_energy(energy));
        let text = format!(
            "the flux is uncertain by {error} of the energy; terms beyond the quadratic one moved {} as much energy as \
             it did; no wavenumber changed by more than {unexplained} for other reasons (losses, drives, ends, sampling)",
            percent(self.share_beyond())
        );
        sheet.fact("balance", text);
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let energy = self.units.energy.clone().unwrap_or_default();
        let per_length = self.units.length.as_ref();
        let per_length = per_length.map_or(String::new(), |unit| format!("rad/{unit}"));
        sheet.line("wavenumber", "wavenumber", &per_length, &self.wavenumber);
        for (name, values) in [
            ("gained", Some(&self.gained)),
            ("change", Some(&self.change)),
            ("flux", Some(&self.flux)),
            ("beyond", self.beyond.as_ref()),
        ] {
            if let Some(values) = values {
                sheet.line(name, "wavenumber", &energy, values);
            }
        }
        let axes = ["wavenumber", "partner"];
        sheet.plane("transfer", axes, &energy, &self.transfer);
        sheet.plane("umklapp", axes, &energy, &self.umklapp);
        let groups = &self.locality.flux;
        let least: Vec<f64> = groups.iter().map(|(from, _)| *from).collect();
        sheet.line("disparity", "group", "", least);
        let flux: Vec<f64> = groups.iter().flat_map(|(_, flux)| flux.clone()).collect();
        let axes = [
            ("group", groups.len()),
            ("wavenumber", self.wavenumber.len()),
        ];
        sheet.variable("flux_of_group", &axes, &energy, flux);
    }

    /// Wavenumbers up to the last one that takes part.
    fn shown(&self) -> usize {
        let sizes = self.transfer.rows().into_iter().map(largest);
        let sizes: Vec<f64> = sizes.take(self.gained.len()).collect();
        let most = largest(&sizes);
        let last = sizes.iter().rposition(|size| *size > SHOWN * most);
        (last.unwrap_or(0) + 2).clamp(3.min(sizes.len()), sizes.len())
    }

    /// Energy that each wavenumber gained with each larger partner.
    fn map(&self) -> Chart {
        let n = self.shown();
        let values = Array2::from_shape_fn((n, n), |(p, k)| match 2 * p < k {
            true => f64::NAN,
            false => (self.transfer[[k, p]] + self.umklapp[[k, p]]) / self.energy,
        });
        let most = largest(values.iter().filter(|v| v.is_finite()));
        let most = if most > 0.0 { most } else { 1.0 };
        let step = self.wavenumber[1];
        let ends = -0.5 * step..(n as f64 - 0.5) * step;
        let label = self.units.wavenumber();
        Chart {
            title: "what each pair brings".into(),
            caption: "Which wavenumbers gain energy, and from which partners.".into(),
            y_label: label.replacen("wavenumber k", "larger partner p", 1),
            x_label: label,
            label: "energy gained, share".into(),
            x: ends.clone(),
            y: ends,
            values,
            colors: Colors::Between(-most..most),
            roles: [Role::Wavenumber; 2].map(Some),
            ..Chart::default()
        }
    }

    /// Shares of the energy over the wavenumbers that are shown.
    fn shares(&self, label: &str, colour: usize, values: &[f64]) -> Series {
        let n = self.shown();
        let shares = values[..n].iter().map(|value| value / self.energy);
        let shares: Vec<f64> = shares.collect();
        Series::of(label, colour, &self.wavenumber[..n], &shares)
    }

    /// What each wavenumber gained.
    fn change_chart(&self) -> Chart {
        let mut series = vec![
            self.shares("change of energy", PURPLE, &self.change)
                .with(Look::Dashed),
            self.shares("gained from pairs", VERMILLION, &self.gained),
        ];
        if let Some(beyond) = &self.beyond {
            series.push(self.shares("beyond the quadratic force", SKY, beyond));
        }
        let (title, label) = ("energy that each wavenumber gained", "energy gained, share");
        Chart::of(title, self.units.wavenumber(), label, series).about_zero()
    }

    /// The flux with the groups of triads that carry it: of near wavenumbers, of far ones, and the rest.
    fn flux_chart(&self) -> Chart {
        let sum = |wanted: &dyn Fn(f64) -> bool| -> Vec<f64> {
            let groups = || self.locality.flux.iter().filter(|(from, _)| wanted(*from));
            let at = |k: usize| groups().map(|(_, flux)| flux[k]).sum();
            (0..self.flux.len()).map(at).collect()
        };
        let mut series = vec![self.shares("all triads", PURPLE, &self.flux)];
        for (label, colour, ratios) in [
            ("ratios of 2 to 4", BLUE, 2.0..4.0),
            ("4 to 8", GREEN, 4.0..8.0),
            ("8 and more", VERMILLION, 8.0..f64::INFINITY),
        ] {
            let flux = sum(&|from| ratios.contains(&from));
            series.push(self.shares(label, colour, &flux));
        }
        let others = sum(&|from| from.is_nan() || from == 0.0);
        if largest(&others) > 1e-3 * largest(&self.flux) {
            series.push(self.shares("with k = 0, umklapp", SKY, &others));
        }
        let at = self.wavenumber[self.locality.at];
        let largest = self.is_told().then(|| Mark::new(at, "largest"));
        let (title, label) = ("flux past each wavenumber", "flux past k, share");
        Chart {
            marks: largest.into_iter().collect(),
            ..Chart::of(title, self.units.wavenumber(), label, series).about_zero()
        }
    }
}
