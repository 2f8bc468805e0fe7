//! Throughput of the transforms of columns, planes and short-time segments, and whether it was kept.
//!
//! `cascade`, `rustfft` (two columns as one complex one) and `realfft` transform the same arrays in interleaved rounds.
//! `--check` compares the ratio to rustfft with the baseline of this kind of processor, and names the cases that the baseline
//! lacks; with `--instructions` it compares instruction counts, which do not depend on load or clock, and need valgrind. The
//! exit code is 1 if more than 10 % is lost, or nothing can be compared.

mod check;
mod count;

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::{Parser, ValueEnum};
use serde::Serialize;
use throughput::{
    ArrayShape, Baseline, CaseOf, Comparison, Counted, CountedCase, Implementation, Machine,
    Precision, Ratios, Rounds, Throughput, TransformKind, Versions, table,
};

use check::Fault;

/// What is typed.
#[derive(Debug, Parser)]
#[command(name = "throughput", version, about, max_term_width = 100)]
struct Bench {
    /// Kind of transform [default: all; with `--shape` or `--instructions` columns].
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        conflicts_with = "instructions"
    )]
    kind: Vec<KindArg>,
    /// Shape of the arrays, times by columns; may be given more than once
    /// [default: 4096x300, 16384x300 and 10007x300, a plane of 2048x2048, short-time 16384x300; with
    /// `--instructions` small ones].
    #[arg(long, value_name = "ROWSxCOLUMNS")]
    shape: Vec<ArrayShape>,
    /// Number types [default: of columns both, else f64].
    #[arg(long, value_enum, value_delimiter = ',')]
    precision: Vec<PrecisionArg>,
    /// Measure with N threads besides one.
    #[arg(long, value_name = "N", default_value_t = 1, conflicts_with = "instructions",
          value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
    /// Rounds; every library runs once in each. One more warms up.
    #[arg(long, value_name = "N", default_value_t = 25, conflicts_with = "instructions",
          value_parser = clap::value_parser!(u32).range(1..=100_000))]
    rounds: u32,
    /// Count instructions a sample with valgrind instead of taking times.
    #[arg(long)]
    instructions: bool,
    /// Compare with a baseline; exit code 1 where more than 10 % of the throughput is lost.
    #[arg(long, conflicts_with = "record")]
    check: bool,
    /// The baseline to compare with [default: benches/baseline.json of the repository, built in].
    #[arg(long, value_name = "FILE", requires = "check")]
    baseline: Option<PathBuf>,
    /// Write the results to a baseline; they replace the same cases on this machine or build.
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Print all that was found as JSON, every time included.
    #[arg(long)]
    json: bool,
    /// Only transform, this many times: runs inside valgrind.
    #[arg(long, hide = true, requires = "by")]
    repeat: Option<usize>,
    /// What transforms then.
    #[arg(long, hide = true, requires = "repeat")]
    by: Option<Counted>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum KindArg {
    /// All columns of an array.
    Columns,
    /// Both axes of an array.
    Plane,
    /// Segments of 256 samples, 32 apart, of all columns.
    ShortTime,
}

