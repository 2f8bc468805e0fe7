//! What results on records share: places and units in words, records laid over those of a run, what is left.

use ndarray::Array2;

use super::records::Records;
use super::verdict::Misfit;
use crate::field::Quantity;
use crate::measure::cycles_per;
use crate::sheet::{
    BLUE, Chart, Colors, GREEN, Look, PlotRow, Role, Series, Sheet, VERMILLION, listed, range,
    with_unit,
};
use crate::unit::{compose, label, square};

/// Records that are drawn, and bodies that a sentence names, at most.
const DRAWN: usize = 4;
const NAMED: usize = 4;

/// What a record of a quantity is at.
pub(super) fn place(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Force => "contact",
        _ => "body",
    }
}

/// What records of a quantity are at.
pub(super) fn places(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Force => "contacts",
        _ => "bodies",
    }
}

/// Some places of a quantity: `body 3`, `bodies 3, 5 and others`.
pub(super) fn some_places(quantity: Quantity, bodies: &[usize], most: usize) -> String {
    let shown: Vec<String> = bodies.iter().take(most).map(usize::to_string).collect();
    match bodies.len() {
        1 => format!("{} {}", place(quantity), shown[0]),
        count if count > most => {
            let (shown, more) = (shown.join(", "), count - most);
            format!("{} {shown} and {more} more", places(quantity))
        }
        _ => format!("{} {}", places(quantity), listed(&shown)),
    }
}

/// The unit of frequencies beside times of a unit; empty for none.
pub(super) fn per_time(time: &str) -> String {
    match time {
        "" => String::new(),
        time => cycles_per(time),
    }
}

/// What a chain that amplifies rounding leaves out.
pub(super) fn warn_of_horizon(sheet: &mut Sheet<'_>, until: Option<f64>, time: &str) {
    if let Some(until) = until.map(|until| with_unit(until, time)) {
        sheet.warn(
            format!("the chain amplifies rounding: its runs agree until {until}, and later samples are left out"),
            "no later sample tells a chain point by point; compare statistics of an ensemble (`cascade sweep`)",
        );
    }
}

impl Misfit {
    /// Where noise explains nothing, in words.
    pub(super) fn place(&self, records: &Records) -> String {
        let bodies = match self.is_everywhere {
            true => format!("at all {}", places(records.quantity)),
            false => format!("at {}", some_places(records.quantity, &self.bodies, NAMED)),
        };
        let at = |time: f64| with_unit(time, &records.units[0]);
        let ends = [records.times[0], records.times[records.times.len() - 1]];
        let words = |[from, to]: [f64; 2]| match (from <= ends[0], to >= ends[1]) {
            (false, true) => format!(", after {}", at(from)),
            (true, false) => format!(", until {}", at(to)),
            _ => format!(", from {} to {}", at(from), at(to)),
        };
        let times = self.times.map(words);
        bodies + &times.unwrap_or_default() + &self.band(records)
    }

    /// Its frequencies, behind a comma; empty for all.
    pub(super) fn band(&self, records: &Records) -> String {
        let at = |f: f64| with_unit(f, &per_time(&records.units[0]));
        let nyquist = 0.5 / records.step();
        let [low, high] = self.frequencies;
        match (low < 0.02 * nyquist, high > 0.9 * nyquist) {
            (true, true) => String::new(),
            (false, true) => format!(", above {}", at(low)),
            (true, false) => format!(", below {}", at(high)),
            (false, false) => format!(", between {} and {}", at(low), at(high)),
        }
    }
}

/// Measured records laid over those of a run, as `(time, site)`; missing samples are NaN.
#[derive(Debug, Clone)]
pub struct Overlay {
    pub records: Records,
    pub measured: Array2<f64>,
    pub run: Array2<f64>,
    /// What is measured beyond the run.
    pub residual: Array2<f64>,
}

impl Overlay {
    pub(super) fn of(records: &Records, run: &[f64]) -> Overlay {
        let (measured, run) = (records.plane(&records.values), records.plane(run));
        Overlay {
            records: records.clone(),
            residual: &measured - &run,
            measured,
            run,
        }
    }

    /// Root mean square of what is left of each record.
    pub(super) fn by_site(&self) -> Vec<f64> {
        let rms = |column: ndarray::ArrayView1<f64>| {
            let known: Vec<f64> = column.iter().copied().filter(|v| v.is_finite()).collect();
            super::model::rms(&known)
        };
        self.residual.columns().into_iter().map(rms).collect()
    }

