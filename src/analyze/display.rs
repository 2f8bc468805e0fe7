//! The part of each axis that figures show.

use std::ops::Range;

use super::axes::{Axes, Grid, Side};
use super::plan::Plan;
use super::request::Request;
use super::rows::SpatialPassResult;
use super::spacetime::ByDirection;
use super::stages::FromRecords;
use crate::error::{Error, Result};
use crate::numeric::sum;

/// Share of the energy beyond an end, at most.
const BEYOND: f64 = 1e-3;

/// Bins shown around those that hold the rest, over their number.
const MARGIN: f64 = 0.05;

/// Least number of bins of the unpadded length from 0 to the end.
const FEW: f64 = 8.0;

/// An end of an axis stays where less than this share of it would be cut.
const LEAST_CUT: f64 = 0.1;

/// Which part of an axis figures show, in the units of the axis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum ShowAxis {
    /// What has energy; see [`Display`].
    #[default]
    Auto,
    /// Up to here; wavenumbers of both signs.
    UpTo(f64),
    /// From `low` to `high`, which may be infinite. Of wavenumbers the sign counts where a figure
    /// has both signs.
    Interval { low: f64, high: f64 },
}

/// Which part of each axis figures show.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Show {
    pub frequency: ShowAxis,
    pub wavenumber: ShowAxis,
    pub time: ShowAxis,
    pub space: ShowAxis,
}

/// The part of an axis that figures show, and what they leave out.
#[derive(Debug, Clone, PartialEq)]
pub struct Extent {
    /// First and last bin (time, site) shown, by index.
    pub bins: Range<usize>,
    /// Their coordinates.
    pub low: f64,
    pub high: f64,
    /// Shares of the energy below and above, which are not shown; NaN where the energy along the axis
    /// is not known, since no result needs it.
    pub below: f64,
    pub above: f64,
    /// Number of bins of the axis.
    pub count: usize,
}

impl Extent {
    /// Whether nothing of the axis is left out.
    pub fn is_whole(&self) -> bool {
        self.bins == (0..self.count)
    }
}

/// The part of each axis that figures show.
///
/// With the energy `E_m` of bin m (time, site), summed over the other axis, each end is cut where at most a thousandth of the
/// energy lies beyond, at least a tenth of the axis. Around what is left a twentieth of it is shown, and at least eight bins.
/// Axes of frequency and wavenumber are cut at their upper end, and the mean does not count; both signs of wavenumbers end
/// alike. An axis is whole without energy, where no result gives the energy along it, and without
/// [maps](super::Request::maps).
#[derive(Debug, Clone, PartialEq)]
pub struct Display([Extent; 5]);

impl Grid {
    /// Bins from `low` to `high`; ends that fall on a bin up to rounding belong to it.
    fn between(&self, (low, high): (f64, f64)) -> Range<usize> {
        let [a, b] = [low, high].map(|end| (end - self.first) / self.step);
        let first = (a.min(b) - 1e-6).ceil().max(0.0);
        let last = (a.max(b) + 1e-6).floor();
        if last < first {
            return 0..0;
        }
        // Saturating casts: ends may be infinite.
        first as usize..(last as usize).saturating_add(1).min(self.count)
    }

    /// What is shown where the energies are those along the axis; `few`: of a spectrum from 0, with so many bins at least.
    fn extent(&self, show: ShowAxis, energies: Option<&[f64]>, few: Option<f64>) -> Extent {
        let energies = energies.filter(|energies| energies.len() == self.count);
        let bins = match (show.ends(self.first), energies) {
            (Some(ends), _) => self.between(ends),
            (None, Some(energies)) => heard(energies, few),
            (None, None) => 0..self.count,
        };
        let share = |part: Range<usize>| match energies.map(|all| sum(&all[part]) / sum(all)) {
            Some(share) if share.is_finite() => share,
            _ => f64::NAN,
        };
        Extent {
            low: self.at(bins.start),
            high: self.at(bins.end.max(bins.start + 1) - 1),
            below: share(0..bins.start),
            above: share(bins.end..self.count),
            count: self.count,
            bins,
        }
    }
}

impl ShowAxis {
    /// Ends of what is to be shown of an axis that begins at `first`; `None` where the result
    /// decides.
    fn ends(self, first: f64) -> Option<(f64, f64)> {
        match self {
            ShowAxis::Auto => None,
            ShowAxis::UpTo(high) => Some((first, high)),
            ShowAxis::Interval { low, high } => Some((low, high)),
        }
    }

    /// That the limits lie on an axis from `first` to its end, in order, and hold a bin.
    fn check(self, option: &'static str, axis: Grid, first: f64) -> Result<()> {
        let Some((low, high)) = self.ends(first) else {
            return Ok(());
        };
        let last = axis.at(axis.count - 1);
        let slack = 0.5 * axis.step + 1e-9 * (last - first);
        let is_inside =
            |end: f64| end.is_infinite() || (first - slack..=last + slack).contains(&end);
        let lowest = axis.first.min(last);
        let holds = high >= lowest && !axis.between((low.max(lowest), high)).is_empty();
        if low < high && is_inside(low) && is_inside(high) && holds {
            return Ok(());
        }
        let digits = crate::measure::digits;
        let expected = format!(
            "limits within {}:{} with a bin between them, the lower one first, or all",
            digits(first),
            digits(last)
        );
        let found = match self {
            ShowAxis::UpTo(high) => high.to_string(),
            _ => format!("{low}:{high}"),
        };
        Err(Error::request(option, expected, found))
    }
}

