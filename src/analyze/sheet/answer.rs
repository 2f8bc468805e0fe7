//! The answer of an analysis in words.

use super::super::{Analysis, Axes};
use crate::measure::{Frequency, size};
use crate::moved::{Answer, Fate, Front, Movement, Place, Reason, Verdict};
use crate::sheet::{Fact, Units, three_digits, with_half};

/// Difference of the shares by direction, as a part of both, up to which waves stand.
const EVEN: f64 = 0.1;
/// Loss per 100 bodies below which a front keeps its energy.
const KEEPS: f64 = 1e-3;

/// The verdict, and a fact for each further question; `None` where no answer was requested.
pub(super) fn describe(analysis: &Analysis) -> Option<(String, Vec<Fact>)> {
    let words = Words::of(analysis)?;
    let mut facts = vec![words.moved(), words.in_time()];
    facts.extend(
        words
            .direction(analysis)
            .into_iter()
            .chain(words.attenuation()),
    );
    Some((words.verdict(), facts))
}

/// The words of an answer.
pub(crate) struct Words<'a> {
    axes: &'a Axes,
    answer: &'a Answer,
    /// Whether waves stand, or come from both sides.
    stands: bool,
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

/// What became of a move by the end.
fn fate(of: &Movement) -> String {
    let end = of.at_end.map(|moves| moves[of.way()]);
    let end = end.map_or(String::new(), |end| with_error(end.share, end.error));
    match of.fate {
        Some(Fate::Back) => format!(", back at the end ({end})"),
        Some(Fate::Lost) => format!(", then lost ({end} at the end)"),
        Some(Fate::Stays) | None => String::new(),
    }
}

/// Three digits with their unit, if there is one.
fn of_unit(value: f64, unit: &str) -> String {
    format!("{} {unit}", three_digits(value)).trim_end().into()
}

