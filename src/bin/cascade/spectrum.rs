//! `cascade spectrum`: power spectral densities of all sites, with intervals.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use wavecascade::estimates::{
    Averaging, Combined, DividedRequest, LeftOutEach, Line, NoiseSource, Peak, SpaceTimeRequest,
    SpectrumAxis, SpectrumEstimate, SpectrumRequest, Tapers, interval_factors, spectrum,
};
use wavecascade::observer::Observer;
use wavecascade::plot::{self, Figure, Style};
use wavecascade::prepare::Window;
use wavecascade::report::{
    LabelledArrays, Provenance, SpectrumSummary, percent, spectrum_arrays, spectrum_html,
};
use wavecascade::{Error, Field};

use crate::coherence::{AverageArgs, averages, gaps_line, gaps_warning};
use crate::estimate::{self, Computation, Estimate, EstimateArgs, Typed};
use crate::failure::Failure;
use crate::parse;
use crate::parts::{self, InParts, PartArgs};
use crate::spacetime::SpaceTime;
use crate::summary::Summary;
use crate::terminal::number;

/// What `cascade spectrum` takes.
#[derive(Debug, Args)]
pub struct Spectrum {
    /// File with the field; several, or patterns such as `'shot*.npy'`, are repeated records (shots) of the
    /// same sites, which are averaged.
    #[arg(required_unless_present = "merge", value_name = "FIELD")]
    pub fields: Vec<PathBuf>,

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

/// The axis of the records.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum AlongArg {
    Time,
    Space,
    Both,
}

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
    pub fn of_both(&self) -> SpaceTimeRequest {
        SpaceTimeRequest {
            averaging: self.averaging(),
            is_whole: self.periodogram,
            space: match (self.space_multitaper, self.space_window) {
                (Some((nw, count)), _) => Tapers::Slepian { nw, count },
                (None, Some(window)) => Tapers::Window(window),
                (None, None) if self.periodogram => Tapers::Window(Window::None),
                (None, None) => Tapers::Window(Window::Hann),
            },
            is_adaptive: !self.equal_weights,
            gaps: self.averages.gaps.into(),
            alpha: self.averages.significance,
            threads: self.estimate.threads(),
            memory: self.averages.memory,
        }
    }

    fn axis(&self) -> Option<SpectrumAxis> {
        match self.along {
            AlongArg::Time => Some(SpectrumAxis::Time),
            AlongArg::Space => Some(SpectrumAxis::Space),
            AlongArg::Both => None,
        }
    }

    /// Whether spectra are taken along both axes.
    pub fn is_both(&self) -> bool {
        self.axis().is_none()
    }

    fn request(&self) -> Result<SpectrumRequest, Error> {
        self.check()?;
        let Some(along) = self.axis() else {
            return Err(Error::Request {
                option: "along",
                expected: "one axis".into(),
                found: "both".into(),
            });
        };
        Ok(SpectrumRequest {
            along,
            averaging: self.averaging(),
            is_whole: self.periodogram,
            is_adaptive: !self.equal_weights,
            has_jackknife: !self.no_jackknife,
            gaps: self.averages.gaps.into(),
            subtract_noise: self.subtract_noise,
            alpha: self.averages.significance,
            threads: self.estimate.threads(),
            memory: self.averages.memory,
        })
    }

    /// That options of one axis are not typed for another.
    pub fn check(&self) -> Result<(), Error> {
        let is_both = self.is_both();
        let refuse = |option, expected: &str, found: &str| {
            Err(Error::Request {
                option,
                expected: expected.into(),
                found: found.into(),
            })
        };
        let along = "it with `--along both` alone";
        let has_tapers = self.averages.multitaper.is_some() || self.space_multitaper.is_some();
        match () {
            () if self.equal_weights && !has_tapers => refuse(
                "equal-weights",
                "it with `--multitaper` or `--space-multitaper`",
                "one taper, which has no weight",
            ),
            () if !is_both && self.space_window.is_some() => {
                refuse("space-window", along, "spectra along one axis")
            }
            () if !is_both && self.space_multitaper.is_some() => {
                refuse("space-multitaper", along, "spectra along one axis")
            }
            () if is_both && self.no_jackknife => refuse(
                "no-jackknife",
                "it with spectra along one axis",
                "`--along both`, which has none",
            ),
            () if is_both && self.subtract_noise => refuse(
                "subtract-noise",
                "it with spectra along one axis",
                "`--along both`",
            ),
            () => Ok(()),
        }
    }
}