impl From<KindArg> for TransformKind {
    fn from(typed: KindArg) -> Self {
        match typed {
            KindArg::Columns => TransformKind::Columns,
            KindArg::Plane => TransformKind::Plane,
            KindArg::ShortTime => TransformKind::ShortTime,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PrecisionArg {
    F64,
    F32,
}

impl From<PrecisionArg> for Precision {
    fn from(typed: PrecisionArg) -> Self {
        match typed {
            PrecisionArg::F64 => Precision::F64,
            PrecisionArg::F32 => Precision::F32,
        }
    }
}

/// Why it did not end well.
#[derive(Debug)]
enum Failure {
    /// Throughput was lost, or could not be compared.
    Bench(Fault),
    /// It could not be measured.
    Throughput(throughput::Error),
    /// There is no folder for the file to record to.
    Record(PathBuf),
    /// Standard output could not be written.
    Output(std::io::Error),
}

impl From<throughput::Error> for Failure {
    fn from(error: throughput::Error) -> Self {
        Failure::Throughput(error)
    }
}

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        Failure::Output(error)
    }
}

impl Failure {
    /// Prints it to standard error, with what can be done; returns the exit code.
    fn report(&self) -> u8 {
        let (text, help) = match self {
            Failure::Bench(fault) => (fault.to_string(), Some(fault.advice())),
            Failure::Throughput(error @ throughput::Error::Shape { .. }) => {
                eprintln!("error: --shape: {error}");
                return 2;
            }
            Failure::Throughput(error @ throughput::Error::Baseline { .. }) => (
                error.to_string(),
                Some("record a new one with `--record FILE`, or name another with `--baseline`"),
            ),
            Failure::Throughput(error) => (error.to_string(), None),
            Failure::Record(path) => {
                let path = path.display();
                eprintln!("error: --record: expected a file in a folder that exists, found {path}");
                return 2;
            }
            // A reader that went away has read enough.
            Failure::Output(error) if error.kind() == std::io::ErrorKind::BrokenPipe => return 0,
            Failure::Output(error) => (format!("cannot write to standard output: {error}"), None),
        };
        eprintln!("error: {text}");
        if let Some(help) = help {
            eprintln!("help: {help}");
        }
        1
    }
}

/// The JSON output.
#[derive(Debug, Serialize)]
struct Said<C> {
    schema: &'static str,
    machine: Machine,
    cores: usize,
    versions: Versions,
    cases: Vec<C>,
    /// Comparison with the baseline, if requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    check: Option<Vec<Comparison>>,
    /// Cases that the baseline lacks.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    not_compared: Vec<String>,
}

impl Bench {
    /// Shapes with precisions, what was typed or the given ones.
    fn arrays(
        &self,
        shapes: &[ArrayShape],
        precisions: &[Precision],
    ) -> Vec<(ArrayShape, Precision)> {
        let typed: Vec<Precision> = self.precision.iter().map(|&typed| typed.into()).collect();
        let precisions = if typed.is_empty() { precisions } else { &typed };
        let shapes = if self.shape.is_empty() {
            shapes
        } else {
            &self.shape
        };
        let of = |&shape: &ArrayShape| precisions.iter().map(move |&precision| (shape, precision));
        shapes.iter().flat_map(of).collect()
    }

    fn kinds(&self) -> Vec<TransformKind> {
        match &self.kind[..] {
            [] if self.shape.is_empty() => TransformKind::ALL.to_vec(),
            [] => vec![TransformKind::Columns],
            some => some.iter().map(|&typed| typed.into()).collect(),
        }
    }

    fn cases(&self) -> Vec<CaseOf> {
        let mut threads = vec![1, usize::from(self.threads)];
        threads.dedup();
        let mut cases = Vec::new();
        for kind in self.kinds() {
            for (shape, precision) in self.arrays(kind.short(), kind.precisions()) {
                cases.extend(threads.iter().map(|&threads| CaseOf {
                    kind,
                    shape,
                    precision,
                    threads,
                }));
            }
        }
        cases
    }

    /// The baseline to compare with, and its name.
    fn baseline(&self) -> Result<Option<(Baseline, String)>, Failure> {
        Ok(match &self.baseline {
            _ if !self.check => None,
            Some(path) => Some((Baseline::read(path)?, path.display().to_string())),
            None => Some((shipped()?, "benches/baseline.json".into())),
        })
    }

    /// What the file to record to holds so far; nothing where there is none.
    fn recorded(&self) -> Result<Option<(Baseline, &Path)>, Failure> {
        let Some(path) = &self.record else {
            return Ok(None);
        };
        if path.exists() {
            return Ok(Some((Baseline::read(path)?, path)));
        }
        // Better now than after the work.
        let folder = path
            .parent()
            .filter(|folder| !folder.as_os_str().is_empty());
        if path.file_name().is_none() || folder.is_some_and(|folder| !folder.is_dir()) {
            return Err(Failure::Record(path.clone()));
        }
        Ok(Some((Baseline::default(), path)))
    }

