//! `cascade analyze`: typed arguments to a request, the run, the files.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use wavecascade::analyze::{
    Analysis, Plan, Request, Results, ShortTime, TimeRange, Welch, plan, run as run_plan,
};
use wavecascade::arrays::Precision;
use wavecascade::budget::{Budget, Motion};
use wavecascade::field::{FileState, Note, OpenOptions, TimeColumn, is_run_file};
use wavecascade::plot::{Format, draw_all};
use wavecascade::report::{
    Archive, ClosureSummary, Doubt, Provenance, ResultDirectory, RunFile, Summary, html,
    write_budget_arrays, write_small_arrays,
};
use wavecascade::{Error, Field};

use crate::advice;
use crate::args::{Analyze, FigureArg, Input, ResultArg};
use crate::effect::refuse_without_effect;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::view_args::request_of;
use crate::{budget, terminal};

/// Runs the command.
pub fn run(typed: Analyze) -> Result<(), Failure> {
    let options = open_options(&typed.input, typed.work.memory);
    let pictures = formats(&typed.output.figures)?;
    refuse_without_effect(&typed)?;
    let request = request(&typed, !pictures.is_empty());
    let out = typed
        .out
        .clone()
        .unwrap_or_else(|| default_out(&typed.field));
    let show = !typed.output.quiet && std::io::stderr().is_terminal();
    let progress = Progress::new(show);

    if typed.work.plan {
        let field = Field::open(
            &typed.field,
            &OpenOptions {
                hash: false,
                ..options
            },
        )?;
        print_notes(&field, typed.output.quiet);
        return print_plan(&plan(&field, &request)?, typed.output.json);
    }
    let started = Instant::now();
    use_threads(request.threads)?;
    // Before any work: could the result be written?
    drop(ResultDirectory::create(&out, typed.force)?);
    // A long file is hashed first, where it can be interrupted; a short one beside the work.
    let hash_first = is_long(&typed.field);
    if hash_first {
        progress.wait("reading the field");
    }
    let options = OpenOptions {
        hash: hash_first,
        ..options
    };
    let field = Field::open(&typed.field, &options)?;
    let plan = plan(&field, &request).map_err(|error| error.of_file(&typed.field))?;

    progress.begin_writing();
    let directory = ResultDirectory::create(&out, typed.force)?;
    let archive = Archive::create(&directory.path().join("spectra.npz"), request.precision)?;
    // Threads that are idle in a pass help with the hash.
    let (analysis, hash) = rayon::join(
        || run_plan(&field, &plan, &archive, &progress),
        || match hash_first {
            true => Ok(None),
            false => field.file_hash(!plan.streams()),
        },
    );
    let mut analysis = analysis.map_err(|error| error.of_file(&typed.field))?;
    analysis.content_hash = analysis.content_hash.or(hash?);
    let opened = field.file_state();
    let read_as = conclusions(&field);
    // Unmapping a file takes about as long as writing the remaining results.
    let (written, ()) = rayon::join(
        || {
            write_small_arrays(&analysis, &archive)?;
            archive.finish()
        },
        || drop(field),
    );
    written?;
    progress.check()?;

    let words = std::env::args_os();
    let command = words.map(|w| w.to_string_lossy().into_owned()).collect();
    let input = typed.field.display().to_string();
    let provenance = Provenance {
        read_as,
        ..Provenance::new(command, Some(input), analysis.content_hash.clone())
    };
    let (budget, closure) = budget(&typed, &directory, &progress)?;
    // All that reads or hashes the file has done so.
    opened.as_ref().map_or(Ok(()), FileState::check)?;
    let json = Summary::new(&analysis, &provenance)
        .with_advice(&advised)
        .with_closure(closure)
        .to_json()
        .map_err(std::io::Error::from)?;
    directory.write("summary.json", &json)?;
    if !pictures.is_empty() {
        draw(&analysis, &pictures, &directory, &progress)?;
        if let Some(budget) = &budget {
            budget::draw(budget, &analysis.name, &pictures, &directory, "budget.html")?;
        }
    }
    progress.check()?;
    let published = directory.publish()?;
    progress.clear();
    let told = Told {
        analysis: &analysis,
        read_as: &provenance.read_as,
        json: &json,
        published: &published,
    };
    tell(&typed, &told, started)
}

