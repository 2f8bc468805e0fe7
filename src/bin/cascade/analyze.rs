//! `cascade analyze`: typed arguments to a request, the run, the files.

use std::sync::Arc;
use std::time::Instant;

use wavecascade::analyze::{
    Analysis, Plan, Request, Results, ShortTime, TimeRange, Welch, plan, run as run_plan,
};
use wavecascade::budget::answer_of_run;
use wavecascade::field::{Note, OpenOptions, TimeColumn, is_run_file};
use wavecascade::report::{Headlines, RunFile, analysis_snippet, label_analysis, records_table};
use wavecascade::sheet::{FigureLayout, Sheet};

use crate::args::{Analyze, ResultArg};
use crate::described;
use crate::dispersion;
use crate::fields::{self, expanded};
use crate::further;
use crate::prelude::*;
use crate::terminal::{HEADING, Tone, print_json, styled};
use crate::words::quoted;

/// Runs the command on one field, or one after the other on several.
pub fn run(typed: &Analyze) -> Result<(), Failure> {
    let files = expanded(&typed.fields)?;
    let is_one = files.len() == 1 || typed.scan.position_from.is_some();
    match (typed.work.plan, is_one) {
        (true, true) => print_plan(typed, &files),
        (true, false) => files.iter().try_for_each(|field| {
            if !typed.result.how.json {
                let name = styled(HEADING, &field.display().to_string());
                writeln!(terminal::stdout(), "{name}")?;
            }
            print_plan(typed, std::slice::from_ref(field))
        }),
        (false, true) => described::run(typed, &typed.result),
        (false, false) => fields::run(typed, &files),
    }
}

/// An analysis with what is said of its file, and of what to ask next.
struct Analyzed {
    analysis: Analysis,
    read_as: Vec<String>,
    further: Option<String>,
}

impl Describe for Analyzed {
    fn describe(&self) -> Sheet<'_> {
        let mut sheet = self.analysis.describe();
        label_analysis(&self.analysis, &mut sheet);
        for conclusion in &self.read_as {
            sheet.fact("read as", conclusion);
        }
        if let Some(further) = &self.further {
            sheet.detail("further", further);
        }
        sheet
    }

    fn figures(&self) -> Vec<FigureLayout> {
        self.analysis.figures()
    }
}

impl Describing for Analyze {
    fn about(&self) -> About<'_> {
        About {
            reading: Some(self.reading()),
            ending: Some("cascade"),
            colors: Some(&self.colors),
            blocks: Some((self.format.into(), "spectra", self.work.precision.into())),
            started: Some(Instant::now()),
            ..About::of("analyze", &self.result.how, &self.fields, "npy")
        }
    }

    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error> {
        let (field, path) = (given.field()?, given.files.first());
        let plan = self.plan(field, given.chain, path, given.is_drawn)?;
        let mut analysis = run_plan(field, &plan, given.sink(), observer)?;
        let run = match (given.runs.first(), path) {
            (Some(Some(run)), _) => Some(Arc::clone(run)),
            (_, Some(path)) if is_run_file(path)? => Some(RunFile::read_motion(path)?.into()),
            _ => None,
        };
        // What moved in wavenumber in a run is that of the total energy.
        if let Some(file) = &run {
            analysis.sample_error = file.run.report.error;
            answer_of_run(&file.run, &mut analysis)?;
        }
        let settled = field.notes.iter().filter(|note| !note.is_doubtful);
        let sentence = |note: &Note| match note.advice {
            Some(advice) => format!("{}; {advice}", note.text),
            None => note.text.clone(),
        };
        let read_as: Vec<String> = settled.map(sentence).collect();
        let typed = path.filter(|_| given.is_typed);
        let is_scan = self.scan.position_from.is_some();
        let further = typed.filter(|_| !is_scan);
        let further = further.and_then(|path| further::sentence(&analysis, run.is_some(), path));
        let next = typed.filter(|_| run.is_some()).map(|path| {
            let field = quoted(&path.to_string_lossy());
            format!("; its energy: cascade budget {field}")
        });
        let script = analysis_snippet(&analysis, self.format.into());
        let found = Found {
            name: Some(analysis.name.clone()),
            read_as: read_as.clone(),
            headlines: Some(Headlines::of(&analysis)),
            next: next.unwrap_or_default(),
            ..Found::of(Analyzed {
                analysis,
                read_as,
                further,
            })
        };
        let found = found.with_text("plot.py", script);
        Ok(match given.records {
            Some(records) => {
                let csv = records_table(records).to_csv();
                let csv = csv.map_err(|error| Error::Write {
                    action: "write",
                    path: "records.csv".into(),
                    source: std::io::Error::other(error),
                });
                found.with_text("records.csv", csv?)
            }
            None => found,
        })
    }
}