    /// The site, of those of a misfit if there is one, of whose record most is left.
    pub(super) fn worst(&self, misfit: Option<&Misfit>) -> usize {
        let (left, bodies) = (self.by_site(), &self.records.bodies);
        let is_told =
            |site: &usize| misfit.is_none_or(|misfit| misfit.bodies.contains(&bodies[*site]));
        let told = (0..bodies.len()).filter(is_told);
        let worst = told.max_by(|a, b| left[*a].total_cmp(&left[*b]));
        worst.unwrap_or(0)
    }

    pub(super) fn bodies(&self) -> Vec<f64> {
        let bodies = self.records.bodies.iter();
        bodies.map(|body| *body as f64).collect()
    }

    /// The records of measurement and run, and what is left, over `time` and `body`.
    pub(super) fn variables<'a>(&'a self, sheet: &mut Sheet<'a>, run: &str) {
        let [time, unit] = &self.records.units;
        sheet.line("time", "time", time, &self.records.times);
        sheet.line("body", "body", "", self.bodies());
        for (name, plane) in [
            ("measured", &self.measured),
            (run, &self.run),
            ("residual", &self.residual),
        ] {
            sheet.plane(name, ["time", "body"], unit, plane);
        }
    }

    /// Some records over those of the run; what is left over time and bodies; spectra. With a worst record, what is left
    /// comes first, beside that.
    pub(super) fn pictures(&self, run: &str, worst: Option<usize>) -> Vec<PlotRow> {
        let sites = self.records.bodies.len();
        let count = DRAWN.min(sites);
        let some = (0..count).map(|i| i * (sites - 1) / (count - 1).max(1));
        let some = some.filter(|site| Some(*site) != worst);
        let records = some.map(|site| self.record(site, run));
        let [left, spectra] = [self.map(run), self.spectra(run)];
        let plots: Vec<Chart> = match worst {
            Some(worst) => [left, self.record(worst, run), spectra]
                .into_iter()
                .chain(records)
                .collect(),
            None => records.chain([left, spectra]).collect(),
        };
        PlotRow::grid(2, plots)
    }

    fn record(&self, site: usize, run: &str) -> Chart {
        let records = &self.records;
        let of = |values: &Array2<f64>| values.column(site).to_vec();
        Chart::of(
            some_places(records.quantity, &records.bodies[site..=site], 1),
            label("time t", &records.units[0]),
            label(records.quantity.name(), &records.units[1]),
            vec![
                Series::of("measured", BLUE, &records.times, &of(&self.measured)),
                Series::of(run, VERMILLION, &records.times, &of(&self.run)).with(Look::Dashed),
            ],
        )
    }

    fn map(&self, run: &str) -> Chart {
        let (records, bodies) = (&self.records, self.bodies());
        let is_even = bodies.windows(3).all(|at| at[2] - at[1] == at[1] - at[0]);
        let is_rising = bodies.windows(2).all(|at| at[1] > at[0]);
        let (x_label, x) = match is_even && is_rising {
            true => ("body", range(&bodies)),
            false => ("record", -0.5..bodies.len() as f64 - 0.5),
        };
        let known = self.residual.iter().filter(|v| v.is_finite());
        let largest = known.fold(0.0, |m: f64, v| m.max(v.abs()));
        Chart {
            title: "what is left".into(),
            caption: format!("Measured less {run}. Noise looks the same everywhere."),
            x_label: x_label.into(),
            y_label: label("time t", &records.units[0]),
            label: label(records.quantity.name(), &records.units[1]),
            x,
            y: range(&records.times),
            values: self.residual.clone(),
            colors: Colors::Between(-largest..largest),
            roles: [Role::Position, Role::Time].map(Some),
            ..Chart::default()
        }
    }

    fn spectra(&self, run: &str) -> Chart {
        let records = &self.records;
        let frequencies = records.frequencies();
        let series = [
            ("measured", BLUE, &self.measured),
            (run, VERMILLION, &self.run),
            ("what is left", GREEN, &self.residual),
        ];
        let series = series.map(|(name, colour, plane)| {
            let density = records.density(plane);
            Series::of(name, colour, &frequencies[1..], &density[1..])
        });
        let [frequency, density] = spectral_units(records);
        Chart::of(
            "by frequency",
            label("frequency f", &frequency),
            label("mean power spectral density", &density),
            series.into(),
        )
        .logarithmic()
    }
}

/// Of frequencies and of power spectral densities.
pub(super) fn spectral_units(records: &Records) -> [String; 2] {
    let [time, sample] = &records.units;
    let frequency = per_time(time);
    let density = match sample.is_empty() {
        true => String::new(),
        false => compose(&[&square(sample)], &[&frequency]),
    };
    [frequency, density]
}
