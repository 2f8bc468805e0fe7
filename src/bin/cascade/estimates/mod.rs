//! What all commands on estimates share: one or several fields, one library call, a directory of results.

pub mod averages;
pub mod bicoherence;
pub mod coherence;
pub mod flux;
pub mod increments;
pub mod modes;
pub mod parts;
pub mod ridges;
pub mod slope;
pub mod spectrum;

use clap::Subcommand;
use wavecascade::estimates::DividedRequest;
use wavecascade::prepare::{Examined, Window, channel_findings};

use crate::args::{DetrendArg, GapsArg};
use crate::prelude::*;
use averages::{AverageArgs, SegmentArgs};
use parts::PartArgs;

/// The commands on estimates of fields.
#[derive(Debug, Subcommand)]
pub enum EstimateCommand {
    /// Compare all sites with a reference: coherence, delay, velocity.
    ///
    /// Averaged over segments of the record, over orthogonal tapers, or over repeated records (several
    /// files). Each number has its level of significance or its error; the segments of one transient are not
    /// independent, and then none is stated.
    #[command(after_help = "Example: cascade coherence scan.npz --reference 0 --segment 512")]
    Coherence(Box<coherence::Coherence>),
    /// Read dispersion off S(k, f): branches, velocities, fitted laws.
    ///
    /// Peaks along k at each frequency, or along f at each wavenumber, that stand above the noise are joined to
    /// branches and located between bins. Each place and each velocity has its error.
    #[command(after_help = "Example: cascade ridges scan.npz")]
    Ridges(Box<ridges::Ridges>),
    /// Measure the flux of energy both ways, and its loss.
    ///
    /// Of the waves of one branch in a linear waveguide: mass per length times group velocity times twice the density of kinetic
    /// energy, at each frequency and site, towards +x and towards -x, and how it decays along x. Each number has its
    /// interval.
    #[command(after_help = "Example: cascade flux scan.npz --mass-per-length 0.3kg/m")]
    Flux(Box<flux::Flux>),
    /// Find motions that are coherent along x at a frequency (SPOD).
    ///
    /// Spectral proper orthogonal decomposition, averaged over segments of the record, over orthogonal tapers, or
    /// over repeated records (several files). Each eigenvalue has its interval, and each mode that is a wave its
    /// wavenumber.
    #[command(after_help = "Example: cascade modes scan.npz --segment 512")]
    Modes(Box<modes::Modes>),
    /// Measure how differences grow with scale: structure functions.
    ///
    /// Increments over separations along x and lags in time, orders 1 to 6, the third with its sign, exponents
    /// over a stated band, histograms. Intervals are over shots, or over parts of a stationary record; missing
    /// samples are left out.
    #[command(after_help = "Example: cascade increments scan.npz")]
    Increments(Box<increments::Increments>),
    /// Fit the slope of a spectrum over a band, and find its breaks.
    ///
    /// Least squares in double logarithmic scales over wavenumbers or frequencies; the interval is that of the
    /// regression, or over shots if there are several. Along x, the slope of each frame of the times, and the time
    /// at which a steepening field forms a shock.
    #[command(after_help = "Example: cascade slope scan.npz --band 100Hz:2kHz")]
    Slope(Box<slope::Slope>),
    /// Find frequencies that are coupled with their sum.
    ///
    /// Averaged over segments of the record or over repeated records (several files), with levels of
    /// significance for one triple of frequencies and for all of them. Bicoherence shows coupling, not which
    /// frequency feeds which; `--transfer` fits what each gains between two sites, linearly and from pairs of others.
    #[command(after_help = "Example: cascade bicoherence scan.npz --site 12 --segment 256")]
    Bicoherence(Box<bicoherence::BicoherenceArgs>),
    /// Estimate power spectral densities, and find lines.
    ///
    /// Averaged over segments, over orthogonal tapers (Thomson's method, with adaptive weights), or over
    /// repeated records (several files). Each value has its degrees of freedom and two intervals, by the chi-square
    /// distribution and by a jackknife; tapers give a test for lines. A single transient has no interval.
    #[command(after_help = "Example: cascade spectrum scan.npz --segment 512")]
    Spectrum(Box<spectrum::Spectrum>),
}

