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
use crate::summary::Summary;
use crate::terminal::number;

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

    fn answer(&self) -> String {
        let Some((_, [f, p, chance])) = strongest(self) else {
            return "no power at any frequency".into();
        };
        let line = format!(
            "{} of the variance at {} {}",
            percent(p),
            number(f),
            self.unit()
        );
        if self.axis == LombAxis::Space {
            return format!("{line}, the largest; averages have no level");
        }
        let chance = match chance {
            chance if chance.is_nan() => {
                return format!("no line can be told from chance; {line} is the largest");
            }
            0.0 => "below 1e-300".to_owned(),
            chance => number(chance),
        };
        match (self.lines().len(), self.significant()) {
            (0, 0) => format!(
                "no line above chance: the largest, {line}, has noise with probability {chance}"
            ),
            (0, _) => format!("no line above the power beside it; the largest is {line}"),
            (count, _) => format!(
                "lines at {count} of {} sites; the largest is {line}",
                self.samples.len()
            ),
        }
    }

    fn tell(&self, summary: &mut Summary) {
        if self.axis == LombAxis::Time {
            let text = format!(
                "{} of {} records are above the level that white noise exceeds with probability {}",
                self.significant(),
                self.samples.len(),
                percent(self.alpha)
            );
            summary.fact("power", &text);
        } else {
            summary.fact(
                "power",
                &format!("profiles at {} times averaged", self.averaged),
            );
        }
        let [shortest, longest, mean] = self.steps;
        let is_even = (longest - shortest).abs() < 1e-6 * mean;
        let missing = self.missing;
        let text = match is_even {
            true => format!("even steps of {}; {missing} samples missing", number(mean)),
            false => format!(
                "steps from {} to {}, {} on average; {missing} samples missing",
                number(shortest),
                number(longest),
                number(mean)
            ),
        };
        summary.fact("sampling", &text);
    }
}

/// The column with the largest power of all, with its frequency, power and the probability that noise has it.
fn strongest(found: &Found) -> Option<(usize, [f64; 3])> {
    let known = found.peaks.iter().copied().enumerate();
    let known = known.filter(|(_, peak)| peak[1].is_finite());
    known.max_by(|(_, a), (_, b)| a[1].total_cmp(&b[1]))
}
