//! What moved: how the energy is spread over frequency along x, or over wavenumber in time, without an edge between low and high.
//!
//! One profile: groups of neighbouring sites in the order in which the wave passes, or of times, each with the
//! cumulative spectrum of its energy above the noise; the shares that moved from the first group to each, with one error.
//! The verdict is the largest share that is told; what became of it by the last group is its fate.
//!
//! Along x, spectra are those of front windows: ten widths of the pulse (median over sites), begun a lead before each arrival.
//! A record that is quiet at both ends is one window. Steady records are cut into segments. In time, spectra are those of spatial
//! snapshots while the wave is inside.
//!
//! Of a struck chain the energy of the front counts first: what it loses per 100 bodies, over the second half of the bodies
//! that it reaches. What moves is asked there; the way to there is the launch.

mod along_x;
mod chain;
mod found;
mod front;
mod in_time;
mod onset;
mod profile;
mod reason;
mod speed;
mod steady;
mod windows;

use serde::Serialize;

pub(crate) use along_x::{Options, along_x, median};
pub(crate) use in_time::{FOLDED, Motion, Profiles, Source, in_time};
pub(crate) use onset::{Onset, piece};
pub use reason::Reason;

/// Moves below this share count as none.
pub const TOLERANCE: f64 = 0.05;

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

/// What became of the largest move by the last place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fate {
    Stays,
    /// The energy is back where it came from.
    Back,
    /// It has not come back: what moved is lost.
    Lost,
}

/// Neighbouring sites (of the file) or times that are compared as one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// First and last site or time row, in the order of travel.
    pub rows: [usize; 2],
    /// The coordinate in their middle.
    pub at: f64,
}

/// A share of the energy that moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Move {
    pub share: f64,
    /// Half the width of its 95 % interval.
    pub error: f64,
    /// What it must exceed to be told, as three standard errors are.
    pub(crate) sure: f64,
    /// Past which frequency or wavenumber, in units of the axis; NaN of none.
    pub at: f64,
    /// Interval of the grid that ends there.
    pub(crate) interval: usize,
}

impl Move {
    const UNKNOWN: Move = Move {
        share: f64::NAN,
        error: f64::NAN,
        sure: f64::NAN,
        at: f64::NAN,
        interval: 0,
    };
}

/// What moved along x (of frequency) or in time (of wavenumber).
#[derive(Debug, Clone, PartialEq)]
pub struct Movement {
    pub verdict: Verdict,
    /// At the place of the largest move; NaN where nothing could be compared.
    pub up: Move,
    pub down: Move,
    /// Up and down at the last place.
    pub at_end: Option<[Move; 2]>,
    pub fate: Option<Fate>,
    /// What moves not stated are below, at 95 %.
    pub bound: f64,
    /// Whether energy itself grew on the side to which shares moved: a transfer, not a selective loss. `None` where
    /// nothing moved, where waves of both directions or none that is known pass, and where errors hide it.
    pub transfer: Option<bool>,
    /// Energy at the place of the largest move over that at the first; NaN where waves of several origins pass.
    pub energy_ratio: f64,
    pub from: Option<Place>,
    /// The place of the largest move.
    pub to: Option<Place>,
    /// Whether what is missing follows behind the front windows: dispersion, neither a transfer nor a loss.
    pub lags: bool,
    /// Why it cannot be told.
    pub reason: Option<Reason>,
}

impl Default for Movement {
    fn default() -> Movement {
        Movement::untold(Reason::NoEnergy)
    }
}

impl Movement {
    pub fn untold(reason: Reason) -> Movement {
        Movement {
            verdict: Verdict::Untold,
            up: Move::UNKNOWN,
            down: Move::UNKNOWN,
            at_end: None,
            fate: None,
            bound: f64::NAN,
            transfer: None,
            energy_ratio: f64::NAN,
            from: None,
            to: None,
            lags: false,
            reason: Some(reason),
        }
    }

