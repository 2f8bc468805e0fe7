//! The answer of an analysis in words.

use super::super::{Analysis, Axes, Direction, Undirected, Warning};
use crate::moved::{Answer, Evidence, GroupSpectrum, KEEPS, Movement, Place, Reason, Verdict};
use crate::sheet::Fact;

/// The verdict, and a fact for its numbers and for each further question; `None` where no answer was requested.
pub(super) fn describe(analysis: &Analysis) -> Option<(String, Vec<Fact>)> {
    let words = Words::of(analysis)?;
    let facts = [
        Some(Fact::new("moved", words.numbers())),
        words.along_x(),
        words.in_time(),
        words.direction(),
        words.attenuation(),
        words.front_and_tail(),
    ];
    Some((words.verdict(), facts.into_iter().flatten().collect()))
}

/// Difference of the shares by direction, as a part of both, up to which they are alike.
const EVEN: f64 = 0.1;

/// What may move unseen from which on it is not said that nothing does.
const WIDE: f64 = 0.15;

/// Part of the sites from which on a verdict is one of all.
const SPAN: f64 = 0.75;

/// The words of an answer.
pub(crate) struct Words<'a> {
    axes: &'a Axes,
    pub(super) answer: &'a Answer,
    /// Of the waves, where shares by direction can be told.
    pub(super) direction: Option<Direction>,
    undirected: Option<Undirected>,
    /// Whether steady records do not follow each other, as those of noise.
    is_noise: bool,
    /// A line that all sites have in common, which hides a wave.
    hum: Option<&'a Warning>,
}

/// Whole percent of a share; one decimal below ten.
fn share(x: f64) -> String {
    match 100.0 * x {
        p if p.is_nan() => "undefined".into(),
        p if p >= 9.95 => format!("{p:.0} %"),
        p => format!("{p:.1} %"),
    }
}

/// What a share is below, rounded up: `2 %`.
fn below(x: f64) -> String {
    format!("{} %", (100.0 * x).ceil().max(1.0))
}

/// By which body a front has lost which share of its energy.
fn lost(of: &Movement) -> (usize, String) {
    let by = of.to.map_or(0, |place| place.rows[0]);
    (by, share(1.0 - of.energy_ratio))
}

/// `1 time`, `2 times`.
fn counted(n: usize, one: &str) -> String {
    format!("{n} {one}{}", if n == 1 { "" } else { "s" })
}

fn short(x: f64) -> String {
    crate::measure::digits(format!("{x:.2e}").parse().unwrap_or(x))
}

impl<'a> Words<'a> {
    /// `None` where no answer was requested.
    pub fn of(analysis: &'a Analysis) -> Option<Words<'a>> {
        let answer = analysis.answer.as_ref()?;
        Some(Words {
            axes: &analysis.axes,
            answer,
            direction: analysis.direction_of_waves().or(analysis.direction),
            undirected: analysis.undirected,
            is_noise: !answer.has_fronts && analysis.undirected == Some(Undirected::Noise),
            hum: analysis.warnings.iter().find(|warning| warning.is_hum()),
        })
    }

    fn frequency(&self, f: f64) -> String {
        let (scale, unit) = match self.axes.frequency_unit().as_str() {
            "Hz" if f >= 1e6 => (1e-6, "MHz".to_owned()),
            "Hz" if f >= 1e3 => (1e-3, "kHz".to_owned()),
            // Longer than the number.
            unit if unit.len() > 12 => (1.0, String::new()),
            unit => (1.0, unit.to_owned()),
        };
        format!("{} {unit}", short(scale * f)).trim_end().to_owned()
    }

    fn wavenumber(&self, k: f64) -> String {
        format!("{} {}", short(k), self.axes.wavenumber_unit())
    }

    fn body(&self) -> &'static str {
        if self.answer.is_struck {
            "body"
        } else {
            "site"
        }
    }

    fn sites(&self, place: &Place) -> String {
        let [a, b] = place.rows;
        match a == b {
            true => a.to_string(),
            false => format!("{a}-{b}"),
        }
    }

    fn time(&self, place: &Place) -> String {
        let unit = self.axes.time.unit.as_deref().unwrap_or_default();
        format!("{} {unit}", short(place.at)).trim_end().to_owned()
    }

