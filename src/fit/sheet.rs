//! What a fit says: values with intervals, the verdict, where the chain and the records part.

use serde_json::json;

use super::cause::Cause;
use super::result::{Fitted, FittedValue};
use super::shown::{places, record_charts, residual_map, spectral_units, spectrum_chart};
use crate::sheet::{
    BLUE, Describe, Plot, PlotRow, Sheet, Table, VERMILLION, error_size, listed, number, percent,
    with_half,
};

/// Values that a sentence names, at most.
const NAMED: usize = 4;

/// Share of the searches that should end in one minimum.
const AGREEING: f64 = 0.5;

const DEFINITIONS: [[&str; 2]; 3] = [
    [
        "interval",
        "95 % interval of the linearized problem. The correlation of the noise is estimated from the residual, and the \
         samples count by it. It holds if the chain is right.",
    ],
    [
        "misfit",
        "What stationary noise does not explain of the residual: regressors made of the signal do, or it is larger in \
         some part of time or at some body. Noise alone is called so in 4 % of fits or less.",
    ],
    [
        "undetermined",
        "A combination of unknowns along which they change by a factor of e, or over all of their bounds, while the \
         records do not change by their noise.",
    ],
];

impl Describe for Fitted {
    fn describe(&self) -> Sheet<'_> {
        let mut sheet = Sheet {
            name: "fit",
            version: 1,
            title: "Fitted chain".into(),
            about: format!(
                "{} fitted to {} samples of {} at {} {}",
                listed(&self.names()),
                self.known,
                self.records.quantity.name(),
                self.records.bodies.len(),
                places(self.records.quantity)
            ),
            answer: self.answer(),
            tables: vec![
                self.table(),
                self.correlation_table(),
                self.searches_table(),
            ],
            definitions: DEFINITIONS.to_vec(),
            ..Sheet::default()
        };
        self.facts(&mut sheet);
        self.warnings(&mut sheet);
        sheet.numbers(json!({
            "values": self.values,
            "undetermined": self.undetermined,
            "misfit": self.misfit,
            "cause": self.cause,
            "noise": self.noise,
            "explained": self.explained,
            "exact": self.is_exact,
            "samples": self.known,
            "independent_samples": self.independent,
            "run_error": self.run_error,
            "horizon": self.horizon,
            "searches": self.searches,
            "runs": self.runs,
            "scene": self.scene,
        }));
        self.variables(&mut sheet);
        sheet
    }

    /// Some records with those of the fitted chain; what is left over time and bodies, and by frequency.
    fn pictures(&self) -> Vec<PlotRow> {
        let mut rows = PlotRow::grid(
            2,
            record_charts(&self.records, &self.measured, ("fitted", &self.fitted)),
        );
        rows.push(PlotRow::of([
            Plot::from(residual_map(&self.records, &self.residual, "fitted")),
            Plot::from(spectrum_chart(
                &self.records,
                [
                    ("measured", BLUE, &self.measured),
                    ("what is left", VERMILLION, &self.residual),
                ],
            )),
        ]));
        rows
    }
}

impl Fitted {
    fn names(&self) -> Vec<String> {
        let keys = self.values.iter().filter(|value| value.is_key);
        keys.map(|value| value.name.clone()).collect()
    }

    fn answer(&self) -> String {
        let keys = self
            .values
            .iter()
            .filter(|value| value.is_key && value.low.is_finite());
        let said: Vec<String> = keys
            .take(NAMED)
            .map(|value| format!("{} = {}", value.name, value.shown()))
            .collect();
        let mut parts = vec![self.verdict()];
        if !said.is_empty() {
            parts.push(said.join(", "));
        }
        parts.extend(
            self.undetermined
                .iter()
                .map(|direction| direction.words.clone()),
        );
        parts.join("; ")
    }

    /// The first words: whether the chain did it.
    fn verdict(&self) -> String {
        let unit = &self.records.units[1];
        let size = self.records.size();
        let share = percent(self.noise / size);
        match &self.misfit {
            _ if self.is_exact => {
                "the model explains all: what is left is the error of its runs".into()
            }
            None => {
                let noise = format!("{} {unit}", number(self.noise));
                format!(
                    "the model explains all but noise of {}, {share} of the signal",
                    noise.trim()
                )
            }
            Some(misfit) => format!(
                "the model does not explain the records: misfit {}; {share} of the signal is left{}",
                misfit.place(&self.records),
                self.cause
                    .as_ref()
                    .map_or(String::new(), |cause| format!("; {}", cause.words()))
            ),
        }
    }

