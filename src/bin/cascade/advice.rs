//! What the user can do about errors and warnings, with the options that mend them.

use std::io::ErrorKind;
use std::path::Path;

use wavecascade::Error;
use wavecascade::chain::RunWarning;
use wavecascade::sheet::Warning;

use crate::examples::names;

/// Of an error, where there is something to do.
pub fn of_error(error: &Error) -> Option<String> {
    let advice = match error {
        Error::Input { fault, .. } => fault.advice(),
        Error::Scan { fault, .. } | Error::Failed(fault) | Error::Unresolved(fault) => {
            &fault.advice
        }
        Error::Scene { fault } => &fault.fault.advice,
        Error::Read { source, path, .. } if source.kind() == ErrorKind::NotFound => {
            return Some(of_missing(path));
        }
        Error::NonFinite { .. } => {
            "state what to do with gaps: `--gaps interpolate` fills them along time, \
             `--gaps mask` gives them no weight; averages of segments (`cascade spectrum`) can leave out those \
             that hold them with `--gaps leave-out`"
        }
        Error::Changed { .. } => {
            "repeat the command once nothing writes to the file, or on a copy (`--read copy`)"
        }
        Error::Exists { .. } => "name another place, or add `--force` to replace it",
        Error::Busy { .. } => "wait for it, or compute parts in directories of their own",
        Error::Damaged { .. } => "begin anew elsewhere",
        Error::Paused { .. } => "the same command goes on from there",
        Error::OutputInUse { .. } => "name another place",
        Error::Memory { .. } => {
            "raise `--memory`, choose fewer sites or times, shorter segments or fewer tapers, or ask for less: \
             `--threads 1`, `--only`, `--equal-weights`"
        }
        Error::Refused { .. } => {
            "lower `--memory`, choose fewer sites or times, use `--threads 1`, or raise the limit \
             (`ulimit -v`, that of the container)"
        }
        Error::Write { source, .. } => match source.kind() {
            ErrorKind::FileTooLarge => "raise the allowed size of files: `ulimit -f unlimited`",
            ErrorKind::QuotaExceeded | ErrorKind::StorageFull => {
                "free some space, or write elsewhere with `--out`"
            }
            _ => "write elsewhere with `--out`",
        },
        _ => return None,
    };
    (!advice.is_empty()).then(|| advice.into())
}

fn of_missing(path: &Path) -> String {
    let name = path.file_stem().unwrap_or_default();
    match names().find(|example| name == *example) {
        Some(name) => format!("`cascade examples {name}` writes it here"),
        None => "check the path; a relative one starts at the current directory".into(),
    }
}

/// A finding about a run, with what to do about it.
pub fn of_run(warning: &RunWarning) -> Warning {
    let advice = match warning {
        RunWarning::Amplifies { .. } => {
            "state a `tolerance` larger than what rounding leaves, or an earlier `end_time`; where \
             single velocities are not to be had, compare energies and spectra, over several seeds"
        }
        RunWarning::Rounding { .. } => "state a larger `tolerance` or an earlier `end_time`",
        RunWarning::OutsideLaw { .. } => "give the law over a wider range, or a weaker impact",
        RunWarning::EnergyBalance { .. } => {
            "state a smaller `tolerance`, or with a method of fixed steps a smaller `step`"
        }
        _ => "",
    };
    Warning::new(warning.message(), advice)
}
