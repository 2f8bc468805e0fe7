//! What a bicoherence says.

use ndarray::Array2;
use serde_json::json;

use super::Bicoherence;
use crate::sheet::{Chart, Colors, Describe, PlotRow, Role, Sheet, Units, number, percent};
use crate::unit::label;

const DEFINITIONS: &str = "\
    Bicoherence b²: |⟨X₁X₂X₃*⟩|² / (⟨|X₁X₂|²⟩ ⟨|X₃|²⟩) at f₁, f₂ and f₃ = f₁ + f₂, 0 to 1: the share of the power at f₃ whose \
        phase follows the sum of the phases at f₁ and f₂. It does not say which of the three feeds which.
    Levels: Without coupling one cell exceeds the level of one cell with the stated probability, and any cell of the whole \
        map the level of the map. Frequencies are said to be coupled where less than 1 % of fields of noise have as much.
    Biphase: The phase of ⟨X₁X₂X₃*⟩: 0 or 180 degrees where crests are peaked or flat, ±90 degrees where one flank is steep.";

/// The probability of a triple below which frequencies are said to be coupled: noise alone had such triples in 0.4 to 0.95 % of
/// some thousand fields. From here to the level of the map they may be.
const SURE: f64 = 0.005;
/// Triples that are printed at most.
const PRINTED: usize = 5;
/// Triples that a summary lists at most.
const LISTED: usize = 20;

impl Describe for Bicoherence {
    /// Variables: `frequency` (nf); of each triple `first`, `second`, `third` (frequencies), `bicoherence`, `biphase`
    /// (triples); `along_site`, `along_position` (n) and `along_largest`, `along_first`, `along_biphase`,
    /// `along_summed`, `along_largest_level`, `along_summed_level` (nf, n), left out if no site was chosen.
    fn describe(&self) -> Sheet<'_> {
        let (words, along) = (self.words(), &self.along);
        let (site, output) = (self.site, self.output);
        let (cells, cell, map) = (self.cells(), self.cell_level(), self.map_level());
        let in_words = |level| self.independence.level_in_words(level, self.alpha);
        let [of_cell, of_map] = [cell, map].map(in_words);
        let title = format!("Bicoherence of site {site} with site {output}");
        let mut sheet = Sheet {
            version: 2,
            about: format!("two frequencies of site {site} with their sum at site {output}"),
            answer: self.answer(),
            note: format!("Levels of chance: of one cell {of_cell}, of the map {of_map}."),
            ..Sheet::of("bicoherence", &title, DEFINITIONS)
        };
        for triple in self.strongest(PRINTED) {
            let [first, second, third] = triple.frequencies.map(number);
            let [biphase, half] = [triple.biphase, triple.biphase_interval].map(f64::to_degrees);
            let (b, unit) = (number(triple.bicoherence), &words.frequency);
            let text = format!(
                "{first} and {second} with {third} {unit}: b² {b}, biphase {biphase:.0} ± {half:.0} degrees"
            );
            sheet.fact("coupled", text);
        }
        self.independence.describe(&mut sheet, self.segment);
        sheet.numbers(json!({
            "time_unit": words.time,
            "space_unit": words.space,
            "site": site,
            "position": self.space.at(site),
            "output": output,
            "output_position": self.space.at(output),
            "alpha": self.alpha,
            "cells": cells,
            "cell_level": cell,
            "above_cell_level": cell.map(|level| self.above(level)),
            "correction": "Sidak",
            "map_level": map,
            "above_map_level": map.map(|level| self.above(level)),
            "strongest": self.strongest(LISTED),
            "along": {
                "sites": along.sites,
                "positions": self.positions(),
                "above_level": along.coupled_outputs(),
            },
        }));
        self.variables(&mut sheet);
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        let maps = [self.map_over_pairs()].into_iter().chain(self.map_along());
        maps.map(|map| PlotRow::of([map]).high(1.2)).collect()
    }
}

impl Bicoherence {
    fn words(&self) -> Units {
        Units::in_words(&self.time, &self.space, None)
    }

    /// `frequency f₁ (Hz)`.
    fn frequency_label(&self, symbol: &str) -> String {
        label(&format!("frequency {symbol}"), &self.words().frequency)
    }

    /// Of the sites along x.
    fn positions(&self) -> Vec<f64> {
        let sites = self.along.sites.iter();
        sites.map(|site| self.space.at(*site)).collect()
    }

    /// Which frequencies are coupled, in words.
    fn answer(&self) -> String {
        let why = match (self.map_level(), self.cells()) {
            (None, _) => self.independence.why_none(),
            (_, 0) => "no triple of frequencies has power at all three",
            _ if self.independence.is_transient() => {
                "pulses of one shape in every record are coupled at all frequencies"
            }
            (Some(level), _) => return self.coupled(level),
        };
        format!("coupling cannot be told: {why}")
    }

