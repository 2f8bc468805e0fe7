//! The linear and quadratic transfer between two sites, beside a bicoherence.

use clap::Args;
use wavecascade::Error;
use wavecascade::estimates::{Transfer, TransferRequest};
use wavecascade::measure::{Frequency, Measure, cycles_per};
use wavecascade::report::percent;

use crate::bicoherence::BicoherenceArgs;
use crate::parse;
use crate::show_args::of_axis;
use crate::summary::Summary;
use crate::terminal::number;

/// Which transfer is fitted.
#[derive(Debug, Args)]
#[command(next_help_heading = "Transfer")]
pub struct TransferArgs {
    /// Fit the linear and the quadratic transfer from `--site` to this site as well.
    #[arg(long, value_name = "SITE")]
    pub transfer: Option<usize>,

    /// Take the record of that site so many samples later: the time that waves need from one to the other.
    #[arg(
        long,
        value_name = "SAMPLES",
        default_value_t = 0,
        requires = "transfer"
    )]
    pub lag: usize,

    /// Frequency up to which there are terms, in cycles per unit of time, or with its unit (2kHz) [default: all below
    /// Nyquist].
    #[arg(long, value_name = "FREQUENCY", value_parser = parse::step::<Frequency>, requires = "transfer")]
    pub highest: Option<Measure<Frequency>>,

    /// How often realisations are drawn anew for the errors.
    #[arg(long, value_name = "N", default_value_t = TransferRequest::default().resamplings, requires = "transfer")]
    pub resamplings: usize,
}

impl TransferArgs {
    /// What is asked for beside a bicoherence, of a field with times in this unit.
    ///
    /// # Errors
    /// For a frequency in a unit that the field does not have.
    pub fn request(
        &self,
        typed: &BicoherenceArgs,
        unit: Option<&str>,
    ) -> Result<Option<TransferRequest>, Error> {
        let unit = unit.map(cycles_per);
        let highest = self
            .highest
            .map(|highest| of_axis("highest", highest, unit.as_deref()));
        let highest = highest.transpose()?;
        Ok(self.transfer.map(|to| TransferRequest {
            from: typed.site,
            to,
            lag: self.lag,
            highest,
            averaging: typed.averages.averaging(),
            gaps: typed.averages.gaps.into(),
            alpha: typed.averages.significance,
            resamplings: self.resamplings,
            threads: typed.estimate.threads(),
            memory: typed.averages.memory,
        }))
    }
}

/// What gained from what, in words.
fn answer(found: &Transfer) -> String {
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

pub fn tell(found: &Transfer, summary: &mut Summary) {
    let (independence, shares) = (&found.independence, &found.shares);
    summary.fact("transfer", &answer(found));
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
pub fn warnings(found: &Transfer) -> Vec<[String; 2]> {
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
