//! `cascade analyze`: typed arguments to a request, the run, the files.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use wavecascade::analyze::{
    Analysis, Request, Results, ShortTime, TimeRange, Welch, plan, run as run_plan,
};
use wavecascade::budget::answer_of_run;
use wavecascade::field::{FileState, Note, OpenOptions, TimeColumn, is_run_file};
use wavecascade::report::{
    ArrayFormat, Provenance, ResultDirectory, RunFile, analysis_snippet, label_analysis,
    records_table, write_beside,
};
use wavecascade::sheet::{Describe, Sheet};
use wavecascade::{Error, Field};

use crate::args::{Analyze, Input, ResultArg};
use crate::described::Described;
use crate::failure::Failure;
use crate::further;
use crate::progress::Progress;
use crate::scan_args::folder_name;
use crate::show_args::AxisUnits;
use crate::summary::Summary;
use crate::terminal::{Tone, print_json};
use crate::words::{as_text, quoted};
use crate::{dispersion, terminal};

/// One field to analyze.
pub struct Task<'a> {
    pub typed: &'a Analyze,
    pub field: &'a Path,
    /// The same, or all files of a scan.
    pub files: &'a [PathBuf],
    pub out: &'a Path,
    /// Whether an earlier result may be replaced.
    pub replace: bool,
    pub progress: &'a Progress,
}

/// A field that has been analyzed.
pub struct Finished {
    pub analysis: Analysis,
    sheet: Sheet<'static>,
    pub json: String,
    /// The file to open first, in the directory of the results.
    pub main: PathBuf,
    /// Whether the field is that of a run.
    is_run: bool,
}

/// Runs the command on one field.
pub fn run(typed: &Analyze, files: &[PathBuf]) -> Result<(), Failure> {
    let field = files[0].as_path();
    if typed.work.plan {
        return print_plan(typed, files);
    }
    let started = Instant::now();
    // `field-cascade` of `field.npy`; of other files with their extension.
    let usual = || match typed.scan.position_from {
        Some(_) => named_after(&folder_name(field), "npy", "-cascade"),
        None => named_after(field, "npy", "-cascade"),
    };
    let out = typed.out.clone().unwrap_or_else(usual);
    let task = Task {
        typed,
        field,
        files,
        out: &out,
        replace: typed.force,
        progress: &Progress::new(!typed.output.quiet),
    };
    let finished = task.run()?;
    tell(typed, &finished, field, started)?;
    typed.figures.present.run(&finished.main)
}

impl Task<'_> {
    /// From the field to its directory of results.
    pub fn run(&self) -> Result<Finished, Failure> {
        let Task {
            typed,
            field: path,
            out,
            progress,
            ..
        } = *self;
        let options = open_options(&typed.input, typed.work.memory);
        let mut drawing = typed.figures.drawing(Some(&typed.colors))?;
        let is_tight = |stated: &u64| *stated < ROOM_FOR_FIGURES;
        drawing.threads = typed.work.memory.filter(is_tight).map(|_| 1);
        use_threads(typed.work.threads)?;
        // Before any work: could the result be written?
        drop(ResultDirectory::create(out, self.replace)?);
        // A long file is hashed first, where it can be interrupted; a short one beside the work.
        let is_scan = typed.scan.position_from.is_some();
        let hash_first = is_scan || is_long(path);
        if hash_first {
            progress.wait("reading the field");
        }
        let options = OpenOptions {
            hash: hash_first,
            ..options
        };
        let (field, records) = typed.scan.open(self.files, &options)?;
        let mut request = request(typed, &field, drawing.is_wanted())?;
        request.dispersion = dispersion::of(typed, path, &field)?;
        let plan = plan(&field, &request)
            .map_err(|error| error.of_file(path).beside(own(typed.work.memory)))?;

        progress.begin_writing();
        let directory = ResultDirectory::create(out, self.replace)?;
        let format: ArrayFormat = typed.output.format.into();
        let spectra = format.create(directory.path(), "spectra", request.precision)?;
        // Threads that are idle in a pass help with the hash, and, unless memory is short, with the run.
        let (analysis, (hash, run)) = rayon::join(
            || run_plan(&field, &plan, &*spectra, progress),
            || {
                let hash = match hash_first {
                    true => Ok(None),
                    false => field.file_hash(!plan.streams()),
                };
                (
                    hash,
                    typed.work.memory.is_none().then(|| motion_of_run(path)),
                )
            },
        );
        let mut analysis = analysis.map_err(|error| error.of_file(path))?;
        let run = run.unwrap_or_else(|| motion_of_run(path))?;
        let is_run = run.is_some();
        if let Some(run) = run {
            in_time_of(&run, &mut analysis)?;
        }
        analysis.content_hash = analysis.content_hash.or(hash?);
        let opened = field.file_state();
        let read_as = conclusions(&field);
        let input = match self.files {
            [first, .., last] => {
                let (first, last) = (first.display(), last.display());
                format!("{} files, {first} to {last}", self.files.len())
            }
            _ => path.display().to_string(),
        };
        let hash = analysis.content_hash.clone();
        let provenance = Provenance {
            read_as: read_as.clone(),
            ..Provenance::new(as_text(), Some(input), hash)
        };
        // Unmapping a file takes about as long as writing the remaining results.
        let mut sheet = analysis.words();
        label_analysis(&analysis, &mut sheet);
        for conclusion in &read_as {
            sheet.fact("read as", conclusion);
        }
        let is_scan = typed.scan.position_from.is_some();
        let further = (!is_scan).then(|| further::sentence(&analysis, is_run, path));
        if let Some(further) = further.flatten() {
            sheet.detail("further", further);
        }
        let (written, ()) = rayon::join(|| analysis.describe().write_to(&*spectra), || drop(field));
        written?;
        progress.check()?;
        // All that reads or hashes the file has done so.
        opened.as_ref().map_or(Ok(()), FileState::check)?;
        let records = records.map(|records| records_table(&records).to_csv());
        let records = records.transpose().map_err(std::io::Error::other)?;
        let described = Described {
            found: &analysis,
            sheet: &sheet,
            name: &analysis.name,
            provenance: &provenance,
        };
        let json = described.json()?;
        let place = (directory, "analyze");
        let main = described.publish(place, Some(spectra), &drawing, progress, &|directory| {
            if let Some(csv) = &records {
                write_beside(directory, "records.csv", csv.as_bytes())?;
            }
            let script = analysis_snippet(&analysis, format);
            write_beside(directory, "plot.py", script.as_bytes()).map(|_| ())
        })?;
        Ok(Finished {
            analysis,
            sheet,
            json,
            main,
            is_run,
        })
    }
}

