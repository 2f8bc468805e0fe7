//! `cascade ridges`: dispersion read off S(k, f).

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use wavecascade::observer::Observer;
use wavecascade::plot::{self, Figure, Style};
use wavecascade::prepare::Window;
use wavecascade::report::{
    LabelledArrays, Provenance, RidgesSummary, percent, ridges_arrays, ridges_csv, ridges_html,
};
use wavecascade::ridges::{
    RidgeCut, RidgeLaw, RidgeParameter, RidgePoint, Ridges as Found, RidgesRequest, ridges,
};
use wavecascade::{Error, Field};

use crate::advice;
use crate::args::{DetrendArg, GapsArg};
use crate::estimate::{Computation, Estimate, EstimateArgs, Typed, alone};
use crate::parse;
use crate::summary::{Summary, with_half};
use crate::terminal::number;

/// What `cascade ridges` takes.
#[derive(Debug, Args)]
pub struct Ridges {
    /// File with the field; several, or patterns such as `'shot*.npy'`, are repeated records of the same sites,
    /// whose spectra are averaged.
    #[arg(required = true, value_name = "FIELD")]
    pub fields: Vec<PathBuf>,

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
    #[arg(long, value_name = "WINDOW", default_value_t = Window::Hann)]
    pub window_time: Window,
    /// Taper along space; none for sites around a ring, whose waves fit.
    #[arg(long, value_name = "WINDOW", default_value_t = Window::Hann)]
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
    #[arg(long, value_name = "SHARE", default_value = "0.01", value_parser = parse::share)]
    pub significance: f64,
    /// Working memory, such as 500MB or 2GiB [default: half of the free memory].
    #[arg(long, value_name = "SIZE", value_parser = parse::bytes)]
    pub memory: Option<u64>,
}

/// `--cut`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CutArg {
    /// Both, each where it is sharper; without a window along space, at each wavenumber.
    Auto,
    /// At each frequency, along k.
    Frequency,
    /// At each wavenumber, along f.
    Wavenumber,
}

impl Typed for Ridges {
    type Found = Found;

    fn fields(&self) -> &[PathBuf] {
        &self.fields
    }

    fn shared(&self) -> &EstimateArgs {
        &self.estimate
    }

    fn memory(&self) -> Option<u64> {
        self.search.memory
    }

    fn computation(&self) -> Result<impl Computation<Found>, Error> {
        let search = &self.search;
        let laws = self.fit.iter().map(|text| RidgeLaw::parse(text));
        let request = RidgesRequest {
            segment: search.segment,
            overlap: search
                .overlap
                .zip(search.segment)
                .map(|(overlap, segment)| overlap.of(segment)),
            window_time: search.window_time,
            window_space: search.window_space,
            detrend: search.detrend.into(),
            gaps: search.gaps.into(),
            cut: match search.cut {
                CutArg::Auto => None,
                CutArg::Frequency => Some(RidgeCut::Frequency),
                CutArg::Wavenumber => Some(RidgeCut::Wavenumber),
            },
            alpha: search.significance,
            range: search.range,
            fewest: search.points,
            laws: laws.collect::<Result<_, Error>>()?,
            threads: self.estimate.threads(),
            memory: search.memory,
        };
        Ok(move |fields: &[&Field], observer: &dyn Observer| ridges(fields, &request, observer))
    }
}

impl Estimate for Found {
    const COMMAND: &'static str = "ridges";

    fn summary(&self, provenance: &Provenance) -> serde_json::Result<String> {
        RidgesSummary::new(self, provenance).to_json()
    }

    fn arrays(&self, to: &dyn LabelledArrays) -> Result<(), Error> {
        ridges_arrays(self, to)
    }

    fn write_beside(&self, directory: &Path) -> Result<(), Error> {
        let path = directory.join("ridges.csv");
        std::fs::write(&path, ridges_csv(self)).map_err(|source| Error::Write {
            path,
            action: "write",
            source,
        })
    }

    fn figures(&self, name: &str, style: &Style) -> Vec<Figure> {
        plot::ridges(self, name, style)
    }

    fn page(
        &self,
        name: &str,
        provenance: &Provenance,
        warnings: &[[String; 2]],
        style: &Style,
    ) -> serde_json::Result<String> {
        ridges_html(self, name, provenance, warnings, style)
    }

    fn warnings(&self) -> Vec<[String; 2]> {
        let of_spectrum = self.analysis.warnings.iter();
        let of_spectrum =
            of_spectrum.map(|warning| [warning.message(), advice::of_warning(warning).into()]);
        let single = self.is_single().then(|| alone(&self.independence, "field"));
        single.into_iter().chain(of_spectrum).collect()
    }

    fn answer(&self) -> String {
        answer(self)
    }

    fn tell(&self, summary: &mut Summary) {
        tell(self, summary);
    }
}

/// Points whose velocity is known to a tenth, at least, for one to be named.
const LEAST_KNOWN: usize = 5;
/// Spread of velocities that are one, over their median.
const ALIKE: f64 = 0.15;

