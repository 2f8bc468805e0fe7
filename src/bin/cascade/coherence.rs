//! `cascade coherence`: all sites of a field against a reference.

use std::path::PathBuf;

use clap::{ArgGroup, Args};
use wavecascade::estimates::{
    Averaging, Coherence as Found, CoherenceRequest, Combined, Delay, DividedRequest, Independence,
    SegmentsLeft, Tapers, coherence,
};
use wavecascade::observer::Observer;
use wavecascade::plot::{self, Figure, Style};
use wavecascade::prepare::Window;
use wavecascade::report::{
    CoherenceSummary, LabelledArrays, Provenance, coherence_arrays, coherence_html, percent,
};
use wavecascade::{Error, Field};

use crate::args::{DetrendArg, GapsArg};
use crate::estimate::{Computation, Estimate, EstimateArgs, Typed, one_realisation};
use crate::failure::Failure;
use crate::parse;
use crate::parts::{self, InParts, PartArgs};
use crate::summary::{Summary, with_half};
use crate::terminal::number;

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

    fn answer(&self) -> String {
        answer(self)
    }

    fn tell(&self, summary: &mut Summary) {
        tell(self, summary);
    }
}

/// What follows the reference, in words.
fn answer(found: &Found) -> String {
    let reference = found.reference;
    if is_silent(found) {
        return format!("nothing can be told: the reference, site {reference}, is silent");
    }
    if found.level().is_none() {
        let why = match found.independence.is_transient() {
            true => found.independence.why(),
            false => "there are fewer than two independent realisations",
        };
        return format!("nothing can be told: {why}");
    }
    let coherent: Vec<usize> = found.coherent_sites().collect();
    let others = found.is_coherent.len() - 1;
    let share = match (coherent.as_slice(), others) {
        ([], _) => return format!("no site follows site {reference} above chance"),
        ([one], _) => format!("site {one}"),
        (all, others) if all.len() == others => format!("all {others} sites"),
        (some, others) => format!("{} of {others} sites", some.len()),
    };
    let (verb, are) = match coherent.len() {
        1 => ("follows", "is"),
        _ => ("follow", "are"),
    };
    let (time_unit, space_unit) = found.units();
    let confidence = percent_of(found.alpha);
    let known: Vec<Delay> = coherent.iter().filter_map(|j| found.delays[*j]).collect();
    if let Some(waves) = &found.velocity {
        let towards = if waves.velocity > 0.0 { "+x" } else { "-x" };
        let half = 0.5 * (waves.high - waves.low).abs();
        let velocity = with_half(
            waves.velocity.abs(),
            half,
            &format!("{space_unit}/{time_unit}"),
        );
        let of = match waves.is_dispersive {
            true => "by frequency".to_owned(),
            false => confidence,
        };
        let is_behind = |delay: &Delay| delay.ambiguity.is_none() && delay.delay > 0.0;
        let is_ahead = |delay: &Delay| delay.ambiguity.is_none() && delay.delay < 0.0;
        let are_known = known.len() == coherent.len();
        let follows = match (known.iter().all(is_behind), known.iter().all(is_ahead)) {
            (true, _) if are_known => format!("{share} {verb} site {reference}"),
            (_, true) if are_known => format!(
                "{share} {} site {reference}",
                verb.replace("follow", "precede")
            ),
            _ => format!("{share} {are} coherent with site {reference}"),
        };
        return format!("{follows}; waves travel towards {towards} at {velocity} ({of})");
    }
    let periods = known.iter().filter_map(|delay| delay.ambiguity);
    if let Some(period) = periods.reduce(f64::max) {
        return format!(
            "{share} {are} coherent with site {reference} in a narrow band: delays are known up to whole periods \
             of {} {time_unit}",
            number(period)
        );
    }
    let later = |sign: f64| {
        known
            .iter()
            .filter(move |delay| sign * delay.delay > delay.interval)
    };
    match (known.as_slice(), later(1.0).count(), later(-1.0).count()) {
        ([], ..) => format!("{share} {are} coherent with site {reference}, but by no single delay"),
        ([one], ..) if coherent.len() == 1 => {
            let delay = with_half(one.delay.abs(), one.interval, &time_unit);
            match one.delay.abs() > one.interval {
                true if one.delay > 0.0 => {
                    format!("{share} follows site {reference} by {delay} ({confidence})")
                }
                true => format!("{share} precedes site {reference} by {delay} ({confidence})"),
                false => {
                    format!("{share} moves with site {reference}, delay {delay} ({confidence})")
                }
            }
        }
        (_, 0, 0) => format!("{share} {are} coherent with site {reference}, without a delay"),
        (all, behind, ahead) => {
            let of = |range: fn(f64, f64) -> f64| {
                let delays = all.iter().map(|delay| delay.delay);
                number(delays.reduce(range).unwrap_or(f64::NAN))
            };
            let what = match ahead {
                0 => format!("{verb} site {reference}"),
                _ => format!(
                    "{are} coherent with site {reference}, {behind} behind it and {ahead} ahead"
                ),
            };
            format!(
                "{share} {what}, by {} to {} {time_unit}",
                of(f64::min),
                of(f64::max)
            )
        }
    }
}

