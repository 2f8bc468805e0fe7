//! Why a verdict cannot be given, and what would give one.

use serde::Serialize;

/// How many sites a headline leaves out, and why.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    pub sites: usize,
    /// Without motion, or none above the noise.
    pub not_reached: usize,
    /// Moving when the record begins.
    pub entered_late: usize,
    /// Whose window the record's end cuts.
    pub cut_off: usize,
    /// Into whose window a reflection falls.
    pub reflected: usize,
}

impl LeftOut {
    /// The largest of them in words.
    fn most(&self) -> (usize, &'static str) {
        let all = [
            (self.not_reached, "are not reached"),
            (self.entered_late, "move when the record begins"),
            (self.cut_off, "are cut off by its end"),
            (self.reflected, "hold a wave that comes the other way"),
        ];
        all.into_iter()
            .max_by_key(|(sites, _)| *sites)
            .unwrap_or((0, ""))
    }
}

/// Why it cannot be told what moved.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Reason {
    NoEnergy,
    /// A single site has no wavenumbers, a few have no groups.
    FewSites {
        sites: usize,
    },
    /// Sites whose window is whole, of those there are.
    FewWindows {
        whole: usize,
        left_out: LeftOut,
    },
    /// Bodies over which the front of a run is followed, too few to tell its launch from its travel.
    ShortChain {
        bodies: usize,
    },
    /// Samples of the record, too few to have frequencies.
    ShortRecord {
        times: usize,
    },
    /// The energy is not above the noise.
    Noise,
    /// The verdict is another one with windows of half or twice the length.
    Windows {
        up: f64,
        down: f64,
    },
    /// The verdict is another one for neighbouring groups.
    Neighbours {
        up: f64,
        down: f64,
    },
    /// Moves smaller than this share are not told from errors.
    Errors {
        bound: f64,
    },
    /// The motion has begun before the record, or hum and drift hide when it begins.
    Begins,
    /// Waves of several origins, whose windows differ.
    Origins,
    /// What comes back is in the windows of what arrives.
    Returns,
    /// Most of the energy lies at frequencies of which a segment holds a few periods.
    Resolution,
    /// The wave is never all inside, and its content differs along x.
    NeverInside,
    /// The wave is inside for less than two periods.
    LeavesEarly,
    /// Energy enters, or leaves, all the while.
    Enters,
    /// Most of the energy lies at wavelengths that the aperture does not resolve.
    LongWaves,
    /// Waves are shorter than two distances of the sites, and appear as longer ones.
    Folded,
    /// Amplitudes differ from site to site, which spreads energy over all wavenumbers.
    Uneven,
    /// Sites are at uneven distances or left out.
    MissingSites,
}

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