/// That all limits lie on the axes of the results, and that there is a picture to show.
pub(super) fn check(request: &Request, axes: &Axes) -> Result<()> {
    let show = &request.show;
    if !request.maps && *show != Show::default() {
        let expected = "maps, which the display limits are for";
        return Err(Error::request("show", expected, "none"));
    }
    let grid = |side: Side| side.grid(axes);
    let wavenumber = grid(Side::Wavenumber);
    let lowest = match show.wavenumber {
        ShowAxis::Interval { .. } => -wavenumber.at(wavenumber.count - 1),
        _ => 0.0,
    };
    let [time, space] = [Side::Time, Side::Space].map(grid);
    (show.frequency).check("show-frequency", grid(Side::Frequency), 0.0)?;
    (show.wavenumber).check("show-wavenumber", wavenumber, lowest)?;
    show.time.check("show-time", time, time.first)?;
    show.space.check("show-space", space, space.first)
}

impl Display {
    /// The display limits of what the passes found.
    pub(super) fn find(plan: &Plan, records: &FromRecords, rows: &SpatialPassResult) -> Display {
        let axes = &plan.axes;
        let (columns, spacetime) = (records.columns.as_ref(), records.spacetime.as_ref());
        let of_both = spacetime.map(|found| &found.wavenumber_energies[..]);
        let folded = of_both.map(|both| folded(both, axes.wavenumber.len()));
        let by_direction = spacetime.map(|found| found.directions.iter());
        let by_direction: Option<Vec<f64>> =
            by_direction.map(|of| of.map(ByDirection::total).collect());
        let of_columns = columns.and_then(|columns| columns.frequency_energies.as_deref());
        let of_times: Vec<f64> = rows.ends.iter().map(|ends| ends.energy).collect();
        let energies = [
            Some(&of_times[..]),
            columns.map(|columns| &columns.energies[..]),
            by_direction.as_deref().or(of_columns),
            folded.as_deref().or(rows.wavenumber_energies.as_deref()),
            of_both,
        ];
        let show = &plan.request.show;
        let part = |side: Side, show: ShowAxis, padding: Option<f64>| {
            let few = padding.map(|padding| FEW * padding);
            let energies = energies[side as usize].filter(|_| plan.request.maps);
            side.grid(axes).extent(show, energies, few)
        };
        let in_space = Some(plan.padding_space());
        let wavenumber = part(Side::Wavenumber, show.wavenumber, in_space);
        let both = match show.wavenumber {
            interval @ ShowAxis::Interval { .. } => interval,
            _ => ShowAxis::Interval {
                low: -wavenumber.high,
                high: wavenumber.high,
            },
        };
        let frequency = Side::Frequency;
        Display([
            part(Side::Time, show.time, None),
            part(Side::Space, show.space, None),
            part(frequency, show.frequency, Some(plan.padding_time())),
            wavenumber,
            part(Side::SignedWavenumber, both, None),
        ])
    }

    /// What figures show of an axis.
    pub(crate) fn part(&self, side: Side) -> &Extent {
        &self.0[side as usize]
    }

    /// Of all axes, with the names of their arrays. Wavenumbers of both signs are those of figures that have both.
    pub fn parts(&self) -> impl Iterator<Item = (&'static str, &Extent)> {
        Side::ALL.into_iter().map(Side::name).zip(&self.0)
    }
}

/// Bins that hold all but a thousandth of the energy at each end, with some around them; each end whole where little would be
/// cut. `few`: of a spectrum from 0, whose mean does not count, with so many bins at least.
fn heard(energies: &[f64], few: Option<f64>) -> Range<usize> {
    let count = energies.len();
    let beyond = BEYOND * sum(&energies[few.map_or(0, |_| 1)..]);
    if !(beyond > 0.0 && beyond.is_finite()) {
        return 0..count;
    }
    let quiet = |rest: &mut f64, energy: &f64| {
        *rest -= energy;
        (*rest >= 0.0).then_some(())
    };
    let below = match few {
        Some(_) => 0,
        None => energies.iter().scan(beyond, quiet).count(),
    };
    let above = energies.iter().rev().scan(beyond, quiet).count();
    let around = MARGIN * (count - above - below) as f64;
    let start = below.saturating_sub(around.ceil() as usize);
    let end = (count - above) as f64 + around;
    let end = (end.max(few.unwrap_or(0.0) + 1.0).ceil() as usize).min(count);
    let is_cut = |cut: usize| cut as f64 >= LEAST_CUT * count as f64;
    let start = if is_cut(start) { start } else { 0 };
    start..if is_cut(count - end) { end } else { count }
}

/// Sums over both signs of an ascending axis of wavenumbers, to `count` bins from 0.
fn folded(both: &[f64], count: usize) -> Vec<f64> {
    let zero = both.len() / 2;
    let mut one = vec![0.0; count];
    for (index, energy) in both.iter().enumerate() {
        if let Some(bin) = one.get_mut(index.abs_diff(zero)) {
            *bin += energy;
        }
    }
    one
}
