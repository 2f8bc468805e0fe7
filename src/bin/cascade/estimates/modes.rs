//! `cascade modes`: motions that are coherent along x, by frequency.

use wavecascade::estimates::{ModesRequest, modes};

use super::*;

/// What `cascade modes` takes.
#[derive(Debug, Args)]
pub struct Modes {
    /// Frequencies whose modes are written, in cycles per unit of time, such as 0.1,0.25 [default: that of the
    /// largest eigenvalue, where a motion is coherent if there is one].
    #[arg(long, value_name = "F,...", value_delimiter = ',')]
    pub frequencies: Vec<f64>,

    /// Modes that are written of each of these frequencies.
    #[arg(long, value_name = "N", default_value_t = ModesRequest::default().modes)]
    pub modes: usize,

    #[command(flatten)]
    pub averages: AverageArgs,
    #[command(flatten)]
    pub estimate: EstimateArgs,
}

impl Estimate for Modes {
    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error> {
        let request = ModesRequest {
            frequencies: self.frequencies.clone(),
            modes: self.modes,
            averaging: self.averages.averaging(),
            gaps: self.averages.segments.gaps.into(),
            alpha: self.averages.segments.significance,
            threads: self.estimate.threads(),
            memory: self.estimate.memory,
        };
        Ok(Found::of(modes(given.fields, &request, observer)?))
    }
}
