//! `cascade spectrum --along both`: `S(k, f)` with intervals.

use std::path::PathBuf;

use wavecascade::estimates::{SpaceTimeEstimate, interval_factors, spacetime};
use wavecascade::observer::Observer;
use wavecascade::plot::{self, Figure, Style};
use wavecascade::report::{
    LabelledArrays, Provenance, SpaceTimeSummary, percent, spacetime_arrays, spacetime_html,
};
use wavecascade::{Error, Field};

use crate::estimate::{Computation, Estimate, EstimateArgs, Typed};
use crate::spectrum::{Spectrum, range_of};
use crate::summary::Summary;
use crate::terminal::number;

/// What is typed of `cascade spectrum`, for spectra along both axes.
#[derive(Debug)]
pub struct SpaceTime(pub Spectrum);

impl Typed for SpaceTime {
    type Found = SpaceTimeEstimate;

    fn fields(&self) -> &[PathBuf] {
        &self.0.fields
    }

    fn shared(&self) -> &EstimateArgs {
        &self.0.estimate
    }

    fn memory(&self) -> Option<u64> {
        self.0.averages.memory
    }

    fn computation(&self) -> Result<impl Computation<SpaceTimeEstimate>, Error> {
        self.0.check()?;
        let request = self.0.of_both();
        Ok(move |fields: &[&Field], observer: &dyn Observer| spacetime(fields, &request, observer))
    }
}

impl Estimate for SpaceTimeEstimate {
    const COMMAND: &'static str = "spectrum";

    fn summary(&self, provenance: &Provenance) -> serde_json::Result<String> {
        SpaceTimeSummary::new(self, provenance).to_json()
    }

    fn arrays(&self, to: &dyn LabelledArrays) -> Result<(), Error> {
        spacetime_arrays(self, to)
    }

    fn figures(&self, name: &str, style: &Style) -> Vec<Figure> {
        vec![plot::spacetime(self, name, style)]
    }

    fn page(
        &self,
        name: &str,
        provenance: &Provenance,
        warnings: &[[String; 2]],
        style: &Style,
    ) -> serde_json::Result<String> {
        spacetime_html(self, name, provenance, warnings, style)
    }

    fn warnings(&self) -> Vec<[String; 2]> {
        warnings(self)
    }

    fn answer(&self) -> String {
        answer(self)
    }

    fn tell(&self, summary: &mut Summary) {
        tell(self, summary);
    }
}

/// Which way the power travels, in words.
fn answer(found: &SpaceTimeEstimate) -> String {
    let (time_unit, space_unit) = found.units();
    let (row, column) = found.largest();
    let [plus, minus, neither] = found.directions();
    if !neither.is_finite() {
        return "no power".into();
    }
    format!(
        "{:.1} % of the power towards +x, {:.1} % towards -x; most at {} {}, k = {} rad/{space_unit}",
        100.0 * plus,
        100.0 * minus,
        number(found.frequency[row]),
        wavecascade::measure::cycles_per(&time_unit),
        number(found.wavenumber[column])
    )
}

fn tell(found: &SpaceTimeEstimate, summary: &mut Summary) {
    match found.degrees_range() {
        Some([least, degrees, most]) => {
            let [low, high] = interval_factors(degrees, found.alpha);
            let text = format!(
                "{} from {} to {} of a value, {} degrees of freedom",
                percent(1.0 - found.alpha),
                number(low),
                number(high),
                range_of(least, degrees, most)
            );
            summary.fact("interval", &text);
        }
        None => summary.fact("interval", "none can be stated"),
    }
    let [.., neither] = found.directions();
    summary.detail("undirected", &format!("{} of the power", percent(neither)));
    let text = format!(
        "{}, mean square {}; Parseval residual {:.1e}",
        number(found.power),
        number(found.mean_square),
        found.parseval
    );
    summary.detail("power", &text);
    let independence = &found.independence;
    let text = format!(
        "records {}, segments {} of {} samples, tapers {} along time and {} along space: {} effective realisations",
        independence.records,
        independence.segments,
        found.segment[0],
        found.tapers[0],
        found.tapers[1],
        number(independence.effective)
    );
    summary.detail("averages", &text);
}

/// What the user should know, each with what to do.
fn warnings(found: &SpaceTimeEstimate) -> Vec<[String; 2]> {
    let mut warnings = Vec::new();
    if found.independence.is_transient() {
        warnings.push(match found.has_interval() {
            false if found.independence.steadiness.is_nan() => [
                format!(
                    "{} at sites that hold most of the energy: no interval is stated",
                    found.independence.why()
                ),
                "use records without missing samples".into(),
            ],
            false => [
                format!(
                    "most of the energy is at sites with a transient (steadiness {}): the field is one \
                     realisation, and no interval is stated",
                    number(found.independence.steadiness)
                ),
                "name several records of the same sites, one a shot".into(),
            ],
            true => [
                format!(
                    "most of the energy is at sites with a transient (steadiness {}): records alone count as \
                     realisations",
                    number(found.independence.steadiness)
                ),
                "name more records of the same sites for narrower intervals".into(),
            ],
        });
    } else if found.tapers[1] > 1 && found.evenness < 1.0 / 3.0 {
        warnings.push([
            format!(
                "the energy is at a few of the sites (evenness {}): the {} tapers along space count as one \
                 realisation",
                number(found.evenness),
                found.tapers[1]
            ),
            "name the sites that move with `--select`".into(),
        ]);
    }
    warnings
}
