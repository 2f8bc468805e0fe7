//! What a coherence says.

use ndarray::{ArrayView1, Axis as Along};
use serde_json::json;

use super::{Coherence, Delay, PhaseSpeed};
use crate::estimates::realisations::REALISATIONS;
use crate::measure::cycles_per;
use crate::sheet::{
    BLUE, Chart, Colors, Column, Describe, HeatChart, Level, Look, Mark, PlotRow, Role, Series,
    Sheet, Units, confidence, edges_from_zero, number, percent, range, with_half,
};
use crate::unit::label;

const DEFINITIONS: [[&str; 2]; 5] = [
    [
        "Coherence γ²",
        "Share of a site's power at a frequency that follows the reference linearly: |S_rj|² / (S_rr S_jj) of \
         averaged cross-spectra, 0 to 1.",
    ],
    [
        "Level",
        "What one cell exceeds by chance with the stated probability where the true coherence is 0. Of many \
         cells, that share exceeds it.",
    ],
    [
        "Delay",
        "By how much a site follows the reference, over all coherent frequencies; positive behind it. Its error \
         assumes that records differ by a delay and independent noise.",
    ],
    [
        "Phase velocity",
        "2πf/k, with k from the phases of the sites around the reference up to the first whose \
         phase is not known to 45 degrees; positive for waves towards +x. Sites must be less than half a wavelength apart.",
    ],
    REALISATIONS,
];

impl Describe for Coherence {
    /// Variables: `frequency` (nf), `position` (n); `coherence`, `phase`, `phase_interval`, `spectrum` (nf, n); `delay`,
    /// `delay_error`, `delay_interval`, `delay_ambiguity` (n), NaN where there is none; `speed_frequency`, `wavenumber`,
    /// `wavenumber_error`, `phase_velocity`, `phase_velocity_error` of the frequencies at which enough sites are
    /// coherent. Where segments are left out, `segments`, `effective_realisations`, `level` (n).
    fn describe(&self) -> Sheet<'_> {
        let (time_unit, space_unit) = self.units();
        let reference = self.reference;
        let position = number(self.space.at(reference));
        let why_none = self.independence.why_none();
        let mut sheet = Sheet {
            about: format!(
                "all sites against site {reference} at {position} {space_unit}, times in {time_unit}"
            ),
            answer: self.answer(),
            note: match self.level() {
                Some(level) => {
                    let (level, alpha) = (number(level), self.alpha);
                    format!("A cell exceeds {level} by chance with probability {alpha}.")
                }
                None => format!("No significance can be stated: {why_none}."),
            },
            ..Sheet::of("coherence", "Coherence with a reference site", &DEFINITIONS)
        };
        sheet.numbers(json!({
            "time_unit": time_unit,
            "space_unit": space_unit,
            "reference": reference,
            "reference_position": self.space.at(reference),
        }));
        self.facts(&mut sheet);
        let level = match self.level() {
            Some(level) => format!("{} at {}", number(level), percent(self.alpha)),
            None => format!("not stated: {why_none}"),
        };
        self.independence
            .describe(&mut sheet, self.segment, [("level of one cell", level)]);
        if let Some(left) = &self.segments_left {
            left.describe(&mut sheet, "sites");
        }
        if self.is_silent() {
            sheet.warn(
                format!("the record of the reference, site {reference}, is silent"),
                "compare with another site (`--reference`)",
            );
        }
        sheet.warnings.extend(self.independence.alone("reference"));
        sheet.numbers(json!({
            "segments_left": self.segments_left,
            "alpha": self.alpha,
            "level": self.level(),
            "above_level": self.above_level(),
            "is_coherent": self.is_coherent,
            "is_both_ways": self.is_both_ways,
            "delays": self.delays,
            "velocity": self.velocity,
            "speeds": self.speeds,
        }));
        self.variables(&mut sheet);
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        let charts = [self.delay_chart(), self.velocity_chart()].into_iter();
        let charts: Vec<Chart> = charts.flatten().collect();
        let mut rows = vec![
            PlotRow::of([self.map()]).high(1.3),
            PlotRow::of([self.mean_chart()]),
        ];
        if !charts.is_empty() {
            rows.push(PlotRow::of(charts));
        }
        rows
    }
}

