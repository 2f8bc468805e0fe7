//! `cascade slope`: the power law of a spectrum over a band.

use wavecascade::estimates::{FieldAxis, SlopeRequest, slope};
use wavecascade::measure::{Frequency, Wavenumber};

use super::*;
use crate::show_args::ends;

/// What `cascade slope` takes.
#[derive(Debug, Args)]
pub struct Slope {
    /// Spectrum over wavenumbers (space) or frequencies (time).
    #[arg(long, value_enum, default_value_t = AlongArg::Space)]
    pub along: AlongArg,
    /// Band of the fit: wavenumbers in rad per unit of length, or frequencies in cycles per unit of time; or with their
    /// unit (1kHz:20kHz).
    #[arg(long, value_name = "FROM:TO", value_parser = band)]
    pub band: String,
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

choice!(AlongArg => FieldAxis { Space, Time });

/// `FROM:TO`, of frequencies or of wavenumbers.
fn band(text: &str) -> Result<String, String> {
    let is_either = ends::<Frequency>(text).is_ok() || ends::<Wavenumber>(text).is_ok();
    match is_either {
        true => Ok(text.to_owned()),
        false => ends::<Wavenumber>(text).map(|_| String::new()),
    }
}

impl Slope {
    /// The band on the axis of the spectrum.
    fn band(&self, units: &AxisUnits) -> Result<(f64, f64), Error> {
        let refused = |expected: &str| Error::request("band", expected, &self.band);
        match self.along {
            AlongArg::Space => {
                let band = ends::<Wavenumber>(&self.band);
                let band = band.map_err(|_| refused("wavenumbers, or --along time"))?;
                units.ends("band", band)
            }
            AlongArg::Time => {
                let band = ends::<Frequency>(&self.band);
                let band = band.map_err(|_| refused("frequencies, or --along space"))?;
                units.ends("band", band)
            }
        }
    }
}

impl Estimate for Slope {
    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error> {
        let units = given.fields.first().copied().map(AxisUnits::of);
        let request = SlopeRequest {
            axis: self.along.into(),
            band: self.band(&units.unwrap_or_default())?,
            breaks: self.breaks,
            frames: self.frames,
            averaging: self.averages.averaging(),
            gaps: self.averages.segments.gaps.into(),
            alpha: self.averages.segments.significance,
            threads: self.estimate.threads(),
            memory: self.estimate.memory,
        };
        Ok(Found::of(slope(given.fields, &request, observer)?))
    }
}
