//! What a fit says: values with intervals, the verdict, where the chain and the records part.

use serde_json::json;

use super::cause::Cause;
use super::result::{Fitted, FittedValue};
use super::shown::{places, some_places, spectral_units, warn_of_horizon};
use crate::sheet::{
    Cell, Describe, Fact, PlotRow, Sheet, Table, error_size, listed, number, percent, with_half,
    with_range, with_unit,
};

/// Values that a sentence names, at most.
const NAMED: usize = 4;

/// Share of the searches that should end in one minimum.
const AGREEING: f64 = 0.5;

const DEFINITIONS: &str = "\
interval: 95 % interval of the linearized problem. The correlation of the noise is estimated from the residual, and \
the samples count by it. It holds if the chain is right.
misfit: What stationary noise does not explain of the residual: regressors made of the signal do, or it is larger in \
some part of time or at some body. Noise alone is called so in 4 % of fits or less.
undetermined: A combination of unknowns along which they change by a factor of e, or over all of their bounds, while \
the records do not change by their noise.";

impl Describe for Fitted {
    fn describe(&self) -> Sheet<'_> {
        let records = &self.overlay.records;
        let tables = vec![
            self.table(),
            self.correlation_table(),
            self.searches_table(),
        ];
        let mut sheet = Sheet {
            about: format!(
                "{} fitted to {} samples of {} at {} {}",
                listed(&self.names()),
                records.known(),
                records.quantity.name(),
                records.bodies.len(),
                places(records.quantity)
            ),
            answer: self.answer(),
            tables,
            ..Sheet::of("fit", "Fitted chain", DEFINITIONS)
        };
        self.facts(&mut sheet);
        self.warnings(&mut sheet);
        sheet.numbers(json!(self));
        sheet.numbers(json!({ "samples": records.known() }));
        self.variables(&mut sheet);
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        let misfit = self.misfit.as_ref();
        let worst = misfit.map(|misfit| self.overlay.worst(Some(misfit)));
        self.overlay.pictures("fitted", worst)
    }
}

impl Fitted {
    fn names(&self) -> Vec<String> {
        let keys = self.values.iter().filter(|value| value.is_key);
        keys.map(|value| value.name.clone()).collect()
    }

    /// Whether the chain did it; if so, the values and what stays undetermined.
    fn answer(&self) -> String {
        let records = &self.overlay.records;
        if let Some(misfit) = &self.misfit {
            let worst = records.bodies[self.overlay.worst(Some(misfit))];
            let place = some_places(records.quantity, &[worst], 1);
            let (left, band) = (percent(1.0 - self.explained), misfit.band(records));
            let most = if misfit.bodies.len() > 1 { " most" } else { "" };
            return format!(
                "the model does not explain the records: {left} of the energy is left, beyond noise{most} at {place}{band}"
            );
        }
        let verdict = match self.is_exact {
            true => "the model explains all: what is left is the error of its runs".into(),
            false => format!(
                "the model explains all but noise of {}, {} of the signal",
                with_unit(self.noise, &records.units[1]),
                percent(self.noise / records.size())
            ),
        };
        let keys = self.values.iter();
        let keys = keys.filter(|value| value.is_key && value.low.is_finite());
        let values = keys.take(NAMED);
        let values = values.map(|value| format!("{} = {}", value.name, value.shown()));
        let values: Vec<String> = values.collect();
        let open = self.undetermined.iter().map(|open| open.words.clone());
        let parts = [verdict, values.join(", ")].into_iter().chain(open);
        let parts: Vec<String> = parts.filter(|part| !part.is_empty()).collect();
        parts.join("; ")
    }

    fn table(&self) -> Table {
        let columns: [(&str, Cell<FittedValue>); 4] = [
            ("value", |value| Some(value.name.clone())),
            ("fitted", |value| Some(value.shown())),
            ("95 % interval", |value| Some(value.interval())),
            ("start", |value| Some(number(value.start))),
        ];
        Table::of_columns("values", &self.values, &columns).printed()
    }

    fn searches_table(&self) -> Table {
        let row = |search: &super::Search| {
            let values = |of: &[f64]| of.iter().map(|v| number(*v)).collect::<Vec<_>>().join(", ");
            let settled = match search.is_settled {
                true => "",
                false => " (not settled)",
            };
            vec![
                values(&search.start),
                values(&search.end),
                format!("{}{settled}", number(search.missed)),
            ]
        };
        let title = format!("searches over {}", listed(&self.names()));
        let rows = self.searches.iter().map(row);
        Table::of(title, &["from", "to", "missed"], rows)
    }

