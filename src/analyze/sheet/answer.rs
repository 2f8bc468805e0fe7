//! The answer of an analysis in words.

use super::super::{Analysis, Axes, Direction, Warning};
use crate::measure::{Frequency, size};
use crate::moved::{Answer, Fate, Front, Movement, Place, Reason, Verdict};
use crate::sheet::{Fact, with_half};

/// The verdict, and a fact for each further question; `None` where no answer was requested.
pub(super) fn describe(analysis: &Analysis) -> Option<(String, Vec<Fact>)> {
    let words = Words::of(analysis)?;
    let facts = [
        Some(words.moved()),
        Some(words.in_time()),
        words.direction(),
        words.attenuation(),
    ];
    Some((words.verdict(), facts.into_iter().flatten().collect()))
}

/// Difference of the shares by direction, as a part of both, up to which they are alike.
const EVEN: f64 = 0.1;
/// Part of the sites from which on a verdict is one of all.
const SPAN: f64 = 0.75;
/// Sites from which on waves have a direction.
const DIRECTED: usize = 5;
/// Loss per 100 bodies below which a front keeps its energy.
const KEEPS: f64 = 1e-3;

/// The words of an answer.
pub(crate) struct Words<'a> {
    axes: &'a Axes,
    pub(super) answer: &'a Answer,
    /// Of the waves, where shares by direction can be told.
    pub(super) direction: Option<Direction>,
    undirected: Option<Reason>,
    /// What hides a wave: a line that all sites have in common.
    hum: Option<&'a Warning>,
}

/// Whole percent of a share; one decimal below ten.
fn share(x: f64) -> String {
    let decimals = usize::from(100.0 * x < 9.95);
    format!("{:.decimals$} %", 100.0 * x)
}

/// `40.7 ± 1.9 %`.
fn with_error(share: f64, error: f64) -> String {
    with_half(100.0 * share, 100.0 * error, "%")
}

fn fact(name: &'static str, text: String, profile: Option<Vec<f64>>) -> Fact {
    Fact {
        profile: profile.unwrap_or_default(),
        ..Fact::new(name, text)
    }
}

/// What a share is below, rounded up: `2 %`.
fn below(x: f64) -> String {
    format!("{} %", (100.0 * x).ceil().max(1.0))
}

/// `40.7 ± 1.9 % past 4 kHz`, `2.00 ± 0.10 % below 3 kHz`.
fn both(of: &Movement, at: impl Fn(f64) -> String) -> [String; 2] {
    [(of.up, "past"), (of.down, "below")]
        .map(|(of, word)| format!("{} {word} {}", with_error(of.share, of.error), at(of.at)))
}

/// How it goes, in one of three words, and which shares do.
fn told<'w>(of: &Movement, words: [&'w str; 3], [up, down]: [String; 2]) -> (&'w str, String) {
    match of.verdict {
        Verdict::Up => (words[0], up),
        Verdict::Down => (words[1], down),
        _ => (words[2], format!("{up}, {down}")),
    }
}

/// What became of a move by the end.
fn fate(of: &Movement) -> String {
    let Some(end) = of.at_end.map(|moves| moves[of.way()]) else {
        return String::new();
    };
    let end = with_error(end.share, end.error);
    match of.fate {
        Some(Fate::Back) => format!(", back at the end ({end})"),
        Some(Fate::Lost) => format!(", then lost ({end} at the end)"),
        Some(Fate::Stays) => String::new(),
        None => format!(", {end} at the end"),
    }
}

fn short(x: f64) -> String {
    crate::measure::digits(format!("{x:.2e}").parse().unwrap_or(x))
}

