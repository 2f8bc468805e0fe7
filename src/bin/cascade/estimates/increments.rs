//! `cascade increments`: structure functions and intermittency.

use wavecascade::estimates::{IncrementsRequest, SIGNIFICANCE, increments};

use super::*;

/// What `cascade increments` takes.
#[derive(Debug, Args)]
pub struct Increments {
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
    #[arg(long, value_name = "N", default_value_t = IncrementsRequest::default().histograms)]
    pub histograms: usize,
    /// Probability by which intervals do not hold.
    #[arg(long, value_name = "SHARE", default_value_t = SIGNIFICANCE, value_parser = parse::share)]
    pub significance: f64,

    #[command(flatten)]
    pub estimate: EstimateArgs,
}

impl Estimate for Increments {
    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error> {
        let request = IncrementsRequest {
            separations: self.separations.clone(),
            lags: self.lags.clone(),
            band: self.band,
            lag_band: self.lag_band,
            histograms: self.histograms,
            alpha: self.significance,
            threads: self.estimate.threads(),
            memory: self.estimate.memory,
        };
        Ok(Found::of(increments(given.fields, &request, observer)?))
    }
}
