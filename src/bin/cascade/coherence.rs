//! `cascade coherence`: all sites of a field against a reference.

use std::io::{IsTerminal, Write};
use std::path::PathBuf;

use clap::Args;
use wavecascade::estimates::{Averaging, Coherence as Found, CoherenceRequest, Tapers, coherence};
use wavecascade::field::{FileState, OpenOptions};
use wavecascade::observer::Observer;
use wavecascade::prepare::Window;
use wavecascade::report::{
    CoherenceSummary, Provenance, ResultDirectory, coherence_html, percent, write_coherence,
};
use wavecascade::{Field, plot};

use crate::analyze::{named_after, open_options, print_notes, use_threads};
use crate::args::{DetrendArg, GapsArg, Input};
use crate::budget::command;
use crate::chain_args::How;
use crate::failure::Failure;
use crate::fields::expanded;
use crate::figure_args::FigureArgs;
use crate::parse;
use crate::progress::Progress;
use crate::terminal::{self, Lines, Tone, number};

/// What `cascade coherence` takes.
#[derive(Debug, Args)]
pub struct Coherence {
    /// File with the field; several, or patterns such as `'shot*.npy'`, are repeated records (shots) of the
    /// same sites, which are averaged.
    #[arg(required = true, value_name = "FIELD")]
    pub fields: Vec<PathBuf>,

    /// Index of the site that all others are compared with.
    #[arg(long, short, value_name = "SITE", default_value_t = 0)]
    pub reference: usize,

    /// Directory for the results; by default the field's name with `-coherence`, here.
    #[arg(long, short, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// Replace an existing result.
    #[arg(long)]
    pub force: bool,

    #[command(flatten)]
    pub averages: AverageArgs,
    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub figures: FigureArgs,
    #[command(flatten)]
    pub how: How,
}

/// How a record gives several realisations.
#[derive(Debug, Args)]
#[command(next_help_heading = "Averages")]
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

impl Coherence {
    pub fn request(&self) -> CoherenceRequest {
        CoherenceRequest {
            reference: self.reference,
            averaging: self.averages.averaging(),
            gaps: self.averages.gaps.into(),
            alpha: self.averages.significance,
            threads: self.how.threads.map(usize::from),
            memory: self.averages.memory,
        }
    }
}

/// Runs the command.
pub fn run(typed: Coherence) -> Result<(), Failure> {
    let drawing = typed.figures.drawing()?;
    let paths = expanded(&typed.fields)?;
    use_threads(typed.how.threads.map(usize::from))?;
    let default = || named_after(&paths[0], "npy", "-coherence");
    let out = typed.out.clone().unwrap_or_else(default);
    drop(ResultDirectory::create(&out, typed.force)?);
    let progress = Progress::new(!typed.how.quiet && std::io::stderr().is_terminal());
    let options = OpenOptions {
        hash: true,
        ..open_options(&typed.input, typed.averages.memory)
    };
    let mut fields = Vec::new();
    for path in &paths {
        let field = Field::open(path, &options)?;
        print_notes(&field, typed.how.quiet);
        fields.push(field);
    }
    let request = typed.request();
    let all: Vec<&Field> = fields.iter().collect();
    let found = coherence(&all, &request, &progress);
    let found = found.map_err(|error| error.of_file(&paths[0]))?;
    let opened: Vec<FileState> = fields.iter().filter_map(Field::file_state).collect();
    let hash = fields[0].content_hash.clone();
    drop(fields);
    progress.begin_writing();
    let directory = ResultDirectory::create(&out, typed.force)?;
    opened.iter().try_for_each(FileState::check)?;
    let input = paths[0].display().to_string();
    let provenance = Provenance::new(command(), Some(input), hash);
    let json = CoherenceSummary::new(&found, &provenance).to_json();
    let json = json.map_err(std::io::Error::from)?;
    directory.write("summary.json", &json)?;
    write_coherence(&directory.path().join("coherence.npz"), &found)?;
    let warnings = warnings(&found);
    if drawing.is_wanted() {
        progress.stage("drawing", 1);
        let name = paths[0].file_stem().unwrap_or_default().to_string_lossy();
        let figure = plot::coherence(&found, &name, &drawing.style);
        plot::save_all(
            &[figure],
            &directory.path().join("figures"),
            &drawing.formats,
        )?;
        let page = coherence_html(&found, &name, &provenance, &warnings, &drawing.style);
        directory.write("report.html", page.map_err(std::io::Error::from)?)?;
    }
    progress.check()?;
    let published = directory.publish()?;
    progress.clear();
    if !typed.how.quiet {
        for [message, advice] in &warnings {
            terminal::message(Tone::Warning, message);
            terminal::message(Tone::Help, advice);
        }
    }
    let mut stdout = terminal::stdout();
    if typed.how.json {
        writeln!(stdout, "{json}")?;
    } else if !typed.how.quiet {
        write!(stdout, "{}", lines(&found))?;
        let main = match drawing.is_wanted() {
            true => "report.html",
            false => "summary.json",
        };
        writeln!(stdout, "open {}", published.join(main).display())?;
    }
    Ok(())
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

/// What the user should know, each with what to do.
pub fn warnings(found: &Found) -> Vec<[String; 2]> {
    let mut warnings = Vec::new();
    let independence = &found.independence;
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