impl Typed for Spectrum {
    type Found = SpectrumEstimate;

    fn fields(&self) -> &[PathBuf] {
        &self.fields
    }

    fn shared(&self) -> &EstimateArgs {
        &self.estimate
    }

    fn memory(&self) -> Option<u64> {
        self.averages.memory
    }

    fn computation(&self) -> Result<impl Computation<SpectrumEstimate>, Error> {
        let request = self.request()?;
        Ok(move |fields: &[&Field], observer: &dyn Observer| spectrum(fields, &request, observer))
    }
}

impl InParts for Spectrum {
    fn parts(&self) -> &PartArgs {
        &self.parts
    }

    /// Parts have no jackknife, and one axis.
    fn divided(&self) -> Result<DividedRequest, Error> {
        let request = SpectrumRequest {
            has_jackknife: false,
            ..self.request()?
        };
        Ok(request.into())
    }
}

/// Runs the command, or a part of it.
pub fn run(typed: Spectrum) -> Result<(), Failure> {
    let is_in_parts = typed.parts.part.is_some() || !typed.parts.merge.is_empty();
    if typed.is_both() && !is_in_parts {
        return estimate::run(&SpaceTime(typed));
    }
    parts::run(&typed, |found| match found {
        Combined::Spectrum(found) => Some(*found),
        Combined::Coherence(_) => None,
    })
}

impl Estimate for SpectrumEstimate {
    const COMMAND: &'static str = "spectrum";

    fn summary(&self, provenance: &Provenance) -> serde_json::Result<String> {
        SpectrumSummary::new(self, provenance).to_json()
    }

    fn arrays(&self, to: &dyn LabelledArrays) -> Result<(), Error> {
        spectrum_arrays(self, to)
    }

    fn figures(&self, name: &str, style: &Style) -> Vec<Figure> {
        vec![plot::spectrum(self, name, style)]
    }

