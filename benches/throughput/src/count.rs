//! Instructions a sample, counted by valgrind around this program itself.
//!
//! A run of `k + m` transforms less a run of `k` leaves `m` transforms: start, planning and noise go.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::PathBuf;
use std::process::Command;
use std::sync::Mutex;

use serde::Serialize;
use throughput::{
    ArrayShape, Comparison, Counted, CountedCase, Instructions, Precision, TransformKind,
    fit_memory, name,
};

use crate::check::Fault;
use crate::{Bench, Failure, check, versions};

/// Transforms of the shorter run, and by how many the longer one has more.
const FEWER: usize = 1;
const MORE: usize = 4;

/// Instructions a sample of one array.
#[derive(Debug, Clone, Serialize)]
struct Counts {
    #[serde(flatten)]
    shape: ArrayShape,
    precision: Precision,
    /// By instruction set, and of `rustfft`.
    per_sample: BTreeMap<String, f64>,
}

/// Counts, and compares or records them.
pub fn run(typed: &Bench) -> Result<(), Failure> {
    let arrays = typed.arrays(&CountedCase::SHORT, TransformKind::Columns.precisions());
    let cases: Vec<CountedCase> = arrays
        .iter()
        .flat_map(|&(shape, precision)| {
            let all = Counted::all().into_iter();
            all.map(move |by| CountedCase {
                shape,
                precision,
                by,
            })
        })
        .collect();
    let workers = fit_memory(cases.iter().map(CountedCase::memory), cores())?;
    let (baseline, recorded) = (typed.baseline()?, typed.recorded()?);
    let ours = |case: &&CountedCase| case.by != Counted::Rustfft;
    let known = baseline.as_ref().map(|(baseline, name)| {
        let known = baseline.instructions_here();
        let known = known.flat_map(|known| known.per_sample.clone()).collect();
        let place = || {
            let here = Instructions::here(versions(), BTreeMap::new());
            format!("{}, {} build", here.architecture, here.build)
        };
        let cases = cases.iter().filter(ours).map(CountedCase::to_string);
        check::known(known, cases, place, name)
    });
    let known = known.transpose()?;
    let found: BTreeMap<String, f64> = counted(&cases, workers)?;
    let check = known.as_ref().map(|known| {
        let compare = |case: &CountedCase| {
            let case = case.to_string();
            Comparison::of_counts(&case, known[&case], found[&case])
        };
        cases.iter().filter(ours).map(compare).collect::<Vec<_>>()
    });
    let counts: Vec<Counts> = arrays
        .iter()
        .map(|&array| of_array(array, &found))
        .collect();
    let mut text = table(&counts) + &check::text(check.as_deref(), "");
    if let Some((baseline, name)) = &baseline {
        let rustc = baseline
            .instructions_here()
            .map(|known| &*known.versions.rustc);
        let rustc: BTreeSet<&str> = rustc.collect();
        let rustc = rustc.into_iter().collect::<Vec<_>>().join(", ");
        let _ = writeln!(text, "\n{name}: counted in a build by {rustc}");
    }
    if let Some((mut file, path)) = recorded {
        file.set_instructions(Instructions::here(versions(), found.clone()));
        file.write(path)?;
        let _ = writeln!(text, "\nrecorded in {}", path.display());
    }
    typed.say(counts, (check.clone(), Vec::new()), &text)?;
    let name = baseline.map(|(_, name)| name).unwrap_or_default();
    check::verdict(check, "instructions a sample", name)
}

fn of_array((shape, precision): (ArrayShape, Precision), found: &BTreeMap<String, f64>) -> Counts {
    let of = |by: Counted| {
        (
            by.to_string(),
            found[&CountedCase {
                shape,
                precision,
                by,
            }
            .to_string()],
        )
    };
    Counts {
        shape,
        precision,
        per_sample: Counted::all().into_iter().map(of).collect(),
    }
}