/// The budgets of a field that carries its chain, from its samples, and how far they close.
fn budget(
    typed: &Analyze,
    directory: &ResultDirectory,
    progress: &Progress,
) -> Result<(Option<Budget>, ClosureSummary), Failure> {
    let undefined = |reason: &str| Ok((None, ClosureSummary::undefined(reason)));
    let only = &typed.work.only;
    if !(only.is_empty() || only.contains(&ResultArg::Budget)) {
        return undefined("not asked for");
    }
    if !is_run_file(&typed.field) {
        return undefined("the field carries no chain");
    }
    let file = RunFile::read(&typed.field)?;
    if file.run.displacement.is_none() {
        return undefined("the run recorded no displacements");
    }
    let archive = Archive::create(&directory.path().join("budget.npz"), Precision::F64)?;
    let request = request_of(&file.setup);
    let motion = Motion::of(&file.run)?;
    let budget = match wavecascade::budget::run(&motion, &request, &archive, progress) {
        Err(error @ Error::Request { .. }) => {
            drop(archive);
            let path = directory.path().join("budget.npz");
            std::fs::remove_file(path)?;
            return undefined(&error.to_string());
        }
        done => done?,
    };
    write_budget_arrays(&budget, &archive)?;
    archive.finish()?;
    let closure = ClosureSummary::of(&budget.closure);
    Ok((Some(budget), closure))
}

/// Draws figures and the report in parallel.
fn draw(
    analysis: &Analysis,
    formats: &[Format],
    directory: &ResultDirectory,
    progress: &Progress,
) -> Result<(), Failure> {
    use wavecascade::observer::Observer;
    progress.stage("drawing", 1);
    let figures = directory.path().join("figures");
    let (drawn, page) = rayon::join(
        || draw_all(analysis, &figures, formats),
        || directory.write("report.html", html(analysis, &advised)),
    );
    drawn?;
    page?;
    Ok(())
}

/// The analysis and the path of its results, for the summary.
struct Told<'a> {
    analysis: &'a Analysis,
    read_as: &'a [String],
    json: &'a str,
    published: &'a Path,
}

fn tell(typed: &Analyze, told: &Told, started: Instant) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    if typed.output.json {
        writeln!(out, "{}", told.json)?;
        return Ok(());
    }
    if typed.output.quiet {
        return Ok(());
    }
    write!(
        out,
        "{}",
        terminal::summary(told.analysis, told.read_as, terminal::width())
    )?;
    let report = told.published.join("report.html");
    let main = if report.exists() {
        report
    } else {
        told.published.join("summary.json")
    };
    let seconds = started.elapsed().as_secs_f64();
    writeln!(out, "done in {seconds:.2} s; open {}", main.display())?;
    Ok(())
}

fn print_plan(plan: &Plan, json: bool) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    if json {
        let text = serde_json::to_string_pretty(&plan.describe()).map_err(std::io::Error::from)?;
        writeln!(out, "{text}")?;
    } else {
        write!(out, "{}", terminal::plan(plan, terminal::width()))?;
    }
    Ok(())
}

/// How a field was read where nothing states it and nothing speaks against it.
fn conclusions(field: &Field) -> Vec<String> {
    let settled = field.notes.iter().filter(|note| !note.is_doubtful());
    let in_words = |note: &Note| match advice::of_note(note) {
        Some(advice) => format!("{}; {advice}", note.message()),
        None => note.message(),
    };
    settled.map(in_words).collect()
}

/// What to do about a doubt of an analysis.
fn advised(doubt: Doubt) -> Option<String> {
    Some(match doubt {
        Doubt::Warning(warning) => advice::of_warning(warning).into(),
        Doubt::Unresolved(reason) => advice::of_unresolved(reason),
    })
}

/// Prints to standard error how a field was read.
pub fn print_notes(field: &Field, quiet: bool) {
    if quiet {
        return;
    }
    for note in &field.notes {
        let kind = match note.is_doubtful() {
            true => "warning",
            false => "note",
        };
        eprintln!("{kind}: {}", note.message());
        if let Some(advice) = advice::of_note(note) {
            eprintln!("help: {advice}");
        }
    }
}

/// `field-cascade` of `field.npy`; of other files with their extension.
fn default_out(field: &Path) -> PathBuf {
    named_after(field, "npy", "-cascade")
}

/// A name here after that of a file; its extension is left out if it is the `usual` one, so that files
/// that differ in it do not share a name.
pub fn named_after(file: &Path, usual: &str, ending: &str) -> PathBuf {
    let is_usual = file.extension().is_none_or(|extension| extension == usual);
    let name = match is_usual {
        true => file.file_stem(),
        false => file.file_name(),
    };
    let mut name = name.unwrap_or("field".as_ref()).to_owned();
    name.push(ending);
    name.into()
}