    fn page(
        &self,
        name: &str,
        provenance: &Provenance,
        warnings: &[[String; 2]],
        style: &Style,
    ) -> serde_json::Result<String> {
        spectrum_html(self, name, provenance, warnings, style)
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

/// Places that are named at most.
const NAMED: usize = 3;

/// Which lines or peaks there are, in words.
fn answer(found: &SpectrumEstimate) -> String {
    let column = match found.along {
        SpectrumAxis::Time => "site",
        SpectrumAxis::Space => "time",
    };
    let unit = found.bin_unit();
    let lines = found
        .line_test
        .as_ref()
        .filter(|_| found.degrees_range().is_some());
    if let Some(test) = lines {
        let places = places(test.lines.iter().map(|line| (line.at, line.column)), found);
        return match test.lines.first() {
            None => format!("no line stands above chance at any {column}"),
            Some(first) => format!(
                "lines at {}; the surest of amplitude {}",
                named(&places, &unit, column),
                amplitude(first, found)
            ),
        };
    }
    match found.peaks() {
        None => format!(
            "no peak can be told from chance: {}",
            found.independence.why()
        ),
        Some(peaks) if peaks.is_empty() => {
            format!("no peak stands above the power on either side of it at any {column}")
        }
        Some(peaks) => {
            let places = places(
                peaks.iter().map(|peak: &Peak| (peak.at, peak.column)),
                found,
            );
            format!(
                "peaks at {}; the highest {} times the power beside it",
                named(&places, &unit, column),
                number(peaks[0].ratio)
            )
        }
    }
}

fn amplitude(line: &Line, found: &SpectrumEstimate) -> String {
    let unit = found.unit.as_deref().unwrap_or_default();
    let text = format!(
        "{} \u{b1} {} {unit}",
        number(line.amplitude),
        number(line.amplitude_error)
    );
    text.trim_end().to_owned()
}

/// Frequencies and how many sites have them, from frequencies of sites: those within two bins are one.
fn places(
    found: impl Iterator<Item = (f64, usize)>,
    of: &SpectrumEstimate,
) -> Vec<(f64, Vec<usize>)> {
    let near = 2.0 * (of.bins[1] - of.bins[0]);
    let mut places: Vec<(f64, Vec<usize>)> = Vec::new();
    for (at, column) in found {
        match places
            .iter_mut()
            .find(|(other, _)| (at - *other).abs() <= near)
        {
            Some((_, columns)) if columns.contains(&column) => {}
            Some((_, columns)) => columns.push(column),
            None => places.push((at, vec![column])),
        }
    }
    places
}

/// `50.00 and 100.0 Hz (64 and 3 sites)`.
fn named(places: &[(f64, Vec<usize>)], unit: &str, column: &str) -> String {
    let shown = &places[..places.len().min(NAMED)];
    let joined = |words: Vec<String>| match words.as_slice() {
        [one] => one.clone(),
        [all @ .., last] => format!("{} and {last}", all.join(", ")),
        [] => String::new(),
    };
    let at = joined(shown.iter().map(|(at, _)| number(*at)).collect());
    let counts = joined(
        shown
            .iter()
            .map(|(_, columns)| columns.len().to_string())
            .collect(),
    );
    let plural = if counts == "1" { "" } else { "s" };
    let more = match places.len() - shown.len() {
        0 => String::new(),
        more => format!(", and {more} more"),
    };
    format!("{at} {unit} ({counts} {column}{plural}){more}")
}

fn tell(found: &SpectrumEstimate, summary: &mut Summary) {
    let confidence = percent(1.0 - found.alpha);
    match found.degrees_range() {
        Some([least, median, most]) => {
            let [low, high] = interval_factors(median, found.alpha);
            let text = format!(
                "{confidence} from {} to {} of a value, {} degrees of freedom",
                number(low),
                number(high),
                range_of(least, median, most)
            );
            summary.fact("interval", &text);
        }
        None => summary.fact("interval", "none can be stated"),
    }
    gaps_line(summary, found.segments_left.as_ref());
    noise_line(summary, found);
    if let Some(test) = found
        .line_test
        .as_ref()
        .filter(|_| found.degrees_range().is_some())
        && let Some(first) = test.lines.first()
    {
        let (time_unit, space_unit) = found.units();
        let (columns, column_unit) = match found.along {
            SpectrumAxis::Time => ("sites", space_unit),
            SpectrumAxis::Space => ("times", time_unit),
        };
        let text = format!(
            "{} at {} {columns}, F above {}; the surest: amplitude {} at {} {} and {} {column_unit}",
            test.lines.len(),
            test.columns(),
            number(test.level_of_all),
            amplitude(first, found),
            number(first.at),
            found.bin_unit(),
            number(found.coordinate(first.column)),
        );
        summary.fact("lines", &text);
    }
    if found.degrees_range().is_some()
        && found.has_jackknife
        && found.left_out == LeftOutEach::Record
    {
        summary.detail(
            "jackknife",
            "over records, whose segments are not independent",
        );
    }
    summary.detail("averages", &averages(&found.independence, found.segment[0]));
}

/// A number with its range, where it has one: `28.52`, `11.75 (9.669 to 14.00)`.
pub fn range_of(least: f64, middle: f64, most: f64) -> String {
    match most - least < 1e-3 * middle {
        true => number(middle),
        false => format!("{} ({} to {})", number(middle), number(least), number(most)),
    }
}

/// How loud the noise is, and what of it was subtracted.
fn noise_line(summary: &mut Summary, found: &SpectrumEstimate) {
    let Some(noise) = &found.noise else { return };
    let Some(median) = noise.median() else {
        summary.fact(
            "noise",
            "none can be told: no site is quiet at first, or flat below Nyquist",
        );
        return;
    };
    let source = match median.source {
        NoiseSource::LeadIn { .. } => "before the motion arrives".to_owned(),
        NoiseSource::Top { from } => {
            format!(
                "where the spectrum is flat, from {} {}",
                number(from),
                found.bin_unit()
            )
        }
    };
    let unit = found.unit.as_ref();
    let unit = unit.map(|unit| format!(" ({unit})²/{}", found.bin_unit()));
    let unit = unit.unwrap_or_default();
    summary.fact(
        "noise",
        &format!(
            "at {} of {} sites, {source}: median {} ({} to {}){unit}",
            noise.known(),
            noise.sites.len(),
            number(median.density),
            number(median.low),
            number(median.high),
        ),
    );
    if let Some(left) = &noise.subtracted {
        let clipped: usize = left.clipped_bins.iter().sum();
        let bins = noise.known() * found.bins.len();
        let added: f64 = left.clipped_power.iter().sum();
        summary.fact(
            "subtracted",
            &format!(
                "{clipped} of {bins} bins were below the noise and are 0, which adds {} to the mean square of a \
                 site on average",
                number(added / noise.known() as f64),
            ),
        );
    }
}

/// What the user should know, each with what to do.
fn warnings(found: &SpectrumEstimate) -> Vec<[String; 2]> {
    let mut warnings = Vec::new();
    let columns = match found.along {
        SpectrumAxis::Time => "sites",
        SpectrumAxis::Space => "times",
    };
    let left = found.segments_left.as_ref();
    warnings.extend(gaps_warning(left, columns));
    // Those of which nothing is left are named already.
    let empty = left.map_or(0, |left| left.empty().len());
    let without = found.without_interval() - empty;
    if let Some(noise) = found
        .noise
        .as_ref()
        .filter(|noise| noise.subtracted.is_some())
    {
        let unknown = noise.sites.len() - noise.known();
        if unknown > 0 {
            warnings.push([
                format!(
                    "nothing is subtracted at {unknown} of {} sites, whose noise is not known",
                    noise.sites.len()
                ),
                "record from before the motion arrives, or sample fast enough that noise alone is left at the top"
                    .into(),
            ]);
        }
    }
    let filled = found.steadiness.iter().filter(|s| s.is_nan()).count();
    let without = without.saturating_sub(filled);
    let all = found.has_interval.len();
    if filled > 0 {
        warnings.push([
            format!(
                "of {filled} of {all} {columns} more than a twentieth of the samples were filled: no interval is stated"
            ),
            "leave out the segments that miss samples: `--gaps leave-out`".into(),
        ]);
    }
    if without > 0 {
        warnings.push(match found.along {
            SpectrumAxis::Time => [
                format!(
                    "{without} of {all} sites have a transient, which is one realisation: no interval is stated"
                ),
                "name several records of the same sites, one a shot".into(),
            ],
            SpectrumAxis::Space => [
                format!(
                    "{without} of {all} snapshots have their energy at a few sites: no interval is stated"
                ),
                "read the mean over the times, if it has an interval, or name several records, one a shot"
                    .into(),
            ],
        });
    }
    if let Some(mean) = &found.mean
        && mean.low.iter().all(|v| v.is_nan())
    {
        warnings.push([
            format!(
                "the mean over the times has no interval: energy changes (steadiness {}), or times are few",
                number(mean.steadiness)
            ),
            "analyse a part of the record in which it is steady".into(),
        ]);
    }
    warnings
}
