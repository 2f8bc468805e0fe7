//! `cascade coherence`: all sites of a field against a reference.

use std::path::PathBuf;

use clap::{ArgGroup, Args};
use wavecascade::estimates::{
    Averaging, Coherence as Found, CoherenceRequest, Combined, DividedRequest, SegmentsLeft,
    Tapers, coherence,
};
use wavecascade::observer::Observer;
use wavecascade::plot::{self, Figure, Style};
use wavecascade::prepare::Window;
use wavecascade::report::{
    CoherenceSummary, LabelledArrays, Provenance, coherence_arrays, coherence_html, percent,
};
use wavecascade::{Error, Field};

use crate::args::{DetrendArg, GapsArg};
use crate::estimate::{Computation, Estimate, EstimateArgs, Typed};
use crate::failure::Failure;
use crate::parse;
use crate::parts::{self, InParts, PartArgs};
use crate::terminal::{self, Lines, number};

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
    #[arg(long, value_name = "WINDOW", default_value_t = Window::Hann, conflicts_with = "multitaper")]
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
    #[arg(long, value_name = "SHARE", default_value = "0.05", value_parser = parse::share)]
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

    fn fields(&self) -> &[PathBuf] {
        &self.fields
    }

    fn shared(&self) -> &EstimateArgs {
        &self.estimate
    }

    fn memory(&self) -> Option<u64> {
        self.averages.memory
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

    fn divided(&self, _n_sites: usize) -> Result<DividedRequest, Error> {
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

/// Runs the command, or a part of it.
pub fn run(typed: &Coherence) -> Result<(), Failure> {
    parts::run(typed, |found| match found {
        Combined::Coherence(found) => Some(*found),
        _ => None,
    })
}

impl Estimate for Found {
    const COMMAND: &'static str = "coherence";

    fn summary(&self, provenance: &Provenance) -> serde_json::Result<String> {
        CoherenceSummary::new(self, provenance).to_json()
    }

    fn arrays(&self, to: &dyn LabelledArrays) -> Result<(), Error> {
        coherence_arrays(self, to)
    }

    fn figures(&self, name: &str, style: &Style) -> Vec<Figure> {
        vec![plot::coherence(self, name, style)]
    }

    fn page(
        &self,
        name: &str,
        provenance: &Provenance,
        warnings: &[[String; 2]],
        style: &Style,
    ) -> serde_json::Result<String> {
        coherence_html(self, name, provenance, warnings, style)
    }

    fn warnings(&self) -> Vec<[String; 2]> {
        warnings(self)
    }

    fn lines(&self) -> String {
        lines(self)
    }
}

/// What was found, in words.
fn lines(found: &Found) -> String {
    let mut lines = Lines::new(terminal::width());
    let independence = &found.independence;
    lines.line(
        "averages",
        &format!(
            "records {}, segments {} of {} samples, tapers {}: {} effective realisations",
            independence.records,
            independence.segments,
            found.segment[0],
            independence.tapers,
            number(independence.effective)
        ),
    );
    gaps_line(&mut lines, found.segments_left.as_ref());
    let (Some(level), Some(above)) = (found.level(), found.above_level()) else {
        lines.line("significance", "none can be stated");
        return lines.text;
    };
    lines.line(
        "coherence",
        &format!(
            "{} of the cells are above {}, the level that {} exceed by chance",
            percent(above),
            number(level),
            percent(found.alpha)
        ),
    );
    let (time_unit, space_unit) = found.units();
    let resolved =
        |s: &&wavecascade::estimates::PhaseSpeed| s.velocity_error < 0.1 * s.velocity.abs();
    let speeds: Vec<f64> = found
        .speeds
        .iter()
        .filter(resolved)
        .map(|s| s.velocity)
        .collect();
    if let Some(first) = speeds.first() {
        let least = speeds.iter().fold(*first, |a, b| a.min(*b));
        let most = speeds.iter().fold(*first, |a, b| a.max(*b));
        lines.line(
            "phase velocity",
            &format!(
                "{} to {} {space_unit}/{time_unit}, where it is known to a tenth ({} frequencies)",
                number(least),
                number(most),
                speeds.len()
            ),
        );
    }
    lines.text
}

/// How many segments are left of sites that miss samples.
pub fn gaps_line(lines: &mut Lines, left: Option<&SegmentsLeft>) {
    let Some(left) = left.filter(|left| left.incomplete() > 0) else {
        return;
    };
    let [least, median] = left.least_and_median();
    lines.line(
        "gaps",
        &format!(
            "{} of {} sites lose segments: {median} of {} are left at the median, {least} at the least",
            left.incomplete(),
            left.left.len(),
            left.of,
        ),
    );
}

/// Of sites (or times) of which nothing is left.
pub fn gaps_warning(left: Option<&SegmentsLeft>, columns: &str) -> Option<[String; 2]> {
    const SHOWN: usize = 8;
    let left = left?;
    let empty = left.empty();
    let shown: Vec<String> = empty.iter().take(SHOWN).map(usize::to_string).collect();
    let more = if empty.len() > SHOWN { ", ..." } else { "" };
    (!empty.is_empty()).then(|| {
        [
            format!(
                "{} of {} {columns} miss samples in all {} segments and are left out: {}{more}",
                empty.len(),
                left.left.len(),
                left.of,
                shown.join(", "),
            ),
            "shorter segments (`--segment`) lose less to a gap; `cascade lomb` needs none".into(),
        ]
    })
}

/// What the user should know, each with what to do.
pub fn warnings(found: &Found) -> Vec<[String; 2]> {
    let mut warnings = Vec::new();
    warnings.extend(gaps_warning(found.segments_left.as_ref(), "sites"));
    let independence = &found.independence;
    if found
        .spectrum
        .column(found.reference)
        .iter()
        .all(|s| *s == 0.0)
    {
        warnings.push([
            format!(
                "the record of the reference, site {}, is silent: nothing is coherent with it",
                found.reference
            ),
            "compare with another site (`--reference`)".into(),
        ]);
    }
    if independence.is_transient() && independence.records < 2 {
        warnings.push([
            format!(
                "the record of the reference is a transient: its energy lies in a few of its parts \
                 (steadiness {}), and segments of one transient are not independent; no significance is \
                 stated",
                number(independence.steadiness)
            ),
            "name several records of the same sites, one a shot".into(),
        ]);
    }
    warnings
}