impl<'a> Words<'a> {
    /// `None` where no answer was requested.
    pub fn of(analysis: &'a Analysis) -> Option<Words<'a>> {
        Some(Words {
            axes: &analysis.axes,
            answer: analysis.answer.as_ref()?,
            direction: analysis.direction_of_waves().or(analysis.direction),
            undirected: analysis.undirected,
            hum: analysis.warnings.iter().find(|warning| warning.is_hum()),
        })
    }

    fn frequency(&self, f: f64) -> String {
        let unit = self.axes.frequency_unit();
        let sizes = [("MHz", 1e6), ("kHz", 1e3), ("Hz", 1.0)];
        if let Some(hertz) = size::<Frequency>(&unit).map(|size| f * size) {
            let of = sizes.iter().find(|(_, size)| hertz >= *size);
            let (name, size) = of.unwrap_or(&sizes[2]);
            return format!("{} {name}", short(hertz / size));
        }
        // Longer than the number.
        let unit = if unit.len() > 12 { "" } else { &unit };
        format!("{} {unit}", short(f)).trim_end().to_owned()
    }

    fn wavenumber(&self, k: f64) -> String {
        format!("{} {}", short(k), self.axes.wavenumber_unit())
    }

    /// `body 3`, `sites 4-7`.
    pub fn sites(&self, place: &Place) -> String {
        match (self.answer.is_struck, place.rows) {
            (true, [a, b]) if a == b => format!("body {a}"),
            (false, [a, b]) if a == b => format!("site {a}"),
            (true, [a, b]) => format!("bodies {a}-{b}"),
            (false, [a, b]) => format!("sites {a}-{b}"),
        }
    }

    /// `t = 0.02 s`.
    pub fn time(&self, place: &Place) -> String {
        let unit = self.axes.time.unit.as_deref().unwrap_or_default();
        format!("t = {} {unit}", short(place.at))
            .trim_end()
            .to_owned()
    }

    /// The first line: what is told of frequency and of wavenumber, the larger move first. Of a periodic box frequencies along x say
    /// nothing.
    fn verdict(&self) -> String {
        let [f, k] = [&self.answer.frequency, &self.answer.wavenumber];
        if let Some(front) = self.answer.front.as_ref().filter(|_| self.answer.is_struck) {
            return self.of_front(front);
        }
        let is_told = |of: &Movement| of.verdict != Verdict::Untold;
        let along_x = (is_told(f) && !self.answer.is_periodic).then(|| self.along_x(f));
        let in_time = is_told(k).then(|| self.wavenumbers(k));
        let size = |of: &Movement| if of.moves() { of.most().share } else { 0.0 };
        let mut told: Vec<String> = along_x.into_iter().chain(in_time).collect();
        if size(k) > size(f) {
            told.reverse();
        }
        if !told.is_empty() {
            return told.join("; ");
        }
        let (what, of) = match self.answer.is_periodic || k.bound < f.bound.min(1.0) {
            true => ("in wavenumber in time", k),
            false => ("in frequency along x", f),
        };
        let (_, reason, advice) = self.why(&of.reason.unwrap_or(Reason::NoEnergy));
        format!("what moves {what} cannot be told: {reason}; {advice}")
    }

    fn along_x(&self, of: &Movement) -> String {
        let ends = of.from.zip(of.to);
        let (from, to) = ends.map_or((0, 0), |(from, to)| (from.rows[0], to.rows[1]));
        let way = if to < from { "towards -x" } else { "along x" };
        if of.moves() && of.transfer == Some(true) {
            let both = both(of, |f| self.frequency(f));
            let (moves, what) = told(of, ["moves up", "moves down", "spreads"], both);
            let fate = fate(of);
            return format!("energy {moves} in frequency {way}: {what} by site {to}{fate}");
        }
        if of.moves() {
            return format!("{}{}", self.shares(of, &format!("site {to}")), fate(of));
        }
        let is_noise = matches!(self.undirected, Some(Reason::Noise { .. }));
        let hidden = match self.hum {
            Some(hum) => format!("; {}; {}", hum.message(), hum.advice()),
            None if is_noise && !self.answer.has_fronts => {
                " in records like noise, which may hide a weak wave".into()
            }
            None => String::new(),
        };
        // Where the wave is seen at a part of the sites.
        let is_part = ((from.abs_diff(to) + 1) as f64) < SPAN * self.axes.n_sites as f64;
        let span = match ends {
            Some(_) if is_part => format!(" from site {from} to {to}"),
            _ => String::new(),
        };
        let bound = below(of.bound);
        format!("no energy moves in frequency {way}{span} (less than {bound}, at 95 %){hidden}")
    }

    /// Which shares have changed, where no energy is told to move.
    fn shares(&self, of: &Movement, by: &str) -> String {
        let [up, down] = [of.up, of.down].map(|of| with_error(of.share, of.error));
        let [f, g] = [of.up.at, of.down.at].map(|f| self.frequency(f));
        let (late, changed) = match of.verdict {
            Verdict::Up => ("lower", format!("share above {f} grows by {up}")),
            Verdict::Down => ("higher", format!("share above {g} falls by {down}")),
            _ => (
                "some",
                format!("shares above {f} and below {g} grow by {up} and {down}"),
            ),
        };
        let changed = format!("{changed} by {by}");
        match of.transfer {
            _ if of.lags => format!("{late} frequencies lag behind the front: its {changed}"),
            Some(true) => format!("energy moves: its {changed}"),
            Some(false) => format!("selective loss: the {changed}, no energy is gained there"),
            None => format!("the {changed}; whether energy is gained there cannot be told"),
        }
    }

    fn wavenumbers(&self, of: &Movement) -> String {
        if !of.moves() {
            return format!("wavenumbers stay (less than {} moves)", below(of.bound));
        }
        let both = both(of, |k| self.wavenumber(k));
        let (so, what) = told(of, ["rise", "fall", "spread"], both);
        let by = of.to.map(|to| format!(" by {}", self.time(&to)));
        format!(
            "wavenumbers {so}: {what}{}{}",
            by.unwrap_or_default(),
            fate(of)
        )
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
        let few = (self.axes.n_sites < DIRECTED).then_some(Reason::FewSites);
        few.or(self.undirected).map(|reason| reason.message())
    }

    /// Of a struck chain.
    fn of_front(&self, front: &Front) -> String {
        let of = &self.answer.frequency;
        // Of what it has at their first.
        let left = (-front.loss_per_100_bodies).exp();
        let loss = with_error(1.0 - left, left * front.error);
        let damping = if self.answer.is_lossy {
            ", to damping too"
        } else {
            ""
        };
        let [from, to] = front.bodies;
        let loses = match front.loss_per_100_bodies < KEEPS.max(front.error) {
            true => format!("the front keeps its energy: it loses {loss} per 100 bodies"),
            false => format!(
                "the front loses {loss} of its energy per 100 bodies{damping}, from body {from} to {to}"
            ),
        };
        let by = of.to.map_or(0, |place| place.rows[1]);
        let bound = below(of.bound);
        match of.verdict {
            Verdict::Untold => loses,
            Verdict::Unchanged => {
                format!("{loses}, and its content stays (less than {bound} moves)")
            }
            _ => format!("{loses}; {}", self.shares(of, &format!("body {by}"))),
        }
    }

    /// The second line: both shares, and what they compare; the share above the frequency of the verdict along x.
    fn moved(&self) -> Fact {
        let of = &self.answer.frequency;
        let moved = |of: &Movement| {
            let [up, down] = both(of, |f| self.frequency(f));
            match [of.up, of.down].map(|of| of.share >= 0.01) {
                [true, true] => format!("{up}, {down}"),
                [true, false] => up,
                [false, true] => down,
                [false, false] => "less than 1 %".into(),
            }
        };
        let launch = self.answer.launch.as_ref();
        let launch = launch.filter(|of| of.most().share > 0.0);
        let launch = launch.map(|launch| format!("launch {}", moved(launch)));
        let travel = of.from.zip(of.to).map(|(from, to)| {
            let [from, to] = [from, to].map(|place| self.sites(&place));
            format!("{}, {to} against {from}", moved(of))
        });
        let reason = of.reason.map(|reason| self.why(&reason).1);
        let untold = reason.map(|reason| format!("nothing is told: {reason}"));
        let said: Vec<String> = [launch, travel, untold].into_iter().flatten().collect();
        let profile = self.answer.along_x.as_ref().map(|evidence| {
            let first = &evidence.groups[0].cumulative;
            let half = first.partition_point(|c| *c < 0.5).min(first.len() - 1);
            evidence.above(of.past().unwrap_or(evidence.upper[half]))
        });
        fact("moved", said.join("; "), profile)
    }

    /// The energy at the last place over that at the first, where one wave passes both. Of a struck chain the first line says it: first
    /// bodies hold all that the launch leaves behind.
    fn attenuation(&self) -> Option<Fact> {
        let stands = !self.answer.has_fronts && self.direction.is_some_and(|d| is_even(&d));
        let is_one = !self.answer.frequency.energy_ratio.is_nan();
        let evidence = self.answer.along_x.as_ref();
        let evidence = evidence.filter(|_| is_one && !stands && !self.answer.is_struck)?;
        let groups = &evidence.groups;
        let (first, last) = (groups.first()?, groups.last()?);
        let ratio = last.energy / first.energy;
        let [from, to] = [first, last].map(|group| self.sites(&group.place));
        // Without a sign of zero.
        let decibels = (100.0 * ratio.log10()).round() / 10.0 + 0.0;
        let share = share(ratio);
        let text = format!("the energy at {to} is {share} of that at {from} ({decibels:+.1} dB)");
        let energies = groups.iter().map(|group| group.energy).collect();
        (ratio > 0.0).then(|| fact("attenuation", text, Some(energies)))
    }

    fn in_time(&self) -> Fact {
        let of = &self.answer.wavenumber;
        let text = match of.reason {
            Some(reason) => format!("wavenumbers: cannot be told: {}", reason.message()),
            // Not of the front alone.
            None if self.answer.is_struck => format!("of all bodies, {}", self.wavenumbers(of)),
            None => self.wavenumbers(of),
        };
        let evidence = self.answer.along_t.as_ref();
        let evidence = evidence.filter(|_| of.most().at.is_finite());
        let above = evidence.map(|evidence| evidence.above(of.most().at));
        fact("in time", text, above)
    }

    fn direction(&self) -> Option<Fact> {
        // What does not move has none.
        let moves = self.answer.frequency.reason != Some(Reason::NoEnergy);
        let direction = self.direction.filter(|_| moves)?;
        let [plus, minus] = [direction.toward_plus_x, direction.toward_minus_x].map(share);
        let speed = self.answer.speed;
        let neither = match direction.undirected > 0.01 {
            true => format!(", {} neither (k = 0 or f = 0)", share(direction.undirected)),
            false => String::new(),
        };
        let stands = match is_even(&direction) && !self.answer.has_fronts {
            true => ": waves stand, or come from both sides",
            false => "",
        };
        let text = match self.undirected() {
            Some(reason) => format!("cannot be told: {reason}"),
            // In a chain of cells, a one-way wave has components of both signs.
            None if self.answer.is_struck => match speed.is_some_and(|of| of.value < 0.0) {
                true => "the front travels towards -x".into(),
                false => "the front travels towards +x".into(),
            },
            None => format!("{plus} towards +x, {minus} towards -x{neither}{stands}"),
        };
        let unit = format!("{}/{}", self.axes.space_unit(), self.axes.time_unit());
        let speed = speed.map(|of| with_half(of.value.abs(), of.error, &unit));
        let speed = speed.map(|speed| format!("; arrivals at {speed}"));
        Some(Fact::new("direction", text + &speed.unwrap_or_default()))
    }
}

/// Whether as much goes one way as the other.
fn is_even(direction: &Direction) -> bool {
    let [plus, minus] = [direction.toward_plus_x, direction.toward_minus_x];
    (plus - minus).abs() < EVEN * (plus + minus)
}

/// Of pictures: where shares moved, and how much.
#[cfg(feature = "figures")]
impl Words<'_> {
    pub fn in_frequency(&self, of: &Movement) -> [(f64, String); 2] {
        let [up, down] = both(of, |f| self.frequency(f));
        [(of.up.at, up), (of.down.at, down)]
    }

    pub fn in_wavenumber(&self, of: &Movement) -> [(f64, String); 2] {
        let [up, down] = both(of, |k| self.wavenumber(k));
        [(of.up.at, up), (of.down.at, down)]
    }
}
