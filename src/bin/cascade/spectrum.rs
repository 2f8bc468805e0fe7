//! `cascade spectrum`: power spectral densities of all sites, with intervals.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use wavecascade::Error;
use wavecascade::estimates::{
    Averaging, Combined, DividedRequest, LeftOutEach, SpectrumAxis, SpectrumEstimate, SpectrumRequest, Tapers,
    interval_factors, spectrum,
};
use wavecascade::plot::{self, Figure, Style};
use wavecascade::prepare::Window;
use wavecascade::report::{Provenance, SpectrumSummary, percent, spectrum_html, write_spectrum};

use crate::coherence::AverageArgs;
use crate::estimate::{self, Estimate, EstimateArgs};
use crate::failure::Failure;
use crate::parts::{self, PartArgs};
use crate::terminal::{self, Lines, number};

/// What `cascade spectrum` takes.
#[derive(Debug, Args)]
pub struct Spectrum {
    /// File with the field; several, or patterns such as `'shot*.npy'`, are repeated records (shots) of the
    /// same sites, which are averaged.
    #[arg(required_unless_present = "merge", value_name = "FIELD")]
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

    /// Leave out the jackknife, which takes each segment a second time; the other intervals stay.
    #[arg(long, help_heading = "Averages")]
    pub no_jackknife: bool,

    #[command(flatten)]
    pub averages: AverageArgs,
    #[command(flatten)]
    pub parts: PartArgs,
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

/// Runs the command.
pub fn run(typed: Spectrum) -> Result<(), Failure> {
    let averaging = match typed.periodogram {
        true => Averaging {
            tapers: Tapers::Window(Window::None),
            ..typed.averages.averaging()
        },
        false => typed.averages.averaging(),
    };
    let request = SpectrumRequest {
        along: typed.along.into(),
        averaging,
        is_whole: typed.periodogram,
        is_adaptive: !typed.equal_weights,
        has_jackknife: !typed.no_jackknife && typed.parts.part.is_none(),
        gaps: typed.averages.gaps.into(),
        alpha: typed.averages.significance,
        threads: typed.estimate.threads(),
        memory: typed.averages.memory,
    };
    if !typed.parts.merge.is_empty() {
        return parts::merge(&typed.parts.merge, &typed.estimate, |found| match found {
            Combined::Spectrum(found) => Some(*found),
            _ => None,
        });
    }
    if let Some(part) = typed.parts.part {
        let request = DividedRequest::from(request);
        let part = ("spectrum", &request, part);
        return parts::write(&typed.fields, &typed.estimate, typed.averages.memory, part);
    }
    estimate::run(
        &typed.fields,
        &typed.estimate,
        typed.averages.memory,
        |fields, observer| spectrum(fields, &request, observer),
    )
}

impl Estimate for SpectrumEstimate {
    const COMMAND: &'static str = "spectrum";

    fn summary(&self, provenance: &Provenance) -> serde_json::Result<String> {
        SpectrumSummary::new(self, provenance).to_json()
    }

    fn write_arrays(&self, directory: &Path) -> Result<(), Error> {
        write_spectrum(&directory.join("spectrum.npz"), self)
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
    if found.degrees_range().is_some() && found.has_jackknife && found.left_out == LeftOutEach::Record {
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
