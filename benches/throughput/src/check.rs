//! Comparison of results with the baseline.

use std::collections::BTreeMap;
use std::fmt::{self, Write};

use throughput::{Comparison, LARGEST_LOSS};

use crate::Failure;

/// Why a bench did not end well.
#[derive(Debug)]
pub enum Fault {
    /// The baseline lacks this machine or build, or some cases.
    Unknown {
        place: String,
        baseline: String,
        /// All where nothing is known of the place.
        cases: Option<Vec<String>>,
    },
    /// Cases that lost too much.
    Lost {
        lost: Vec<Comparison>,
        of: usize,
        baseline: String,
        unit: &'static str,
    },
    /// Instructions could not be counted.
    Valgrind { reason: String, absent: bool },
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fault::Unknown {
                place,
                baseline,
                cases: None,
            } => {
                write!(f, "{baseline} has no baseline for {place}")
            }
            Fault::Unknown {
                place,
                baseline,
                cases: Some(cases),
            } => write!(
                f,
                "{baseline} has no baseline for these cases on {place}: {}",
                cases.join("; ")
            ),
            Fault::Lost {
                lost,
                of,
                baseline,
                unit,
            } => {
                let percent = 100.0 * LARGEST_LOSS;
                write!(
                    f,
                    "{} of {of} cases lost more than {percent} % of the throughput in {baseline}:",
                    lost.len()
                )?;
                lost.iter().try_for_each(|c| {
                    let Comparison {
                        case,
                        baseline,
                        found,
                        kept,
                    } = c;
                    let lost = 100.0 * (1.0 - kept);
                    write!(
                        f,
                        "\n  {case}: {baseline:.3} {unit}, now {found:.3}: {lost:.1} % lost"
                    )
                })
            }
            Fault::Valgrind { reason, .. } => write!(f, "cannot count instructions: {reason}"),
        }
    }
}

impl Fault {
    /// What can be done about it.
    pub fn advice(&self) -> &'static str {
        match self {
            Fault::Unknown { .. } => {
                "record one from a version that is known to be fast, on a quiet machine: `--record FILE \
                 --rounds 200` (for counts `--instructions --record FILE`), and compare \
                 with `--check --baseline FILE`; FILE may be benches/baseline.json of the repository"
            }
            Fault::Lost { .. } => {
                "where the change is meant to cost this, record a new baseline: the same command with \
                 `--record FILE` in place of `--check`; otherwise look at what changed in \
                 crates/column-fft/src/columns, the compiler or the versions above"
            }
            Fault::Valgrind { absent: true, .. } => {
                "install it (`apt-get install valgrind`, `dnf install valgrind`), or compare times: \
                 leave `--instructions` out"
            }
            Fault::Valgrind { absent: false, .. } => {
                "run the command above by hand, or compare times: leave `--instructions` out"
            }
        }
    }
}

/// The baseline, if it has all `cases`.
pub fn known(
    known: BTreeMap<String, f64>,
    cases: impl Iterator<Item = String>,
    place: impl Fn() -> String,
    baseline: &str,
) -> Result<BTreeMap<String, f64>, Failure> {
    let unknown = |cases| {
        Failure::Bench(Fault::Unknown {
            place: place(),
            baseline: baseline.into(),
            cases,
        })
    };
    if known.is_empty() {
        return Err(unknown(None));
    }
    let missing: Vec<String> = cases.filter(|case| !known.contains_key(case)).collect();
    match missing.is_empty() {
        true => Ok(known),
        false => Err(unknown(Some(missing))),
    }
}

/// The baseline, if it has any of `cases`, and the cases that it lacks.
pub fn known_of_some(
    all: BTreeMap<String, f64>,
    cases: impl Iterator<Item = String>,
    place: impl Fn() -> String,
    baseline: &str,
) -> Result<(BTreeMap<String, f64>, Vec<String>), Failure> {
    let (told, missing): (Vec<_>, Vec<_>) = cases.partition(|case| all.contains_key(case));
    // Where nothing can be compared, that is a failure.
    let needed = if told.is_empty() {
        missing.clone()
    } else {
        told
    };
    let known = known(all, needed.into_iter(), place, baseline)?;
    Ok((known, missing))
}

/// Which cases are not compared; nothing where all are.
pub fn not_compared(cases: &[String], baseline: &str) -> String {
    match cases {
        [] => String::new(),
        _ => format!(
            "\nnot compared, since {baseline} has no baseline for them here (`--record FILE` makes \
             one): {}\n",
            cases.join("; ")
        ),
    }
}

/// A line a case; nothing where nothing is compared.
pub fn text(check: Option<&[Comparison]>, unit: &str) -> String {
    let Some(check) = check else {
        return String::new();
    };
    let mut text = format!(
        "\n{:<36} {:>12} {:>12} {:>12}\n",
        "case", "baseline", "now", "speed"
    );
    for Comparison {
        case,
        baseline,
        found,
        kept,
    } in check
    {
        let (baseline, found) = (
            format!("{unit} {baseline:.3}"),
            format!("{unit} {found:.3}"),
        );
        let change = 100.0 * (kept - 1.0);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{case:<36} {baseline:>12} {found:>12} {change:>+10.1} %"
        );
    }
    text
}

/// A failure where a case lost too much.
pub fn verdict(
    check: Option<Vec<Comparison>>,
    unit: &'static str,
    baseline: String,
) -> Result<(), Failure> {
    let check = check.unwrap_or_default();
    let of = check.len();
    let lost: Vec<Comparison> = check.into_iter().filter(Comparison::is_loss).collect();
    match lost.is_empty() {
        true => Ok(()),
        false => Err(Failure::Bench(Fault::Lost {
            lost,
            of,
            baseline,
            unit,
        })),
    }
}