    /// The same numbers, but nothing is said of them.
    pub(crate) fn but_untold(self, reason: Reason) -> Movement {
        Movement {
            verdict: Verdict::Untold,
            transfer: None,
            fate: None,
            lags: false,
            reason: Some(reason),
            ..self
        }
    }

    /// Whether a move is told.
    pub fn moves(&self) -> bool {
        matches!(self.verdict, Verdict::Up | Verdict::Down | Verdict::Spreads)
    }

    /// Past which frequency or wavenumber the larger of the moves that are told goes.
    pub fn past(&self) -> Option<f64> {
        self.moves().then(|| self.most().at)
    }

    /// The larger of the two moves.
    pub fn most(&self) -> Move {
        [self.up, self.down][self.way()]
    }

    /// Whether it is up (0) or down (1).
    pub(crate) fn way(&self) -> usize {
        usize::from(self.down.share > self.up.share)
    }
}

/// The spectrum of a group, as figures show it.
#[derive(Debug, Clone, PartialEq)]
pub struct GroupSpectrum {
    pub place: Place,
    pub cumulative: Vec<f64>,
    pub energy: f64,
}

/// The profile that a verdict rests on.
#[derive(Debug, Clone, PartialEq)]
pub struct Evidence {
    /// Upper ends of the intervals.
    pub upper: Vec<f64>,
    pub groups: Vec<GroupSpectrum>,
    /// Up and down from the first group to each.
    pub moves: Vec<[Move; 2]>,
    /// The first group and that of the largest move.
    pub compared: [usize; 2],
}

impl Evidence {
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

/// How fast arrivals travel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Speed {
    /// In units of length over units of time; negative towards -x.
    pub value: f64,
    /// Half the width of its 95 % interval.
    pub error: f64,
}

/// The front of a struck chain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Front {
    /// `-100 d ln E / dj` of its energy E at body j.
    pub loss_per_100_bodies: f64,
    /// Half the width of its 95 % interval.
    pub error: f64,
    /// First and last body between which it is taken: the second half of those that the front reaches.
    pub bodies: [usize; 2],
}

/// The answer to the question of an analysis.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Answer {
    /// Along x, from low to high frequency or back. Of a struck chain, over the second half of the bodies that its front reaches.
    pub frequency: Movement,
    /// Of a struck chain, from the first bodies to there.
    pub launch: Option<Movement>,
    pub front: Option<Front>,
    /// In time, from low to high wavenumber or back.
    pub wavenumber: Movement,
    /// Of arrivals.
    pub speed: Option<Speed>,
    /// Whether bodies of a chain were struck or driven.
    pub is_struck: bool,
    /// Whether the chain is known to lose energy.
    pub is_lossy: bool,
    /// Whether the sites are those of a periodic box.
    pub is_periodic: bool,
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
    /// Variance of the noise, summed over the sites: of steady records, that of their white floor. Of an analysis, over that of
    /// the record.
    pub(crate) noise: f64,
    /// What each record says.
    pub(crate) onsets: Vec<Onset>,
    /// Of a measured field with fronts: arrivals by site, the width of the pulse and the length of the windows, in samples.
    pub(crate) windows: Option<ArrivalWindows>,
}

impl Answer {
    /// Takes what is told of wavenumbers.
    pub(crate) fn tell(&mut self, in_time: Result<(Movement, Evidence), Reason>) {
        (self.wavenumber, self.along_t) = match in_time {
            Ok((movement, evidence)) => (movement, Some(evidence)),
            Err(reason) => (Movement::untold(reason), None),
        };
    }

    /// Of frequencies along x, whose reason is that of wavenumbers until they are looked at.
    pub(crate) fn untold(reason: Reason) -> Answer {
        Answer {
            frequency: Movement::untold(reason),
            wavenumber: Movement::untold(reason),
            ..Answer::default()
        }
    }
}

/// Windows from arrivals on, in samples.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ArrivalWindows {
    pub arrivals: Vec<Option<usize>>,
    /// Of the pulse.
    pub width: f64,
    pub samples: usize,
}
