//! `cascade spectrum`: power spectral densities of all sites, with intervals.

use wavecascade::estimates::{
    Averaging, DividedRequest, FieldAxis, SpaceTimeRequest, SpectrumRequest, Tapers, spacetime,
    spectrum,
};

use super::*;

/// What `cascade spectrum` takes.
#[derive(Debug, Args)]
#[command(mut_arg("fields", |arg| arg.required(false).required_unless_present("merge")))]
pub struct Spectrum {
    /// Spectra of the records of sites, over frequency, of the snapshots, over wavenumber, or of both, over
    /// wavenumber and frequency.
    #[arg(long, conflicts_with = "merge", value_enum, default_value_t = AlongArg::Time, value_name = "AXIS")]
    pub along: AlongArg,

    /// The whole record as one segment, without a taper: a periodogram, of two degrees of freedom.
    #[arg(
        long,
        conflicts_with_all = ["merge", "segment", "window", "multitaper"],
        help_heading = "Averages"
    )]
    pub periodogram: bool,
    /// Give all tapers of `--multitaper` (and `--space-multitaper`) the same weight, in place of adaptive ones.
    #[arg(long, conflicts_with = "merge", help_heading = "Averages")]
    pub equal_weights: bool,

    /// Leave out the jackknife, which takes each segment a second time; the other intervals stay.
    #[arg(long, conflicts_with = "merge", help_heading = "Averages")]
    pub no_jackknife: bool,

    /// Subtract the noise of each site, where it is known; never below 0.
    #[arg(long, conflicts_with = "merge")]
    pub subtract_noise: bool,

    /// With `--along both`, taper over the sites [default: hann]; names as for `--window`.
    #[arg(
        long,
        value_name = "WINDOW",
        conflicts_with_all = ["merge", "space_multitaper"],
        help_heading = "Averages"
    )]
    pub space_window: Option<Window>,
    /// With `--along both`, K Slepian tapers over the sites, of space-bandwidth product NW, such as 2,3.
    #[arg(
        long,
        value_name = "NW,K",
        value_parser = parse::multitaper,
        conflicts_with = "merge",
        help_heading = "Averages"
    )]
    pub space_multitaper: Option<(f64, usize)>,

    #[command(flatten)]
    pub averages: AverageArgs,
    #[command(flatten)]
    pub parts: PartArgs,
    #[command(flatten)]
    pub estimate: EstimateArgs,
}

choice!(AlongArg => Option<FieldAxis> {
    Time => Some(FieldAxis::Time),
    Space => Some(FieldAxis::Space),
    Both => None,
});

impl Spectrum {
    fn averaging(&self) -> Averaging {
        match self.periodogram {
            true => Averaging {
                tapers: Tapers::Window(Window::None),
                ..self.averages.averaging()
            },
            false => self.averages.averaging(),
        }
    }

    /// The request of `--along both`.
    fn of_both(&self) -> SpaceTimeRequest {
        SpaceTimeRequest {
            averaging: self.averaging(),
            is_whole: self.periodogram,
            space: match (self.space_multitaper, self.space_window) {
                (Some((nw, count)), _) => Tapers::Slepian { nw, count },
                (None, Some(window)) => Tapers::Window(window),
                (None, None) if self.periodogram => Tapers::Window(Window::None),
                (None, None) => Tapers::Window(Window::USUAL),
            },
            is_adaptive: !self.equal_weights,
            gaps: self.averages.segments.gaps.into(),
            alpha: self.averages.segments.significance,
            threads: self.estimate.threads(),
            memory: self.estimate.memory,
        }
    }

    fn request(&self, along: FieldAxis) -> SpectrumRequest {
        SpectrumRequest {
            along,
            averaging: self.averaging(),
            is_whole: self.periodogram,
            is_adaptive: !self.equal_weights,
            has_jackknife: !self.no_jackknife,
            gaps: self.averages.segments.gaps.into(),
            subtract_noise: self.subtract_noise,
            alpha: self.averages.segments.significance,
            threads: self.estimate.threads(),
            memory: self.estimate.memory,
        }
    }
}

impl Estimate for Spectrum {
    /// That spectra from which noise is subtracted are of one axis.
    fn check(&self) -> Result<(), Error> {
        let is_of_one = !self.subtract_noise || self.along != AlongArg::Both;
        let expected = "it with spectra along one axis";
        Error::require(is_of_one, "subtract-noise", expected, "`--along both`")
    }

    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error> {
        Ok(match self.along.into() {
            Some(along) => Found::of(spectrum(given.fields, &self.request(along), observer)?),
            None => Found::of(spacetime(given.fields, &self.of_both(), observer)?),
        })
    }

    fn parts(&self) -> Option<&PartArgs> {
        Some(&self.parts)
    }

    /// Parts have no jackknife, and one axis.
    fn divided(&self) -> Result<DividedRequest, Error> {
        let along: Option<FieldAxis> = self.along.into();
        let along = along.ok_or_else(|| Error::request("along", "one axis", "both"))?;
        let request = SpectrumRequest {
            has_jackknife: false,
            ..self.request(along)
        };
        Ok(request.into())
    }
}
