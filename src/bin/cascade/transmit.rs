//! `cascade transmit`: what comes through a chain, against its make.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use wavecascade::Error;
use wavecascade::attenuation::{
    Compared, MeasuredPoint, Transmission, TransmissionCurve, TransmissionPoint,
    TransmissionRequest, measured_peaks, read_curve,
};
use wavecascade::chain::scene::{SceneSource, Units};
use wavecascade::observer::Observer;
use wavecascade::plot::Overlay;
use wavecascade::report::{
    TRANSMISSION_SCHEMA, transmission_csv, transmission_html, transmission_snippet, versioned_json,
    write_beside,
};

use crate::analyze::{print_notes, use_threads};
use crate::attenuate::{compared_line, default_over, failure_lines, without_arrival_line};
use crate::chain_args::How;
use crate::estimates::subject_of;
use crate::failure::Failure;
use crate::figure_args::FigureArgs;
use crate::progress::Progress;
use crate::saved::Saved;
use crate::scene_keys::SceneKeys;
use crate::summary::Summary;
use crate::table::Table;
use crate::terminal::{self, number};

/// What `cascade transmit` takes.
#[derive(Debug, Args)]
pub struct Transmit {
    /// File with the scene; without one, the options state all keys.
    pub scene: Option<PathBuf>,

    /// The key that is the abscissa and its numbers, as for `cascade sweep`: angle=2:90:45 (equal
    /// steps), stiffness_ratio=1:100:45log (equal ratios) [default: these, with and without a
    /// material].
    #[arg(long, value_name = "KEY=VALUES")]
    pub over: Option<String>,

    /// Another key and its values, a curve for each: striker_velocity=0.5,1,2 or sites=21,41,81 or
    /// tangent=0,1e-6. Repeat it for all combinations.
    #[arg(long, value_name = "KEY=VALUES")]
    pub vary: Vec<String>,

    /// Leave out the search for the extremes between the values.
    #[arg(long)]
    pub no_extremes: bool,

    /// A measured curve (.csv: key, relative force, standard error if known) to lay over the
    /// first one, or VALUE=FIELD, a velocity field measured at this value of the key, times counted
    /// from the impact on: largest velocity and arrival (half of it) at the last site are compared.
    #[arg(long, value_name = "FILE")]
    pub measured: Option<String>,

    /// Directory for the results: transmission.json, curves.csv, the figure transmission,
    /// report.html, and the finished chains, so that an interrupted run resumes. Without it nothing is saved.
    #[arg(long, short, value_name = "DIR")]
    pub out: Option<PathBuf>,

    #[command(flatten)]
    pub figures: FigureArgs,

    #[command(flatten)]
    pub how: How,

    #[command(flatten)]
    pub keys: SceneKeys,
}

/// All that is printed and kept.
#[derive(Debug, Serialize)]
pub struct TransmissionReport {
    #[serde(flatten)]
    pub transmission: Transmission,
    /// Relative forces, or of a field the largest velocity of the last site.
    measured: Vec<Compared>,
    /// Of a field: when that velocity is half of its largest for the last time before it.
    measured_arrivals: Vec<Compared>,
    /// Its value of the key, where there is a velocity but no arrival, measured or computed.
    measured_without_arrival: Vec<f64>,
    #[serde(skip)]
    laid_over: MeasuredForces,
}

impl TransmissionReport {
    /// `report.html`.
    pub fn page(&self) -> String {
        transmission_html(&self.transmission, self.laid_over.laid_over())
    }

    /// # Errors
    /// None for results of this program.
    pub fn to_json(&self) -> serde_json::Result<String> {
        versioned_json(TRANSMISSION_SCHEMA, self)
    }
}

impl Transmit {
    /// Follows the pulse through the chains of `scene` with the typed keys, and lays measured forces beside it.
    pub fn find(
        &self,
        scene: SceneSource,
        observer: &dyn Observer,
    ) -> Result<TransmissionReport, Error> {
        let scene = scene.with(self.keys.settings.clone());
        let over = match &self.over {
            Some(over) => over.clone(),
            None => default_over(&scene)?,
        };
        let measured = MeasuredForces::read(self.measured.as_deref(), self.how.quiet)?;
        let request = TransmissionRequest {
            also: measured.values(),
            vary: self.vary.clone(),
            locate: !self.no_extremes,
            ..TransmissionRequest::new(scene, over)
        };
        let transmission = request.run(self.out.as_deref(), observer)?;
        let [compared, measured_arrivals] = measured.beside(transmission.curves.first());
        let measured_without_arrival = match (&measured, compared.as_slice()) {
            (MeasuredForces::Field { .. }, [velocity]) if measured_arrivals.is_empty() => {
                vec![velocity.measured.at]
            }
            _ => Vec::new(),
        };
        Ok(TransmissionReport {
            measured: compared,
            measured_arrivals,
            measured_without_arrival,
            transmission,
            laid_over: measured,
        })
    }
}