/// The motion of a run, if a file holds one.
pub fn motion_of_run(path: &Path) -> Result<Option<RunFile>, Failure> {
    Ok(is_run_file(path)?
        .then(|| RunFile::read_motion(path))
        .transpose()?)
}

/// What moved in wavenumber in a run is that of the total energy.
pub fn in_time_of(file: &RunFile, analysis: &mut Analysis) -> Result<(), Failure> {
    analysis.sample_error = file.run.report.error;
    Ok(answer_of_run(&file.run, analysis)?)
}

/// Stated memory below which figures, which take some 20 MB each, are drawn one by one.
const ROOM_FOR_FIGURES: u64 = 128 << 20;

fn tell(
    typed: &Analyze,
    finished: &Finished,
    field: &Path,
    started: Instant,
) -> Result<(), Failure> {
    if typed.output.json {
        return Ok(writeln!(terminal::stdout(), "{}", finished.json)?);
    }
    if typed.output.quiet {
        return Ok(());
    }
    let mut summary = Summary::of(&finished.analysis.name, &finished.sheet);
    let seconds = started.elapsed().as_secs_f64();
    let mut last = format!("done in {seconds:.2} s; open {}", finished.main.display());
    if finished.is_run {
        let field = quoted(&field.to_string_lossy());
        last += &format!("; its energy: cascade budget {field}");
    }
    summary.last(&last);
    Ok(summary.print(typed.output.detail.verbose)?)
}

/// Prints what would be computed of a field.
pub fn print_plan(typed: &Analyze, files: &[PathBuf]) -> Result<(), Failure> {
    let is_drawn = typed.figures.drawing(Some(&typed.colors))?.is_wanted();
    let options = OpenOptions {
        hash: false,
        ..open_options(&typed.input, typed.work.memory)
    };
    let (field, _) = typed.scan.open(files, &options)?;
    print_notes(&field, typed.output.quiet);
    let mut request = request(typed, &field, is_drawn)?;
    request.dispersion = dispersion::of(typed, &files[0], &field)?;
    let stated = typed.work.memory;
    let mut plan = plan(&field, &request).map_err(|error| error.beside(own(stated)))?;
    let beside = own(stated);
    (plan.memory_needed, plan.memory_allowed) =
        (plan.memory_needed + beside, plan.memory_allowed + beside);
    if typed.output.json {
        return print_json(&plan.describe());
    }
    let text = terminal::plan(&plan, terminal::width());
    Ok(write!(terminal::stdout(), "{text}")?)
}

/// How a field was read where nothing states it and nothing speaks against it.
pub fn conclusions(field: &Field) -> Vec<String> {
    let settled = field.notes.iter().filter(|note| !note.is_doubtful);
    let in_words = |note: &Note| match note.advice {
        Some(advice) => format!("{}; {advice}", note.text),
        None => note.text.clone(),
    };
    settled.map(in_words).collect()
}