    /// The first line.
    fn verdict(&self) -> String {
        let of = &self.answer.frequency;
        if let Some(reason) = &of.reason {
            if self.sheds(of) {
                return format!(
                    "{}; which way its content moves cannot be told: {}",
                    self.shed(of),
                    reason.message()
                );
            }
            let (_, reason, advice) = self.why(reason);
            return format!("what moves in frequency along x cannot be told: {reason}; {advice}");
        }
        if self.answer.is_struck {
            return self.of_front(of);
        }
        let to = of.to.map_or(0, |place| place.rows[1]);
        let is_back = of
            .from
            .zip(of.to)
            .is_some_and(|(from, to)| to.rows[0] < from.rows[0]);
        let way = if is_back { "towards -x" } else { "along x" };
        match of.verdict {
            Verdict::Unchanged => {
                let (span, bound) = (self.span(of), below(of.bound));
                let hidden = match self.hum {
                    Some(hum) => format!("; {}", hum.message()),
                    None if self.is_noise => {
                        " in records like noise, which may hide a weak wave".into()
                    }
                    None => String::new(),
                };
                match of.bound > WIDE {
                    true => format!(
                        "no move in frequency along x{span} is seen, but up to {bound} may move unseen (95 %){hidden}"
                    ),
                    false => format!(
                        "no energy moves in frequency along x{span} (less than {bound}, at 95 %){hidden}"
                    ),
                }
            }
            Verdict::Down if of.lags => format!(
                "higher frequencies lag behind the front: its {} by site {to}",
                self.shares(of)
            ),
            Verdict::Up if of.lags => format!(
                "lower frequencies lag behind the front: its {} by site {to}",
                self.shares(of)
            ),
            Verdict::Spreads if of.lags => {
                format!(
                    "frequencies part: low and high ones do not keep up with the front by site {to}"
                )
            }
            // Shares tell no more where several waves pass, or gains differ.
            _ if of.transfer.is_none() => format!(
                "the {} by site {to}; whether energy is gained there cannot be told",
                self.shares(of)
            ),
            _ if of.transfer == Some(false) => format!(
                "selective loss: the {}, no energy is gained {}",
                self.shares(of),
                match of.verdict {
                    Verdict::Down => "below",
                    _ => "there",
                }
            ),
            Verdict::Up => format!(
                "energy moves up in frequency {way}: {} of it past {} by site {to}",
                share(of.up),
                self.frequency(of.up_at)
            ),
            Verdict::Down => format!(
                "energy moves down in frequency {way}: {} of it below {} by site {to}",
                share(of.down),
                self.frequency(of.down_at)
            ),
            _ => format!(
                "energy spreads in frequency {way}: {} past {}, {} below {} by site {to}",
                share(of.up),
                self.frequency(of.up_at),
                share(of.down),
                self.frequency(of.down_at)
            ),
        }
    }

    /// Why frequencies cannot be told: stable name, message and advice.
    pub(super) fn why(&self, reason: &Reason) -> (&'static str, String, &'static str) {
        match self.hum {
            Some(hum) => (hum.code(), hum.message(), hum.advice()),
            None => reason.parts(),
        }
    }

    /// Why shares by direction are withheld, if they are.
    pub(super) fn undirected(&self) -> Option<String> {
        Some(match self.undirected? {
            Undirected::Folded { share: top } => format!(
                "wavenumbers fold, {} of the energy lies in the top tenth",
                share(top)
            ),
            Undirected::Short { wavelength } => format!(
                "wavenumbers fold, wavelengths of {} {} are shorter than twice the spacing",
                short(wavelength),
                self.axes.space_unit()
            ),
            Undirected::Long { wavelength } => format!(
                "wavelengths of {} {} are longer than twice the array",
                short(wavelength),
                self.axes.space_unit()
            ),
            Undirected::Noise => "the energy is spread over all wavenumbers, as noise is".into(),
        })
    }

    /// Which shares have changed by how much.
    fn shares(&self, of: &Movement) -> String {
        let (up, down) = (self.frequency(of.up_at), self.frequency(of.down_at));
        match of.verdict {
            Verdict::Up => format!("share above {up} grows by {}", share(of.up)),
            Verdict::Down => format!("share above {down} falls by {}", share(of.down)),
            _ => format!("shares above {up} and below {down} grow"),
        }
    }

    /// Between which sites, where the wave is seen at a part of them.
    fn span(&self, of: &Movement) -> String {
        let ends = of.from.zip(of.to);
        let ends = ends.map(|(from, to)| (from.rows[0], to.rows[1]));
        match ends {
            Some((from, to))
                if ((from.abs_diff(to) + 1) as f64) < SPAN * self.axes.n_sites as f64 =>
            {
                format!(" from site {from} to {to}")
            }
            _ => String::new(),
        }
    }