    fn table(&self) -> Table {
        let row = |value: &FittedValue| {
            vec![
                value.name.clone(),
                value.shown(),
                match value.low.is_finite() {
                    true => format!("{} to {}", number(value.low), number(value.high)),
                    false => "undetermined".into(),
                },
                number(value.start),
            ]
        };
        Table {
            title: "values".into(),
            head: ["value", "fitted", "95 % interval", "start"]
                .map(Into::into)
                .to_vec(),
            rows: self.values.iter().map(row).collect(),
            is_fact: true,
        }
    }

    fn searches_table(&self) -> Table {
        let row = |search: &super::Search| {
            let values = |of: &[f64]| of.iter().map(|v| number(*v)).collect::<Vec<_>>().join(", ");
            let settled = if search.is_settled {
                ""
            } else {
                " (not settled)"
            };
            vec![
                values(&search.start),
                values(&search.end),
                format!("{}{settled}", number(search.missed)),
            ]
        };
        Table {
            title: format!("searches over {}", listed(&self.names())),
            head: ["from", "to", "missed"].map(Into::into).to_vec(),
            rows: self.searches.iter().map(row).collect(),
            is_fact: false,
        }
    }

    fn facts(&self, sheet: &mut Sheet<'_>) {
        let tau = self.known as f64 / self.independent;
        let noise = match tau > 1.05 {
            true => format!(
                "correlated: {} samples count as {:.0}",
                self.known, self.independent
            ),
            false => format!("white, in {} samples", self.known),
        };
        sheet.fact(
            "explained",
            format!("{} of the records' squares", percent(self.explained)),
        );
        sheet.fact("noise", noise);
        let text = format!(
            "{} of {} end in this minimum",
            self.agreeing(),
            self.searches.len()
        );
        sheet.fact("searches", format!("{text}; {} runs", self.runs));
        let by_body: Vec<f64> = self.by_site();
        sheet.facts.push(crate::sheet::Fact {
            profile: by_body.clone(),
            ..crate::sheet::Fact::new(
                "left by body",
                format!(
                    "{} to {} {}",
                    number(by_body.iter().copied().fold(f64::INFINITY, f64::min)),
                    number(by_body.iter().copied().fold(0.0, f64::max)),
                    self.records.units[1]
                )
                .trim()
                .to_owned(),
            )
        });
        sheet.detail(
            "error of runs",
            format!("{} of the records", error_size(self.run_error)),
        );
        let lines = self
            .scene
            .iter()
            .map(|[key, text]| format!("{key} = {text}"));
        sheet.detail("scene", lines.collect::<Vec<_>>().join("; "));
    }

    fn warnings(&self, sheet: &mut Sheet<'_>) {
        if let Some(horizon) = self.horizon {
            sheet.warn(
                format!(
                    "the chain amplifies rounding: its runs agree until {} {}, and later samples, {} of each record, \
                     are left out",
                    number(horizon.until),
                    self.records.units[0],
                    horizon.left_out
                ),
                "no later sample can be fitted point by point; compare statistics of an ensemble (`cascade sweep`)",
            );
        }
        if self.misfit.is_some() {
            let advice = match &self.cause {
                Some(cause) => format!("free or correct it: {}", cause.name),
                None => "free what may be missing: none of losses, the exponent, one mass, coefficient or gain alone, or \
                         another end explains it; or leave out the records or times at fault"
                    .into(),
            };
            sheet.warn(
                "the intervals hold for a chain that is right, and this one is not",
                advice,
            );
        }
        let at_bound: Vec<String> = self
            .values
            .iter()
            .filter(|v| v.is_at_bound)
            .map(|v| v.name.clone())
            .collect();
        if !at_bound.is_empty() {
            sheet.warn(
                format!("the fit ended at a bound of {}", listed(&at_bound)),
                "widen the bound, or ask whether the chain is right",
            );
        }
        if (self.agreeing() as f64) < AGREEING * self.searches.len() as f64 {
            sheet.warn(
                format!(
                    "{} of {} searches ended elsewhere",
                    self.searches.len() - self.agreeing(),
                    self.searches.len()
                ),
                "narrow the bounds, or raise `--starts`",
            );
        }
        if !self.undetermined.is_empty() {
            sheet.warn(
                "the records do not determine all that is free",
                "fix one key of each combination, or add records that tell them apart",
            );
        }
    }