impl Reason {
    /// Stable name, for programs.
    pub fn code(&self) -> &'static str {
        match self {
            Reason::NoEnergy => "no-energy",
            Reason::FewSites { .. } => "few-sites",
            Reason::FewWindows { .. } => "few-windows",
            Reason::ShortChain { .. } => "short-chain",
            Reason::ShortRecord { .. } => "short-record",
            Reason::Noise => "noise",
            Reason::Windows { .. } => "windows",
            Reason::Neighbours { .. } => "neighbours",
            Reason::Errors { .. } => "errors",
            Reason::Begins => "begins",
            Reason::Origins => "origins",
            Reason::Returns => "returns",
            Reason::Resolution => "resolution",
            Reason::NeverInside => "never-inside",
            Reason::LeavesEarly => "leaves-early",
            Reason::Enters => "enters",
            Reason::LongWaves => "long-waves",
            Reason::Folded => "folded",
            Reason::Uneven => "uneven",
            Reason::MissingSites => "missing-sites",
        }
    }

    /// Stable name, message and advice.
    pub(crate) fn parts(&self) -> (&'static str, String, &'static str) {
        (self.code(), self.message(), self.advice())
    }

    /// The reason, without a full stop.
    pub fn message(&self) -> String {
        match *self {
            Reason::NoEnergy => "nothing moves".into(),
            Reason::FewSites { sites: 1 } => "there is one site".into(),
            Reason::FewSites { sites } => format!("there are {sites} sites"),
            Reason::FewWindows { whole, left_out } => {
                let (sites, why) = left_out.most();
                match sites {
                    0 => format!("{whole} sites have a whole front window"),
                    _ => format!(
                        "{whole} of {} sites have a whole front window; {sites} {why}",
                        left_out.sites
                    ),
                }
            }
            Reason::ShortChain { bodies } => format!(
                "the front is followed over {bodies} bodies, in which it may not have formed yet"
            ),
            Reason::ShortRecord { times: 1 } => "the record has one time".into(),
            Reason::ShortRecord { times } => format!("the record has {times} times"),
            Reason::Noise => "the wave does not rise far enough above the noise".into(),
            Reason::Windows { up, down } => format!(
                "it differs with the window: {} up, {} down at another length",
                percent(up),
                percent(down)
            ),
            Reason::Neighbours { up, down } => format!(
                "it differs nearby: {} up, {} down",
                percent(up),
                percent(down)
            ),
            Reason::Errors { bound } if bound < 1.0 => {
                format!("errors hide moves of up to {}", percent(bound))
            }
            Reason::Errors { .. } => "errors hide moves of any size".into(),
            Reason::Begins => "no quiet part of the records goes before the wave".into(),
            Reason::Origins => "waves of several origins pass".into(),
            Reason::Returns => "what comes back mixes with what arrives".into(),
            Reason::Resolution => "the record holds a few periods of most of the motion".into(),
            Reason::NeverInside => "the wave is longer than the array".into(),
            Reason::LeavesEarly => "the wave is inside for less than two periods".into(),
            Reason::Enters => "energy enters or leaves all the while".into(),
            Reason::LongWaves => "wavelengths are as long as the array".into(),
            Reason::Folded => {
                "wavenumbers fold: waves are shorter than two distances of the sites".into()
            }
            Reason::Uneven => "amplitudes differ from site to site, as gains make them".into(),
            Reason::MissingSites => "sites are left out".into(),
        }
    }

    /// What to record or to ask for instead.
    pub fn advice(&self) -> &'static str {
        match self {
            Reason::NoEnergy => "check the file with `cascade inspect`",
            Reason::FewSites { .. } => "record more sites",
            Reason::FewWindows { left_out, .. } => {
                let of = [left_out.cut_off, left_out.entered_late, left_out.reflected];
                match of.iter().max() {
                    Some(&most) if most == left_out.reflected && most > 0 => {
                        "shorten the window with `--front-window`, or move the ends away"
                    }
                    Some(&most) if most == left_out.entered_late && most > 0 => {
                        "begin the record before the wave enters"
                    }
                    _ => "record longer, or shorten the window with `--front-window`",
                }
            }
            Reason::ShortChain { .. } => "simulate a longer chain, and for longer",
            Reason::ShortRecord { .. } | Reason::Windows { .. } => "record longer",
            Reason::Noise => "average several records, or state `--noise`",
            Reason::Neighbours { .. } => "record more sites behind it",
            Reason::Errors { .. } => "average several records, or record longer",
            Reason::Begins => "begin the record before the wave enters, without hum and drift",
            Reason::Origins => "record one source at a time, or analyze the sites beside each",
            Reason::Returns => {
                "end the record with `--times` before the wave is back, or move the ends away"
            }
            Reason::Resolution => "record longer",
            Reason::Enters => "record longer, or a longer stretch of the structure",
            Reason::NeverInside | Reason::LeavesEarly | Reason::LongWaves => {
                "record a longer stretch of the structure"
            }
            Reason::Folded => "place sites at smaller distances",
            Reason::Uneven => "repair dead sites, and divide records by their gains",
            Reason::MissingSites => "record all sites, at even distances",
        }
    }
}