/// What all commands on estimates take.
#[derive(Debug, Args)]
pub struct EstimateArgs {
    /// File with the field; several, or patterns such as `'shot*.npy'`, are repeated records (shots) of the
    /// same sites, which are averaged.
    #[arg(required = true, value_name = "FIELD")]
    pub fields: Vec<PathBuf>,

    /// Working memory, such as 500MB or 2GiB [default: half of the free memory].
    #[arg(long, value_name = "SIZE", value_parser = parse::bytes)]
    pub memory: Option<u64>,

    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub result: ResultArgs,
}

impl EstimateArgs {
    /// Worker threads; `None`: one a core.
    fn threads(&self) -> Option<usize> {
        self.result.how.threads
    }

    pub fn reading(&self) -> Reading<'_> {
        Reading::of(&self.input, self.memory)
    }
}

/// What is typed of an estimate.
pub trait Estimate: Sync {
    /// That the options fit each other, before any work.
    fn check(&self) -> Result<(), Error> {
        Ok(())
    }

    /// Makes the result.
    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error>;

    /// Of one that can be summed in parts, which of them are typed.
    fn parts(&self) -> Option<&PartArgs> {
        None
    }

    /// What is summed of it.
    ///
    /// # Errors
    /// For options that contradict themselves, and estimates without parts.
    fn divided(&self) -> Result<DividedRequest, Error> {
        let expected = "spectrum or coherence";
        Err(Error::request("estimate", expected, "another command"))
    }
}

impl EstimateCommand {
    /// The one place that lists the types of arguments.
    pub fn typed(&self) -> (&'static str, &dyn Estimate, &EstimateArgs) {
        use EstimateCommand::*;
        match self {
            Bicoherence(typed) => ("bicoherence", &**typed, &typed.estimate),
            Coherence(typed) => ("coherence", &**typed, &typed.estimate),
            Flux(typed) => ("flux", &**typed, &typed.estimate),
            Increments(typed) => ("increments", &**typed, &typed.estimate),
            Modes(typed) => ("modes", &**typed, &typed.estimate),
            Ridges(typed) => ("ridges", &**typed, &typed.estimate),
            Slope(typed) => ("slope", &**typed, &typed.estimate),
            Spectrum(typed) => ("spectrum", &**typed, &typed.estimate),
        }
    }

    /// Runs the command, or a part of it.
    pub fn run(&self) -> Result<(), Failure> {
        let (_, estimate, shared) = self.typed();
        match estimate.parts() {
            Some(parts) if !parts.merge.is_empty() => {
                run(&parts::Merge(self, parts), &shared.result)
            }
            Some(PartArgs {
                part: Some(part), ..
            }) => parts::write(self, *part),
            _ => run(self, &shared.result),
        }
    }
}

impl Describing for EstimateCommand {
    fn about(&self) -> About<'_> {
        let (name, _, shared) = self.typed();
        About {
            reading: Some(shared.reading()),
            arrays: Some(name),
            ..About::of(name, &shared.result.how, &shared.fields, "npy")
        }
    }

    fn check(&self) -> Result<(), Error> {
        self.typed().1.check()
    }

    /// With what is wrong with the channels of the first field.
    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error> {
        let first = given.fields.first().copied();
        let found = self.typed().1.find(given, observer)?;
        let channels = first.map(|field| channel_findings(field, observer));
        let examined = Examined {
            found: found.result,
            channels: channels.transpose()?.unwrap_or_default(),
        };
        Ok(Found {
            result: Box::new(examined),
            ..found
        })
    }
}
