//! What a space-time spectrum says.

use serde_json::json;

use super::SpaceTimeEstimate;
use crate::estimates::realisations::{
    TRANSIENT, degrees_as_numbers, interval_in_words, spectrum_chart, without_mean,
};
use crate::measure::cycles_per;
use crate::sheet::{
    Chart, Describe, HeatChart, PlotRow, Role, Sheet, Units, confidence, edges_from_zero, number,
    percent, range, six_digits,
};
use crate::unit::{compose, label};

const DEFINITIONS: [[&str; 2]; 5] = [
    [
        "Space-time spectrum",
        "Power spectral density over wavenumber and frequency, one-sided in f and two-sided in k. Positive k \
         travels towards +x.",
    ],
    [
        "Power",
        "The integral over f and k: the mean square of the samples under the squares of the tapers. Without \
         tapers, and with segments that cover the record, it is the mean square.",
    ],
    [
        "Degrees of freedom",
        "Twice the number of independent realisations: segments, records, and tapers along both axes. \
         Overlapping segments count by their effective number, tapers by their weights: those that leak count less \
         where the spectrum is low. If the energy lies at a few sites, tapers along space count as one.",
    ],
    [
        "Interval",
        "Where the true density lies with the stated probability, if the field is stationary in time and alike \
         along space.",
    ],
    TRANSIENT,
];

impl Describe for SpaceTimeEstimate {
    /// Variables: `frequency` (nf), `wavenumber` (nk); `spectrum`, `degrees_of_freedom`, `low`, `high` (nf, nk), NaN where
    /// there is no interval.
    fn describe(&self) -> Sheet<'_> {
        let (time_unit, space_unit) = self.units();
        let degrees = self.degrees_range();
        let interval = interval_in_words(degrees, self.alpha);
        let mut sheet = Sheet {
            needs_sites_in_step: true,
            about: format!(
                "power spectral density over wavenumber and frequency, times in {time_unit}, positions in {space_unit}"
            ),
            answer: self.answer(),
            note: match degrees {
                Some(_) => format!("Interval: {interval}. Positive k travels towards +x."),
                None => format!(
                    "No interval can be stated: {}. Positive k travels towards +x.",
                    self.independence.why_none()
                ),
            },
            ..Sheet::of(
                "spacetime",
                "Space-time spectrum with intervals",
                &DEFINITIONS,
            )
        };
        let [plus, minus, neither] = self.directions();
        sheet.fact("interval", interval);
        sheet.detail("undirected", format!("{} of the power", percent(neither)));
        let square = match &self.unit {
            Some(unit) => format!(" ({unit})²"),
            None => String::new(),
        };
        let [power, mean_square] = [self.power, self.mean_square].map(number);
        let text = format!(
            "{power}{square}, mean square {mean_square}{square}; Parseval residual {:.1e}",
            self.parseval
        );
        sheet.detail("power", text);
        self.warnings(&mut sheet);
        sheet.numbers(json!({
            "time_unit": time_unit,
            "space_unit": space_unit,
            "unit": self.unit,
        }));
        let rows = [("tapers along space", self.tapers[1].to_string())];
        self.independence.describe(&mut sheet, self.segment, rows);
        let (row, column) = self.largest();
        sheet.numbers(json!({
            "tapers_along_time": self.tapers[0],
            "tapers_along_space": self.tapers[1],
            "half_bandwidth": self.half_bandwidth,
            "evenness_along_space": self.evenness,
            "alpha": self.alpha,
            "degrees_of_freedom": degrees_as_numbers(degrees, self.alpha),
            "power": self.power,
            "mean_square": self.mean_square,
            "parseval_residual": self.parseval,
            "largest": {
                "frequency": self.frequency[row],
                "wavenumber": self.wavenumber[column],
                "density": self.spectrum[[row, column]],
            },
            "towards_plus_x": plus,
            "towards_minus_x": minus,
            "undirected": neither,
        }));
        let units = Units::of(&self.time, &self.space, self.unit.as_deref());
        let (f, k) = (&units.frequency[..], &units.wavenumber[..]);
        sheet.line("frequency", "frequency", f, &self.frequency);
        sheet.line("wavenumber", "wavenumber", k, &self.wavenumber);
        let density = match f.is_empty() || k.is_empty() {
            true => String::new(),
            false => compose(&[&units.density(f, "")], &[k]),
        };
        for (name, unit, array) in [
            ("spectrum", &density[..], &self.spectrum),
            ("degrees_of_freedom", "", &self.degrees),
            ("low", &density, &self.low),
            ("high", &density, &self.high),
        ] {
            sheet.plane(name, ["frequency", "wavenumber"], unit, array);
        }
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        let (row, column) = self.largest();
        let (time_unit, space_unit) = self.units();
        let [k_label, f_label] = self.axis_labels();
        let [at_f, at_k] = [self.frequency[row], self.wavenumber[column]].map(six_digits);
        let at_f = format!("at f = {at_f} {}", cycles_per(&time_unit));
        let at_k = format!("at k = {at_k} rad/{space_unit}");
        let along_k = self.cut(at_f, (k_label, &self.wavenumber), |i| (row, i));
        let along_f = self.cut(at_k, (f_label, &self.frequency), |m| (m, column));
        vec![
            PlotRow::of([self.map()]).high(1.4),
            PlotRow::of([along_k, along_f]),
        ]
    }
}

