//! The survey of all samples before the transforms: time by time if that suffices, otherwise record
//! by record.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::extremes::Extremes;
use super::scan::{self, ChannelScan, Gap};
use super::{Gaps, Prepared};
use crate::error::{Error, Result};
use crate::field::Field;
use crate::numeric::pieces;
use crate::observer::Observer;

/// Samples per stretch of times.
const STRETCH: usize = 1 << 16;

/// Bytes per gap while gaps are collected: twice by site, once by time.
const GAP_BYTES: u64 = 3 * size_of::<Gap>() as u64;

/// Times per stretch, if they are contiguous.
fn stretch(field: &Field) -> usize {
    (STRETCH / field.n_sites()).max(1)
}

/// Bytes of scratch per thread for samples that must be decoded or copied.
pub(crate) fn survey_bytes(field: &Field, n_sites: usize) -> u64 {
    match field.is_time_major() {
        true => 8 * (stretch(field) + 1) as u64 * n_sites as u64,
        false => 0,
    }
}

impl Prepared<'_> {
    /// What each record holds; keeps account of its gaps.
    pub(super) fn scan(&mut self, gaps: Gaps, observer: &dyn Observer) -> Result<Vec<ChannelScan>> {
        let mut scans = match self.field.is_time_major() {
            true => self.extremes(observer)?.scans(),
            false => vec![None; self.n_sites()],
        };
        for (scan, _) in scans.iter_mut().zip(&self.left_out).filter(|of| *of.1) {
            *scan = Some(ChannelScan::default());
        }
        let is_open = |j: usize| scans[j].is_none();
        if (0..self.n_sites()).any(is_open) {
            observer.stage("looking at the samples", self.n_sites() as u64);
        }
        let room = (self.tiles.memory / GAP_BYTES) as usize;
        let kept = AtomicUsize::new(0);
        let found = self.each_record_of(is_open, observer, |j, record, _| {
            let scan = ChannelScan::of(record);
            // Past the limit gaps are still counted, but no longer kept.
            let is_kept = kept.fetch_add(scan.gaps, Ordering::Relaxed) + scan.gaps <= room;
            let filled = match scan.gaps > 0 && gaps != Gaps::Refuse && is_kept {
                true => scan::fill(record, j, gaps),
                false => Vec::new(),
            };
            (scan, filled)
        })?;
        let looked_at = found.iter().map(|of| of.as_ref().map(|(scan, _)| *scan));
        let scans = scans.into_iter().zip(looked_at);
        let scans: Vec<ChannelScan> = scans.filter_map(|(scan, of)| scan.or(of)).collect();
        let count: u64 = scans.iter().map(|s: &ChannelScan| s.gaps as u64).sum();
        if count > 0 && gaps == Gaps::Refuse {
            let gaps = scans.iter().zip(self.sites.clone());
            let gaps = gaps.filter_map(|(s, j)| Some((self.times.start + s.first_gap?, j)));
            return Err(Error::NonFinite {
                name: self.field.name.clone(),
                count,
                first: gaps.min().unwrap_or_default(),
                sites: scans.iter().filter(|s| s.gaps > 0).count(),
                n_sites: scans.len(),
            });
        }
        if kept.into_inner() > room && gaps != Gaps::Refuse {
            return Err(Error::Memory {
                what: "keeping account of the gaps",
                needed: count * GAP_BYTES,
                allowed: self.tiles.memory,
            });
        }
        let filled = found.into_iter().flatten();
        self.gaps = filled.flat_map(|(_, filled)| filled).collect();
        self.gaps_by_time = self.gaps.clone();
        self.gaps_by_time.sort_by_key(|g| (g.time, g.site));
        Ok(scans)
    }

    /// Examines the samples in memory order.
    fn extremes(&self, observer: &dyn Observer) -> Result<Extremes> {
        observer.stage("looking at the samples", self.n_times() as u64);
        let none = || Extremes::none(self.n_sites());
        let parts: Vec<Range<usize>> = pieces(self.n_times(), stretch(self.field)).collect();
        // Few parts, since each has statistics of all sites.
        let least = parts.len().div_ceil(4 * rayon::current_num_threads());
        let seen = parts
            .into_par_iter()
            .with_min_len(least)
            .try_fold(none, |mut seen, times| {
                observer.go_on()?;
                // Held extremes need the previous time.
                let first = times.start.saturating_sub(1);
                let mut room = vec![0.0; (times.end - first) * self.n_sites()];
                let rows = self.snapshots(first..times.end, &mut room);
                seen.take(rows, self.n_sites(), first < times.start);
                observer.advance(times.len() as u64);
                self.release_times(first..times.end);
                Ok::<_, Error>(seen)
            })
            .try_reduce(none, |a, b| Ok(a.merged(b)));
        self.release_pages();
        seen
    }
}
