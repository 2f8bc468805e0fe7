//! `cascade ridges`: dispersion read off S(k, f).

use wavecascade::ridges::{RidgeCut, RidgeLaw, RidgesRequest, ridges};

use super::*;

/// What `cascade ridges` takes.
#[derive(Debug, Args)]
pub struct Ridges {
    /// Fit a law to the ridges, by least squares: monatomic, diatomic, or a formula of k with the values its
    /// constants start from, such as `c*abs(k); c=1` (omega in rad per unit of time; a is the distance of
    /// sites). May be repeated.
    #[arg(long, value_name = "LAW")]
    pub fit: Vec<String>,

    #[command(flatten)]
    pub search: SearchArgs,
    #[command(flatten)]
    pub estimate: EstimateArgs,
}

/// The spectrum, and what of it is a ridge.
#[derive(Debug, Args)]
#[command(next_help_heading = "Ridges")]
pub struct SearchArgs {
    /// Samples a segment [default: a power of two near a quarter of the record].
    #[arg(long, value_name = "SAMPLES")]
    pub segment: Option<usize>,
    /// Samples, or share, that neighbouring segments have in common [default: half].
    #[arg(long, value_name = "SAMPLES|SHARE", value_parser = parse::overlap, requires = "segment")]
    pub overlap: Option<parse::Overlap>,
    /// Taper of the segments along time: none, hann, hamming, blackman-harris, flat-top, tukey[:TAPER],
    /// kaiser[:BETA], dpss[:NW].
    #[arg(long, value_name = "WINDOW", default_value_t = Window::USUAL)]
    pub window_time: Window,
    /// Taper along space; none for sites around a ring, whose waves fit.
    #[arg(long, value_name = "WINDOW", default_value_t = Window::USUAL)]
    pub window_space: Window,
    /// Look for peaks along k at each frequency, or along f at each wavenumber.
    #[arg(long, value_enum, default_value_t = CutArg::Auto)]
    pub cut: CutArg,
    /// Peaks weaker than the largest power by more than this are none.
    #[arg(long, value_name = "DB", default_value_t = RidgesRequest::default().range)]
    pub range: f64,
    /// Points of a ridge, at least.
    #[arg(long, value_name = "COUNT", default_value_t = RidgesRequest::default().fewest)]
    pub points: usize,
    /// Remove from each segment.
    #[arg(long, value_enum, default_value_t = DetrendArg::Mean, value_name = "WHAT")]
    pub detrend: DetrendArg,
    /// What to do with samples that are not finite.
    #[arg(long, value_enum, default_value_t = GapsArg::Refuse)]
    pub gaps: GapsArg,
    /// Probability by which noise has a peak anywhere in the spectrum.
    #[arg(long, value_name = "SHARE", default_value_t = RidgesRequest::default().alpha, value_parser = parse::share)]
    pub significance: f64,
}

choice!(CutArg => Option<RidgeCut> {
    /// Both, each where it is sharper; without a window along space, at each wavenumber.
    Auto => None,
    /// At each frequency, along k.
    Frequency => Some(RidgeCut::Frequency),
    /// At each wavenumber, along f.
    Wavenumber => Some(RidgeCut::Wavenumber),
});

impl Ridges {
    fn laws(&self) -> Result<Vec<RidgeLaw>, Error> {
        self.fit.iter().map(|text| RidgeLaw::parse(text)).collect()
    }
}

impl Estimate for Ridges {
    fn check(&self) -> Result<(), Error> {
        self.laws().map(|_| ())
    }

    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error> {
        let search = &self.search;
        let request = RidgesRequest {
            segment: search.segment,
            overlap: parse::overlap_of(search.overlap, search.segment),
            window_time: search.window_time,
            window_space: search.window_space,
            detrend: search.detrend.into(),
            gaps: search.gaps.into(),
            cut: search.cut.into(),
            alpha: search.significance,
            range: search.range,
            fewest: search.points,
            laws: self.laws()?,
            threads: self.estimate.threads(),
            memory: self.estimate.memory,
        };
        let found = ridges(given.fields, &request, observer)?;
        let csv = found.csv();
        Ok(Found::of(found).with_text("ridges.csv", csv))
    }
}