    fn say<C: Serialize>(
        &self,
        cases: Vec<C>,
        (check, not_compared): (Option<Vec<Comparison>>, Vec<String>),
        text: &str,
    ) -> Result<(), Failure> {
        let mut stdout = std::io::stdout();
        let (machine, versions) = (Machine::here(), versions());
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        if !self.json {
            let Versions {
                cascade,
                rustfft,
                realfft,
                rustc,
            } = &versions;
            write!(
                stdout,
                "cascade {cascade}, rustfft {rustfft}, realfft {realfft}; {rustc}\n\
                 {machine}, {cores} cores\n\n{text}"
            )?;
            return Ok(());
        }
        let schema = "cascade-bench/1";
        let said = Said {
            schema,
            machine,
            cores,
            versions,
            cases,
            check,
            not_compared,
        };
        let text = serde_json::to_string_pretty(&said).map_err(std::io::Error::from)?;
        Ok(writeln!(stdout, "{text}")?)
    }
}

fn main() -> std::process::ExitCode {
    let done = run(Bench::parse());
    done.map_or_else(|failure| failure.report(), |()| 0).into()
}

fn run(typed: Bench) -> Result<(), Failure> {
    if let (Some(times), Some(by)) = (typed.repeat, typed.by) {
        for (shape, precision) in typed.arrays(&[], TransformKind::Columns.precisions()) {
            CountedCase {
                shape,
                precision,
                by,
            }
            .repeat(times)?;
        }
        return Ok(());
    }
    match typed.instructions {
        true => count::run(&typed),
        false => times(&typed),
    }
}

fn times(typed: &Bench) -> Result<(), Failure> {
    let cases = typed.cases();
    cases.iter().try_for_each(CaseOf::check)?;
    throughput::fit_memory(cases.iter().map(CaseOf::memory), 1)?;
    let (baseline, recorded) = (typed.baseline()?, typed.recorded()?);
    let rounds = Rounds {
        rounds: typed.rounds as usize,
        ways: vec![
            Implementation::Cascade,
            Implementation::Rustfft,
            Implementation::Realfft,
        ],
    };
    let known = baseline.as_ref().map(|(baseline, name)| {
        let known = baseline.ratios_on(&Machine::here());
        let place = || Machine::here().to_string();
        let cases = cases.iter().map(CaseOf::to_string);
        check::known_of_some(known, cases, place, name)
    });
    let (known, not_compared) = known.transpose()?.unzip();
    let not_compared: Vec<String> = not_compared.unwrap_or_default();
    let mut found = measured(&rounds, &cases)?;
    let compare = |found: &Throughput, known: &BTreeMap<String, f64>| {
        let case = found.case.to_string();
        let known = known.get(&case)?;
        Some(Comparison::of_ratios(
            &case,
            *known,
            found.ratio(Implementation::Rustfft),
        ))
    };
    if let Some(known) = &known {
        // A loss must show again in more rounds before it counts.
        let longer = Rounds {
            rounds: 4 * rounds.rounds,
            ..rounds.clone()
        };
        for found in found
            .iter_mut()
            .filter(|found| compare(found, known).is_some_and(|c| c.is_loss()))
        {
            *found = longer.measure(found.case)?;
        }
    }
    let check = known.as_ref().map(|known| {
        found
            .iter()
            .filter_map(|f| compare(f, known))
            .collect::<Vec<_>>()
    });
    let name = baseline.map(|(_, name)| name).unwrap_or_default();
    let mut text = table(&found) + LEGEND;
    text += &check::text(check.as_deref(), "x");
    text += &check::not_compared(&not_compared, &name);
    if let Some((mut file, path)) = recorded {
        let ratios = found
            .iter()
            .map(|f| (f.case.to_string(), f.ratio(Implementation::Rustfft)));
        file.set_ratios(Ratios {
            machine: Machine::here(),
            versions: versions(),
            rounds: rounds.rounds,
            ratio_to_rustfft: ratios.collect(),
        });
        file.write(path)?;
        text += &format!("\nrecorded in {}\n", path.display());
    }
    typed.say(found, (check.clone(), not_compared), &text)?;
    check::verdict(check, "times the speed of rustfft", name)
}

fn measured(rounds: &Rounds, cases: &[CaseOf]) -> Result<Vec<Throughput>, Failure> {
    let found = cases.iter().map(|case| rounds.measure(*case));
    Ok(found.collect::<throughput::Result<_>>()?)
}

/// The baseline of the repository; a test reads it.
fn shipped() -> throughput::Result<Baseline> {
    let text = include_str!("../../baseline.json");
    Baseline::parse("benches/baseline.json".as_ref(), text)
}

/// Versions of this build.
fn versions() -> Versions {
    let lock = include_str!("../../../Cargo.lock");
    Versions::of_build(env!("CARGO_PKG_VERSION"), lock, env!("THROUGHPUT_RUSTC"))
}

const LEGEND: &str = "
columns: each by itself; plane: both axes; short-time: segments of 256 samples, 32 apart, of all
columns; ms: median (of the processor's time with one thread); GFLOP/s: 2.5 n log2 n for a column,
plane or segment of n samples; of bound: array read and spectra written once at the rate of a copy;
rel. error: the one to expect of cascade, where one is stated; x: how many times as long as cascade,
median over rounds (planes: columns as named, rows by rustfft; short-time: windowed copies of segments,
made anew each round)
";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_baseline_and_versions_can_be_read() {
        shipped().unwrap();
        let versions = versions();
        for version in [&versions.rustfft, &versions.realfft] {
            assert_eq!(version.split('.').count(), 3, "{version}");
        }
        assert!(versions.rustc.starts_with("rustc "), "{}", versions.rustc);
    }
}