/// A parameter of a fitted law with its standard error, if it has one.
fn parameter(p: &RidgeParameter) -> String {
    match p.error.is_finite() {
        true => format!(
            "{} = {} \u{b1} {}",
            p.name,
            number(p.value),
            number(p.error)
        ),
        false => format!("{} = {}", p.name, number(p.value)),
    }
}

/// The law, or the velocity, in words.
fn answer(found: &Found) -> String {
    if found.ridges.is_empty() {
        return "no ridge stands above the noise".into();
    }
    // Relative to the number of free points.
    let fits = found.fits.iter().filter(|fit| fit.deviation < 1.0);
    if let Some(fit) = fits.min_by(|a, b| a.reduced.total_cmp(&b.reduced)) {
        let parameters = fit.parameters.iter();
        let errors = match fit.parameters.iter().all(|p| p.error.is_finite()) {
            true => " (standard errors)",
            false => "",
        };
        return format!(
            "{} with {}{errors}, within {} bins",
            fit.name,
            parameters.map(parameter).collect::<Vec<_>>().join(", "),
            number(fit.deviation)
        );
    }
    let axes = &found.analysis.axes;
    let unit = format!("{}/{}", axes.space.space_unit(), axes.time.time_unit());
    let branches = match found.branches() {
        1 => "one branch".to_owned(),
        count => format!("{count} branches"),
    };
    if found.is_single() {
        let speeds = found.points().map(|p| p.group_velocity.abs());
        let mut speeds: Vec<f64> = speeds.filter(|speed| speed.is_finite()).collect();
        speeds.sort_by(f64::total_cmp);
        let middle = speeds.get(speeds.len() / 2);
        let around =
            middle.map(|speed| format!(", group velocity around {} {unit}", number(*speed)));
        return format!(
            "{branches}{}; of a single transient no error is stated",
            around.unwrap_or_default()
        );
    }
    let magnitudes = |of: fn(&RidgePoint) -> [f64; 2]| {
        let known = found.points().map(of);
        let known = known.filter(|[speed, error]| *error < 0.1 * speed.abs());
        let mut speeds: Vec<f64> = known.map(|[speed, _]| speed.abs()).collect();
        speeds.sort_by(f64::total_cmp);
        let at = |share: f64| speeds[(share * (speeds.len() - 1) as f64).round() as usize];
        (speeds.len() >= LEAST_KNOWN).then(|| [0.05, 0.5, 0.95].map(at))
    };
    // Folded wavenumbers have other phase velocities, but the same group velocity.
    let group = magnitudes(|p| [p.group_velocity, p.group_velocity_error]);
    let is_one = |[low, middle, high]: &[f64; 3]| high - low < ALIKE * middle;
    if let Some([low, middle, high]) = group.filter(is_one) {
        let [forwards, backwards] = [1.0, -1.0].map(|sign| {
            let signed = found.points().filter(|p| sign * p.group_velocity > 0.0);
            signed.count()
        });
        let ways = match (forwards, backwards) {
            (_, 0) => "towards +x",
            (0, _) => "towards -x",
            (plus, minus) if minus * 20 < plus => "towards +x",
            (plus, minus) if plus * 20 < minus => "towards -x",
            _ => "both ways",
        };
        let speed = with_half(middle, 0.5 * (high - low), &unit);
        return format!("waves {ways} at a group velocity of {speed} ({branches})");
    }
    match (
        group,
        magnitudes(|p| [p.phase_velocity, p.phase_velocity_error]),
    ) {
        (Some([low, _, high]), _) => format!(
            "{branches}, group velocity from {} to {} {unit}",
            number(low),
            number(high)
        ),
        (None, Some([low, _, high])) => format!(
            "{branches}, phase velocity from {} to {} {unit}",
            number(low),
            number(high)
        ),
        (None, None) => format!("{branches}, no velocity of which is known to a tenth"),
    }
}

fn tell(found: &Found, summary: &mut Summary) {
    if !found.ridges.is_empty() {
        let text = format!(
            "{} of {} branches with {} points above {} times the noise",
            found.ridges.len(),
            found.branches(),
            found.points().count(),
            number(found.level)
        );
        summary.fact("ridges", &text);
    }
    for fit in &found.fits {
        let parameters = fit.parameters.iter();
        let parameters = parameters.map(parameter);
        let text = format!(
            "{}: {}; deviation {} bins, reduced chi-square {}",
            fit.name,
            parameters.collect::<Vec<_>>().join(", "),
            number(fit.deviation),
            number(fit.reduced)
        );
        summary.fact("fit", &text);
    }
    let conventions = &found.analysis.conventions;
    summary.detail(
        "spectrum",
        &format!(
            "records {}, segments {} of {} samples: {} effective realisations",
            found.records,
            conventions.segments,
            conventions.segment,
            number(found.realisations)
        ),
    );
    let text = match found.is_single() {
        true => format!("{} times the background", number(found.level)),
        false => format!(
            "{} times the noise, which noise exceeds anywhere with probability {}",
            number(found.level),
            percent(found.alpha)
        ),
    };
    summary.detail("level", &text);
}