/// Measured forces.
#[derive(Debug)]
enum MeasuredForces {
    Nothing,
    Curve(Vec<MeasuredPoint>),
    /// At the last site.
    Field {
        velocity: MeasuredPoint,
        arrival: Option<MeasuredPoint>,
    },
}

impl MeasuredForces {
    fn read(typed: Option<&str>, quiet: bool) -> Result<MeasuredForces, Error> {
        let Some(typed) = typed else {
            return Ok(MeasuredForces::Nothing);
        };
        let with_value = typed.split_once('=');
        let with_value = with_value.and_then(|(v, path)| Some((v.parse::<f64>().ok()?, path)));
        let Some((at, path)) = with_value else {
            return Ok(MeasuredForces::Curve(read_curve(Path::new(typed))?));
        };
        let options = wavecascade::field::OpenOptions::default();
        let field = wavecascade::Field::open(path, &options)?;
        print_notes(&field, quiet);
        let last = measured_peaks(&field).last().copied();
        field.check_unchanged()?;
        let Some(peak) = last.filter(|peak| peak.site + 1 == field.n_sites()) else {
            return Err(Error::Unfit {
                path: path.into(),
                expected: "a field with a pulse at its last site".into(),
                found: "none there".into(),
            });
        };
        let (velocity, arrival) = peak.points(at);
        Ok(MeasuredForces::Field { velocity, arrival })
    }

    fn values(&self) -> Vec<f64> {
        match self {
            MeasuredForces::Nothing => Vec::new(),
            MeasuredForces::Curve(points) => points.iter().map(|p| p.at).collect(),
            MeasuredForces::Field { velocity, .. } => vec![velocity.at],
        }
    }

    /// Beside the points of a curve: forces or velocities, and arrivals.
    fn beside(&self, curve: Option<&TransmissionCurve>) -> [Vec<Compared>; 2] {
        let point = |at: f64| curve?.points.iter().find(|p| p.value == at);
        let forces = |m: &MeasuredPoint| Some(m.compared_with(point(m.at)?.relative_force));
        match self {
            MeasuredForces::Nothing => [Vec::new(), Vec::new()],
            MeasuredForces::Curve(points) => {
                [points.iter().filter_map(forces).collect(), Vec::new()]
            }
            MeasuredForces::Field { velocity, arrival } => {
                let pulse = point(velocity.at).map(|p| p.pulse);
                let speed = pulse.map(|p| p.peak_velocity.value);
                let arrived = pulse.and_then(|p| p.velocity_rise_time).map(|t| t.value);
                [(Some(velocity), speed), (arrival.as_ref(), arrived)]
                    .map(|(m, c)| m.zip(c).map(|(m, c)| m.compared_with(c)))
                    .map(|compared| compared.into_iter().collect())
            }
        }
    }

    fn laid_over(&self) -> Overlay<'_> {
        match self {
            MeasuredForces::Nothing => Overlay::Nothing,
            MeasuredForces::Curve(points) => Overlay::Forces(points),
            MeasuredForces::Field { velocity, arrival } => {
                Overlay::Field([std::slice::from_ref(velocity), arrival.as_slice()])
            }
        }
    }
}

/// Runs the command.
pub fn run(typed: Transmit) -> Result<(), Failure> {
    typed
        .figures
        .refuse_without(typed.out.is_some(), "`--out`")?;
    let drawing = typed.figures.drawing()?;
    use_threads(typed.how.threads.map(usize::from))?;
    let scene = match &typed.scene {
        Some(path) => SceneSource::read(path)?,
        None => SceneSource::default(),
    };
    let progress = Progress::new(!typed.how.quiet && std::io::stderr().is_terminal());
    progress.begin_writing();
    let result = typed.find(scene, &progress);
    progress.clear();
    let found = result?;
    let (transmission, measured) = (&found.transmission, &found.laid_over);
    let json = found.to_json().map_err(std::io::Error::from)?;
    let mut main = None;
    if let Some(out) = &typed.out {
        let csv = transmission_csv(transmission).map_err(std::io::Error::other)?;
        let page = found.page();
        let figure =
            wavecascade::plot::transmission(transmission, measured.laid_over(), &drawing.style);
        let saved = Saved {
            name: "transmission",
            json: &json,
            csv: &csv,
            page: &page,
        };
        main = Some(out.join(saved.keep(out, &drawing, &figure)?));
        let others = transmission.curves.first();
        let others = others.map_or(&[][..], |curve| &curve.settings);
        let others: Vec<&str> = others.iter().map(|(key, _)| &**key).collect();
        let snippet = transmission_snippet(&transmission.key, &others);
        write_beside(out, "plot.py", snippet.as_bytes())?;
    }
    if typed.how.json {
        writeln!(terminal::stdout(), "{json}")?;
    } else if !typed.how.quiet {
        let subject = match &typed.scene {
            Some(scene) => subject_of(std::slice::from_ref(scene)),
            None => "struck chains".into(),
        };
        let mut summary = told(&subject, &found);
        if let Some(main) = main {
            summary.last(&format!("open {}", main.display()));
        }
        summary.print(typed.how.detail.verbose)?;
    }
    match transmission.failed.len() {
        0 => Ok(()),
        failed => Err(Failure::Chains(failed)),
    }
}