impl Coherence {
    fn is_silent(&self) -> bool {
        let reference = self.spectrum.column(self.reference);
        reference.iter().all(|s| *s == 0.0)
    }

    /// What follows the reference, in words.
    fn answer(&self) -> String {
        let reference = self.reference;
        if self.is_silent() {
            return format!("nothing can be told: the reference, site {reference}, is silent");
        }
        if self.level().is_none() {
            return format!("nothing can be told: {}", self.independence.why_none());
        }
        let coherent: Vec<usize> = self.coherent_sites().collect();
        let others = self.is_coherent.len() - 1;
        let share = match (coherent.as_slice(), others) {
            ([], _) => {
                let unit = self.units().0;
                let length = number(self.segment[0] as f64 * self.time.step);
                return format!(
                    "no site follows site {reference} above chance within a segment ({length} {unit})"
                );
            }
            ([one], _) => format!("site {one}"),
            (all, others) if all.len() == others => format!("all {others} sites"),
            (some, others) => format!("{} of {others} sites", some.len()),
        };
        let (verb, are) = match coherent.len() {
            1 => ("follows", "is"),
            _ => ("follow", "are"),
        };
        let (time_unit, space_unit) = self.units();
        let confidence = confidence(self.alpha);
        let together = format!("{share} {are} coherent with site {reference}");
        if self.is_both_ways {
            return format!("{together}, by no single delay: waves run both ways");
        }
        let known: Vec<Delay> = coherent.iter().filter_map(|j| self.delays[*j]).collect();
        if let Some(waves) = &self.velocity {
            let towards = if waves.velocity > 0.0 { "+x" } else { "-x" };
            let half = 0.5 * (waves.high - waves.low).abs();
            let unit = format!("{space_unit}/{time_unit}");
            let velocity = with_half(waves.velocity.abs(), half, &unit);
            let of = match waves.is_dispersive {
                true => "by frequency".to_owned(),
                false => confidence,
            };
            let are_all = |sign: f64| {
                let is = |delay: &Delay| delay.ambiguity.is_none() && sign * delay.delay > 0.0;
                known.len() == coherent.len() && known.iter().all(is)
            };
            let precede = verb.replace("follow", "precede");
            let follows = match (are_all(1.0), are_all(-1.0)) {
                (true, _) => format!("{share} {verb} site {reference}"),
                (_, true) => format!("{share} {precede} site {reference}"),
                _ => together,
            };
            return format!("{follows}; waves travel towards {towards} at {velocity} ({of})");
        }
        let periods = known.iter().filter_map(|delay| delay.ambiguity);
        if let Some(period) = periods.reduce(f64::max) {
            let period = number(period);
            return format!(
                "{together} in a narrow band: delays are known up to whole periods of {period} {time_unit}"
            );
        }
        let later = |sign: f64| {
            let known = known.iter();
            known.filter(move |delay| sign * delay.delay > delay.interval)
        };
        let by_frequency = known.iter().rev().find_map(|delay| delay.by_frequency);
        if let Some(parts) = by_frequency {
            let [low, high] = parts.map(|part| {
                let [frequency, delay] = part.map(number);
                let unit = cycles_per(&time_unit);
                format!("{delay} {time_unit} at {frequency} {unit}")
            });
            return format!("{together}, by delays that depend on frequency: {low}, {high}");
        }
        match (known.as_slice(), later(1.0).count(), later(-1.0).count()) {
            ([], ..) => format!("{together}, but by no single delay"),
            ([one], ..) if coherent.len() == 1 => {
                let delay = with_half(one.delay.abs(), one.interval, &time_unit);
                let how = match one.delay.abs() > one.interval {
                    true if one.delay > 0.0 => format!("follows site {reference} by {delay}"),
                    true => format!("precedes site {reference} by {delay}"),
                    false => format!("moves with site {reference}, delay {delay}"),
                };
                format!("{share} {how} ({confidence})")
            }
            (_, 0, 0) => format!("{together}, without a delay"),
            (all, behind, ahead) => {
                let of = |range: fn(f64, f64) -> f64| {
                    let delays = all.iter().map(|delay| delay.delay);
                    number(delays.reduce(range).unwrap_or(f64::NAN))
                };
                let what = match ahead {
                    0 => format!("{share} {verb} site {reference}"),
                    _ => format!("{together}, {behind} behind it and {ahead} ahead"),
                };
                let [least, most] = [of(f64::min), of(f64::max)];
                format!("{what}, by {least} to {most} {time_unit}")
            }
        }
    }