    /// Root mean squares of what is left.
    fn by_site(&self) -> Vec<f64> {
        self.residual
            .columns()
            .into_iter()
            .map(|column| known_rms(column.iter().copied()))
            .collect()
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let [time, unit] = &self.records.units;
        let bodies: Vec<f64> = self
            .records
            .bodies
            .iter()
            .map(|body| *body as f64)
            .collect();
        sheet.line("time", "time", time, &self.records.times);
        sheet.line("body", "body", "", bodies);
        sheet.plane("measured", ["time", "body"], unit, &self.measured);
        sheet.plane("fitted", ["time", "body"], unit, &self.fitted);
        sheet.plane("residual", ["time", "body"], unit, &self.residual);
        sheet.line("residual_by_body", "body", unit, self.by_site());
        let [frequency, density] = spectral_units(&self.records);
        sheet.line("frequency", "frequency", &frequency, &self.frequencies);
        sheet.line(
            "residual_spectrum",
            "frequency",
            &density,
            &self.residual_spectrum,
        );
        sheet.line(
            "measured_spectrum",
            "frequency",
            &density,
            &self.measured_spectrum,
        );
        sheet.columns(
            "parameter",
            &self.values,
            &[
                ("value", "", |v: &FittedValue| v.value),
                ("low", "", |v| v.low),
                ("high", "", |v| v.high),
                ("start", "", |v| v.start),
            ],
        );
        sheet.plane("correlation", ["parameter", "other"], "", &self.correlation);
        sheet.line("noise_correlation", "lag", "", &self.noise_correlation);
    }

    /// Correlations of the values.
    fn correlation_table(&self) -> Table {
        let names = || self.values.iter().map(|value| value.name.clone());
        let rows = names().zip(self.correlation.rows());
        let row = |(name, row): (String, ndarray::ArrayView1<f64>)| {
            let entry = |v: &f64| {
                if v.is_finite() {
                    format!("{v:.2}")
                } else {
                    "undetermined".into()
                }
            };
            [name].into_iter().chain(row.iter().map(entry)).collect()
        };
        Table {
            title: "correlations".into(),
            head: [String::new()].into_iter().chain(names()).collect(),
            rows: rows.map(row).collect(),
            is_fact: false,
        }
    }
}

impl Cause {
    /// It and all that explain as much.
    fn names(&self) -> String {
        let rivals = self.rivals.iter().cloned();
        let all: Vec<String> = [self.name.clone()].into_iter().chain(rivals).collect();
        match self.rivals.is_empty() {
            true => self.name.clone(),
            false => format!("one of {}", listed(&all)),
        }
    }

    /// What freeing it does.
    fn words(&self) -> String {
        let to = match self.held.is_nan() || !self.rivals.is_empty() {
            true => String::new(),
            false => format!(" ({} to {})", number(self.held), number(self.free)),
        };
        let rest = if self.is_all {
            "noise alone"
        } else {
            "a misfit"
        };
        format!(
            "freeing {}{to} takes {} of that and leaves {rest}",
            self.names(),
            percent(self.explained)
        )
    }

    /// What a chain that it alone explains differs by.
    pub(super) fn differs(&self) -> String {
        match self.held.is_nan() || !self.rivals.is_empty() {
            true => format!("by {}", self.names()),
            false => format!(
                "by one number: {}, {} in place of {}",
                self.name,
                number(self.free),
                number(self.held)
            ),
        }
    }
}

impl FittedValue {
    /// With half of its interval and its unit.
    pub fn shown(&self) -> String {
        match self.low.is_finite() {
            true => with_half(self.value, 0.5 * (self.high - self.low), &self.unit),
            false => format!("{} {}", number(self.value), self.unit)
                .trim()
                .to_owned(),
        }
    }
}

fn known_rms(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    values.filter(|v| v.is_finite()).for_each(|v| {
        sum += v * v;
        count += 1.0;
    });
    (sum / f64::max(count, 1.0)).sqrt()
}
