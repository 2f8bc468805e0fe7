//! The answer of an analysis in words.

use super::super::quality::is_hum;
use super::super::{Analysis, Axes, Direction, Warning};
use crate::measure::{Frequency, size};
use crate::moved::{Answer, Fate, Front, Movement, Place, Reason, Verdict};
use crate::sheet::{Fact, three_digits, with_half};

/// The verdict, and a fact for each further question; `None` where no answer was requested.
pub(super) fn describe(analysis: &Analysis) -> Option<(String, Vec<Fact>)> {
    let words = Words::of(analysis)?;
    let mut facts = vec![words.moved(), words.in_time()];
    facts.extend(words.direction().into_iter().chain(words.attenuation()));
    Some((words.verdict(), facts))
}

/// Difference of the shares by direction, as a part of both, up to which they are alike.
const EVEN: f64 = 0.1;
/// Part of the sites from which on a verdict is one of all.
const SPAN: f64 = 0.75;
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

/// What a share is below, rounded up: `2 %`.
fn below(x: f64) -> String {
    format!("{} %", (100.0 * x).ceil().max(1.0))
}

/// `40.7 ± 1.9 % past 4 kHz`, `2.00 ± 0.10 % below 3 kHz`.
pub(crate) fn both(of: &Movement, at: impl Fn(f64) -> String) -> [String; 2] {
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

/// Three digits with their unit, if there is one.
fn of_unit(value: f64, unit: &str) -> String {
    format!("{} {unit}", three_digits(value)).trim_end().into()
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

impl<'a> Words<'a> {
    /// `None` where no answer was requested.
    pub fn of(analysis: &'a Analysis) -> Option<Words<'a>> {
        Some(Words {
            axes: &analysis.axes,
            answer: analysis.answer.as_ref()?,
            direction: analysis.direction_of_waves().or(analysis.direction),
            undirected: analysis.undirected,
            hum: analysis.warnings.iter().find(|warning| is_hum(warning)),
        })
    }

    pub fn frequency(&self, f: f64) -> String {
        let unit = self.axes.frequency_unit();
        let (value, unit) = match size::<Frequency>(&unit).map(|size| f * size) {
            Some(hertz) if hertz >= 1e6 => (1e-6 * hertz, "MHz"),
            Some(hertz) if hertz >= 1e3 => (1e-3 * hertz, "kHz"),
            Some(hertz) => (hertz, "Hz"),
            // Longer than the number.
            None if unit.len() > 12 => (f, ""),
            None => (f, &*unit),
        };
        of_unit(value, unit)
    }

    pub fn wavenumber(&self, k: f64) -> String {
        of_unit(k, &self.axes.wavenumber_unit())
    }

    /// `body 3`, `sites 4-7`.
    pub fn sites(&self, place: &Place) -> String {
        let is_struck = self.answer.is_struck;
        match place.rows {
            [a, b] if a == b => format!("{} {a}", if is_struck { "body" } else { "site" }),
            [a, b] => format!("{} {a}-{b}", if is_struck { "bodies" } else { "sites" }),
        }
    }

    /// `t = 0.02 s`.
    pub fn time(&self, place: &Place) -> String {
        let unit = self.axes.time.unit.as_deref().unwrap_or_default();
        format!("t = {}", of_unit(place.at, unit))
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
            return self.shares(of, &format!("site {to}")) + &fate(of);
        }
        let hum = self
            .hum
            .map(|hum| format!("; {}; {}", hum.message, hum.advice));
        // Where the wave is seen at a part of the sites.
        let is_part = ((from.abs_diff(to) + 1) as f64) < SPAN * self.axes.n_sites as f64;
        let span = ends
            .filter(|_| is_part)
            .map(|_| format!(" from site {from} to {to}"));
        let (span, hum) = (span.unwrap_or_default(), hum.unwrap_or_default());
        let bound = below(of.bound);
        let is_noise = matches!(self.undirected, Some(Reason::Noise { .. }));
        let of = ["", " in records like noise"][usize::from(is_noise)];
        format!("no energy moves in frequency {way}{span}{of} (less than {bound}, at 95 %){hum}")
    }

    /// Which shares have changed, where no energy is told to move.
    fn shares(&self, of: &Movement, by: &str) -> String {
        let [up, down] = [of.up, of.down].map(|of| with_error(of.share, of.error));
        let [f, g] = [of.up.at, of.down.at].map(|f| self.frequency(f));
        let [grows, falls] = [f + " grows by " + &up, g + " falls by " + &down];
        let both = [grows, falls].map(|how| format!("share above {how}"));
        let (late, changed) = told(of, ["lower", "higher", "some"], both);
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
        let (by, fate) = (by.unwrap_or_default(), fate(of));
        format!("wavenumbers {so}: {what}{by}{fate}")
    }

    /// Why frequencies cannot be told: stable name, message and advice.
    pub(super) fn why(&self, reason: &Reason) -> (&str, String, &str) {
        match self.hum {
            Some(hum) => (hum.code, hum.message.clone(), &hum.advice),
            None => reason.parts(),
        }
    }

    /// Why shares by direction are withheld, if they are.
    pub(super) fn undirected(&self) -> Option<String> {
        self.undirected.map(|reason| reason.message())
    }

    /// Of a struck chain.
    fn of_front(&self, front: &Front) -> String {
        let of = &self.answer.frequency;
        // Of what it has at their first.
        let left = (-front.loss_per_100_bodies).exp();
        let loss = with_error(1.0 - left, left * front.error);
        let damping = ["", ", to damping too"][usize::from(self.answer.is_lossy)];
        let [from, to] = front.bodies;
        let loses = match front.loss_per_100_bodies < KEEPS.max(front.error) {
            true => format!("keeps its energy: it loses {loss} per 100 bodies"),
            false => format!(
                "loses {loss} of its energy per 100 bodies{damping}, from body {from} to {to}"
            ),
        };
        let by = of.to.map_or(0, |place| place.rows[1]);
        let bound = below(of.bound);
        let content = match of.verdict {
            Verdict::Untold => String::new(),
            Verdict::Unchanged => format!(", and its content stays (less than {bound} moves)"),
            _ => format!("; {}", self.shares(of, &format!("body {by}"))),
        };
        format!("the front {loses}{content}")
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
        let reason = of
            .reason
            .map(|reason| "nothing is told: ".to_owned() + &self.why(&reason).1);
        let said: Vec<String> = [launch, travel, reason].into_iter().flatten().collect();
        let profile = self.answer.along_x.as_ref().map(|evidence| {
            let first = &evidence.groups[0].cumulative;
            let half = first.partition_point(|c| *c < 0.5).min(first.len() - 1);
            evidence.above(of.past().unwrap_or(evidence.upper[half]))
        });
        Fact::new("moved", said.join("; ")).along(profile)
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
        (ratio > 0.0).then(|| Fact::new("attenuation", text).along(Some(energies)))
    }

    fn in_time(&self) -> Fact {
        let of = &self.answer.wavenumber;
        let text = match of.reason {
            Some(reason) => format!("wavenumbers: cannot be told: {}", reason.message()),
            // Not of the front alone.
            None if self.answer.is_struck => format!("of all bodies, {}", self.wavenumbers(of)),
            None => self.wavenumbers(of),
        };
        let at = of.most().at;
        let evidence = self.answer.along_t.as_ref().filter(|_| at.is_finite());
        Fact::new("in time", text).along(evidence.map(|evidence| evidence.above(at)))
    }

    fn direction(&self) -> Option<Fact> {
        // What does not move has none.
        let moves = self.answer.frequency.reason != Some(Reason::NoEnergy);
        let direction = self.direction.filter(|_| moves)?;
        let [plus, minus] = [direction.toward_plus_x, direction.toward_minus_x].map(share);
        let speed = self.answer.speed;
        let sign = ['+', '-'][usize::from(speed.is_some_and(|of| of.value < 0.0))];
        let mut text = match self.undirected() {
            Some(reason) => format!("cannot be told: {reason}"),
            // In a chain of cells, a one-way wave has components of both signs.
            None if self.answer.is_struck => format!("the front travels towards {sign}x"),
            None => format!("{plus} towards +x, {minus} towards -x"),
        };
        let is_shared = self.undirected().is_none() && !self.answer.is_struck;
        if is_shared && direction.undirected > 0.01 {
            text += &format!(", {} neither (k = 0 or f = 0)", share(direction.undirected));
        }
        if is_shared && is_even(&direction) && !self.answer.has_fronts {
            text += ": waves stand, or come from both sides";
        }
        if let Some(of) = speed {
            let unit = format!("{}/{}", self.axes.space_unit(), self.axes.time_unit());
            text = text + "; arrivals at " + &with_half(of.value.abs(), of.error, &unit);
        }
        Some(Fact::new("direction", text))
    }
}

/// Whether as much goes one way as the other.
fn is_even(direction: &Direction) -> bool {
    let [plus, minus] = [direction.toward_plus_x, direction.toward_minus_x];
    (plus - minus).abs() < EVEN * (plus + minus)
}
