//! What a coherence says.

use serde_json::json;

use super::{Coherence, Delay, PhaseSpeed};
use crate::sheet::{
    BLUE, Chart, Colors, Column, Describe, Look, Mark, PlotRow, Role, Series, Sheet, Units,
    confidence, percent, with_half,
};
use crate::unit::label;

const DEFINITIONS: &str = "\
    Coherence γ²: Share of a site's power at a frequency that follows the reference linearly, 0 to 1.
    Level: What one cell exceeds by chance with the stated probability. Of many cells, that share exceeds it.
    Delay: By how much a site follows the reference, over all coherent frequencies, if records differ by a delay and \
        independent noise; positive behind it.
    Phase velocity: 2πf/k, with k from the phases of the sites around the reference that are known to 45 degrees; positive \
        towards +x. Sites must be less than half a wavelength apart.";

impl Describe for Coherence {
    /// Variables: `frequency` (nf), `position` (n); `coherence`, `phase`, `phase_interval`, `spectrum` (nf, n); `delay`,
    /// `delay_error`, `delay_interval`, `delay_ambiguity` (n), NaN where there is none; `speed_frequency`, `wavenumber`,
    /// `wavenumber_error`, `phase_velocity`, `phase_velocity_error` of the frequencies at which enough sites are
    /// coherent. Where segments are left out, `segments`, `effective_realisations`, `level` (n).
    fn describe(&self) -> Sheet<'_> {
        let (words, reference) = (self.words(), self.reference);
        let level = self.independence.level_in_words(self.level(), self.alpha);
        let mut sheet = Sheet {
            about: format!("all sites against site {reference}"),
            answer: self.answer(),
            note: format!("Level that one cell exceeds by chance: {level}."),
            ..Sheet::of("coherence", "Coherence with a reference site", DEFINITIONS)
        };
        if let Some(above) = self.above_level() {
            let above = percent(above);
            let text = format!("{above} of the cells are above the level of chance, {level}");
            sheet.fact("coherence", text);
        }
        self.independence.describe(&mut sheet, self.segment);
        if let Some(left) = &self.segments_left {
            left.describe(&mut sheet, "sites");
        }
        sheet.numbers(json!({
            "time_unit": words.time,
            "space_unit": words.space,
            "reference": reference,
            "reference_position": self.space.at(reference),
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
        let charts = self.charts();
        let charts = PlotRow::grid(charts.len(), charts);
        let map = [PlotRow::of([self.map()]).high(1.3)];
        map.into_iter().chain(charts).collect()
    }
}

impl Coherence {
    fn words(&self) -> Units {
        Units::in_words(&self.time, &self.space, None)
    }

    /// What is coherent with the reference, and how late it is, in words.
    fn answer(&self) -> String {
        if self.above_level().is_none() {
            let why = match self.level() {
                Some(_) => "the reference is silent, or all others are",
                None => self.independence.why_none(),
            };
            return format!("coherence cannot be told: {why}");
        }
        let delays = self.coherent_sites();
        let delays = delays.filter_map(|j| Some((j, self.delays[j]?)));
        let single = delays.filter(|(_, d)| d.ambiguity.is_none() && d.by_frequency.is_none());
        let furthest = single.max_by(|(_, a), (_, b)| a.delay.abs().total_cmp(&b.delay.abs()));
        let (words, share) = (self.words(), confidence(self.alpha));
        let how = match (&self.velocity, furthest) {
            _ if self.is_both_ways => "; waves run both ways".into(),
            (Some(waves), _) => {
                let towards = if waves.velocity > 0.0 { "+x" } else { "-x" };
                let half = 0.5 * (waves.high - waves.low).abs();
                let velocity = with_half(waves.velocity.abs(), half, &words.velocity);
                let of = if waves.is_dispersive {
                    "by frequency"
                } else {
                    &share
                };
                format!("; waves travel towards {towards} at {velocity} ({of})")
            }
            (None, Some((site, delay))) => {
                let delay = with_half(delay.delay, delay.interval, &words.time);
                format!("; delay of site {site}: {delay} ({share})")
            }
            (None, None) => String::new(),
        };
        let (count, others) = (self.coherent_sites().count(), self.is_coherent.len() - 1);
        let reference = self.reference;
        format!("{count} of {others} sites coherent with site {reference}{how}")
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let units = Units::of(&self.time, &self.space, self.unit.as_deref());
        sheet.axis(Role::Frequency, &units, &self.frequency);
        sheet.axis(Role::Position, &units, self.positions());
        if let Some(left) = &self.segments_left {
            let sites = 0..left.left.len();
            let levels: Vec<f64> = sites.map(|j| self.level_at(j)).collect();
            left.variables(sheet, "position");
            sheet.line("level", "position", "", levels);
        }
        let density = units.density(&[&units.frequency], "");
        for (name, unit, array) in [
            ("coherence", "", &self.coherence),
            ("phase", "rad", &self.phase),
            ("phase_interval", "rad", &self.phase_interval),
            ("spectrum", &density, &self.spectrum),
        ] {
            sheet.plane(name, ["frequency", "position"], unit, array);
        }
        let time = &units.time[..];
        let delays: [Column<Option<Delay>>; 4] = [
            ("delay", time, |d| d.map_or(f64::NAN, |d| d.delay)),
            ("delay_error", time, |d| d.map_or(f64::NAN, |d| d.error)),
            ("delay_interval", time, |d| {
                d.map_or(f64::NAN, |d| d.interval)
            }),
            ("delay_ambiguity", time, |d| {
                d.and_then(|d| d.ambiguity).unwrap_or(f64::NAN)
            }),
        ];
        sheet.columns("position", &self.delays, &delays);
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

    fn map(&self) -> Chart {
        let positions = self.positions();
        let roles = [Role::Position, Role::Frequency];
        let axes = [&positions[..], &self.frequency];
        Chart {
            title: "coherence γ²(f, x)".into(),
            caption: "How much of each site's power follows the reference, by frequency.".into(),
            label: "coherence γ²".into(),
            colors: Colors::Between(0.0..1.0),
            marks: vec![Mark::new(positions[self.reference], "reference")],
            ..Chart::over(&self.words(), roles, axes, self.coherence.clone())
        }
    }

    /// Delays along x, and phase velocities that are known to a half, with their errors.
    fn charts(&self) -> Vec<Chart> {
        let words = self.words();
        let delays = self.delays.iter().zip(self.positions());
        let delays = delays.filter_map(|(delay, x)| delay.map(|d| [x, d.delay, d.error]));
        let speeds = self.speeds.iter();
        let speeds = speeds.map(|speed| [speed.frequency, speed.velocity, speed.velocity_error]);
        let speeds = speeds.filter(|[_, velocity, error]| *error < 0.5 * velocity.abs());
        let chart = |title, x, y: String, points: Vec<[f64; 3]>| {
            let series = vec![Series::with_errors("", BLUE, points).with(Look::Dots)];
            let several = series[0].points.len() > 1;
            several.then(|| Chart::of(title, words.label(x), y, series).about_zero())
        };
        let (delay, velocity) = (
            label("delay", &words.time),
            label("velocity", &words.velocity),
        );
        let title = "delay behind the reference";
        let delays = chart(title, Role::Position, delay, delays.collect());
        let title = "phase velocity";
        let speeds = chart(title, Role::Frequency, velocity, speeds.collect());
        delays.into_iter().chain(speeds).collect()
    }
}