    fn facts(&self, sheet: &mut Sheet<'_>) {
        let records = &self.overlay.records;
        if let Some(misfit) = &self.misfit {
            let left = percent(1.0 - self.explained);
            let place = misfit.place(records);
            sheet.fact("left", format!("{left} of the energy, {place}"));
            if let Some(cause) = &self.cause {
                sheet.fact("cause", cause.words());
            }
            let open: Vec<&str> = self.undetermined.iter().map(|open| &*open.words).collect();
            if !open.is_empty() {
                sheet.fact("undetermined", open.join("; "));
            }
        }
        let known = records.known();
        let independent = self.independent;
        let noise = match known as f64 / independent > 1.05 {
            true => format!("correlated: {known} samples count as {independent:.0}"),
            false => format!("white, in {known} samples"),
        };
        let explained = percent(self.explained);
        sheet.fact("explained", format!("{explained} of the records' squares"));
        sheet.fact("noise", noise);
        let (agreeing, all) = (self.agreeing(), self.searches.len());
        let text = format!(
            "{agreeing} of {all} end in this minimum; {} runs",
            self.runs
        );
        sheet.fact("searches", text);
        let profile = self.overlay.by_site();
        let least = profile.iter().copied().fold(f64::INFINITY, f64::min);
        let most = profile.iter().copied().fold(0.0, f64::max);
        let most = with_unit(most, &records.units[1]);
        sheet.facts.push(Fact {
            profile,
            ..Fact::new("left by body", format!("{} to {most}", number(least)))
        });
        let error = error_size(self.run_error);
        sheet.detail("error of runs", format!("{error} of the records"));
        let lines = self.scene.iter();
        let lines = lines.map(|[key, text]| format!("{key} = {text}"));
        sheet.detail("scene", lines.collect::<Vec<_>>().join("; "));
    }

    fn warnings(&self, sheet: &mut Sheet<'_>) {
        let until = self.horizon.map(|horizon| horizon.until);
        warn_of_horizon(sheet, until, &self.overlay.records.units[0]);
        if self.misfit.is_some() {
            let advice = match &self.cause {
                Some(cause) => format!("free or correct it: {}", cause.name),
                None => "free what may be missing: none of losses, the exponent, one mass, coefficient or gain alone, or \
                         another end explains it; or leave out the records or times at fault"
                    .into(),
            };
            let text = "the intervals hold for a chain that is right, and this one is not";
            sheet.warn(text, advice);
        }
        let at_bound = self.values.iter().filter(|value| value.is_at_bound);
        let at_bound: Vec<String> = at_bound.map(|value| value.name.clone()).collect();
        if !at_bound.is_empty() {
            sheet.warn(
                format!("the fit ended at a bound of {}", listed(&at_bound)),
                "widen the bound, or ask whether the chain is right",
            );
        }
        let (all, elsewhere) = (self.searches.len(), self.searches.len() - self.agreeing());
        if elsewhere as f64 > (1.0 - AGREEING) * all as f64 {
            let text = format!("{elsewhere} of {all} searches ended elsewhere");
            sheet.warn(text, "narrow the bounds, or raise `--starts`");
        }
        if !self.undetermined.is_empty() {
            sheet.warn(
                "the records do not determine all that is free",
                "fix one key of each combination, or add records that tell them apart",
            );
        }
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let (overlay, records) = (&self.overlay, &self.overlay.records);
        overlay.variables(sheet, "fitted");
        let unit = &records.units[1];
        sheet.line("residual_by_body", "body", unit, overlay.by_site());
        let [frequency, density] = spectral_units(records);
        sheet.line("frequency", "frequency", &frequency, records.frequencies());
        for (name, plane) in [
            ("residual_spectrum", &overlay.residual),
            ("measured_spectrum", &overlay.measured),
        ] {
            sheet.line(name, "frequency", &density, records.density(plane));
        }
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
        let names: Vec<&str> = self.values.iter().map(|value| &*value.name).collect();
        let entry = |v: &f64| match v.is_finite() {
            true => format!("{v:.2}"),
            false => "undetermined".into(),
        };
        let rows = names.iter().zip(self.correlation.rows());
        let rows = rows.map(|(name, row)| {
            let row = row.iter().map(entry);
            [(*name).to_owned()].into_iter().chain(row).collect()
        });
        Table::of("correlations", &[&[""], &names[..]].concat(), rows)
    }
}

impl Cause {
    /// What freeing it does.
    fn words(&self) -> String {
        let to = match self.value() {
            Some([held, free]) => format!(" ({held} to {free})"),
            None => String::new(),
        };
        let rest = match self.is_all {
            true => "noise alone",
            false => "a misfit",
        };
        let (names, share) = (self.names(), percent(self.explained));
        format!("freeing {names}{to} takes {share} of that and leaves {rest}")
    }

    /// What a chain that it alone explains differs by.
    pub(super) fn differs(&self) -> String {
        let name = &self.name;
        match self.value() {
            Some([held, free]) => format!("by one number: {name}, {free} in place of {held}"),
            None => format!("by {}", self.names()),
        }
    }

    /// It and all that explain as much.
    fn names(&self) -> String {
        let all = [std::slice::from_ref(&self.name), &self.rivals].concat();
        let one_of = if all.len() > 1 { "one of " } else { "" };
        format!("{one_of}{}", listed(&all))
    }

    /// Held and free, where it alone explains as much.
    fn value(&self) -> Option<[String; 2]> {
        let is_told = !self.held.is_nan() && self.rivals.is_empty();
        is_told.then(|| [self.held, self.free].map(number))
    }
}

impl FittedValue {
    fn interval(&self) -> String {
        match self.low.is_finite() {
            true => format!("{} to {}", number(self.low), number(self.high)),
            false => "undetermined".into(),
        }
    }

    /// With half of its interval and its unit; with both ends of an interval that a bound cuts.
    pub fn shown(&self) -> String {
        let [below, above] = [self.value - self.low, self.high - self.value];
        match below.min(above) > 0.5 * below.max(above) {
            true => with_half(self.value, 0.5 * (below + above), &self.unit),
            false if self.low.is_finite() => {
                let of = with_range(self.low, self.value, self.high);
                format!("{of} {}", self.unit).trim_end().to_owned()
            }
            false => with_unit(self.value, &self.unit),
        }
    }
}
