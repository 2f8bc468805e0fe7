//! Messages of failures, and their exit codes.

use std::io::Write;
use std::process::ExitCode;

use wavecascade::Error;
use wavecascade::chain::scene::KeyPlace;

use crate::advice;
use crate::bench::Fault;

/// Why a command did not end well.
#[derive(Debug)]
pub enum Failure {
    Library(Error),
    /// Number of runs of a sweep that failed.
    Members(usize),
    /// Number of chains that failed.
    Chains(usize),
    /// Number of orders whose localized wave could not be resolved.
    Orders(usize),
    /// Throughput was lost, or could not be compared.
    Bench(Fault),
    /// Throughput could not be measured.
    Throughput(wavecascade_throughput::Error),
    /// Standard output was closed or could not be written.
    Output(std::io::Error),
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Failure::Library(error)
    }
}

impl From<wavecascade_throughput::Error> for Failure {
    fn from(error: wavecascade_throughput::Error) -> Self {
        Failure::Throughput(error)
    }
}

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        Failure::Output(error)
    }
}

/// As shells count an interrupt.
pub const INTERRUPTED: u8 = 130;

impl Failure {
    /// Prints it to standard error. 2: the request was wrong; 1: the run failed; 130: interrupted.
    pub fn report(&self) -> ExitCode {
        let mut err = std::io::stderr().lock();
        // Nothing can be done where even this cannot be written.
        let _ = match self {
            Failure::Library(Error::Request {
                option,
                expected,
                found,
            }) => writeln!(err, "error: --{option}: expected {expected}, found {found}"),
            // A key that is missing where there is no file is an option that is missing.
            Failure::Library(Error::Scene { fault })
                if fault.place == KeyPlace::Nowhere && !fault.key.is_empty() =>
            {
                let option = fault.key.replace('_', "-");
                writeln!(
                    err,
                    "error: --{}",
                    fault.to_string().replacen(&fault.key, &option, 1)
                )
            }
            Failure::Library(error) => writeln!(err, "error: {error}"),
            Failure::Members(failed) => writeln!(
                err,
                "error: {failed} of the runs failed; the last column of the table says why"
            ),
            Failure::Chains(failed) => writeln!(
                err,
                "error: {failed} of the chains could not be followed, for reasons given under `failed`; the others stand"
            ),
            Failure::Orders(unresolved) => writeln!(
                err,
                "error: {unresolved} of the orders could not be resolved; the others stand"
            ),
            Failure::Bench(fault) => writeln!(err, "error: {fault}"),
            Failure::Throughput(error @ wavecascade_throughput::Error::Shape { .. }) => {
                writeln!(err, "error: --shape: {error}")
            }
            Failure::Throughput(error) => writeln!(err, "error: {error}"),
            // A reader that went away (`cascade ... | head`) has read enough: no failure.
            Failure::Output(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
            Failure::Output(error) => {
                writeln!(err, "error: cannot write to standard output: {error}")
            }
        };
        if let Failure::Library(error) = self
            && let Some(advice) = advice::of_error(error)
        {
            let _ = writeln!(err, "help: {advice}");
        }
        if let Failure::Bench(fault) = self {
            let _ = writeln!(err, "help: {}", fault.advice());
        }
        if let Failure::Throughput(wavecascade_throughput::Error::Baseline { .. }) = self {
            let _ = writeln!(
                err,
                "help: record a new one with `cascade bench --record FILE`, or name another with `--baseline`"
            );
        }
        match self {
            Failure::Library(Error::Cancelled | Error::Paused { .. }) => {
                ExitCode::from(INTERRUPTED)
            }
            Failure::Library(error) if error.is_usage() => ExitCode::from(2),
            Failure::Throughput(wavecascade_throughput::Error::Shape { .. }) => ExitCode::from(2),
            Failure::Output(error) if error.kind() == std::io::ErrorKind::BrokenPipe => {
                ExitCode::SUCCESS
            }
            _ => ExitCode::from(1),
        }
    }
}
