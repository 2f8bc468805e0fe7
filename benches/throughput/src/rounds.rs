//! Implementations timed in interleaved rounds, and the evaluation of their times.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

use serde::Serialize;

use crate::{Buffer, CaseOf, Description, Implementation};
use crate::{Error, Result};
use wavecascade_system::threads::in_pool;

/// The clock that times are measured with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Clock {
    /// CPU time of the calling thread. Other load matters only through shared caches and memory.
    Thread,
    /// Wall-clock time.
    Wall,
}

impl Clock {
    /// Wall-clock time for several threads, and on systems without per-thread CPU time.
    fn of(threads: usize) -> Clock {
        match threads {
            1 if cfg!(unix) => Clock::Thread,
            _ => Clock::Wall,
        }
    }

    /// The duration of `work`.
    pub fn milliseconds(self, work: impl FnOnce()) -> f64 {
        let (start, waited) = (self.thread_seconds(), Instant::now());
        work();
        1e3 * match self.thread_seconds().zip(start) {
            Some((end, start)) => end - start,
            None => waited.elapsed().as_secs_f64(),
        }
    }

    fn thread_seconds(self) -> Option<f64> {
        #[cfg(unix)]
        if self == Clock::Thread {
            let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
            return Some(time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64);
        }
        None
    }
}

/// The number of rounds, and the implementations that run in each.
#[derive(Debug, Clone)]
pub struct Rounds {
    /// Timed rounds; one warm-up round precedes them.
    pub rounds: usize,
    pub ways: Vec<Implementation>,
}

/// The results of the rounds of a case.
#[derive(Debug, Clone, Serialize)]
pub struct Throughput {
    #[serde(flatten)]
    pub case: CaseOf,
    /// Our algorithm.
    pub method: String,
    /// [`column_fft::RealToComplexColumns::expected_error`]; of other kinds none is stated.
    pub expected_error: Option<f64>,
    pub median_ms: f64,
    /// [`CaseOf::operations`] over the median time.
    pub gflops: f64,
    /// Bytes per second that a copy reads and writes: [`copy_rate`].
    pub copy_bytes_per_second: f64,
    /// Time to transfer array and spectra at the rate of the copy, over the median time.
    pub part_of_bound: f64,
    /// Time of each other implementation relative to ours: [`Throughput::ratio`].
    pub ratio_to: BTreeMap<Implementation, f64>,
    pub clock: Clock,
    /// All times by that clock, round by round.
    pub times_ms: BTreeMap<Implementation, Vec<f64>>,
}

impl Rounds {
    /// Runs all implementations of a case in interleaved rounds.
    ///
    /// # Errors
    /// As [`CaseOf::prepare`]; [`crate::Error::Threads`] without threads.
    pub fn measure(&self, case: CaseOf) -> Result<Throughput> {
        let mut arrays = case.prepare()?;
        let mut times: BTreeMap<Implementation, Vec<f64>> = BTreeMap::new();
        let clock = Clock::of(case.threads);
        in_pool(Some(case.threads), || {
            for round in 0..=self.rounds {
                for &way in &self.ways {
                    let time = clock.milliseconds(|| arrays.run(way, case.threads > 1));
                    if round > 0 {
                        times.entry(way).or_default().push(time);
                    }
                }
            }
        })
        .map_err(|error| Error::Threads {
            threads: case.threads,
            reason: error.to_string(),
        })?;
        let about = arrays.about();
        // Frees the memory that the copy needs.
        drop(arrays);
        Ok(Throughput::new(
            case,
            about,
            copy_rate(case.threads)?,
            times,
        ))
    }
}

impl Throughput {
    fn new(
        case: CaseOf,
        about: Description,
        copy_bytes_per_second: f64,
        times_ms: BTreeMap<Implementation, Vec<f64>>,
    ) -> Throughput {
        let ours = &times_ms[&Implementation::Cascade];
        let median_ms = median(ours.clone());
        let ratio = |times: &Vec<f64>| median(times.iter().zip(ours).map(|(t, o)| t / o).collect());
        let ratio_to = times_ms
            .iter()
            .filter(|(way, _)| **way != Implementation::Cascade);
        let bytes = case.bytes() as f64;
        Throughput {
            case,
            method: about.method,
            expected_error: about.expected_error,
            median_ms,
            gflops: case.operations() / median_ms / 1e6,
            copy_bytes_per_second,
            part_of_bound: 1e3 * bytes / copy_bytes_per_second / median_ms,
            ratio_to: ratio_to.map(|(&way, times)| (way, ratio(times))).collect(),
            clock: Clock::of(case.threads),
            times_ms,
        }
    }

