//! The shifts of the records of a scan.

use super::super::align::{Alignment, Apart, Shift};
use super::super::options::OpenOptions;
use super::Scan;
use super::position::fault_of;
use super::records::Head;
use crate::error::{Result, ScanFault};

/// By the delays of the references, else by the times of the files.
pub(super) fn alignment(scan: &Scan, heads: &[Head], options: &OpenOptions) -> Result<Alignment> {
    let (jitter, method) = (options.jitter, options.resample.time);
    let first = &heads[0].time;
    let shift = |head: &Head| -> Result<Shift> {
        if let (Some(_), Some(delay)) = (&scan.reference, head.delay) {
            let left = Shift {
                whole: -delay.samples,
                fraction: 0.0,
                left: -delay.fraction,
            };
            let exact = left.total();
            let resampled = method.and_then(|_| Shift::of(exact, jitter, method));
            return Ok(resampled.unwrap_or(left));
        }
        let shift = (head.time.origin - first.origin) / first.step;
        let parts = Shift::of(shift, jitter, method);
        parts.ok_or_else(|| fault_of(&head.path, ScanFault::Fraction { shift }))
    };
    let shifts = heads.iter().map(shift).collect::<Result<Vec<_>>>()?;
    let lengths = heads.iter().map(|head| head.n_times).collect();
    Alignment::new(shifts, lengths, method).map_err(|Apart { early, late }| {
        let other = heads[late].path.clone();
        fault_of(&heads[early].path, ScanFault::NoCommonTime { other })
    })
}
