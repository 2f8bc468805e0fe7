//! The answer of an analysis in words.

use super::super::{Analysis, Axes, Direction, Undirected, Warning};
use crate::measure::{Frequency, size};
use crate::moved::{Answer, Fate, Front, Move, Movement, Place, Reason, Verdict};
use crate::sheet::Fact;

/// The verdict, and a fact for each further question; `None` where no answer was requested.
pub(super) fn describe(analysis: &Analysis) -> Option<(String, Vec<Fact>)> {
    let words = Words::of(analysis)?;
    let facts = [
        Some(Fact::new("moved", words.numbers())),
        words.along_x(),
        words.in_time(),
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

/// A share with its error, to the same digit: `41 ± 2 %`.
fn with_error(of: &Move) -> String {
    value_with_error(of.share, of.error)
}

/// `41 ± 2 % past 4 kHz`, `2.0 ± 0.1 % below 3 kHz`.
fn of_both(of: &Movement, at: impl Fn(f64) -> String) -> [String; 2] {
    [(of.up, "past"), (of.down, "below")]
        .map(|(of, word)| format!("{} {word} {}", with_error(&of), at(of.at)))
}

/// How it goes, in one of three words, and which shares do.
fn told(
    of: &Movement,
    words: [&'static str; 3],
    at: impl Fn(f64) -> String,
) -> (&'static str, String) {
    let [up, down] = of_both(of, at);
    match of.verdict {
        Verdict::Up => (words[0], up),
        Verdict::Down => (words[1], down),
        _ => (words[2], format!("{up}, {down}")),
    }
}

/// To the first digit of the error, rounded up from hundredths on; exact values have none.
fn value_with_error(value: f64, error: f64) -> String {
    let [value, error] = [value, error].map(|x| 100.0 * x);
    let finest = if value >= 0.995 { 2 } else { 4 };
    let digits = match error {
        error if error >= 0.95 && value >= 9.95 => 0,
        error if error >= 0.095 || error == 0.0 => 1,
        error => ((-error.log10()).ceil() as usize).min(finest),
    };
    let least = 10f64.powi(-(digits as i32));
    // Without a sign of zero.
    let value = if value.abs() < 0.5 * least {
        0.0
    } else {
        value
    };
    match error == 0.0 {
        true => format!("{value:.digits$} %"),
        false => format!("{value:.digits$} ± {:.digits$} %", error.max(least)),
    }
}

/// What became of a move by the end.
fn fate(of: &Movement) -> String {
    let end = of.at_end.map(|moves| with_error(&moves[of.way()]));
    match (of.fate, end) {
        (Some(Fate::Back), Some(end)) => format!(", back at the end ({end})"),
        (Some(Fate::Lost), Some(end)) => format!(", then lost ({end} at the end)"),
        (None, Some(end)) if of.moves() => format!(", {end} at the end"),
        _ => String::new(),
    }
}

/// What a share is below, rounded up: `2 %`.
fn below(x: f64) -> String {
    format!("{} %", (100.0 * x).ceil().max(1.0))
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
        let unit = self.axes.frequency_unit();
        let sizes = [("MHz", 1e6), ("kHz", 1e3), ("Hz", 1.0)];
        let hertz = size::<Frequency>(&unit).map(|size| f * size);
        let of = hertz.map(|f| *sizes.iter().find(|(_, of)| f >= *of).unwrap_or(&sizes[2]));
        let text = match hertz.zip(of) {
            Some((f, (name, size))) => format!("{} {name}", short(f / size)),
            // Longer than the number.
            None if unit.len() > 12 => short(f),
            None => format!("{} {unit}", short(f)),
        };
        text.trim_end().to_owned()
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

    /// The first line: what is told of frequency and of wavenumber, the larger move first. Of a periodic box frequencies along x say
    /// nothing.
    fn verdict(&self) -> String {
        let [f, k] = [&self.answer.frequency, &self.answer.wavenumber];
        let is_told = |of: &Movement| of.verdict != Verdict::Untold;
        if let Some(front) = self.answer.front.as_ref().filter(|_| self.answer.is_struck) {
            return self.of_front(front);
        }
        let along_x = (is_told(f) && !self.answer.is_periodic).then(|| self.in_frequency_told(f));
        let in_time = is_told(k).then(|| self.in_wavenumber_told(k));
        let size = |of: &Movement| if of.moves() { of.most().share } else { 0.0 };
        match (along_x, in_time) {
            (Some(x), Some(t)) if size(k) > size(f) => format!("{t}; {x}"),
            (Some(x), Some(t)) => format!("{x}; {t}"),
            (Some(told), None) | (None, Some(told)) => told,
            (None, None) => {
                let (what, of) = match self.answer.is_periodic || k.bound < f.bound.min(1.0) {
                    true => ("in wavenumber in time", k),
                    false => ("in frequency along x", f),
                };
                let reason = of.reason.as_ref().map(|reason| self.why(reason));
                let (_, reason, advice) = reason.unwrap_or_default();
                format!("what moves {what} cannot be told: {reason}; {advice}")
            }
        }
    }

    fn in_frequency_told(&self, of: &Movement) -> String {
        let ends = of
            .from
            .zip(of.to)
            .map(|(from, to)| (from.rows[0], to.rows[1]));
        let (from, to) = ends.unwrap_or_default();
        let way = if to < from { "towards -x" } else { "along x" };
        let hidden = match self.hum {
            Some(hum) => format!("; {}", hum.message()),
            None if self.is_noise => " in records like noise, which may hide a weak wave".into(),
            None => String::new(),
        };
        // Where the wave is seen at a part of the sites.
        let is_part = ((from.abs_diff(to) + 1) as f64) < SPAN * self.axes.n_sites as f64;
        let span = match ends {
            Some(_) if is_part => format!(" from site {from} to {to}"),
            _ => String::new(),
        };
        let (moves, what) = told(of, ["moves up", "moves down", "spreads"], |f| {
            self.frequency(f)
        });
        match of.transfer {
            _ if !of.moves() => format!(
                "no energy moves in frequency {way}{span} (less than {}, at 95 %){hidden}",
                below(of.bound)
            ),
            Some(true) => format!(
                "energy {moves} in frequency {way}: {what} by site {to}{}",
                fate(of)
            ),
            _ => format!("{}{}", self.shares(of, &format!("site {to}")), fate(of)),
        }
    }

    /// Which shares have changed, where no energy is told to move.
    fn shares(&self, of: &Movement, by: &str) -> String {
        let [up, down] = [&of.up, &of.down].map(with_error);
        let [above, under] = [of.up.at, of.down.at].map(|f| self.frequency(f));
        let (late, changed) = match of.verdict {
            Verdict::Up => (
                "lower",
                format!("share above {above} grows by {up} by {by}"),
            ),
            Verdict::Down => (
                "higher",
                format!("share above {under} falls by {down} by {by}"),
            ),
            _ => (
                "low and high",
                format!("shares above {above} and below {under} grow by {up} and {down} by {by}"),
            ),
        };
        match of.transfer {
            _ if of.lags => format!("{late} frequencies lag behind the front: its {changed}"),
            Some(true) => format!("energy moves: its {changed}"),
            Some(false) => format!("selective loss: the {changed}, no energy is gained there"),
            _ => format!("the {changed}; whether energy is gained there cannot be told"),
        }
    }

    fn in_wavenumber_told(&self, of: &Movement) -> String {
        if !of.moves() {
            return format!("wavenumbers stay (less than {} moves)", below(of.bound));
        }
        let (move_so, what) = told(of, ["rise", "fall", "spread"], |k| self.wavenumber(k));
        let by = of.to.map(|to| format!(" by t = {}", self.time(&to)));
        format!(
            "wavenumbers {move_so}: {what}{}{}",
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
        if self.axes.n_sites < DIRECTED {
            return Some(
                format!("there are {}", counted(self.axes.n_sites, "site"))
                    .replace("are 1", "is 1"),
            );
        }
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

    /// Of a struck chain.
    fn of_front(&self, front: &Front) -> String {
        let of = &self.answer.frequency;
        // Of what it has at their first.
        let left = (-front.loss_per_100_bodies).exp();
        let loss = value_with_error(1.0 - left, left * front.error);
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
        match of.verdict {
            Verdict::Untold => loses,
            Verdict::Unchanged => {
                let bound = below(of.bound);
                format!("{loses}, and its content stays (less than {bound} moves)")
            }
            _ => format!("{loses}; {}", self.shares(of, &format!("body {by}"))),
        }
    }

    /// The second line: both shares, and what they compare.
    fn numbers(&self) -> String {
        let of = &self.answer.frequency;
        let untold = match of.reason.as_ref().map(|reason| self.why(reason)) {
            Some((_, reason, _)) => format!("; along x nothing is told: {reason}"),
            None => String::new(),
        };
        if of.up.share.is_nan() {
            let times = counted(self.axes.n_times, "time");
            return format!("{times}, {}{untold}", counted(self.axes.n_sites, "site"));
        }
        let moved = |of: &Movement| {
            let parts = [(&of.up, "up"), (&of.down, "down")];
            let parts = parts.iter().filter(|(of, _)| of.share >= 0.01);
            let parts: Vec<String> = parts
                .map(|(of, way)| format!("{} {way} at {}", with_error(of), self.frequency(of.at)))
                .collect();
            match parts.is_empty() {
                true => "less than 1 %".into(),
                false => parts.join(", "),
            }
        };
        let places = of.from.zip(of.to).map(|(from, to)| {
            let bodies = if self.answer.is_struck {
                "bodies"
            } else {
                "sites"
            };
            format!(
                ", {bodies} {} against {}",
                self.sites(&to),
                self.sites(&from)
            )
        });
        let launch = self
            .answer
            .launch
            .as_ref()
            .filter(|of| of.most().share > 0.0);
        let launch = launch.map(|launch| format!("launch {}; then ", moved(launch)));
        let [launch, places] = [launch, places].map(Option::unwrap_or_default);
        format!("{launch}{}{places}{untold}", moved(of))
    }

    fn along_x(&self) -> Option<Fact> {
        let evidence = self.answer.along_x.as_ref()?;
        let of = &self.answer.frequency;
        let first = &evidence.groups[0].cumulative;
        let half = first.iter().position(|c| *c >= 0.5)?;
        let edge = of.past().unwrap_or(evidence.upper[half]);
        let profile = evidence.above(edge);
        let last = profile.len() - 1;
        let at = |group: usize| {
            let sites = self.sites(&evidence.groups[group].place);
            format!("{} at {} {sites}", share(profile[group]), self.body())
        };
        let middle = match evidence.compared[1] {
            compared if compared == last || compared == 0 => last / 2,
            compared => compared,
        };
        let text = format!(
            "share of the energy above {}: {}, {}, {}",
            self.frequency(edge),
            at(0),
            at(middle),
            at(last)
        );
        Some(Fact {
            profile,
            ..Fact::new("along x", text)
        })
    }

    /// The energy at the last place over that at the first, where one wave passes both.
    fn attenuation(&self) -> Option<Fact> {
        let evidence = self.answer.along_x.as_ref()?;
        let stands = !self.answer.has_fronts && self.direction.is_some_and(|d| is_even(&d));
        // Of a struck chain the first line says it: first bodies hold all that the launch leaves behind.
        let is_said = self.answer.is_struck;
        if stands || is_said || self.answer.frequency.energy_ratio.is_nan() {
            return None;
        }
        let energies: Vec<f64> = evidence.groups.iter().map(|group| group.energy).collect();
        let [first, last] = [0, energies.len() - 1];
        let ratio = energies[last] / energies[first];
        let what = match self.answer.has_fronts {
            true => "the window's",
            false => "the record's",
        };
        let [from, to] = [first, last].map(|group| self.sites(&evidence.groups[group].place));
        let text = format!(
            "{what} energy at {} {to} is {} of that at {from} ({:+.1} dB)",
            self.body(),
            share(ratio),
            // Without a sign of zero.
            (100.0 * ratio.log10()).round() / 10.0 + 0.0
        );
        (ratio > 0.0).then(|| Fact {
            profile: energies,
            ..Fact::new("attenuation", text)
        })
    }

    fn in_time(&self) -> Option<Fact> {
        let of = &self.answer.wavenumber;
        let text = match &of.reason {
            Some(reason) => format!("wavenumbers: cannot be told: {}", reason.message()),
            // Not of the front alone.
            None if self.answer.is_struck => {
                format!("of all bodies, {}", self.in_wavenumber_told(of))
            }
            None => self.in_wavenumber_told(of),
        };
        let evidence = self
            .answer
            .along_t
            .as_ref()
            .filter(|_| of.most().at.is_finite());
        Some(Fact {
            profile: evidence.map_or(Vec::new(), |evidence| evidence.above(of.most().at)),
            ..Fact::new("in time", text)
        })
    }

    fn direction(&self) -> Option<Fact> {
        // What does not move has none.
        let moves = self.answer.frequency.reason != Some(Reason::NoEnergy);
        let direction = self.direction.filter(|_| moves)?;
        let [space, time] = [&self.axes.space, &self.axes.time];
        let speed = self.answer.speed.map(|speed| {
            let unit = match (&space.unit, &time.unit) {
                (Some(length), Some(time)) => format!("{length}/{time}"),
                (Some(length), None) => format!("{length} per {}", time.time_unit()),
                _ => {
                    let length = space.space_unit().replace("unit", "units");
                    format!(
                        "{} per {}",
                        length.replace("site", "sites"),
                        time.time_unit()
                    )
                }
            };
            let decimals = (1.0 - speed.error.log10().floor()).clamp(0.0, 6.0) as usize;
            let (value, error) = (speed.value.abs(), speed.error.max(1e-6));
            format!("; arrivals at {value:.decimals$} ± {error:.decimals$} {unit}")
        });
        let speed = speed.unwrap_or_default();
        let text = match self.undirected() {
            Some(reason) => format!("cannot be told: {reason}{speed}"),
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
                let neither = match direction.undirected > 0.01 {
                    true => format!(", {} neither (k = 0 or f = 0)", share(direction.undirected)),
                    false => String::new(),
                };
                let standing = match is_even(&direction) && !self.answer.has_fronts {
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
}

/// Whether as much goes one way as the other.
fn is_even(direction: &Direction) -> bool {
    let [plus, minus] = [direction.toward_plus_x, direction.toward_minus_x];
    (plus - minus).abs() < EVEN * (plus + minus)
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

    /// The shares that moved, and where: `24 ± 1 % up past 4.1 Hz`.
    pub fn in_frequency(&self, of: &Movement) -> [(f64, String); 2] {
        if of.transfer == Some(true) {
            return moves(of, |f| self.frequency(f));
        }
        let changed = |sign: &str, by: &Move| {
            let text = format!(
                "share above {}: {sign}{}",
                self.frequency(by.at),
                with_error(by)
            );
            (by.at, text)
        };
        [changed("+", &of.up), changed("−", &of.down)]
    }

    pub fn in_wavenumber(&self, of: &Movement) -> [(f64, String); 2] {
        moves(of, |k| self.wavenumber(k))
    }
}

#[cfg(feature = "figures")]
fn moves(of: &Movement, place: impl Fn(f64) -> String) -> [(f64, String); 2] {
    let up = format!("{} up past {}", with_error(&of.up), place(of.up.at));
    let down = format!("{} down below {}", with_error(&of.down), place(of.down.at));
    [(of.up.at, up), (of.down.at, down)]
}
