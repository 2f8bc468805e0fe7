//! `cascade spectrum`: power spectral densities of all sites, with intervals.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use wavecascade::estimates::{
    Averaging, LeftOutEach, SpectrumAxis, SpectrumEstimate, SpectrumRequest, Tapers,
    interval_factors, spectrum,
};
use wavecascade::observer::Observer;
use wavecascade::plot::{self, Figure, Style};
use wavecascade::prepare::Window;
use wavecascade::report::{
    LabelledArrays, Provenance, SpectrumSummary, percent, spectrum_arrays, spectrum_html,
};
use wavecascade::{Error, Field};

use crate::coherence::AverageArgs;
use crate::estimate::{Computation, Estimate, EstimateArgs, Typed};
use crate::terminal::{self, Lines, number};

/// What `cascade spectrum` takes.
#[derive(Debug, Args)]
pub struct Spectrum {
    /// File with the field; several, or patterns such as `'shot*.npy'`, are repeated records (shots) of the
    /// same sites, which are averaged.
    #[arg(required = true, value_name = "FIELD")]
    pub fields: Vec<PathBuf>,

    /// Spectra of the records of sites, over frequency, or of the snapshots, over wavenumber.
    #[arg(long, value_enum, default_value_t = AlongArg::Time, value_name = "AXIS")]
    pub along: AlongArg,

    /// The whole record as one segment, without a taper: a periodogram, of two degrees of freedom.
    #[arg(
        long,
        conflicts_with_all = ["segment", "window", "multitaper"],
        help_heading = "Averages"
    )]
    pub periodogram: bool,
    /// Give all tapers of `--multitaper` the same weight, in place of adaptive ones.
    #[arg(long, requires = "multitaper", help_heading = "Averages")]
    pub equal_weights: bool,

    #[command(flatten)]
    pub averages: AverageArgs,
    #[command(flatten)]
    pub estimate: EstimateArgs,
}

/// The axis of the records.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum AlongArg {
    Time,
    Space,
}

impl From<AlongArg> for SpectrumAxis {
    fn from(along: AlongArg) -> SpectrumAxis {
        match along {
            AlongArg::Time => SpectrumAxis::Time,
            AlongArg::Space => SpectrumAxis::Space,
        }
    }
}

impl Typed for Spectrum {
    type Found = SpectrumEstimate;

    fn fields(&self) -> &[PathBuf] {
        &self.fields
    }

    fn shared(&self) -> &EstimateArgs {
        &self.estimate
    }

    fn memory(&self) -> Option<u64> {
        self.averages.memory
    }

    fn computation(&self) -> Result<impl Computation<SpectrumEstimate>, Error> {
        let averaging = match self.periodogram {
            true => Averaging {
                tapers: Tapers::Window(Window::None),
                ..self.averages.averaging()
            },
            false => self.averages.averaging(),
        };
        let request = SpectrumRequest {
            along: self.along.into(),
            averaging,
            is_whole: self.periodogram,
            is_adaptive: !self.equal_weights,
            gaps: self.averages.gaps.into(),
            alpha: self.averages.significance,
            threads: self.estimate.threads(),
            memory: self.averages.memory,
        };
        Ok(move |fields: &[&Field], observer: &dyn Observer| spectrum(fields, &request, observer))
    }
}

impl Estimate for SpectrumEstimate {
    const COMMAND: &'static str = "spectrum";

    fn summary(&self, provenance: &Provenance) -> serde_json::Result<String> {
        SpectrumSummary::new(self, provenance).to_json()
    }

    fn arrays(&self, to: &dyn LabelledArrays) -> Result<(), Error> {
        spectrum_arrays(self, to)
    }

    fn figures(&self, name: &str, style: &Style) -> Vec<Figure> {
        vec![plot::spectrum(self, name, style)]
    }

    fn page(
        &self,
        name: &str,
        provenance: &Provenance,
        warnings: &[[String; 2]],
        style: &Style,
    ) -> serde_json::Result<String> {
        spectrum_html(self, name, provenance, warnings, style)
    }

    fn warnings(&self) -> Vec<[String; 2]> {
        warnings(self)
    }

    fn lines(&self) -> String {
        lines(self)
    }
}

/// What was found, in words.
fn lines(found: &SpectrumEstimate) -> String {
    let mut lines = Lines::new(terminal::width());
    let independence = &found.independence;
    lines.line(
        "averages",
        &format!(
            "records {}, segments {} of {} samples, tapers {}: {} effective realisations",
            independence.records,
            independence.segments,
            found.segment[0],
            independence.tapers,
            number(independence.effective)
        ),
    );
    let confidence = percent(1.0 - found.alpha);
    match found.degrees_range() {
        Some([least, median, most]) => {
            let [low, high] = interval_factors(median, found.alpha);
            lines.line(
                "interval",
                &format!(
                    "{confidence} from {} to {} of a value, by {} degrees of freedom ({} to {})",
                    number(low),
                    number(high),
                    number(median),
                    number(least),
                    number(most)
                ),
            );
        }
        None => lines.line("interval", "none can be stated"),
    }
    if found.degrees_range().is_some() && found.left_out == LeftOutEach::Record {
        lines.line(
            "jackknife",
            "over records, whose segments are not independent",
        );
    }
    let Some(test) = &found.line_test else {
        return lines.text;
    };
    if found.degrees_range().is_none() {
        return lines.text;
    }
    let Some(first) = test.lines.first() else {
        lines.line(
            "lines",
            &format!("none: no F is above {}", number(test.level_of_all)),
        );
        return lines.text;
    };
    let (time_unit, space_unit) = found.units();
    let (columns, column_unit) = match found.along {
        SpectrumAxis::Time => ("sites", space_unit),
        SpectrumAxis::Space => ("times", time_unit),
    };
    lines.line(
        "lines",
        &format!(
            "{} at {} {columns}, F above {}; the surest: amplitude {} ± {}{} at {} {} and {} {column_unit}",
            test.lines.len(),
            test.columns(),
            number(test.level_of_all),
            number(first.amplitude),
            number(first.amplitude_error),
            found.unit.as_ref().map(|unit| format!(" {unit}")).unwrap_or_default(),
            number(first.at),
            found.bin_unit(),
            number(found.coordinate(first.column)),
        ),
    );
    lines.text
}

/// What the user should know, each with what to do.
fn warnings(found: &SpectrumEstimate) -> Vec<[String; 2]> {
    let mut warnings = Vec::new();
    let without = found.without_interval();
    if without > 0 {
        let all = found.has_interval.len();
        warnings.push(match found.along {
            SpectrumAxis::Time => [
                format!(
                    "{without} of {all} sites have a transient: its energy lies in a few parts of the record, \
                     it is one realisation, and no interval is stated"
                ),
                "name several records of the same sites, one a shot".into(),
            ],
            SpectrumAxis::Space => [
                format!(
                    "{without} of {all} snapshots have their energy in a few parts of the sites: they are one \
                     realisation each, and no interval of theirs is stated"
                ),
                "read the mean over the times, if it has an interval, or name several records, one a shot"
                    .into(),
            ],
        });
    }
    if let Some(mean) = &found.mean
        && mean.low.iter().all(|v| v.is_nan())
    {
        warnings.push([
            format!(
                "the mean over the times has no interval: the energy changes in time (steadiness {}), or there \
                 are fewer than 32 times",
                number(mean.steadiness)
            ),
            "analyse a part of the record in which it is steady".into(),
        ]);
    }
    warnings
}