    /// Median over rounds of another implementation's time over ours; NaN if it did not run.
    pub fn ratio(&self, way: Implementation) -> f64 {
        self.ratio_to.get(&way).copied().unwrap_or(f64::NAN)
    }
}

/// A table with a header and one line per case.
pub fn table(found: &[Throughput]) -> String {
    let ways: Vec<Implementation> = found
        .first()
        .map_or(Vec::new(), |f| f.ratio_to.keys().copied().collect());
    let mut text = String::from(
        "      kind        shape  type  threads        ms  GFLOP/s  of bound  rel. error",
    );
    for way in &ways {
        let _ = write!(text, "  {}", way.name());
    }
    text.push('\n');
    for f in found {
        let CaseOf {
            kind,
            shape,
            precision,
            threads,
        } = f.case;
        let error = f.expected_error;
        let error = error.map_or("-".into(), |error| format!("{error:.1e}"));
        let _ = write!(
            text,
            "{kind:>10}  {:>11}   {}  {threads:>7} {:>9.3} {:>8.1} {:>9.3}  {error:>10}",
            shape.to_string(),
            crate::case::name(precision),
            f.median_ms,
            f.gflops,
            f.part_of_bound,
        );
        for way in &ways {
            let ratio = format!("x {:.2}", f.ratio(*way));
            let _ = write!(text, "  {ratio:>width$}", width = way.name().len());
        }
        text.push('\n');
    }
    text
}

/// The median; the upper one for an even number of values, NaN for none.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// What [`copy_rate`] holds: as much is copied as there is room to copy to.
pub(crate) const COPIED_BYTES: u64 = 256 << 20;

/// Bytes per second read and written when `threads` threads copy 128 MiB in total: the best of
/// nine.
///
/// # Errors
/// [`crate::Error::Memory`] where there is no memory.
pub fn copy_rate(threads: usize) -> Result<f64> {
    let bytes = (COPIED_BYTES / 2) as usize;
    let (mut from, mut to) = (Buffer::new(bytes)?, Buffer::new(bytes)?);
    from.of::<u8>().fill(1);
    to.of::<u8>().fill(2);
    let part = bytes.div_ceil(threads);
    let mut copy = || {
        let start = Instant::now();
        std::thread::scope(|scope| {
            for (from, to) in from
                .of::<u8>()
                .chunks(part)
                .zip(to.of::<u8>().chunks_mut(part))
            {
                scope.spawn(move || to.copy_from_slice(black_box(from)));
            }
        });
        start.elapsed().as_secs_f64()
    };
    let best = (0..9).map(|_| copy()).fold(f64::INFINITY, f64::min);
    Ok(2.0 * bytes as f64 / best)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Precision;
    use crate::{ArrayShape, TransformKind};

    /// By hand: bytes, operations and ratios of a case with known times.
    #[test]
    fn val_figures_follow_from_the_times() {
        let case = CaseOf {
            kind: TransformKind::Columns,
            shape: ArrayShape::new(1024, 100),
            precision: Precision::F32,
            threads: 1,
        };
        let times = BTreeMap::from([
            (Implementation::Cascade, vec![2.0, 4.0, 1.0]),
            (Implementation::Rustfft, vec![6.0, 8.0, 5.0]),
        ]);
        let about = Description {
            method: String::new(),
            expected_error: Some(1e-7),
        };
        let found = Throughput::new(case, about, 1e9, times);
        assert_eq!(found.median_ms, 2.0);
        assert_eq!(found.ratio(Implementation::Rustfft), 3.0);
        assert!(found.ratio(Implementation::Realfft).is_nan());
        assert_eq!(found.gflops, 2.5 * 1024.0 * 10.0 * 100.0 / 2e-3 / 1e9);
        // 1024 samples and 513 bins of two numbers, four bytes each, at a gigabyte a second.
        let bound_ms = 100.0 * (1024.0 + 2.0 * 513.0) * 4.0 / 1e9 * 1e3;
        assert!((found.part_of_bound / (bound_ms / 2.0) - 1.0).abs() < 1e-12);
        let table = table(&[found]);
        assert!(
            table.contains("1024x100   f32        1     2.000"),
            "{table}"
        );
        assert!(table.contains("x 3.00"), "{table}");
    }

    #[test]
    fn medians_are_in_the_middle() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert!(median(Vec::new()).is_nan());
    }
}