/// `95 %`, by which an interval holds.
pub fn percent_of(alpha: f64) -> String {
    format!("{} %", 100.0 * ((1.0 - alpha) * 1e4).round() / 1e4)
}

fn is_silent(found: &Found) -> bool {
    let reference = found.spectrum.column(found.reference);
    reference.iter().all(|s| *s == 0.0)
}

fn tell(found: &Found, summary: &mut Summary) {
    if let (Some(level), Some(above)) = (found.level(), found.above_level()) {
        let text = format!(
            "{} of the cells are above {}, the level that {} exceed by chance",
            percent(above),
            number(level),
            percent(found.alpha)
        );
        summary.fact("coherence", &text);
    }
    let (time_unit, space_unit) = found.units();
    let digits = |x: f64| format!("{x:.6}");
    let known = found.coherent_sites();
    let known = known.filter_map(|j| Some((j, found.delays[j]?)));
    if let Some((site, delay)) = known.last() {
        let ambiguity = match delay.ambiguity {
            Some(period) => format!(", up to whole periods of {} {time_unit}", number(period)),
            None => String::new(),
        };
        let text = format!(
            "{} of site {site} at {} {space_unit}, from {} frequencies{ambiguity}",
            with_half(delay.delay, delay.interval, &time_unit),
            number(found.space.at(site)),
            delay.frequencies
        );
        summary.fact("delay", &text);
    }
    if let Some(waves) = &found.velocity {
        let by = match (waves.sites, waves.frequencies) {
            (Some(sites), _) => format!("the delays of {sites} sites"),
            (_, Some(1)) => "the phases at one frequency".into(),
            (_, frequencies) => format!("the phases at {} frequencies", frequencies.unwrap_or(0)),
        };
        let text = format!(
            "{} {space_unit}/{time_unit} ({} to {}), from {by}",
            digits(waves.velocity),
            digits(waves.low),
            digits(waves.high)
        );
        summary.detail("phase velocity", &text);
    }
    gaps_line(summary, found.segments_left.as_ref());
    summary.detail("averages", &averages(&found.independence, found.segment[0]));
}

/// What is averaged.
pub fn averages(independence: &Independence, segment: usize) -> String {
    format!(
        "records {}, segments {} of {segment} samples, tapers {}: {} effective realisations",
        independence.records,
        independence.segments,
        independence.tapers,
        number(independence.effective)
    )
}

/// How many segments are left of sites that miss samples.
pub fn gaps_line(summary: &mut Summary, left: Option<&SegmentsLeft>) {
    let Some(left) = left.filter(|left| left.incomplete() > 0) else {
        return;
    };
    let [least, median] = left.least_and_median();
    summary.fact(
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
            "shorter segments (`--segment`) lose less to a gap".into(),
        ]
    })
}

/// What the user should know, each with what to do.
pub fn warnings(found: &Found) -> Vec<[String; 2]> {
    let mut warnings = Vec::new();
    warnings.extend(gaps_warning(found.segments_left.as_ref(), "sites"));
    let independence = &found.independence;
    if is_silent(found) {
        warnings.push([
            format!(
                "the record of the reference, site {}, is silent",
                found.reference
            ),
            "compare with another site (`--reference`)".into(),
        ]);
    }
    warnings.extend(one_realisation(independence, "reference"));
    warnings
}
