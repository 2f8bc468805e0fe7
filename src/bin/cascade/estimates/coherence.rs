//! `cascade coherence`: all sites of a field against a reference.

use std::path::PathBuf;

use clap::{ArgGroup, Args};
use wavecascade::estimates::SIGNIFICANCE;
use wavecascade::estimates::{
    Averaging, Coherence as Found, CoherenceRequest, Combined, DividedRequest, Tapers, coherence,
};
use wavecascade::observer::Observer;
use wavecascade::prepare::Window;
use wavecascade::{Error, Field};

use crate::args::{DetrendArg, GapsArg};
use crate::estimates::parts::{self, InParts, PartArgs};
use crate::estimates::{Computation, EstimateArgs, Typed};
use crate::failure::Failure;
use crate::parse;

/// What `cascade coherence` takes.
#[derive(Debug, Args)]
pub struct Coherence {
    /// File with the field; several, or patterns such as `'shot*.npy'`, are repeated records (shots) of the
    /// same sites, which are averaged.
    #[arg(required_unless_present = "merge", value_name = "FIELD")]
    pub fields: Vec<PathBuf>,

    /// Index of the site that all others are compared with.
    #[arg(
        long,
        conflicts_with = "merge",
        short,
        value_name = "SITE",
        default_value_t = 0
    )]
    pub reference: usize,

    #[command(flatten)]
    pub averages: AverageArgs,
    #[command(flatten)]
    pub parts: PartArgs,
    #[command(flatten)]
    pub estimate: EstimateArgs,
}

/// Options of averages that belong to the parts of a result, and not to what makes it of them.
const OF_PARTS: [&str; 7] = [
    "segment",
    "overlap",
    "window",
    "multitaper",
    "detrend",
    "gaps",
    "significance",
];

/// How a record gives several realisations.
#[derive(Debug, Args)]
#[command(next_help_heading = "Averages")]
#[command(group = ArgGroup::new("averaging").multiple(true).args(OF_PARTS))]
pub struct AverageArgs {
    /// Samples a segment [default: a power of two near an eighth of the record; with `--multitaper` all].
    #[arg(long, value_name = "SAMPLES")]
    pub segment: Option<usize>,
    /// Samples, or share, that neighbouring segments have in common [default: half].
    #[arg(long, value_name = "SAMPLES|SHARE", value_parser = parse::overlap, requires = "segment")]
    pub overlap: Option<parse::Overlap>,
    /// Taper of the segments: none, hann, hamming, blackman-harris, flat-top, tukey[:TAPER],
    /// kaiser[:BETA], dpss[:NW].
    #[arg(long, value_name = "WINDOW", default_value_t = Window::USUAL, conflicts_with = "multitaper")]
    pub window: Window,
    /// Thomson's method: K Slepian tapers of time-bandwidth product NW, at most 2 NW - 1, such as 4,7.
    #[arg(long, value_name = "NW,K", value_parser = parse::multitaper)]
    pub multitaper: Option<(f64, usize)>,
    /// Remove from each segment.
    #[arg(long, value_enum, default_value_t = DetrendArg::Mean, value_name = "WHAT")]
    pub detrend: DetrendArg,
    /// What to do with samples that are not finite.
    #[arg(long, value_enum, default_value_t = GapsArg::Refuse)]
    pub gaps: GapsArg,
    /// Probability by which the level of significance is exceeded by chance.
    #[arg(long, value_name = "SHARE", default_value_t = SIGNIFICANCE, value_parser = parse::share)]
    pub significance: f64,
    /// Working memory, such as 500MB or 2GiB [default: half of the free memory].
    #[arg(long, value_name = "SIZE", value_parser = parse::bytes)]
    pub memory: Option<u64>,
}

impl AverageArgs {
    pub fn averaging(&self) -> Averaging {
        Averaging {
            segment: self.segment,
            overlap: self
                .overlap
                .zip(self.segment)
                .map(|(overlap, segment)| overlap.of(segment)),
            tapers: match self.multitaper {
                Some((nw, count)) => Tapers::Slepian { nw, count },
                None => Tapers::Window(self.window),
            },
            detrend: self.detrend.into(),
        }
    }
}

impl Typed for Coherence {
    type Found = Found;
    const COMMAND: &'static str = "coherence";

    fn fields(&self) -> &[PathBuf] {
        &self.fields
    }

    fn shared(&self) -> &EstimateArgs {
        &self.estimate
    }

    fn memory(&self) -> Option<u64> {
        self.averages.memory
    }

    /// Or a part of it.
    fn run(&self) -> Result<(), Failure> {
        parts::run(self, |found| match found {
            Combined::Coherence(found) => Some(*found),
            _ => None,
        })
    }

    fn computation(&self) -> Result<impl Computation<Found>, Error> {
        let request = self.request();
        Ok(move |fields: &[&Field], observer: &dyn Observer| coherence(fields, &request, observer))
    }
}

impl InParts for Coherence {
    fn parts(&self) -> &PartArgs {
        &self.parts
    }

    fn divided(&self) -> Result<DividedRequest, Error> {
        Ok(self.request().into())
    }
}

impl Coherence {
    fn request(&self) -> CoherenceRequest {
        CoherenceRequest {
            reference: self.reference,
            averaging: self.averages.averaging(),
            gaps: self.averages.gaps.into(),
            alpha: self.averages.significance,
            threads: self.estimate.threads(),
            memory: self.averages.memory,
        }
    }
}
