//! Averages of products of several transforms, which allow a single window.

use clap::Args;
use wavecascade::estimates::SIGNIFICANCE;
use wavecascade::estimates::{Averaging, Tapers};
use wavecascade::prepare::Window;

use crate::args::{DetrendArg, GapsArg};
use crate::parse;

/// How a record gives several realisations, under one window.
#[derive(Debug, Args)]
#[command(next_help_heading = "Averages")]
pub struct TripleArgs {
    /// Samples a segment [default: a power of two that leaves enough segments].
    #[arg(long, value_name = "SAMPLES")]
    pub segment: Option<usize>,
    /// Samples, or share, that neighbouring segments have in common [default: half].
    #[arg(long, value_name = "SAMPLES|SHARE", value_parser = parse::overlap, requires = "segment")]
    pub overlap: Option<parse::Overlap>,
    /// Taper of the segments: none, hann, hamming, blackman-harris, flat-top, tukey[:TAPER],
    /// kaiser[:BETA], dpss[:NW].
    #[arg(long, value_name = "WINDOW", default_value_t = Window::USUAL)]
    pub window: Window,
    /// Remove from each segment.
    #[arg(long, value_enum, default_value_t = DetrendArg::Mean, value_name = "WHAT")]
    pub detrend: DetrendArg,
    /// What to do with samples that are not finite.
    #[arg(long, value_enum, default_value_t = GapsArg::Refuse)]
    pub gaps: GapsArg,
    /// Probability by which a level is exceeded by chance, and by which an interval errs.
    #[arg(long, value_name = "SHARE", default_value_t = SIGNIFICANCE, value_parser = parse::share)]
    pub significance: f64,
    /// Working memory, such as 500MB or 2GiB [default: half of the free memory].
    #[arg(long, value_name = "SIZE", value_parser = parse::bytes)]
    pub memory: Option<u64>,
}

impl TripleArgs {
    pub fn averaging(&self) -> Averaging {
        Averaging {
            segment: self.segment,
            overlap: self
                .overlap
                .zip(self.segment)
                .map(|(overlap, segment)| overlap.of(segment)),
            tapers: Tapers::Window(self.window),
            detrend: self.detrend.into(),
        }
    }
}