    /// What is above the level of the map.
    fn coupled(&self, map: f64) -> String {
        let (site, output) = (self.site, self.output);
        let Some(triple) = self.strongest(1).pop() else {
            let level = number(map);
            return format!(
                "no frequencies of site {site} are coupled with their sum at site {output} above chance (b² below {level})"
            );
        };
        let [first, second, third] = triple.frequencies.map(number);
        let (are, share) = match triple.chance < SURE {
            true => ("are", "less than 1 %".into()),
            false => ("may be", percent(triple.chance)),
        };
        let (b, unit) = (number(triple.bicoherence), self.words().frequency);
        let (count, cells) = (self.above(map), self.cells());
        format!(
            "{first} and {second} {unit} of site {site} {are} coupled with {third} {unit} of site {output} (b² {b}, which \
             noise reaches in {share} of fields), one of {count} such triples of {cells}"
        )
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let units = Units::of(&self.time, &self.space, None);
        let cycles = &units.frequency[..];
        sheet.axis(Role::Frequency, &units, &self.frequency);
        for (i, name) in ["first", "second", "third"].into_iter().enumerate() {
            let bins = self.map.bins.iter().map(|bins| bins[i] as f64);
            let values: Vec<f64> = bins.map(|bin| bin * self.frequency[1]).collect();
            sheet.line(name, "triple", cycles, values);
        }
        sheet.line("bicoherence", "triple", "", &self.map.bicoherence);
        sheet.line("biphase", "triple", "rad", &self.map.biphase);
        let along = &self.along;
        if along.sites.is_empty() {
            return;
        }
        let sites: Vec<f64> = along.sites.iter().map(|j| *j as f64).collect();
        sheet.line("along_site", "along_site", "", sites);
        let positions = self.positions();
        sheet.line("along_position", "along_site", &units.space, positions);
        for (name, unit, array) in [
            ("along_largest", "", &along.largest),
            ("along_first", cycles, &along.first),
            ("along_biphase", "rad", &along.biphase),
            ("along_summed", "", &along.summed),
            ("along_largest_level", "", &along.largest_level),
            ("along_summed_level", "", &along.summed_level),
        ] {
            sheet.plane(name, ["frequency", "along_site"], unit, array);
        }
    }

    /// Over the two frequencies that are added.
    fn map_over_pairs(&self) -> Chart {
        let bins = &self.map.bins;
        let last = bins.iter().map(|bins| bins[0]).max().unwrap_or(1);
        let cells = bins.iter().zip(&self.map.bicoherence);
        let cells = cells.map(|([first, second, _], b)| ([*first, *second], *b));
        Chart {
            title: "bicoherence b²(f₁, f₂)".into(),
            caption: "Which frequencies are coupled with their sum.".into(),
            x_label: self.frequency_label("f₁"),
            y_label: self.frequency_label("f₂"),
            label: "bicoherence b²".into(),
            colors: shown(&self.map.bicoherence, self.map_level()),
            ..over_pairs(cells, last, self.frequency[1])
        }
    }

    /// The largest at each output frequency along x; `None` for fewer than two sites.
    fn map_along(&self) -> Option<Chart> {
        let (along, positions) = (&self.along, self.positions());
        let levels = along.largest_level.iter().copied();
        let level = levels.filter(|level| level.is_finite()).reduce(f64::max);
        let roles = [Role::Position, Role::Frequency];
        let axes = [&positions[..], &self.frequency];
        (positions.len() > 1).then(|| Chart {
            title: "along x".into(),
            caption: "The largest bicoherence of all pairs with the sum f₃, at each site.".into(),
            y_label: self.frequency_label("f₃ = f₁ + f₂"),
            label: "largest b² over f₁".into(),
            colors: shown(&along.largest, level),
            ..Chart::over(&self.words(), roles, axes, along.largest.clone())
        })
    }
}

/// The map of cells at a bin, from 1 to the last, and the bin of a second frequency.
pub(super) fn over_pairs(
    cells: impl Iterator<Item = ([isize; 2], f64)> + Clone,
    last: isize,
    df: f64,
) -> Chart {
    let seconds = || cells.clone().map(|([_, second], _)| second);
    let (lowest, highest) = (seconds().min().unwrap_or(-1), seconds().max().unwrap_or(1));
    let shape = ((highest - lowest + 1) as usize, last as usize);
    let mut values = Array2::from_elem(shape, f64::NAN);
    for ([bin, second], value) in cells {
        values[[(second - lowest) as usize, bin as usize - 1]] = value;
    }
    Chart {
        x: 0.5 * df..(last as f64 + 0.5) * df,
        y: (lowest as f64 - 0.5) * df..(highest as f64 + 0.5) * df,
        values,
        roles: [Role::Frequency; 2].map(Some),
        ..Chart::default()
    }
}

/// Colours that show what is above the level.
fn shown<'b>(values: impl IntoIterator<Item = &'b f64>, level: Option<f64>) -> Colors {
    let largest = values.into_iter().copied().fold(0.0, f64::max);
    let top = largest.max(1.2 * level.unwrap_or(0.0)).clamp(0.05, 1.0);
    Colors::Between(0.0..top)
}