/// The summary for the terminal.
fn told(subject: &str, found: &TransmissionReport) -> Summary {
    let transmission = &found.transmission;
    let mut summary = Summary::new(subject, &answer(transmission));
    for curve in &transmission.curves {
        curve_lines(&mut summary, transmission, curve);
    }
    let compared = found.measured.iter().map(|c| compared_line("measured", c));
    let arrivals = found.measured_arrivals.iter();
    let arrivals = arrivals.map(|c| compared_line("measured arrival", c));
    compared
        .chain(arrivals)
        .for_each(|line| summary.sentence(&line));
    if let Some([message, why]) = without_arrival_line(&found.measured_without_arrival) {
        summary.warning(&message, &why);
    }
    failure_lines(&transmission.failed)
        .iter()
        .for_each(|line| summary.sentence(line));
    for curve in &transmission.curves {
        summary.detailed_rows(points(transmission, curve));
    }
    summary.detailed_sentence("rel. force: relative to the homogeneous chain");
    if transmission.units == Units::Si {
        summary.detailed_sentence("times of flight in s, speeds in m/s");
    }
    summary
}

/// The least and the largest of all curves, in words.
fn answer(transmission: &Transmission) -> String {
    let key = transmission.key.replace('_', " ");
    let points = |curve: &TransmissionCurve| {
        let extremes = curve.extremes.iter().map(|extreme| extreme.point);
        let all: Vec<TransmissionPoint> = curve.points.iter().copied().chain(extremes).collect();
        all
    };
    let mut all: Vec<TransmissionPoint> = transmission.curves.iter().flat_map(points).collect();
    all.sort_by(|a, b| a.relative_force.total_cmp(&b.relative_force));
    match (all.first(), all.last()) {
        (Some(least), Some(most)) => format!(
            "force at the wall least at {key} {} ({} of the homogeneous chain's), largest at {} ({})",
            number(least.value),
            number(least.relative_force),
            number(most.value),
            number(most.relative_force)
        ),
        _ => "nothing comes through at any value".into(),
    }
}

/// Settings of a curve, or nothing.
fn settings_of(curve: &TransmissionCurve) -> String {
    let settings = curve.settings.iter();
    let settings: Vec<String> = settings
        .map(|(key, text)| format!("{key} = {text}"))
        .collect();
    settings.join(", ")
}

/// The extremes of a curve and its marks.
fn curve_lines(summary: &mut Summary, transmission: &Transmission, curve: &TransmissionCurve) {
    let key = transmission.key.replace('_', " ");
    let settings = settings_of(curve);
    if let Some(least) = curve.least().filter(|_| !settings.is_empty()) {
        summary.sentence(&format!(
            "{settings}: least {} of the force, at {key} {}",
            number(least.relative_force),
            number(least.value)
        ));
    }
    for extreme in &curve.extremes {
        let kind = match extreme.is_maximum {
            true => "maximum",
            false => "minimum",
        };
        summary.sentence(&format!(
            "{kind}, located to {}: {} of the force at {key} {}",
            number(extreme.value_error),
            number(extreme.point.relative_force),
            number(extreme.point.value)
        ));
    }
    for mark in &curve.localized {
        summary.sentence(&format!(
            "{key} {} carries the localized wave of order {}, ratio {}",
            number(mark.value),
            mark.order,
            number(mark.ratio)
        ));
    }
    if !curve.nothing_at.is_empty() {
        let at: Vec<String> = curve.nothing_at.iter().map(|at| number(*at)).collect();
        summary.sentence(&format!("nothing arrives at {key} {}", at.join(", ")));
    }
    for order in &curve.unresolved_orders {
        summary.sentence(&format!(
            "the localized wave of order {order} could not be resolved"
        ));
    }
}

/// All points of a curve.
fn points(transmission: &Transmission, curve: &TransmissionCurve) -> Table {
    let key = transmission.key.replace('_', " ");
    let mut table = Table::new(&key);
    for name in ["ratio", "rel. force", "flight", "speed"] {
        table = table.numbers(name);
    }
    let mut table = table.words("");
    let all = curve.points.iter().map(|point| (point, String::new()));
    let extremes = curve.extremes.iter().map(|extreme| {
        let kind = if extreme.is_maximum {
            "maximum"
        } else {
            "minimum"
        };
        (&extreme.point, kind.to_owned())
    });
    for (point, note) in all.chain(extremes) {
        table.row(vec![
            number(point.value),
            number(point.stiffness_ratio),
            format!("{:.6}", point.relative_force),
            number(point.time_of_flight.value),
            number(point.mean_speed),
            note,
        ]);
    }
    table
}