/// One line for each array: counts, and in brackets the ratio of `rustfft`'s count to them.
fn table(counts: &[Counts]) -> String {
    let mut text =
        String::from("instructions a sample; in brackets rustfft's over them\n\n      shape  type");
    let all = Counted::all();
    for by in &all {
        let _ = write!(text, " {:>16}", by.to_string());
    }
    for Counts {
        shape,
        precision,
        per_sample,
    } in counts
    {
        let _ = write!(text, "\n{:>11}   {}", shape.to_string(), name(*precision));
        let theirs = per_sample[&Counted::Rustfft.to_string()];
        for by in &all {
            let count = per_sample[&by.to_string()];
            let _ = match by {
                Counted::Rustfft => write!(text, " {count:>16.2}"),
                Counted::Cascade(_) => write!(text, " {count:>8.2} ({:5.2})", theirs / count),
            };
        }
    }
    text + "\n"
}

/// Cases are counted in parallel, at most one for each core: counts do not depend on load.
fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Counts of all cases, `workers` at once.
fn counted(cases: &[CountedCase], workers: usize) -> Result<BTreeMap<String, f64>, Failure> {
    let program = std::env::current_exe().map_err(|error| {
        let reason = format!("cannot find this program: {error}");
        Failure::Bench(Fault::Valgrind {
            reason,
            absent: false,
        })
    })?;
    let (left, found) = (Mutex::new(cases.iter()), Mutex::new(Vec::new()));
    let next = || left.lock().ok().and_then(|mut left| left.next());
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                while let Some(case) = next() {
                    let count = of_case(&program, case);
                    let failed = count.is_err();
                    if let Ok(mut found) = found.lock() {
                        found.push((case.to_string(), count));
                    }
                    if failed {
                        break;
                    }
                }
            });
        }
    });
    let found = found.into_inner().unwrap_or_default();
    let found = found.into_iter().map(|(case, count)| Ok((case, count?)));
    found.collect::<Result<_, Fault>>().map_err(Failure::Bench)
}

fn of_case(program: &PathBuf, case: &CountedCase) -> Result<f64, Fault> {
    let fewer = of_run(program, case, FEWER)?;
    let more = of_run(program, case, FEWER + MORE)?;
    Ok((more as f64 - fewer as f64) / (MORE * case.shape.samples()) as f64)
}

/// Instructions of one run of this program inside valgrind.
fn of_run(program: &PathBuf, case: &CountedCase, transforms: usize) -> Result<u64, Fault> {
    let CountedCase {
        shape,
        precision,
        by,
    } = case;
    let mut command = Command::new("valgrind");
    command
        .args([
            "--tool=cachegrind",
            "--cache-sim=no",
            "--cachegrind-out-file=/dev/null",
        ])
        .arg(program)
        .args(["--repeat", &transforms.to_string(), "--by", &by.to_string()])
        .args([
            "--shape",
            &shape.to_string(),
            "--precision",
            name(*precision),
        ]);
    let output = command.output().map_err(|error| Fault::Valgrind {
        reason: format!("cannot run valgrind: {error}"),
        absent: error.kind() == std::io::ErrorKind::NotFound,
    })?;
    let said = String::from_utf8_lossy(&output.stderr);
    let counted = references(&said).filter(|_| output.status.success());
    counted.ok_or_else(|| Fault::Valgrind {
        reason: format!(
            "{command:?} ended with {} and said:\n{}",
            output.status,
            said.trim()
        ),
        absent: false,
    })
}

/// The number in cachegrind's line `==1== I   refs:      1,234`.
fn references(said: &str) -> Option<u64> {
    let mut lines = said.lines().filter_map(|line| line.split_once("refs:"));
    let (_, number) = lines.find(|(name, _)| name.split_whitespace().last() == Some("I"))?;
    number.trim().replace(',', "").parse().ok()
}

#[cfg(test)]
mod tests {
    use super::references;

    #[test]
    fn the_count_is_found_in_what_cachegrind_says() {
        let said = "==7== Command: x refs: 1\n==7== \n==7== I   refs:      4,421,488\n";
        assert_eq!(references(said), Some(4_421_488));
        assert_eq!(
            references("==7== I refs: 12\n==7== I1  misses: 3"),
            Some(12)
        );
        assert_eq!(references("valgrind: failed to start"), None);
    }
}