impl SpaceTimeEstimate {
    /// Which way the power travels, in words.
    fn answer(&self) -> String {
        let (time_unit, space_unit) = self.units();
        let (row, column) = self.largest();
        let [plus, minus, neither] = self.directions().map(|share| 100.0 * share);
        if !neither.is_finite() {
            return "no power".into();
        }
        let [f, k] = [self.frequency[row], self.wavenumber[column]].map(number);
        let f_unit = cycles_per(&time_unit);
        format!(
            "{plus:.1} % of the power towards +x, {minus:.1} % towards -x; most at {f} {f_unit}, k = {k} rad/{space_unit}"
        )
    }

    fn warnings(&self, sheet: &mut Sheet) {
        let independence = &self.independence;
        let steadiness = number(independence.steadiness);
        if independence.is_transient() {
            let (message, advice) = match self.has_interval() {
                false if independence.steadiness.is_nan() => {
                    let (why, at) = (independence.why(), "at sites that hold most of the energy");
                    let message = format!("{why} {at}: no interval is stated");
                    (message, "use records without missing samples")
                }
                false => (
                    format!(
                        "most of the energy is at sites with a transient (steadiness {steadiness}): the field is one \
                         realisation, and no interval is stated"
                    ),
                    "name several records of the same sites, one a shot",
                ),
                true => (
                    format!(
                        "most of the energy is at sites with a transient (steadiness {steadiness}): records alone \
                         count as realisations"
                    ),
                    "name more records of the same sites for narrower intervals",
                ),
            };
            sheet.warn(message, advice);
        } else if self.tapers[1] > 1 && self.evenness < 1.0 / 3.0 {
            let message = format!(
                "the energy is at a few of the sites (evenness {}): the {} tapers along space count as one \
                 realisation",
                number(self.evenness),
                self.tapers[1]
            );
            sheet.warn(message, "name the sites that move with `--select`");
        }
    }

    fn density_label(&self) -> String {
        let (time_unit, space_unit) = self.units();
        let per = format!("({} · rad/{space_unit})", cycles_per(&time_unit));
        let unit = match &self.unit {
            Some(unit) => format!("({unit})²/{per}"),
            None => format!("per {per}"),
        };
        label("power spectral density", &unit)
    }

    fn axis_labels(&self) -> [String; 2] {
        let (time_unit, space_unit) = self.units();
        [
            label("wavenumber k", &format!("rad/{space_unit}")),
            label("frequency f", &cycles_per(&time_unit)),
        ]
    }

    fn map(&self) -> HeatChart {
        let [x_label, y_label] = self.axis_labels();
        HeatChart {
            title: "space-time spectrum S(k, f)".into(),
            caption: "Power by wavenumber and frequency; positive wavenumbers travel towards +x."
                .into(),
            x_label,
            y_label,
            label: self.density_label(),
            x: range(&self.wavenumber),
            y: edges_from_zero(&self.frequency),
            values: without_mean(&self.spectrum, self.mean_is_removed),
            roles: Some([Role::Wavenumber, Role::Frequency]),
            ..HeatChart::default()
        }
    }

    /// The density along an axis, with its interval.
    fn cut(
        &self,
        title: String,
        x: (String, &[f64]),
        cell: impl Fn(usize) -> (usize, usize),
    ) -> Chart {
        let along = |array: &ndarray::Array2<f64>| -> Vec<f64> {
            (0..x.1.len()).map(|i| array[cell(i)]).collect()
        };
        let [spectrum, low, high] = [&self.spectrum, &self.low, &self.high].map(along);
        let values = [&spectrum[..], &low, &high];
        let interval = format!("{} interval", confidence(self.alpha));
        spectrum_chart(title, x, self.density_label(), values, interval)
    }
}