    /// Of a struck chain.
    fn of_front(&self, of: &Movement) -> String {
        let keeps = match of.energy_ratio {
            ratio if ratio > KEEPS => "keeps its energy".into(),
            ratio => format!("keeps {} of its energy", share(ratio)),
        };
        if let Some(site) = of.settled_at {
            return format!(
                "no energy moves up in frequency: the front settles by body {site} and {keeps}"
            );
        }
        if self.answer.is_lossy && of.energy_ratio < KEEPS {
            let (by, lost) = lost(of);
            return format!(
                "the front loses {lost} by body {by}, to damping too; it never settles"
            );
        }
        let sheds = match of.energy_ratio < KEEPS {
            true => format!("{}; it never settles", self.shed(of)),
            false => "the front never settles".into(),
        };
        let which = sheds.replacen("the front", "which", 1);
        match of.verdict {
            Verdict::Up if of.lags => {
                format!("lower frequencies do not keep up with the front, {which}")
            }
            Verdict::Spreads if of.lags => {
                format!(
                    "frequencies part: low and high ones do not keep up with the front, {which}"
                )
            }
            Verdict::Down if of.lags => format!("higher frequencies lag behind the front, {which}"),
            Verdict::Up | Verdict::Down | Verdict::Spreads => {
                let [moves, keeps] = match of.verdict {
                    Verdict::Up => ["moves up", "lies higher"],
                    Verdict::Down => ["moves down", "lies lower"],
                    _ => ["spreads", "is spread"],
                };
                match of.transfer {
                    Some(true) => format!("energy {moves} in frequency: {sheds}"),
                    // What is shed is in the tail: neither a transfer nor a loss.
                    _ => format!("{sheds}, and what it keeps {keeps} in frequency"),
                }
            }
            _ if of.energy_ratio >= KEEPS => format!(
                "no energy moves in frequency (less than {}, at 95 %): the front disperses and keeps its content",
                below(of.bound)
            ),
            _ => format!("no energy moves in frequency: {sheds}"),
        }
    }

    /// Whether the front of a struck chain without losses leaves a part of its energy behind, whatever its content does.
    fn sheds(&self, of: &Movement) -> bool {
        // The launch leaves a part behind, which is none that the front sheds.
        let is_launch = matches!(of.reason, Some(Reason::ShortChain { .. }));
        let is_known =
            self.answer.is_struck && !self.answer.is_lossy && of.settled_at.is_none() && !is_launch;
        is_known && of.energy_ratio < KEEPS && of.to.is_some()
    }

    /// What it leaves behind, and where its tail is.
    fn shed(&self, of: &Movement) -> String {
        let (by, lost) = lost(of);
        let into = match &self.answer.tail {
            Some(tail) => format!(
                " into a tail around {}",
                self.frequency(tail.peak_frequency)
            ),
            None => String::new(),
        };
        format!("the front sheds {lost} by body {by}{into}")
    }

    /// The second line.
    fn numbers(&self) -> String {
        let of = &self.answer.frequency;
        if of.up.is_nan() {
            let [times, sites] = [(self.axes.n_times, "time"), (self.axes.n_sites, "site")]
                .map(|(n, one)| counted(n, one));
            return format!("{times}, {sites}");
        }
        let launch = self
            .answer
            .launch
            .as_ref()
            .filter(|launch| launch.most() > 0.0);
        let moved = |of: &Movement| {
            let at = |q: f64| match q.is_nan() {
                true => String::new(),
                false => format!(" at {}", self.frequency(q)),
            };
            let parts = [(of.up, "up", of.up_at), (of.down, "down", of.down_at)];
            let parts: Vec<String> = parts
                .iter()
                .filter(|(moved, ..)| *moved >= 0.01)
                .map(|(moved, way, q)| format!("{} {way}{}", share(*moved), at(*q)))
                .collect();
            match parts.is_empty() {
                true => "less than 1 %".into(),
                false => parts.join(", "),
            }
        };
        let places = of.from.zip(of.to).map(|(from, to)| {
            let body = if self.answer.is_struck {
                "bodies"
            } else {
                "sites"
            };
            format!(", {body} {} against {}", self.sites(&from), self.sites(&to))
        });
        let start = match launch {
            Some(launch) => format!("launch {}; then ", moved(launch)),
            None => String::new(),
        };
        format!("{start}{}{}", moved(of), places.unwrap_or_default())
    }

