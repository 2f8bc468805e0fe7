//! `cascade lomb`: spectra of records at uneven times or with gaps.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use wavecascade::estimates::{Lomb as Found, LombAxis, LombRequest, lomb};
use wavecascade::observer::Observer;
use wavecascade::plot::{self, Figure, Style};
use wavecascade::report::{
    LabelledArrays, LombSummary, Provenance, lomb_arrays, lomb_html, percent,
};
use wavecascade::{Error, Field};

use crate::estimate::{Computation, Estimate, EstimateArgs, Typed};
use crate::parse;
use crate::terminal::{self, Lines, number};

/// What `cascade lomb` takes.
#[derive(Debug, Args)]
pub struct Lomb {
    /// File with the field. Its times (or positions) may be uneven; samples that are not finite are left out.
    #[arg(value_name = "FIELD")]
    pub field: PathBuf,

    /// Take spectra of each site's record, or of the profiles at all times, averaged.
    #[arg(long, value_enum, default_value_t = AxisArg::Time)]
    pub axis: AxisArg,
    /// Frequencies for each that the record resolves, 1/T.
    #[arg(long, value_name = "NUMBER", default_value_t = LombRequest::default().oversampling)]
    pub oversampling: f64,
    /// Highest frequency, in cycles per unit of the axis [default: half of the inverse mean step].
    #[arg(long, value_name = "FREQUENCY")]
    pub highest: Option<f64>,
    /// Probability by which noise exceeds the level anywhere in a record's spectrum.
    #[arg(long, value_name = "SHARE", default_value = "0.05", value_parser = parse::share)]
    pub significance: f64,
    /// Working memory, such as 500MB or 2GiB [default: half of the free memory].
    #[arg(long, value_name = "SIZE", value_parser = parse::bytes)]
    pub memory: Option<u64>,

    #[command(flatten)]
    pub estimate: EstimateArgs,
}

/// `--axis`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AxisArg {
    Time,
    Space,
}

impl Typed for Lomb {
    type Found = Found;

    fn fields(&self) -> &[PathBuf] {
        std::slice::from_ref(&self.field)
    }

    fn shared(&self) -> &EstimateArgs {
        &self.estimate
    }

    fn memory(&self) -> Option<u64> {
        self.memory
    }

    fn computation(&self) -> Result<impl Computation<Found>, Error> {
        let request = LombRequest {
            axis: match self.axis {
                AxisArg::Time => LombAxis::Time,
                AxisArg::Space => LombAxis::Space,
            },
            oversampling: self.oversampling,
            highest: self.highest,
            alpha: self.significance,
            threads: self.estimate.threads(),
            memory: self.memory,
        };
        Ok(
            move |fields: &[&Field], observer: &dyn Observer| match fields {
                [one] => lomb(one, &request, observer),
                _ => Err(Error::Request {
                    option: "field",
                    expected: "one field".into(),
                    found: fields.len().to_string(),
                }),
            },
        )
    }
}

impl Estimate for Found {
    const COMMAND: &'static str = "lomb";
    const UNEVEN: bool = true;

    fn summary(&self, provenance: &Provenance) -> serde_json::Result<String> {
        LombSummary::new(self, provenance).to_json()
    }

    fn arrays(&self, to: &dyn LabelledArrays) -> Result<(), Error> {
        lomb_arrays(self, to)
    }

    fn figures(&self, name: &str, style: &Style) -> Vec<Figure> {
        vec![plot::lomb(self, name, style)]
    }

    fn page(
        &self,
        name: &str,
        provenance: &Provenance,
        warnings: &[[String; 2]],
        style: &Style,
    ) -> serde_json::Result<String> {
        lomb_html(self, name, provenance, warnings, style)
    }

    fn warnings(&self) -> Vec<[String; 2]> {
        Vec::new()
    }

    fn lines(&self) -> String {
        let mut lines = Lines::new(terminal::width());
        lines.line(
            "sampling",
            &format!(
                "steps from {} to {}, {} on average; {} samples missing",
                number(self.steps[0]),
                number(self.steps[1]),
                number(self.steps[2]),
                self.missing
            ),
        );
        let text = match self.axis {
            LombAxis::Time => format!(
                "{} of {} records have a power above the level that white noise exceeds anywhere with probability {}",
                self.significant(),
                self.samples.len(),
                percent(self.alpha)
            ),
            LombAxis::Space => format!("profiles at {} times averaged", self.averaged),
        };
        lines.line("power", &text);
        let known = self.peaks.iter().filter(|peak| peak[1].is_finite());
        if let Some([f, p, chance]) = known.max_by(|a, b| a[1].total_cmp(&b[1])) {
            let alarm = match chance.is_finite() {
                true => format!(", false-alarm probability {}", number(*chance)),
                false => String::new(),
            };
            let text = format!(
                "{} of the variance at {} {}{alarm}",
                percent(*p),
                number(*f),
                self.unit()
            );
            lines.line("largest", &text);
        }
        lines.text
    }
}