/// Prints to standard error how a field was read.
pub fn print_notes(field: &Field, quiet: bool) {
    for note in field.notes.iter().filter(|_| !quiet) {
        let kind = match note.is_doubtful {
            true => Tone::Warning,
            false => Tone::Note,
        };
        terminal::message(kind, &note.text);
        if let Some(advice) = note.advice {
            terminal::message(Tone::Help, advice);
        }
    }
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

/// Whether reading the file once is slow enough to show progress.
fn is_long(field: &Path) -> bool {
    const A_WHILE: u64 = 256 << 20;
    std::fs::metadata(field).is_ok_and(|file| file.len() > A_WHILE)
}

/// Limits the global pool, which hashes and draws, to `threads` threads. It is built once: the first of
/// several fields decides.
pub fn use_threads(threads: Option<usize>) -> Result<(), Failure> {
    static BUILT: AtomicBool = AtomicBool::new(false);
    let threads = threads.filter(|_| !BUILT.swap(true, Ordering::Relaxed));
    let built = threads.map_or(Ok(()), |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build_global()
    });
    Ok(built.map_err(|error| Error::Threads {
        threads: threads.unwrap_or_default(),
        reason: error.to_string(),
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
        variable: typed.variable.clone(),
        time_dim: typed.time_dim.clone(),
        space_dim: typed.space_dim.clone(),
        at: typed.at.clone(),
        select: typed.select.clone(),
        jitter: typed.jitter.unwrap_or(OpenOptions::default().jitter),
        resample: typed.resample.unwrap_or_default(),
        delays: typed.delays.map(Into::into).unwrap_or_default(),
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
        read: typed.read.map(Into::into).unwrap_or_default(),
        hash: true,
    }
}

/// Sets what is asked in the units of the field's axes.
fn in_units(typed: &Analyze, field: &Field, request: &mut Request) -> Result<(), Error> {
    let (units, bands) = (AxisUnits::of(field), &typed.bands);
    if let Some(times) = typed.preparation.times {
        let (from, to) = units.ends("times", times)?;
        request.times = TimeRange::Interval { from, to };
    }
    let edges = (bands.band_edge_frequency, bands.band_edge_wavenumber);
    request.band_edge_frequency = units.stated("band-edge-frequency", edges.0)?;
    request.band_edge_wavenumber = units.stated("band-edge-wavenumber", edges.1)?;
    request.reference_time = units.stated("reference-time", bands.reference_time)?;
    request.front_window = units.stated("front-window", bands.front_window)?;
    request.noise = units.stated("noise", bands.noise)?;
    let times = typed.short_time.short_time_times.iter();
    let times = times.map(|at| units.number("short-time-times", *at));
    request.short_time.times = times.collect::<Result<_, _>>()?;
    let band = bands.direction_band;
    let band = band.map(|band| units.ends("direction-band", band));
    request.direction_band = band.transpose()?;
    request.show = typed.show.in_units(&units)?;
    Ok(())
}

/// What is asked of an analysis of a field, but for dispersion relations.
pub fn request(typed: &Analyze, field: &Field, draws: bool) -> Result<Request, Error> {
    let (prepare, spectra, bands) = (&typed.preparation, &typed.spectra, &typed.bands);
    let mut request = Request {
        results: results(typed),
        sites: prepare.sites.clone(),
        without_sites: prepare.without_sites.clone(),
        // In the units of the field's axes, once it is open: see [`in_units`].
        times: match prepare.times {
            None if prepare.until_arrival => TimeRange::UntilArrival {
                threshold: prepare.arrival_threshold,
            },
            _ => TimeRange::All,
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
        least_move: bands.least_move,
        periodic: bands.periodic,
        subtract_noise: bands.subtract_noise,
        dispersion: None,
        maps: draws,
        short_time: ShortTime {
            sites: typed.short_time.short_time_sites.clone(),
            times: Vec::new(),
            segment: typed.short_time.short_time_segment,
            hop: typed.short_time.short_time_hop,
            segment_space: typed.short_time.short_space_segment,
            hop_space: typed.short_time.short_space_hop,
            window: typed.short_time.short_time_window,
        },
        precision: typed.work.precision.into(),
        threads: typed.work.threads,
        memory: typed.work.memory.map(|stated| stated - own(Some(stated))),
        ..Request::default()
    };
    in_units(typed, field, &mut request)?;
    Ok(request)
}

/// What of a stated memory the program itself takes: code, libraries, a report while it is written.
/// Less than twice as much is left to the samples.
pub fn own(stated: Option<u64>) -> u64 {
    const PROGRAM: u64 = 20 << 20;
    match stated {
        Some(stated) if stated >= 2 * PROGRAM => PROGRAM,
        _ => 0,
    }
}

/// Where nothing is named, all that can be computed: along space only if all sites are there, and along both axes
/// only if noise is not subtracted.
fn results(typed: &Analyze) -> Results {
    let only = &typed.work.only;
    if only.is_empty() {
        let has_all_sites = typed.preparation.without_sites.is_empty();
        return Results {
            spatial: has_all_sites,
            spacetime: has_all_sites && !typed.bands.subtract_noise,
            flux_surrogate: has_all_sites,
            ..Results::ALL
        };
    }
    Results {
        temporal: only.contains(&ResultArg::Temporal),
        spatial: only.contains(&ResultArg::Spatial),
        spacetime: only.contains(&ResultArg::Spacetime),
        flux_surrogate: only.contains(&ResultArg::Flux),
        short_time: only.contains(&ResultArg::ShortTime),
        answer: true,
    }
}