    /// The edge at which the profile along an axis is drawn.
    fn edge(of: &Movement, launch: Option<&Movement>) -> f64 {
        let of = match launch.filter(|launch| launch.most() > of.most()) {
            Some(launch) => launch,
            None => of,
        };
        if of.up >= of.down {
            of.up_at
        } else {
            of.down_at
        }
    }

    fn along_x(&self) -> Option<Fact> {
        let evidence = self.answer.along_x.as_ref()?;
        let of = &self.answer.frequency;
        if of.verdict == Verdict::Unchanged && !self.answer.is_struck {
            return self.medians(evidence);
        }
        let edge = Self::edge(of, self.answer.launch.as_ref());
        if !edge.is_finite() {
            return None;
        }
        let profile = evidence.above(edge);
        let [a, b] = evidence.compared;
        let [from, to] = [a, b].map(|group| evidence.groups[group].place);
        let text = format!(
            "{} of the energy lies above {} at {} {}, {} at {}",
            share(profile[a]),
            self.frequency(edge),
            self.body(),
            from.rows[0],
            share(profile[b]),
            to.rows[0]
        );
        Some(Fact {
            profile,
            ..Fact::new("along x", text)
        })
    }

    /// Half of the energy lies below which frequency, at the places compared.
    fn medians(&self, evidence: &Evidence) -> Option<Fact> {
        let [a, b] = evidence.compared.map(|group| &evidence.groups[group]);
        let median = |group: &GroupSpectrum| {
            let at = group.cumulative.iter().position(|c| *c >= 0.5)?;
            Some(self.frequency(evidence.upper[at]))
        };
        let text = format!(
            "half of the energy lies below {} at site {}, below {} at {}",
            median(a)?,
            a.place.rows[0],
            median(b)?,
            b.place.rows[0]
        );
        Some(Fact::new("along x", text))
    }

    /// The energy at the last place over that at the first, where one wave passes both.
    fn attenuation(&self) -> Option<Fact> {
        let of = &self.answer.frequency;
        let (from, to) = of.from.zip(of.to)?;
        let ratio = of.energy_ratio;
        if !(ratio.is_finite() && ratio > 0.0) {
            return None;
        }
        let what = match (self.answer.is_struck, self.answer.has_fronts) {
            (true, _) => "the front's",
            (false, true) => "the window's",
            (false, false) => "the record's",
        };
        let groups = self
            .answer
            .along_x
            .as_ref()
            .map(|evidence| &evidence.groups);
        let text = format!(
            "{what} energy at {} {} is {} of that at {} ({:+.1} dB)",
            self.body(),
            to.rows[0],
            share(ratio),
            from.rows[0],
            10.0 * ratio.log10()
        );
        let energies = groups.into_iter().flatten().map(|group| group.energy);
        Some(Fact {
            profile: energies.collect(),
            ..Fact::new("attenuation", text)
        })
    }

    fn in_time(&self) -> Option<Fact> {
        let of = &self.answer.wavenumber;
        let edge = Self::edge(of, None);
        let span = of.from.zip(of.to);
        let span =
            span.map(|(from, to)| format!(" from t = {} to {}", self.time(&from), self.time(&to)));
        let span = span.unwrap_or_default();
        let up = || format!("{} past {}", share(of.up), self.wavenumber(of.up_at));
        let down = || format!("{} below {}", share(of.down), self.wavenumber(of.down_at));
        let back = if of.returns { ", and back" } else { "" };
        let text = match (of.verdict, &of.reason) {
            (Verdict::Untold, reason) => {
                let reason = reason.as_ref().map(|r| r.message()).unwrap_or_default();
                format!("wavenumbers: cannot be told: {reason}")
            }
            (Verdict::Unchanged, _) if of.bound > WIDE => {
                format!(
                    "wavenumbers are not seen to move{span}, but up to {} may",
                    below(of.bound)
                )
            }
            (Verdict::Unchanged, _) => {
                format!(
                    "wavenumbers stay{span} (less than {} moves)",
                    below(of.bound)
                )
            }
            (Verdict::Up, _) => format!("wavenumbers rise: {}{span}{back}", up()),
            (Verdict::Down, _) => format!("wavenumbers fall: {}{span}{back}", down()),
            (Verdict::Spreads, _) => {
                format!("wavenumbers spread: {}, {}{span}{back}", up(), down())
            }
        };
        let evidence = self.answer.along_t.as_ref().filter(|_| edge.is_finite());
        Some(Fact {
            profile: evidence.map_or(Vec::new(), |evidence| evidence.above(edge)),
            ..Fact::new("in time", text)
        })
    }

