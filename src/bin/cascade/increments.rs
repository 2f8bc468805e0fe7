//! `cascade increments`: structure functions and intermittency.

use std::path::PathBuf;

use clap::Args;
use wavecascade::estimates::{
    FieldAxis, Increments as Found, IncrementsRequest, IntervalBasis, increments,
};
use wavecascade::observer::Observer;
use wavecascade::plot::{self, Figure, Style};
use wavecascade::report::{
    IncrementsSummary, LabelledArrays, Provenance, increment_sentences, increments_arrays,
    increments_html,
};
use wavecascade::{Error, Field};

use crate::estimate::{Computation, Estimate, EstimateArgs, Typed};
use crate::parse;
use crate::summary::{Summary, with_half};
use crate::terminal::number;

/// What `cascade increments` takes.
#[derive(Debug, Args)]
pub struct Increments {
    /// File with the field; several, or patterns such as `'shot*.npy'`, are repeated records (shots) of the
    /// same sites.
    #[arg(required = true, value_name = "FIELD")]
    pub fields: Vec<PathBuf>,

    /// Separations along x, in sites, such as 1,2,4,8 [default: powers of √2 up to a quarter of the sites].
    #[arg(long, value_name = "SITES,...", value_delimiter = ',')]
    pub separations: Option<Vec<usize>>,
    /// Lags in time, in samples [default: powers of √2 up to a quarter of the record].
    #[arg(long, value_name = "SAMPLES,...", value_delimiter = ',')]
    pub lags: Option<Vec<usize>>,
    /// Separations over which exponents are fitted, in units of length.
    #[arg(long, value_name = "FROM:TO", value_parser = parse::interval)]
    pub band: Option<(f64, f64)>,
    /// Lags over which exponents are fitted, in units of time.
    #[arg(long, value_name = "FROM:TO", value_parser = parse::interval)]
    pub lag_band: Option<(f64, f64)>,
    /// Scales of each axis with a histogram.
    #[arg(long, value_name = "N", default_value_t = 4)]
    pub histograms: usize,
    /// Probability by which intervals do not hold.
    #[arg(long, value_name = "SHARE", default_value = "0.05", value_parser = parse::share)]
    pub significance: f64,
    /// Working memory, such as 500MB or 2GiB [default: half of the free memory].
    #[arg(long, value_name = "SIZE", value_parser = parse::bytes)]
    pub memory: Option<u64>,

    #[command(flatten)]
    pub estimate: EstimateArgs,
}

impl Typed for Increments {
    type Found = Found;

    fn fields(&self) -> &[PathBuf] {
        &self.fields
    }

    fn shared(&self) -> &EstimateArgs {
        &self.estimate
    }

    fn memory(&self) -> Option<u64> {
        self.memory
    }

    fn computation(&self) -> Result<impl Computation<Found>, Error> {
        let request = IncrementsRequest {
            separations: self.separations.clone(),
            lags: self.lags.clone(),
            band: self.band,
            lag_band: self.lag_band,
            histograms: self.histograms,
            alpha: self.significance,
            threads: self.estimate.threads(),
            memory: self.memory,
        };
        Ok(
            move |fields: &[&Field], observer: &dyn Observer| {
                increments(fields, &request, observer)
            },
        )
    }
}

impl Estimate for Found {
    const COMMAND: &'static str = "increments";

    fn summary(&self, provenance: &Provenance) -> serde_json::Result<String> {
        IncrementsSummary::new(self, provenance).to_json()
    }

    fn arrays(&self, to: &dyn LabelledArrays) -> Result<(), Error> {
        increments_arrays(self, to)
    }

    fn figures(&self, name: &str, style: &Style) -> Vec<Figure> {
        vec![plot::increments(self, name, style)]
    }

    fn page(
        &self,
        name: &str,
        provenance: &Provenance,
        warnings: &[[String; 2]],
        style: &Style,
    ) -> serde_json::Result<String> {
        increments_html(self, name, provenance, warnings, style)
    }

    fn warnings(&self) -> Vec<[String; 2]> {
        if self.basis != IntervalBasis::None {
            return Vec::new();
        }
        let message = format!(
            "the record is a transient (steadiness {}), one realisation: no interval is stated",
            number(self.steadiness)
        );
        let advice = "name several records of the same sites, one a shot";
        vec![[message, advice.into()]]
    }

    fn answer(&self) -> String {
        if self.basis == IntervalBasis::None {
            return "intermittency cannot be told: one transient is one realisation".into();
        }
        let (time_unit, space_unit) = self.units();
        let ends = self.axes.iter().filter_map(|axis| {
            let (name, unit) = match axis.axis {
                FieldAxis::Space => ("along x", &space_unit),
                FieldAxis::Time => ("in time", &time_unit),
            };
            let [small, large] = [axis.scales.first()?, axis.scales.last()?];
            let apart = small.flatness - large.flatness;
            let is_intermittent = apart > small.flatness_half() + large.flatness_half();
            Some((name, unit, [small, large], is_intermittent))
        });
        let ends: Vec<_> = ends.collect();
        let Some(first) = ends.iter().find(|end| end.3).or(ends.first()) else {
            return "no increments".into();
        };
        let (_, unit, scales, is_intermittent) = first;
        let [small, large] = scales.map(|m| {
            let flatness = with_half(m.flatness, m.flatness_half(), "");
            format!("{} at {} {unit}", flatness.trim_end(), number(m.scale))
        });
        let names: Vec<&str> = ends
            .iter()
            .filter(|end| end.3 == *is_intermittent)
            .map(|end| end.0)
            .collect();
        match *is_intermittent {
            true => format!(
                "intermittent {}: flatness {small}, {large}",
                names.join(" and ")
            ),
            false => format!("no intermittency is shown: flatness {small}, {large}"),
        }
    }

    fn tell(&self, summary: &mut Summary) {
        for (name, text) in increment_sentences(self) {
            summary.fact(&name, &text);
        }
        if self.axes.iter().all(|axis| axis.exponents.is_none()) {
            summary.detail("exponents", "none: state a band with --band or --lag-band");
        }
        for axis in &self.axes {
            let pairs: u64 = axis.scales.iter().map(|m| m.pairs).sum();
            let name = format!("{:?}", axis.axis).to_lowercase();
            let text = format!("{} scales, {pairs} pairs of samples", axis.scales.len());
            summary.detail(&name, &text);
        }
    }
}