/// The formats typed, each once.
pub fn formats(typed: &[FigureArg]) -> Result<Vec<Format>, Failure> {
    let typed_any = |f: &FigureArg| typed.contains(f);
    let known = [(FigureArg::Png, Format::Png), (FigureArg::Svg, Format::Svg)];
    let chosen: Vec<Format> = known
        .into_iter()
        .filter_map(|(typed, format)| typed_any(&typed).then_some(format))
        .collect();
    if typed_any(&FigureArg::None) && !chosen.is_empty() {
        return Err(Failure::Library(Error::Request {
            option: "figures",
            expected: "formats, or none alone".into(),
            found: "both".into(),
        }));
    }
    Ok(chosen)
}

/// Whether reading the file once is slow enough to show progress.
fn is_long(field: &Path) -> bool {
    const A_WHILE: u64 = 256 << 20;
    std::fs::metadata(field).is_ok_and(|file| file.len() > A_WHILE)
}

/// Limits the global pool, which hashes and draws, to `threads` threads.
pub fn use_threads(threads: Option<usize>) -> Result<(), Failure> {
    let Some(threads) = threads else {
        return Ok(());
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    Ok(pool.build_global().map_err(|e| Error::Threads {
        threads,
        reason: e.to_string(),
    })?)
}

pub fn open_options(typed: &Input, memory: Option<u64>) -> OpenOptions {
    OpenOptions {
        layout: typed.layout.map(Into::into),
        dt: typed.dt,
        rate: typed.rate,
        dx: typed.dx,
        t0: typed.t0,
        x0: typed.x0,
        time_unit: typed.time_unit.clone(),
        space_unit: typed.space_unit.clone(),
        unit: typed.unit.clone(),
        quantity: typed.quantity.map(Into::into),
        member: typed.member.clone(),
        header: typed.header.map(Into::into).unwrap_or_default(),
        time_column: match typed.time_column.as_deref() {
            None => TimeColumn::Detect,
            Some("none") => TimeColumn::None,
            Some(text) => match text.parse() {
                Ok(index) => TimeColumn::Index(index),
                Err(_) => TimeColumn::Name(text.to_owned()),
            },
        },
        memory,
        hash: true,
    }
}

fn request(typed: &Analyze, draws: bool) -> Request {
    let (prepare, spectra, bands) = (&typed.preparation, &typed.spectra, &typed.bands);
    Request {
        results: results(&typed.work.only),
        sites: prepare.sites.clone(),
        times: match prepare.times {
            Some((from, to)) => TimeRange::Interval { from, to },
            None if prepare.until_arrival => TimeRange::UntilArrival {
                threshold: prepare.arrival_threshold,
            },
            None => TimeRange::All,
        },
        gaps: prepare.gaps.into(),
        detrend_field_mean: prepare.detrend_field.into(),
        detrend_space: prepare.detrend_space.into(),
        detrend_time: prepare.detrend_time.into(),
        window_time: spectra.window_time,
        window_space: spectra.window_space,
        scaling: spectra.scaling.into(),
        welch: spectra.segment.map(|segment| Welch {
            segment,
            overlap: spectra.overlap.map_or(segment / 2, |o| o.of(segment)),
        }),
        pad_time: spectra.pad_time,
        pad_space: spectra.pad_space,
        reference_site: bands.reference_site,
        reference_time: bands.reference_time,
        band_edge_frequency: bands.band_edge_frequency,
        band_edge_wavenumber: bands.band_edge_wavenumber,
        front_window: bands.front_window,
        noise: bands.noise,
        direction_band: bands.direction_band,
        maps: draws,
        short_time: ShortTime {
            sites: typed.short_time.short_time_sites.clone(),
            times: typed.short_time.short_time_times.clone(),
            segment: typed.short_time.short_time_segment,
            hop: typed.short_time.short_time_hop,
            segment_space: typed.short_time.short_space_segment,
            hop_space: typed.short_time.short_space_hop,
            window: typed.short_time.short_time_window,
        },
        precision: typed.work.precision.into(),
        threads: typed.work.threads.map(usize::from),
        memory: typed.work.memory,
    }
}

fn results(only: &[ResultArg]) -> Results {
    if only.is_empty() {
        return Results::ALL;
    }
    Results {
        temporal: only.contains(&ResultArg::Temporal),
        spatial: only.contains(&ResultArg::Spatial),
        spacetime: only.contains(&ResultArg::Spacetime),
        flux_surrogate: only.contains(&ResultArg::Flux),
        short_time: only.contains(&ResultArg::ShortTime),
    }
}
