//! What moved: how the energy is spread over frequency at one place and at another, or over wavenumber at one time and
//! at another, without an edge between low and high.
//!
//! `C(f)` is the share of the moving energy up to f. From a to b the share
//!
//! ```text
//! U = max_f [C_a(f) - C_b(f)]  moved up,    D = max_f [C_b(f) - C_a(f)]  moved down:
//! ```
//!
//! `U > 0` with `D = 0` is up at every edge (first-order stochastic dominance), both are a spread. Energy below the
//! resolution of a window is drift and counts for neither.
//!
//! Along x, spectra are those of front windows: ten widths of the pulse (full width at half maximum of the squared envelope,
//! median over sites) from each arrival on, noise subtracted. A site is left out that is not reached, is entered before the
//! record begins, is cut off by its end, or whose window holds a reflection. Four neighbours are a group. Steady records have
//! one window, the record, in segments. In time, spectra are those of profiles, averaged over windows longer than a period, while
//! the wave is inside.
//!
//! Of a struck chain, launch and travel are apart: the front has formed at the first group from which U and D to every
//! later group stay below the tolerance. Its windows fade out (the square of half a cosine), so that what it leaves behind
//! counts less the later it comes. A front that forms nowhere in the first half of the chain sheds energy: then windows do not fade, and the
//! groups compared are the first and the last with three tenths of its energy.

mod along_x;
mod front;
mod gain;
mod graded;
mod groups;
mod in_time;
mod onset;
mod reason;
mod share;
mod speed;
mod steady;
mod windows;

use serde::Serialize;

pub(crate) use along_x::{AlongX, Options, along_x};
pub(crate) use gain::{GainChange, GainStep};
pub(crate) use in_time::{FOLDED, Profiles, Source, in_time};
pub use reason::{LeftOut, Reason};
use share::{Group, Moved};

/// Moves below this share count as none.
pub const TOLERANCE: f64 = 0.05;
/// Part of its energy from which on a front keeps it: windows hold a longer pulse to a tenth less.
pub(crate) const KEEPS: f64 = 0.88;
/// Part of the larger energy below which gains do not count by the smaller one.
const LEFT: f64 = 0.01;

/// What is said of a move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    Up,
    Down,
    /// Both up and down.
    Spreads,
    Unchanged,
    /// It cannot be told; see [`Movement::reason`].
    Untold,
}

impl Verdict {
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Up => "up",
            Verdict::Down => "down",
            Verdict::Spreads => "spreads",
            Verdict::Unchanged => "unchanged",
            Verdict::Untold => "untold",
        }
    }
}

/// Neighbouring sites (of the file) or times that are compared as one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// First and last site or time row, in the order of travel.
    pub rows: [usize; 2],
    /// The coordinate in their middle.
    pub at: f64,
}

/// What moved between two places (of frequency) or times (of wavenumber). Frequencies and wavenumbers in the units of the axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Movement {
    pub verdict: Verdict,
    /// Share that moved up; NaN where nothing could be compared.
    pub up: f64,
    /// Where the cumulative spectra differ so.
    pub up_at: f64,
    pub down: f64,
    pub down_at: f64,
    /// What moves not stated are below, at 95 %.
    pub bound: f64,
    /// Whether energy itself grew beyond the edge towards which shares moved: a transfer, not a selective loss. `None` where
    /// nothing moved, of a front that sheds energy, where waves of both directions or none that is known pass, and where errors hide it.
    pub transfer: Option<bool>,
    /// Energy at the second place over that at the first; NaN where waves of several origins pass.
    pub energy_ratio: f64,
    pub from: Option<Place>,
    pub to: Option<Place>,
    /// Of a struck chain, the first site at which the front has formed.
    pub settled_at: Option<usize>,
    /// Whether it moved back by the end.
    pub returns: bool,
    /// Whether what is missing follows behind the front windows: dispersion, neither a transfer nor a loss.
    pub lags: bool,
    /// Why it cannot be told.
    pub reason: Option<Reason>,
}

