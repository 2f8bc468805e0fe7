//! Options of averages over realisations, which several estimates take.

use clap::ArgGroup;
use wavecascade::estimates::{Averaging, SIGNIFICANCE, Tapers};

use super::*;

/// Options of averages that belong to the parts of a result, and not to what makes it of them.
const OF_PARTS: &str = "segment overlap window multitaper detrend gaps significance";

/// How a record gives several realisations, under one window.
#[derive(Debug, Args)]
#[command(next_help_heading = "Averages")]
pub struct SegmentArgs {
    /// Samples a segment [default: a power of two that leaves enough segments; with `--multitaper` all].
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
}

/// The same under one window or several tapers.
#[derive(Debug, Args)]
#[command(next_help_heading = "Averages")]
#[command(group = ArgGroup::new("averaging").multiple(true).args(OF_PARTS.split(' ')))]
pub struct AverageArgs {
    #[command(flatten)]
    pub segments: SegmentArgs,
    /// Thomson's method: K Slepian tapers of time-bandwidth product NW, at most 2 NW - 1, such as 4,7.
    #[arg(long, value_name = "NW,K", value_parser = parse::multitaper, conflicts_with = "window")]
    pub multitaper: Option<(f64, usize)>,
}

impl SegmentArgs {
    pub fn averaging(&self) -> Averaging {
        Averaging {
            segment: self.segment,
            overlap: parse::overlap_of(self.overlap, self.segment),
            tapers: Tapers::Window(self.window),
            detrend: self.detrend.into(),
        }
    }
}

impl AverageArgs {
    pub fn averaging(&self) -> Averaging {
        let usual = self.segments.averaging();
        let slepian = |(nw, count)| Tapers::Slepian { nw, count };
        Averaging {
            tapers: self.multitaper.map_or(usual.tapers, slepian),
            ..usual
        }
    }
}
