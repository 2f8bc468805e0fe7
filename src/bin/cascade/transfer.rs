//! `cascade transfer`: linear and quadratic transfer between two sites.

use std::path::PathBuf;

use clap::Args;
use wavecascade::estimates::{Transfer as Found, TransferRequest, transfer};
use wavecascade::measure::{Frequency, Measure, cycles_per};
use wavecascade::observer::Observer;
use wavecascade::plot::{self, Figure, Style};
use wavecascade::report::{
    LabelledArrays, Provenance, TransferSummary, percent, transfer_arrays, transfer_html,
};
use wavecascade::{Error, Field};

use crate::estimate::{Computation, Estimate, EstimateArgs, Typed};
use crate::parse;
use crate::show_args::of_axis;
use crate::summary::Summary;
use crate::terminal::number;
use crate::triple_args::TripleArgs;

/// What `cascade transfer` takes.
#[derive(Debug, Args)]
pub struct Transfer {
    /// File with the field; several, or patterns such as `'shot*.npy'`, are repeated records (shots) of the
    /// same sites, which are averaged.
    #[arg(required = true, value_name = "FIELD")]
    pub fields: Vec<PathBuf>,

    /// Index of the site of the input.
    #[arg(long, value_name = "SITE")]
    pub from: Option<usize>,

    /// Index of the site of the output.
    #[arg(long, value_name = "SITE")]
    pub to: Option<usize>,

    /// Take the output so many samples later: the time that waves need from one site to the other.
    #[arg(long, value_name = "SAMPLES", default_value_t = 0)]
    pub lag: usize,

    /// Frequency up to which there are terms, in cycles per unit of time, or with its unit (2kHz) [default: all below
    /// Nyquist].
    #[arg(long, value_name = "FREQUENCY", value_parser = parse::step::<Frequency>)]
    pub highest: Option<Measure<Frequency>>,

    /// How often realisations are drawn anew for the errors.
    #[arg(long, value_name = "N", default_value_t = 200)]
    pub resamplings: usize,

    #[command(flatten)]
    pub averages: TripleArgs,
    #[command(flatten)]
    pub estimate: EstimateArgs,
}

impl Typed for Transfer {
    type Found = Found;

    fn fields(&self) -> &[PathBuf] {
        &self.fields
    }

    fn shared(&self) -> &EstimateArgs {
        &self.estimate
    }

    fn memory(&self) -> Option<u64> {
        self.averages.memory
    }

    fn computation(&self) -> Result<impl Computation<Found>, Error> {
        // Not required by the parser: a file of styles is checked against commands without options.
        let site = |option, site: Option<usize>| {
            site.ok_or_else(|| Error::Request {
                option,
                expected: "the index of a site".into(),
                found: "none".into(),
            })
        };
        let request = TransferRequest {
            from: site("from", self.from)?,
            to: site("to", self.to)?,
            lag: self.lag,
            highest: None,
            averaging: self.averages.averaging(),
            gaps: self.averages.gaps.into(),
            alpha: self.averages.significance,
            resamplings: self.resamplings,
            threads: self.estimate.threads(),
            memory: self.averages.memory,
        };
        let typed = self.highest;
        Ok(move |fields: &[&Field], observer: &dyn Observer| {
            let unit = fields.first().and_then(|field| field.time.unit.as_deref());
            let unit = unit.map(cycles_per);
            let highest = typed.map(|typed| of_axis("highest", typed, unit.as_deref()));
            let request = TransferRequest {
                highest: highest.transpose()?,
                ..request.clone()
            };
            transfer(fields, &request, observer)
        })
    }
}

impl Estimate for Found {
    const COMMAND: &'static str = "transfer";

    fn summary(&self, provenance: &Provenance) -> serde_json::Result<String> {
        TransferSummary::new(self, provenance).to_json()
    }

    fn arrays(&self, to: &dyn LabelledArrays) -> Result<(), Error> {
        transfer_arrays(self, to)
    }

    fn figures(&self, name: &str, style: &Style) -> Vec<Figure> {
        vec![plot::transfer(self, name, style)]
    }

    fn page(
        &self,
        name: &str,
        provenance: &Provenance,
        warnings: &[[String; 2]],
        style: &Style,
    ) -> serde_json::Result<String> {
        transfer_html(self, name, provenance, warnings, style)
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

/// What gained from what, in words.
fn answer(found: &Found) -> String {
    if !found.holds() {
        return "no quadratic transfer is shown: it does not predict what was not fitted".into();
    }
    let Some(at) = found.passage() else {
        return "no frequencies gain from others more than by chance".into();
    };
    let towards = if at.flux > 0.0 { "higher" } else { "lower" };
    let share = |power: f64| percent(power.abs() / found.input());
    format!(
        "{} \u{b1} {} of the input's power moves past {} {} to {towards} frequencies",
        share(at.flux),
        share(at.flux_error),
        number(at.frequency),
        cycles_per(&found.units().0)
    )
}

fn tell(found: &Found, summary: &mut Summary) {
    let (independence, shares) = (&found.independence, &found.shares);
    let text = format!(
        "linear {}, quadratic {}, residual {} of its power",
        percent(shares.linear),
        percent(shares.quadratic),
        percent(shares.residual)
    );
    summary.fact("output", &text);
    let text = format!(
        "of what was not fitted, linear terms explain {}, quadratic ones {} of the rest",
        percent(shares.held_out_linear),
        percent(shares.held_out_of_rest)
    );
    summary.fact("prediction", &text);
    summary.detail("findings", &found.findings());
    if found.holds() {
        summary.detail("passage", &found.answer());
    }
    let text = format!(
        "records {}, segments {} of {} samples: {} effective realisations for {} unknowns of a frequency",
        independence.records,
        independence.segments,
        found.segment[0],
        number(independence.effective),
        found.unknowns
    );
    summary.detail("averages", &text);
}

/// What the user should know, each with what to do.
fn warnings(found: &Found) -> Vec<[String; 2]> {
    let mut warnings = Vec::new();
    let undetermined: usize = found.outputs.iter().map(|output| output.undetermined).sum();
    if undetermined > 0 {
        warnings.push([
            format!(
                "{undetermined} terms are not determined: their inputs are 0 or vary together with others"
            ),
            "keep to frequencies that the input has (--highest), or excite more of them".into(),
        ]);
    }
    if !found.holds() {
        warnings.push([
            "quadratic terms do not predict this field; their gains mean nothing".into(),
            "try more realisations, neighbouring sites, --lag; `cascade budget` if the chain is known".into(),
        ]);
    }
    warnings
}
