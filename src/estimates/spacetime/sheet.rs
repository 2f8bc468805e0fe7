//! What a space-time spectrum says.

use serde_json::json;

use super::SpaceTimeEstimate;
use crate::estimates::realisations::without_mean;
use crate::sheet::{
    BLUE, Chart, Describe, PlotRow, Role, Series, Sheet, Units, confidence, number, percent,
    six_digits,
};

const DEFINITIONS: &str = "\
    Space-time spectrum: Power spectral density, one-sided in f and two-sided in k. Positive k travels towards +x.
    Power: The integral over f and k: the mean square of the samples under the squares of the tapers.
    Degrees of freedom: Twice the number of independent realisations: segments, records, and tapers along both axes, less \
        what overlap and unequal weights cost. If the energy lies at a few sites, tapers along space count as one.
    Interval: Where the true density lies with the stated probability, if the field is stationary in time and alike along x.";

impl Describe for SpaceTimeEstimate {
    /// Variables: `frequency` (nf), `wavenumber` (nk); `spectrum`, `degrees_of_freedom`, `low`, `high` (nf, nk), NaN where
    /// there is no interval.
    fn describe(&self) -> Sheet<'_> {
        let words = self.words();
        let mut sheet = Sheet {
            needs_sites_in_step: true,
            about: "power spectral density over wavenumber and frequency".into(),
            answer: self.answer(),
            ..Sheet::of(
                "spacetime",
                "Space-time spectrum with intervals",
                DEFINITIONS,
            )
        };
        sheet.degrees_of_freedom(self.degrees_range(), self.alpha);
        self.independence.describe(&mut sheet, self.segment);
        let [plus, minus, neither] = self.directions();
        let (row, column) = self.largest();
        sheet.numbers(json!({
            "time_unit": words.time,
            "space_unit": words.space,
            "unit": self.unit,
            "tapers_along_time": self.tapers[0],
            "tapers_along_space": self.tapers[1],
            "half_bandwidth": self.half_bandwidth,
            "evenness_along_space": self.evenness,
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
        sheet.axis(Role::Frequency, &units, &self.frequency);
        sheet.axis(Role::Wavenumber, &units, &self.wavenumber);
        let density = &units.density(&[&units.frequency, &units.wavenumber], "")[..];
        for (name, unit, array) in [
            ("spectrum", density, &self.spectrum),
            ("degrees_of_freedom", "", &self.degrees),
            ("low", density, &self.low),
            ("high", density, &self.high),
        ] {
            sheet.plane(name, ["frequency", "wavenumber"], unit, array);
        }
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        let ((row, column), words) = (self.largest(), self.words());
        let [at_f, at_k] = [self.frequency[row], self.wavenumber[column]].map(six_digits);
        let at_f = format!("at f = {at_f} {}", words.frequency);
        let at_k = format!("at k = {at_k} {}", words.wavenumber);
        let along_k = self.cut(at_f, (Role::Wavenumber, &self.wavenumber), |i| (row, i));
        let along_f = self.cut(at_k, (Role::Frequency, &self.frequency), |m| (m, column));
        vec![
            PlotRow::of([self.map()]).high(1.4),
            PlotRow::of([along_k, along_f]),
        ]
    }
}

impl SpaceTimeEstimate {
    fn words(&self) -> Units {
        Units::in_words(&self.time, &self.space, self.unit.as_deref())
    }

    /// Which way the power travels, in words.
    fn answer(&self) -> String {
        let ((row, column), words) = (self.largest(), self.words());
        if self.power == 0.0 {
            return "no power".into();
        }
        let [plus, minus, _] = self.directions().map(percent);
        let [f, k] = [self.frequency[row], self.wavenumber[column]].map(number);
        let (f_unit, k_unit) = (words.frequency, words.wavenumber);
        format!(
            "{plus} of the power towards +x, {minus} towards -x; most at {f} {f_unit}, k = {k} {k_unit}"
        )
    }

    fn density_label(&self) -> String {
        let bins = [Role::Frequency, Role::Wavenumber];
        self.words().density_label(&bins)
    }

    fn map(&self) -> Chart {
        let roles = [Role::Wavenumber, Role::Frequency];
        let axes = [&self.wavenumber[..], &self.frequency];
        let values = without_mean(&self.spectrum, self.mean_is_removed);
        Chart {
            title: "space-time spectrum S(k, f)".into(),
            caption: "Power by wavenumber and frequency; positive wavenumbers travel towards +x."
                .into(),
            label: self.density_label(),
            ..Chart::over(&self.words(), roles, axes, values)
        }
    }

    /// The density along an axis, with its interval.
    fn cut(
        &self,
        title: String,
        (role, x): (Role, &[f64]),
        cell: impl Fn(usize) -> (usize, usize),
    ) -> Chart {
        let along = |array: &ndarray::Array2<f64>| -> Vec<f64> {
            (0..x.len()).map(|i| array[cell(i)]).collect()
        };
        let [spectrum, low, high] = [&self.spectrum, &self.low, &self.high].map(along);
        let ends = low.into_iter().zip(high).collect();
        let interval = format!("{} interval", confidence(self.alpha));
        let line = Series::of("", BLUE, x, &spectrum).with_band(interval, ends);
        let label = self.words().label(role);
        Chart::of(title, label, self.density_label(), vec![line]).logarithmic()
    }
}
