//! The part of each axis that figures show.

use std::ops::Range;

use super::columns::TemporalPassResult;
use super::plan::Plan;
use super::request::Request;
use super::result::Axes;
use super::rows::SpatialPassResult;
use super::spacetime::{ByDirection, Frequencies};
use crate::arrays::Precision;
use crate::diagnostics::MapBuilder;
use crate::error::{Error, Result};
use crate::moved::ArrivalWindows;
use crate::numeric::sum;

/// Share of the energy above the upper end of an axis of frequency or wavenumber, at most.
const BEYOND: f64 = 1e-3;

/// Bins up to the end are this many times those up to the share.
const MARGIN: f64 = 1.05;

/// Least number of bins of the unpadded length from 0 to the end.
const FEW: f64 = 8.0;

/// Magnitude, as a share of the largest, up to which times and sites are empty: no colour scale of
/// eight decades of the energy shows them.
const QUIET: f64 = 1e-4;

/// An end of an axis stays where less than this share of it would be cut.
const LEAST_CUT: f64 = 0.1;

/// Widths of the pulse that are shown before the first arrival.
const LEAD: f64 = 3.0;

/// Which part of an axis figures show, in the units of the axis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum ShowAxis {
    /// What has energy; see [`Display`].
    #[default]
    Auto,
    /// The whole axis.
    Whole,
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

impl Show {
    /// Every axis whole.
    pub const WHOLE: Show = Show {
        frequency: ShowAxis::Whole,
        wavenumber: ShowAxis::Whole,
        time: ShowAxis::Whole,
        space: ShowAxis::Whole,
    };
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
/// With the energy `E_m` of bin m, summed over the other axis of `S(k, f)` (without it, of `S(f, x)`
/// or `S(k, t)`), every bin with its one-sided weight, axes of frequency and wavenumber end at the
/// least bin M with `sum_{m > M} E_m <= 0.001 sum_{m > 0} E_m`, a twentieth beyond it, and at eight
/// bins at least: at most 0.1 % of the energy is not shown, and the mean does not count. Both signs
/// of wavenumbers end alike. Times and positions are whole, but for ends of at least a tenth of the
/// axis at which the field stays below 1e-4 of its largest magnitude; of a measured wave that arrives, times are those from
/// a little before its first arrival to the end of the last window of the answer. A field without energy is shown
/// whole, and so is every axis without [maps](super::Request::maps).
#[derive(Debug, Clone, PartialEq)]
pub struct Display {
    pub frequency: Extent,
    pub wavenumber: Extent,
    /// Of figures with both signs of the wavenumber.
    pub wavenumber_signed: Extent,
    pub time: Extent,
    pub space: Extent,
}

/// An axis of bins.
#[derive(Debug, Clone, Copy)]
struct BinAxis {
    first: f64,
    step: f64,
    count: usize,
}

impl BinAxis {
    fn at(&self, bin: usize) -> f64 {
        self.first + bin as f64 * self.step
    }

    /// Bins from `low` to `high`; ends that fall on a bin up to rounding belong to it.
    fn between(&self, (low, high): (f64, f64)) -> Range<usize> {
        let first = ((low - self.first) / self.step - 1e-6).ceil().max(0.0);
        let last = ((high - self.first) / self.step + 1e-6).floor();
        if last < first {
            return 0..0;
        }
        // Saturating casts: ends may be infinite.
        first as usize..(last as usize).saturating_add(1).min(self.count)
    }

    /// What is shown where `part` holds what is to be seen.
    fn shown(&self, show: ShowAxis, part: Range<usize>) -> Range<usize> {
        match show.ends(self.first) {
            Some(ends) => self.between(ends),
            None if show == ShowAxis::Auto => part,
            None => 0..self.count,
        }
    }