    fn direction(&self) -> Option<Fact> {
        let direction = self.direction?;
        let [space, time] = [&self.axes.space, &self.axes.time];
        let speed = self.answer.speed.map(|speed| {
            let unit = match (&space.unit, &time.unit) {
                (Some(length), Some(time)) => format!("{length}/{time}"),
                _ => {
                    let length = match &space.unit {
                        Some(length) => length.clone(),
                        None => space
                            .space_unit()
                            .replace("site", "sites")
                            .replace("unit", "units"),
                    };
                    format!("{length} per {}", time.time_unit())
                }
            };
            let decimals = (1.0 - speed.error.log10().floor()).clamp(0.0, 6.0) as usize;
            let (value, error) = (speed.value.abs(), speed.error.max(1e-6));
            format!("{value:.decimals$} ± {error:.decimals$} {unit}")
        });
        let speed = match &speed {
            Some(speed) => format!("; arrivals at {speed}"),
            None => String::new(),
        };
        let text = match self.undirected() {
            Some(reason) => format!("cannot be told: {reason}{speed}"),
            None if direction.toward_plus_x.is_nan() => "cannot be told: there is one site".into(),
            // In a chain of cells, a one-way wave has components of both signs.
            None if self.answer.is_struck => {
                let way = match self.answer.speed {
                    Some(speed) if speed.value < 0.0 => "-x",
                    _ => "+x",
                };
                format!("the front travels towards {way}{speed}")
            }
            None => {
                let [plus, minus] = [direction.toward_plus_x, direction.toward_minus_x];
                let even = (plus - minus).abs() < EVEN * (plus + minus);
                let neither = match direction.undirected > 0.01 {
                    true => format!(", {} neither (k = 0 or f = 0)", share(direction.undirected)),
                    false => String::new(),
                };
                let standing = match even && !self.answer.has_fronts {
                    true => ": waves stand, or come from both sides",
                    false => "",
                };
                format!(
                    "{} towards +x, {} towards -x{neither}{standing}{speed}",
                    share(plus),
                    share(minus)
                )
            }
        };
        Some(Fact::new("direction", text))
    }

    fn front_and_tail(&self) -> Option<Fact> {
        let (front, tail) = (self.answer.front?, self.answer.tail?);
        let least = if self.answer.is_struck { 0.005 } else { 0.1 };
        if tail.energy_share < least {
            return None;
        }
        let (moved, way) = match tail.up >= tail.down {
            true => (tail.up, "higher"),
            false => (tail.down, "lower"),
        };
        let text = format!(
            "{} and {} of the energy; the tail lies around {}, {} of it {way}",
            share(front.energy_share),
            share(tail.energy_share),
            self.frequency(tail.peak_frequency),
            share(moved)
        );
        Some(Fact::new("front, tail", text))
    }
}

/// Of pictures.
#[cfg(feature = "figures")]
impl Words<'_> {
    /// The name of a group of sites.
    pub fn named_sites(&self, place: &Place) -> String {
        let name = match (self.answer.is_struck, place.rows[0] == place.rows[1]) {
            (true, true) => "body",
            (true, false) => "bodies",
            (false, true) => "site",
            (false, false) => "sites",
        };
        format!("{name} {}", self.sites(place))
    }

    pub fn named_time(&self, place: &Place) -> String {
        format!("t = {}", self.time(place))
    }

    /// The shares that moved, and where: `24 % up past 4.1 Hz`.
    pub fn in_frequency(&self, of: &Movement) -> [(f64, String); 2] {
        if of.transfer == Some(false) && !self.answer.is_struck {
            let changed =
                |share: String, at| format!("share above {}: {share}", self.frequency(at));
            let up = changed(format!("+{}", share(of.up)), of.up_at);
            let down = changed(format!("−{}", share(of.down)), of.down_at);
            return [(of.up_at, up), (of.down_at, down)];
        }
        moves(of, |f| self.frequency(f))
    }

    pub fn in_wavenumber(&self, of: &Movement) -> [(f64, String); 2] {
        moves(of, |k| self.wavenumber(k))
    }
}

#[cfg(feature = "figures")]
fn moves(of: &Movement, place: impl Fn(f64) -> String) -> [(f64, String); 2] {
    let up = format!("{} up past {}", share(of.up), place(of.up_at));
    let down = format!("{} down below {}", share(of.down), place(of.down_at));
    [(of.up_at, up), (of.down_at, down)]
}