impl<'a> Words<'a> {
    /// `None` where no answer was requested.
    pub fn of(analysis: &'a Analysis) -> Option<Words<'a>> {
        let answer = analysis.answer.as_ref()?;
        let is_even = analysis.direction.is_some_and(|of| {
            let [plus, minus] = [of.toward_plus_x, of.toward_minus_x];
            (plus - minus).abs() < EVEN * (plus + minus)
        });
        Some(Words {
            axes: &analysis.axes,
            answer,
            stands: is_even && !answer.has_fronts,
        })
    }

    pub fn frequency(&self, f: f64) -> String {
        let unit = self.axes.units().frequency;
        match size::<Frequency>(&unit).map(|size| f * size) {
            Some(hertz) if hertz >= 1e6 => of_unit(1e-6 * hertz, "MHz"),
            Some(hertz) if hertz >= 1e3 => of_unit(1e-3 * hertz, "kHz"),
            Some(hertz) => of_unit(hertz, "Hz"),
            // Longer than the number.
            None if unit.len() > 12 => three_digits(f),
            None => of_unit(f, &unit),
        }
    }

    pub fn wavenumber(&self, k: f64) -> String {
        of_unit(k, &self.axes.units().wavenumber)
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
        let (f, k) = (&self.answer.frequency, &self.answer.wavenumber);
        if let Some(front) = self.answer.front.as_ref().filter(|_| self.answer.is_struck) {
            return self.of_front(front);
        }
        let is_told = |of: &Movement| of.verdict != Verdict::Untold;
        let along_x = (is_told(f) && !self.answer.is_periodic).then(|| self.along_x(f));
        let in_time = is_told(k).then(|| self.wavenumbers(k));
        let mut told: Vec<String> = along_x.into_iter().chain(in_time).collect();
        let size = |of: &Movement| if of.moves() { of.most().share } else { 0.0 };
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
        let (_, reason, advice) = of.reason.unwrap_or(Reason::NoEnergy).parts();
        format!("what moves {what} cannot be told: {reason}; {advice}")
    }

    /// Whether energy moves, or shares of it for another reason.
    fn along_x(&self, of: &Movement) -> String {
        let ends = of.from.zip(of.to);
        let way = match ends.is_some_and(|(from, to)| to.rows[1] < from.rows[0]) {
            true => "towards -x",
            false => "along x",
        };
        let site = |place: Place| place.rows[1];
        let Some(to) = of.to.filter(|_| of.moves()).map(site) else {
            let sites =
                ends.map(|(from, to)| format!(" from site {} to {}", from.rows[0], site(to)));
            let (sites, bound) = (sites.unwrap_or_default(), below(of.bound));
            return format!(
                "no energy moves in frequency {way}{sites} (less than {bound}, at 95 %)"
            );
        };
        match of.transfer == Some(true) && !of.lags {
            true => {
                let words = ["moves up", "moves down", "spreads"];
                let (moves, shares) = told(of, words, both(of, |f| self.frequency(f)));
                format!(
                    "energy {moves} in frequency {way}: {shares} by site {to}{}",
                    fate(of)
                )
            }
            false => self.shares(of, &format!("site {to}")) + &fate(of),
        }
    }

    /// Which shares have changed, where no energy is told to move.
    fn shares(&self, of: &Movement, by: &str) -> String {
        let changed = [(of.up, "grows"), (of.down, "falls")].map(|(of, how)| {
            let share = with_error(of.share, of.error);
            format!("share above {} {how} by {share}", self.frequency(of.at))
        });
        let (late, changed) = told(of, ["lower", "higher", "some"], changed);
        match of.transfer {
            _ if of.lags => {
                format!("{late} frequencies lag behind the front: its {changed} by {by}")
            }
            Some(true) => format!("energy moves: its {changed} by {by}"),
            Some(false) => {
                format!("selective loss: the {changed} by {by}, no energy is gained there")
            }
            None => {
                format!("the {changed} by {by}; whether energy is gained there cannot be told")
            }
        }
    }

    fn wavenumbers(&self, of: &Movement) -> String {
        if !of.moves() {
            return format!("wavenumbers stay (less than {} moves)", below(of.bound));
        }
        let (so, shares) = told(
            of,
            ["rise", "fall", "spread"],
            both(of, |k| self.wavenumber(k)),
        );
        let by = of.to.map_or(String::new(), |to| self.time(&to));
        format!("wavenumbers {so}: {shares} by {by}{}", fate(of))
    }

    /// Of a struck chain.
    fn of_front(&self, front: &Front) -> String {
        let of = &self.answer.frequency;
        // Of what it has at their first.
        let left = (-front.loss_per_100_bodies).exp();
        let loss = with_error(1.0 - left, left * front.error);
        let [from, to] = front.bodies;
        let loses = match front.loss_per_100_bodies < KEEPS.max(front.error) {
            true => format!("keeps its energy: it loses {loss} per 100 bodies"),
            false => format!("loses {loss} of its energy per 100 bodies, from body {from} to {to}"),
        };
        let content = match of.verdict {
            Verdict::Untold => String::new(),
            Verdict::Unchanged => {
                let bound = below(of.bound);
                format!(", and its content stays (less than {bound} moves)")
            }
            _ => {
                let by = of.to.map_or(0, |place| place.rows[1]);
                format!("; {}", self.shares(of, &format!("body {by}")))
            }
        };
        format!("the front {loses}{content}")
    }

    /// The second line: both shares, and what they compare; the share above the frequency of the verdict along x.
    fn moved(&self) -> Fact {
        let of = &self.answer.frequency;
        let moved = |of: &Movement| {
            let shares = [of.up, of.down]
                .into_iter()
                .zip(both(of, |f| self.frequency(f)));
            let large = shares.filter(|(of, _)| of.share >= 0.01);
            let large: Vec<String> = large.map(|(_, text)| text).collect();
            match large.is_empty() {
                true => "less than 1 %".into(),
                false => large.join(", "),
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
            .map(|reason| format!("cannot be told: {}", reason.message()));
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
        let is_one = !self.answer.frequency.energy_ratio.is_nan();
        let evidence = self.answer.along_x.as_ref();
        let evidence = evidence.filter(|_| is_one && !self.stands && !self.answer.is_struck)?;
        let (first, last) = (evidence.groups.first()?, evidence.groups.last()?);
        let ratio = last.energy / first.energy;
        let [from, to] = [first, last].map(|group| self.sites(&group.place));
        // Without a sign of zero.
        let decibels = (100.0 * ratio.log10()).round() / 10.0 + 0.0;
        let share = three_digits(100.0 * ratio);
        let text = format!("the energy at {to} is {share} % of that at {from} ({decibels:+.1} dB)");
        let energies = evidence.groups.iter().map(|group| group.energy).collect();
        (ratio > 0.0).then(|| Fact::new("attenuation", text).along(Some(energies)))
    }

    fn in_time(&self) -> Fact {
        let of = &self.answer.wavenumber;
        let text = match of.reason {
            Some(reason) => format!("wavenumbers: cannot be told: {}", reason.message()),
            None => self.wavenumbers(of),
        };
        let at = of.most().at;
        let evidence = self.answer.along_t.as_ref().filter(|_| at.is_finite());
        Fact::new("in time", text).along(evidence.map(|evidence| evidence.above(at)))
    }

    /// Shares by direction, and the speed of arrivals. In a chain of cells a one-way wave has components of both signs.
    fn direction(&self, analysis: &Analysis) -> Option<Fact> {
        let direction = analysis
            .direction_of_waves()
            .filter(|_| !self.answer.is_struck);
        let shares = direction.map(|of| {
            let [plus, minus] = [of.toward_plus_x, of.toward_minus_x].map(|x| 100.0 * x);
            format!("{plus:.1} % towards +x, {minus:.1} % towards -x")
        });
        let untold = analysis.undirected;
        let untold = untold.map(|reason| format!("cannot be told: {}", reason.message()));
        let speed = self.answer.speed.map(|of| {
            let Units { space, time, .. } = self.axes.units();
            let unit = format!("{space}/{time}");
            let sign = ['+', '-'][usize::from(of.value < 0.0)];
            let speed = with_half(of.value.abs(), of.error, &unit);
            format!("arrivals at {speed} towards {sign}x")
        });
        let said: Vec<String> = [shares.or(untold), speed].into_iter().flatten().collect();
        (!said.is_empty()).then(|| Fact::new("direction", said.join("; ")))
    }
}