impl Movement {
    pub fn untold(reason: Reason) -> Movement {
        Movement {
            verdict: Verdict::Untold,
            up: f64::NAN,
            up_at: f64::NAN,
            down: f64::NAN,
            down_at: f64::NAN,
            bound: f64::NAN,
            transfer: None,
            energy_ratio: f64::NAN,
            from: None,
            to: None,
            settled_at: None,
            returns: false,
            lags: false,
            reason: Some(reason),
        }
    }

    /// Between two groups on the grid whose intervals end at `upper`.
    fn between(
        a: &Group,
        b: &Group,
        upper: &[f64],
        tolerance: f64,
        place: &dyn Fn(&Group) -> Place,
    ) -> Movement {
        let moved = Moved::between(a, b);
        let verdict = moved.verdict(tolerance);
        let left = a.energy.min(b.energy).max(LEFT * a.energy.max(b.energy));
        let sure = |v: f64, w: f64| 3.0 * (v + w).sqrt();
        let grows = |[before, v]: [f64; 2], [after, w]: [f64; 2]| {
            // Of what is left: a wave that is damped may gain at its harmonics all the same, unless next to nothing is left.
            let least = 0.5 * tolerance * left;
            after - before > sure(v, w).max(least)
        };
        // Upwards beyond any edge farther out: next to the one at which shares differ most lies what a loud line leaks.
        let (up, down) = (moved.up.at, moved.down.at);
        let grows_above = || (up..upper.len()).any(|m| grows(a.above(m), b.above(m)));
        let grows_below = || grows(a.below(down), b.below(down));
        // Of records that differ by chance more than a gain as large as the move would, neither is known.
        let is_known = |[_, v]: [f64; 2], [_, w]: [f64; 2], moved: f64| {
            !a.differs_by_chance() || sure(v, w) < moved * left
        };
        let knows_above = || is_known(a.above(up), b.above(up), moved.up.share);
        let knows_below = || is_known(a.below(down), b.below(down), moved.down.share);
        let (gains, knows) = match verdict {
            Verdict::Up => (grows_above(), knows_above()),
            Verdict::Down => (grows_below(), knows_below()),
            Verdict::Spreads => (
                grows_above() || grows_below(),
                knows_above() && knows_below(),
            ),
            Verdict::Unchanged | Verdict::Untold => (false, false),
        };
        let transfer = (gains || knows).then_some(gains);
        let at = |share: &share::Share| {
            if share.share > 0.0 {
                upper[share.at]
            } else {
                f64::NAN
            }
        };
        Movement {
            verdict,
            up: moved.up.share,
            up_at: at(&moved.up),
            down: moved.down.share,
            down_at: at(&moved.down),
            bound: moved.bound(),
            transfer,
            energy_ratio: b.energy / a.energy,
            from: Some(place(a)),
            to: Some(place(b)),
            settled_at: None,
            returns: false,
            lags: false,
            reason: None,
        }
    }

    /// The same shares, where gains that change along x hide the energies.
    pub(crate) fn without_energies(&mut self) {
        (self.transfer, self.energy_ratio) = (None, f64::NAN);
    }

    /// The same numbers, but nothing is said of them.
    pub(crate) fn but_untold(self, reason: Reason) -> Movement {
        Movement {
            verdict: Verdict::Untold,
            transfer: None,
            reason: Some(reason),
            ..self
        }
    }

    /// The larger of the two shares.
    pub fn most(&self) -> f64 {
        self.up.max(self.down)
    }
}

/// The front or its tail at the sites where both are seen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Part {
    /// Of the energy of both.
    pub energy_share: f64,
    /// Share moved up against the front as it has formed; of the front itself against the first bodies.
    pub up: f64,
    pub up_at: Option<f64>,
    pub down: f64,
    pub down_at: Option<f64>,
    /// Where the spectrum is largest.
    pub peak_frequency: f64,
    /// Frequencies between which 80 % of the energy lie.
    pub band: [f64; 2],
}

/// The spectrum of a group, as figures show it.
#[derive(Debug, Clone, PartialEq)]
pub struct GroupSpectrum {
    pub place: Place,
    /// Mean energy of a site in each interval, over its width.
    pub density: Vec<f64>,
    pub cumulative: Vec<f64>,
    pub energy: f64,
}

