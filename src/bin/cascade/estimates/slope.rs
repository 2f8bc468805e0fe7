//! `cascade slope`: the power law of a spectrum over a band.

use clap::{Args, ValueEnum};
use wavecascade::estimates::{FieldAxis, Slope as Found, SlopeRequest, slope};
use wavecascade::measure::{Frequency, Measure, Wavenumber, cycles_per};
use wavecascade::observer::Observer;
use wavecascade::{Error, Field};

use crate::estimates::averages::AverageArgs;
use crate::estimates::{Computation, EstimateArgs, Typed};
use crate::show_args::of_axis;

/// What `cascade slope` takes.
#[derive(Debug, Args)]
pub struct Slope {
    /// Spectrum over wavenumbers (space) or frequencies (time).
    #[arg(long, value_enum, default_value_t = AlongArg::Space)]
    pub along: AlongArg,
    /// Band of the fit: wavenumbers in rad per unit of length, or frequencies in cycles per unit of time; or with their
    /// unit (1kHz:20kHz).
    #[arg(long, value_name = "FROM:TO", value_parser = band)]
    pub band: Option<[BandEnd; 2]>,
    /// Breaks of the law that are searched in the band, at most 2.
    #[arg(long, value_name = "N", default_value_t = SlopeRequest::default().breaks)]
    pub breaks: usize,
    /// Frames of the times with a slope of their own, along x.
    #[arg(long, value_name = "N", default_value_t = SlopeRequest::default().frames)]
    pub frames: usize,

    #[command(flatten)]
    pub averages: AverageArgs,
    #[command(flatten)]
    pub estimate: EstimateArgs,
}

/// An end of the band: a number in the unit of the axis, or with its own.
#[derive(Debug, Clone, Copy)]
pub enum BandEnd {
    Open,
    Frequency(Measure<Frequency>),
    Wavenumber(Measure<Wavenumber>),
}

fn band(text: &str) -> Result<[BandEnd; 2], String> {
    let expected =
        "expected FROM:TO, two numbers with or without a unit, of which one may be left out";
    let end = |text: &str| match text.trim() {
        "" => Ok(BandEnd::Open),
        text => Measure::read(text)
            .map(BandEnd::Frequency)
            .or_else(|_| Measure::read(text).map(BandEnd::Wavenumber))
            .map_err(|_| expected.to_owned()),
    };
    let (from, to) = text.split_once(':').ok_or(expected)?;
    Ok([end(from)?, end(to)?])
}

impl BandEnd {
    /// The number in the unit of the spectrum's axis; `open` for an end left out.
    fn on(self, along: AlongArg, field: &Field, open: f64) -> Result<f64, Error> {
        let unit = match along {
            AlongArg::Space => field
                .space
                .unit
                .as_deref()
                .map(|unit| format!("rad/{unit}")),
            AlongArg::Time => field.time.unit.as_deref().map(cycles_per),
        };
        match (self, along) {
            (BandEnd::Open, _) => Ok(open),
            (BandEnd::Frequency(f), AlongArg::Time) => of_axis("band", f, unit.as_deref()),
            (BandEnd::Wavenumber(k), AlongArg::Space) => of_axis("band", k, unit.as_deref()),
            (BandEnd::Frequency(f), AlongArg::Space) if !f.has_unit => Ok(f.value),
            (BandEnd::Frequency(_), AlongArg::Space) => Err(Error::Request {
                option: "band",
                expected: "wavenumbers, or --along time".into(),
                found: "a frequency".into(),
            }),
            (BandEnd::Wavenumber(_), AlongArg::Time) => Err(Error::Request {
                option: "band",
                expected: "frequencies, or --along space".into(),
                found: "a wavenumber".into(),
            }),
        }
    }
}

/// An axis of the field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AlongArg {
    Space,
    Time,
}

impl Typed for Slope {
    type Found = Found;
    const COMMAND: &'static str = "slope";

    fn shared(&self) -> &EstimateArgs {
        &self.estimate
    }

    fn computation(&self) -> Result<impl Computation<Found>, Error> {
        // Not required by the parser: a file of styles is checked against commands without options.
        let ends = self.band.ok_or_else(|| Error::Request {
            option: "band",
            expected: "the band of the fit, such as 1:20".into(),
            found: "none".into(),
        })?;
        let request = SlopeRequest {
            axis: match self.along {
                AlongArg::Space => FieldAxis::Space,
                AlongArg::Time => FieldAxis::Time,
            },
            band: (f64::NEG_INFINITY, f64::INFINITY),
            breaks: self.breaks,
            frames: self.frames,
            averaging: self.averages.averaging(),
            gaps: self.averages.segments.gaps.into(),
            alpha: self.averages.segments.significance,
            threads: self.estimate.threads(),
            memory: self.estimate.memory,
        };
        let along = self.along;
        Ok(move |fields: &[&Field], observer: &dyn Observer| {
            let mut request = request.clone();
            if let Some(field) = fields.first() {
                let from = ends[0].on(along, field, f64::NEG_INFINITY)?;
                let to = ends[1].on(along, field, f64::INFINITY)?;
                if from > to {
                    return Err(Error::Request {
                        option: "band",
                        expected: "the lower end first".into(),
                        found: format!("{from}:{to}"),
                    });
                }
                request.band = (from, to);
            }
            slope(fields, &request, observer)
        })
    }
}