    fn facts(&self, sheet: &mut Sheet) {
        if let (Some(level), Some(above)) = (self.level(), self.above_level()) {
            let [above, alpha] = [above, self.alpha].map(percent);
            let level = number(level);
            let text = format!(
                "{above} of the cells are above {level}, the level that {alpha} exceed by chance"
            );
            sheet.fact("coherence", text);
        }
        let (time_unit, space_unit) = self.units();
        let known = self.coherent_sites();
        let known = known.filter_map(|j| Some((j, self.delays[j]?)));
        if let Some((site, delay)) = known.last() {
            let ambiguity = match delay.ambiguity {
                Some(period) => format!(", up to whole periods of {} {time_unit}", number(period)),
                None => String::new(),
            };
            let frequencies = match delay.frequencies {
                1 => "one frequency".to_owned(),
                count => format!("{count} frequencies"),
            };
            let behind = with_half(delay.delay, delay.interval, &time_unit);
            let at = number(self.space.at(site));
            let text = format!(
                "{behind} of site {site} at {at} {space_unit}, from {frequencies}{ambiguity}"
            );
            sheet.fact("delay", text);
        }
        if let Some(waves) = &self.velocity {
            let by = match (waves.sites, waves.frequencies) {
                (Some(sites), _) => format!("the delays of {sites} sites"),
                (_, Some(1)) => "the phases at one frequency".into(),
                (_, count) => format!("the phases at {} frequencies", count.unwrap_or(0)),
            };
            let [velocity, low, high] = [waves.velocity, waves.low, waves.high];
            let text = format!(
                "{velocity:.6} {space_unit}/{time_unit} ({low:.6} to {high:.6}), from {by}"
            );
            sheet.detail("phase velocity", text);
        }
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let units = Units::of(&self.time, &self.space, self.unit.as_deref());
        sheet.line("frequency", "frequency", &units.frequency, &self.frequency);
        sheet.line("position", "position", &units.space, self.positions());
        if let Some(left) = &self.segments_left {
            let level = |site: usize| self.level_at(site).unwrap_or(f64::NAN);
            let levels: Vec<f64> = (0..left.left.len()).map(level).collect();
            left.variables(sheet, "position");
            sheet.line("level", "position", "", levels);
        }
        let density = units.density(&units.frequency, "");
        for (name, unit, array) in [
            ("coherence", "", &self.coherence),
            ("phase", "rad", &self.phase),
            ("phase_interval", "rad", &self.phase_interval),
            ("spectrum", &density, &self.spectrum),
        ] {
            sheet.plane(name, ["frequency", "position"], unit, array);
        }
        let time = &units.time[..];
        let delays: [Column<Delay>; 4] = [
            ("delay", time, |d| d.delay),
            ("delay_error", time, |d| d.error),
            ("delay_interval", time, |d| d.interval),
            ("delay_ambiguity", time, |d| d.ambiguity.unwrap_or(f64::NAN)),
        ];
        for (name, unit, of) in delays {
            let delays = self.delays.iter();
            let delays = delays.map(|delay| delay.as_ref().map_or(f64::NAN, of));
            sheet.line(name, "position", unit, delays.collect::<Vec<f64>>());
        }
        let [k, velocity] = [&units.wavenumber[..], &units.velocity];
        let speeds: [Column<PhaseSpeed>; 5] = [
            ("speed_frequency", &units.frequency, |s| s.frequency),
            ("wavenumber", k, |s| s.wavenumber),
            ("wavenumber_error", k, |s| s.wavenumber_error),
            ("phase_velocity", velocity, |s| s.velocity),
            ("phase_velocity_error", velocity, |s| s.velocity_error),
        ];
        sheet.columns("speed_frequency", &self.speeds, &speeds);
    }