/// The cumulative spectra that a verdict rests on.
#[derive(Debug, Clone, PartialEq)]
pub struct Evidence {
    /// Upper ends of the intervals.
    pub upper: Vec<f64>,
    pub groups: Vec<GroupSpectrum>,
    /// The groups compared.
    pub compared: [usize; 2],
    /// Spectrum of the tail on the same intervals, where there is one.
    pub tail: Option<GroupSpectrum>,
}

impl Evidence {
    fn new(
        upper: &[f64],
        groups: &[Group],
        compared: [usize; 2],
        place: &dyn Fn(&Group) -> Place,
    ) -> Evidence {
        Evidence {
            upper: upper.to_vec(),
            groups: groups
                .iter()
                .map(|group| seen(group, upper, place))
                .collect(),
            compared,
            tail: None,
        }
    }

    /// The share of each group's energy above `edge`.
    pub fn above(&self, edge: f64) -> Vec<f64> {
        let m = self.upper.partition_point(|upper| *upper <= edge);
        let share = |group: &GroupSpectrum| match m {
            0 => 1.0,
            m => (1.0 - group.cumulative[m - 1]).clamp(0.0, 1.0),
        };
        self.groups.iter().map(share).collect()
    }
}

fn seen(group: &Group, upper: &[f64], place: &dyn Fn(&Group) -> Place) -> GroupSpectrum {
    let mut lower = 0.0;
    let density = group.spectrum.iter().zip(upper).map(|(energy, upper)| {
        let width = upper - std::mem::replace(&mut lower, *upper);
        energy / width
    });
    GroupSpectrum {
        place: place(group),
        density: density.collect(),
        cumulative: group.cumulative.clone(),
        energy: group.energy,
    }
}

/// How fast arrivals travel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Speed {
    /// In units of length over units of time; negative towards -x.
    pub value: f64,
    /// Half the width of its 95 % interval.
    pub error: f64,
}

/// The answer to the question of an analysis.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// Along x, from low to high frequency or back. Of a struck chain, over the travel of the front; over the whole way, if it
    /// never settles.
    pub frequency: Movement,
    /// Of a struck chain, from the first bodies to where the front has formed.
    pub launch: Option<Movement>,
    pub front: Option<Part>,
    pub tail: Option<Part>,
    /// In time, from low to high wavenumber or back.
    pub wavenumber: Movement,
    /// Of arrivals.
    pub speed: Option<Speed>,
    /// Whether bodies of a chain were struck or driven.
    pub is_struck: bool,
    /// Whether the chain is known to lose energy.
    pub is_lossy: bool,
    /// Whether spectra are those of front windows; of steady records they are those of segments.
    pub has_fronts: bool,
    /// Whether arrivals run one way, and nothing is seen to come back.
    pub(crate) is_one_way: bool,
    pub along_x: Option<Evidence>,
    pub along_t: Option<Evidence>,
    /// Rows between which a struck chain's front is well inside.
    pub(crate) since: Option<std::ops::Range<usize>>,
    /// Of the frequency below which half of the moving energy lies.
    pub(crate) period: f64,
    /// Energy of the noise, over that of the record.
    pub(crate) noise: f64,
    /// Of a measured field with fronts: arrivals by site, the width of the pulse and the length of the windows, in samples.
    pub(crate) windows: Option<ArrivalWindows>,
    /// Channels of a steady record whose gain changes.
    pub(crate) gain_changes: Vec<GainChange>,
    /// Sites from which on gains differ.
    pub(crate) gain_steps: Vec<GainStep>,
    /// Share of the energy that amplitudes which differ from site to site spread over all wavenumbers.
    pub(crate) uneven: f64,
}

/// Windows from arrivals on, in samples.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ArrivalWindows {
    pub arrivals: Vec<Option<usize>>,
    /// Full width at half maximum of the pulse's squared envelope.
    pub width: f64,
    pub samples: usize,
}

/// The least length of at least `samples` with no prime factor above 5.
pub(crate) fn quick(samples: usize) -> usize {
    (samples..)
        .find(|&n| {
            let mut rest = n;
            for factor in [2, 3, 5] {
                while rest.is_multiple_of(factor) {
                    rest /= factor;
                }
            }
            rest == 1
        })
        .unwrap_or(samples)
}