impl Analyze {
    /// How its field is read.
    pub fn reading(&self) -> Reading<'_> {
        Reading {
            scan: Some(&self.scan),
            is_told: true,
            ..Reading::of(&self.input, self.work.memory)
        }
    }

    /// What is done with a field: of this chain, or of that of a run in this file.
    pub fn plan(
        &self,
        field: &Field,
        chain: Option<&Chain>,
        path: Option<&PathBuf>,
        is_drawn: bool,
    ) -> Result<Plan, Error> {
        let of_run = match path {
            Some(path) if is_run_file(path)? => Some(RunFile::read_scene(path)?),
            _ => None,
        };
        let mut request = request(self, field, is_drawn)?;
        request.dispersion = dispersion::stated(self, of_run.as_ref().or(chain), field)?;
        plan(field, &request).map_err(|error| error.beside(own(self.work.memory)))
    }
}

/// Prints what would be computed of a field.
fn print_plan(typed: &Analyze, files: &[PathBuf]) -> Result<(), Failure> {
    let how = &typed.result.how;
    let is_drawn = typed
        .result
        .figures
        .drawing(Some(&typed.colors))?
        .is_wanted();
    let options = open_options(&typed.input, typed.work.memory);
    let (field, _) = typed.scan.open(files, &options)?;
    print_notes(&field, how.quiet);
    let mut plan = typed.plan(&field, None, files.first(), is_drawn)?;
    let beside = own(typed.work.memory);
    (plan.memory_needed, plan.memory_allowed) =
        (plan.memory_needed + beside, plan.memory_allowed + beside);
    if how.json {
        return print_json(&plan.describe());
    }
    let text = terminal::plan(&plan, terminal::width());
    Ok(write!(terminal::stdout(), "{text}")?)
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

/// How a field is opened, without a hash.
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
        hash: false,
    }
}

/// Sets what is asked in the units of the field's axes.
fn in_units(typed: &Analyze, field: &Field, request: &mut Request) -> Result<(), Error> {
    let (units, bands) = (AxisUnits::of(field), &typed.bands);
    let preparation = &typed.preparation;
    request.times = match preparation.times {
        Some(times) => {
            let (from, to) = units.ends("times", times)?;
            TimeRange::Interval { from, to }
        }
        None if preparation.until_arrival => TimeRange::UntilArrival {
            threshold: preparation.arrival_threshold,
        },
        None => TimeRange::All,
    };
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
        threads: typed.result.how.threads,
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
    let is_named = !only.is_empty();
    let is_wanted = |result| !is_named || only.contains(&result);
    let in_space = is_named || typed.preparation.without_sites.is_empty();
    let of_both = is_named || !typed.bands.subtract_noise;
    Results {
        temporal: is_wanted(ResultArg::Temporal),
        spatial: is_wanted(ResultArg::Spatial) && in_space,
        spacetime: is_wanted(ResultArg::Spacetime) && in_space && of_both,
        flux_surrogate: is_wanted(ResultArg::Flux) && in_space,
        short_time: is_wanted(ResultArg::ShortTime),
        answer: true,
    }
}