    fn frequency_label(&self) -> String {
        label("frequency f", &cycles_per(&self.units().0))
    }

    fn map(&self) -> HeatChart {
        let positions = self.positions();
        HeatChart {
            title: "coherence γ²(f, x)".into(),
            caption: "How much of each site's power follows the reference, by frequency.".into(),
            x_label: label("position x", &self.units().1),
            y_label: self.frequency_label(),
            label: "coherence γ²".into(),
            x: range(&positions),
            y: edges_from_zero(&self.frequency),
            values: self.coherence.clone(),
            colors: Colors::Between(0.0..1.0),
            marks: vec![Mark::new(positions[self.reference], "reference")],
            roles: Some([Role::Position, Role::Frequency]),
            ..HeatChart::default()
        }
    }

    /// Mean over the other sites.
    fn mean_chart(&self) -> Chart {
        let mean = |row: ArrayView1<f64>| {
            let others = row.iter().enumerate().filter(|(j, _)| *j != self.reference);
            let known: Vec<f64> = others.map(|(_, g)| *g).filter(|g| g.is_finite()).collect();
            known.iter().sum::<f64>() / known.len() as f64
        };
        let means: Vec<f64> = self.coherence.axis_iter(Along(0)).map(mean).collect();
        let levels = self.level().map(|at| Level::new(at, "level of one cell"));
        Chart {
            y: 0.0..1.0,
            levels: levels.into_iter().collect(),
            ..Chart::of(
                "mean coherence of the other sites",
                self.frequency_label(),
                "coherence γ²",
                vec![Series::of("", BLUE, &self.frequency, &means)],
            )
        }
    }

    fn delay_chart(&self) -> Option<Chart> {
        let (time_unit, space_unit) = self.units();
        let delays = self.delays.iter().zip(self.positions());
        let delays = delays.filter_map(|(delay, x)| delay.map(|d| [x, d.delay, d.error]));
        let series = Series::with_errors("", BLUE, delays).with(Look::Dots);
        let [x, y] = [("position x", space_unit), ("delay", time_unit)];
        let [x, y] = [x, y].map(|(name, unit)| label(name, &unit));
        (series.points.len() > 1).then(|| Chart {
            levels: vec![Level::zero()],
            ..Chart::of("delay behind the reference", x, y, vec![series])
        })
    }

    /// Phase velocities that are known to a half.
    fn velocity_chart(&self) -> Option<Chart> {
        let (time_unit, space_unit) = self.units();
        let resolved = self.speeds.iter();
        let resolved = resolved.filter(|speed| speed.velocity_error < 0.5 * speed.velocity.abs());
        let points = resolved.map(|speed| [speed.frequency, speed.velocity, speed.velocity_error]);
        let series = Series::with_errors("", BLUE, points).with(Look::Dots);
        let y = label("velocity", &format!("{space_unit}/{time_unit}"));
        let chart = |series| Chart::of("phase velocity", self.frequency_label(), y, vec![series]);
        (series.points.len() > 1).then(|| chart(series))
    }
}