    fn extent(&self, bins: Range<usize>, energies: Option<&[f64]>) -> Extent {
        let share = |part: Range<usize>| match energies {
            Some(energies) if energies.len() == self.count => {
                let (part, all) = (sum(&energies[part]), sum(energies));
                if all > 0.0 { part / all } else { f64::NAN }
            }
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
    /// decides, or all is shown.
    fn ends(self, first: f64) -> Option<(f64, f64)> {
        match self {
            ShowAxis::Auto | ShowAxis::Whole => None,
            ShowAxis::UpTo(high) => Some((first, high)),
            ShowAxis::Interval { low, high } => Some((low, high)),
        }
    }

    /// That the limits lie on an axis from `first` to `last`, in order, and hold a bin.
    fn check(self, option: &'static str, axis: BinAxis, lowest: f64) -> Result<()> {
        let Some((low, high)) = self.ends(lowest) else {
            return Ok(());
        };
        let (first, last) = (lowest, axis.at(axis.count - 1));
        let slack = 0.5 * axis.step + 1e-9 * (last - first);
        let is_inside =
            |end: f64| end.is_infinite() || (first - slack..=last + slack).contains(&end);
        let holds = !axis.between((low.max(axis.first), high)).is_empty();
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
    let [frequency, wavenumber, _] = binned(axes);
    let [time, space] = sampled(axes);
    let largest = wavenumber.at(wavenumber.count - 1);
    let lowest = match show.wavenumber {
        ShowAxis::Interval { .. } => -largest,
        _ => 0.0,
    };
    show.frequency.check("show-frequency", frequency, 0.0)?;
    show.wavenumber
        .check("show-wavenumber", wavenumber, lowest)?;
    show.time.check("show-time", time, time.first)?;
    show.space.check("show-space", space, space.first)
}

/// Of frequency, of wavenumber, and of wavenumbers of both signs.
fn binned(axes: &Axes) -> [BinAxis; 3] {
    let bins = [&axes.frequency, &axes.wavenumber, &axes.wavenumber_signed];
    bins.map(|bins| BinAxis {
        first: bins.first().copied().unwrap_or(0.0),
        step: match bins[..] {
            [first, second, ..] => second - first,
            _ => 1.0,
        },
        count: bins.len(),
    })
}

fn sampled(axes: &Axes) -> [BinAxis; 2] {
    let axis = |axis: &crate::field::Axis, count| BinAxis {
        first: axis.origin,
        step: axis.step,
        count,
    };
    [
        axis(&axes.time, axes.n_times),
        axis(&axes.space, axes.n_sites),
    ]
}

impl Display {
    /// Every axis whole, and nothing known of the energy along it.
    pub fn whole(axes: &Axes) -> Display {
        let whole = |axis: BinAxis| axis.extent(0..axis.count, None);
        let [frequency, wavenumber, wavenumber_signed] = binned(axes).map(whole);
        let [time, space] = sampled(axes).map(whole);
        Display {
            frequency,
            wavenumber,
            wavenumber_signed,
            time,
            space,
        }
    }

    /// The display limits of what the passes found.
    pub(super) fn find(
        plan: &Plan,
        (columns, rows, spacetime): (
            Option<&TemporalPassResult>,
            &SpatialPassResult,
            Option<&Frequencies>,
        ),
        field: Option<&MapBuilder>,
        windows: Option<&ArrivalWindows>,
    ) -> Display {
        let (axes, show) = (&plan.axes, &plan.request.show);
        if !plan.request.maps {
            return Display::whole(axes);
        }
        let [frequency, wavenumber, signed] = binned(axes);
        let of_both = spacetime.map(|found| &found.wavenumber_energies[..]);
        let of_one = match of_both {
            Some(both) => Some(folded(both, wavenumber.count)),
            None => rows.wavenumber_energies.clone(),
        };
        let precision = plan.request.precision;
        let padding = plan.padding_space();
        let end = |energies: Option<&[f64]>, padding: f64| {
            energies.and_then(|energies| end_of(energies, padding, precision))
        };
        let of_frequency: Option<Vec<f64>> = match spacetime {
            Some(found) => Some(found.directions.iter().map(ByDirection::total).collect()),
            None => columns.and_then(|columns| columns.frequency_energies.clone()),
        };
        let of_frequency = of_frequency.as_deref();
        let of_time = (!rows.energies.is_empty()).then_some(&rows.energies[..]);
        let of_space = columns.map(|columns| &columns.energies[..]);
        let heard = end(of_frequency, plan.padding_time()).unwrap_or(frequency.count);
        let frequencies = frequency.shown(show.frequency, 0..heard);
        let heard = end(of_one.as_deref(), padding).unwrap_or(wavenumber.count);
        let one_sign = wavenumber.shown(show.wavenumber, 0..heard);
        let both_signs = match show.wavenumber {
            ShowAxis::Interval { low, high } => signed.between((low, high)),
            _ if one_sign == (0..wavenumber.count) => 0..signed.count,
            _ => {
                let (zero, reach) = (signed.count / 2, one_sign.end);
                (zero + 1).saturating_sub(reach)..(zero + reach).min(signed.count)
            }
        };
        let [time, space] = sampled(axes);
        let shape = (axes.n_times, axes.n_sites);
        let loud = field.map(|field| field.louder_than(QUIET, shape));
        let (times, sites) = loud.unwrap_or((0..shape.0, 0..shape.1));
        let (times, sites) = (cut(times, shape.0), cut(sites, shape.1));
        let times = windows.and_then(|of| arriving(of, &times)).unwrap_or(times);
        Display {
            frequency: frequency.extent(frequencies, of_frequency),
            wavenumber: wavenumber.extent(one_sign, of_one.as_deref()),
            wavenumber_signed: signed.extent(both_signs, of_both),
            time: time.extent(time.shown(show.time, times), of_time),
            space: space.extent(space.shown(show.space, sites), of_space),
        }
    }
}

/// The number of bins shown of an axis that begins at 0; `None` where there is no energy, and where
/// little would be cut.
fn end_of(energies: &[f64], padding: f64, precision: Precision) -> Option<usize> {
    let (total, rest) = (sum(energies), sum(&energies[1..]));
    if !(total > 0.0 && total.is_finite()) {
        return None;
    }
    // Beside a mean that is all there is, the rest is rounding errors.
    let rounding = match precision {
        Precision::F64 => 1e-24,
        Precision::F32 => 1e-12,
    };
    let mut last = 0;
    if rest > rounding * total {
        let mut above = 0.0;
        last = energies.len() - 1;
        while last > 0 && above + energies[last] <= BEYOND * rest {
            above += energies[last];
            last -= 1;
        }
    }
    let last = (MARGIN * last as f64).max(FEW * padding).ceil() as usize;
    let least_cut = (1.0 - LEAST_CUT) * energies.len() as f64;
    ((last + 1) as f64 <= least_cut).then_some(last + 1)
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

/// The part of these times in which waves arrive, from a little before the first to the end of the last window; each end
/// as it is where little would be cut.
fn arriving(windows: &ArrivalWindows, times: &Range<usize>) -> Option<Range<usize>> {
    let arrivals = || windows.arrivals.iter().flatten();
    let lead = (LEAD * windows.width) as usize;
    let start = arrivals().min()?.saturating_sub(lead).max(times.start);
    let end = (arrivals().max()? + windows.samples).min(times.end);
    let least = (LEAST_CUT * end.checked_sub(start)? as f64) as usize;
    Some(unless_little(start..end, times, least))
}

/// The part that is heard with a fiftieth of the axis around it; each end whole where little would
/// be cut.
fn cut(heard: Range<usize>, count: usize) -> Range<usize> {
    let least = (LEAST_CUT * count as f64) as usize;
    let around = count.div_ceil(50);
    let start = heard.start.saturating_sub(around);
    let end = (heard.end + around).min(count);
    unless_little(start..end, &(0..count), least)
}

/// A part with each end as that of `all` where at most `least` would be cut there.
fn unless_little(part: Range<usize>, all: &Range<usize>, least: usize) -> Range<usize> {
    let cuts = [part.start - all.start, all.end - part.end].map(|cut| cut > least);
    let start = if cuts[0] { part.start } else { all.start };
    start..if cuts[1] { part.end } else { all.end }
}
