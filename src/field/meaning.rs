//! What the names in files mean: clocks, steps, rates, units, scales. Each meaning is an arm of one table.

use std::collections::HashSet;

use super::Quantity;
use super::labelled::last_name;
use crate::measure::{Length, Time, symbol};

/// What a name stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Meaning {
    /// Times of the samples.
    Time,
    /// A dimension of times, which may count them.
    TimeDimension,
    /// Positions of the sites.
    Position,
    /// A dimension of sites, which may count them.
    SiteDimension,
    /// A number that may be the position of a record.
    RecordPosition,
    /// The field among several arrays.
    Field,
    Step,
    Rate,
    Distance,
    TimeOrigin,
    SpaceOrigin,
    Unit,
    TimeUnit,
    SpaceUnit,
    Scale,
    Offset,
    /// Both limits of stored numbers that are samples, the least, the largest; numbers that are gaps.
    ValidRange,
    ValidMin,
    ValidMax,
    Fill,
    /// A column that counts rows.
    Counter,
}

use Meaning::*;

impl Meaning {
    /// Its names, in small letters and digits alone.
    fn names(self) -> &'static str {
        match self {
            Meaning::Time => {
                "time t timestamp timestamps datetime date dateandtime utc epoch epochtime unixtime zeit zeitstempel \
                 datum uhrzeit temps tiempo tempo seconds second secs sec milliseconds millisecond msec ms microseconds \
                 microsecond usec us nanoseconds nanosecond nsec ns"
            }
            TimeDimension => "times sample samples frame step",
            Position => "position x distance",
            SiteDimension => {
                "y z r offset depth site sites space channel channels trace traces station stations receiver location \
                 atom node point record records"
            }
            RecordPosition => {
                "x y z r position distance offset depth elevation location groupx groupy sourcex sourcey x0"
            }
            Field => "velocity v vel vx",
            Step => {
                "dt timestep deltat delta sampleinterval samplinginterval sampleperiod samplingperiod samplingstep \
                 sampletime samplingtime samplespacing timeinterval timespacing timesampling deltatime tsamp"
            }
            Rate => {
                "fs rate samplingrate samplerate samplingfrequency samplefrequency samplingfreq samplefreq fsample \
                 fsampling outputdatarate datarate acquisitionrate acquisitionfrequency framerate fps sps \
                 samplespersecond scanrate samprate fsamp abtastrate abtastfrequenz"
            }
            Distance => {
                "dx spacing deltax channelspacing sitespacing sensorspacing tracespacing receiverspacing \
                 spatialsamplinginterval spatialsampling spatialinterval"
            }
            TimeOrigin => "t0",
            SpaceOrigin => "x0",
            Unit => "unit units",
            TimeUnit => "timeunit timeunits",
            SpaceUnit => "spaceunit spaceunits",
            Scale => "scalefactor scalefactors scale scales scaling slope slopes",
            Offset => "addoffset addoffsets offset offsets intercept intercepts",
            ValidRange => "validrange",
            ValidMin => "validmin validminimum",
            ValidMax => "validmax validmaximum",
            Fill => "fillvalue missingvalue",
            Counter => {
                "n i no nr num number index idx row line sample samples point points count counter sequence record \
                 unnamed frame"
            }
        }
    }

    /// Names that only settings of instruments have.
    fn of_settings(self) -> &'static str {
        match self {
            Step => "horizontalinterval xinc xincrement increment tinc hresolution",
            TimeOrigin => "xorg xorigin start hoffset",
            Unit => "verticalunits verticalunit yunits yunit vunit",
            TimeUnit => "horizontalunits horizontalunit xunits xunit hunit",
            _ => "",
        }
    }
}

/// What the name of a number looks like that is none of the table: of samples, of times, of positions.
pub(super) const LIKE: [&[&str]; 3] = [
    &["gain", "calib", "sensitiv", "conversion"],
    &["rate", "interval", "freq", "sampling", "timestep"],
    &["spacing", "spatial"],
];

/// Whether a list of this name scales samples, or looks as if it did.
pub(super) fn may_scale(name: &str) -> bool {
    let is_known = |meaning| known_as(name, meaning).is_some();
    is_known(Scale) || is_known(Offset) || LIKE[0].iter().any(|like| key(name).contains(like))
}

/// A name in small letters and digits alone.
pub(super) fn key(name: &str) -> String {
    let letters = name.chars().filter(|c| c.is_alphanumeric());
    letters.flat_map(char::to_lowercase).collect()
}

/// What stands in round or square brackets.
pub(super) fn enclosed(text: &str) -> Option<&str> {
    let text = text.trim();
    let within = |open, close| text.strip_prefix(open)?.strip_suffix(close);
    within('(', ')').or(within('[', ']'))
}

/// A name and its unit: `time_s`, `t/ms`, `Time (s)`, `fs [kHz]`.
pub(super) fn with_unit(name: &str) -> (&str, Option<&str>) {
    let name = name.trim();
    if let Some(at) = name.rfind(['(', '['])
        && let Some(unit) = enclosed(&name[at..])
    {
        return (
            name[..at].trim(),
            Some(unit.trim()).filter(|unit| !unit.is_empty()),
        );
    }
    let split = name.rfind(['_', '/', ' ']).filter(|at| *at > 0);
    let split = split.map(|at| (&name[..at], &name[at + 1..]));
    let is_unit = |unit: &str| {
        symbol::<Time>(unit).is_some() || symbol::<Length>(unit).is_some() || hertz(unit).is_some()
    };
    match split.filter(|(_, unit)| is_unit(unit)) {
        Some((base, unit)) => (base, Some(unit)),
        None => (name, None),
    }
}

/// Whether a name has a meaning, and the unit in it.
pub(super) fn known_as(name: &str, meaning: Meaning) -> Option<Option<String>> {
    means(name, meaning, false)
}

pub(super) fn means(name: &str, meaning: Meaning, is_setting: bool) -> Option<Option<String>> {
    let is_one = |name: &str| {
        let key = key(name);
        // Beside each channel its clock: `Time 1`, `CH1`, `Time 2`, `CH2`.
        let unnumbered = key.trim_end_matches(|c: char| c.is_ascii_digit());
        let is_clock = meaning == Meaning::Time && unnumbered.len() > 3;
        let settings = meaning.of_settings().split(' ').filter(|_| is_setting);
        let mut names = meaning.names().split(' ').chain(settings);
        !key.is_empty() && names.any(|name| name == key || is_clock && name == unnumbered)
    };
    let is_bare = !name.contains(['(', '[', '/']);
    if is_bare && is_one(name) {
        // A clock may be named by its unit alone.
        let is_clock = meaning == Meaning::Time && name.trim().len() > 1;
        let unit = symbol::<Time>(&key(name)).filter(|_| is_clock);
        return Some(unit.map(str::to_owned));
    }
    let (base, unit) = with_unit(name);
    (base != name && is_one(base)).then(|| unit.map(str::to_owned))
}

/// Whether a name is that of coordinates for one of `others` alone: `t_CH1`, `CH1 time (s)` beside `CH1`.
pub(super) fn is_of_column(name: &str, meaning: Meaning, others: &HashSet<&str>) -> bool {
    let (name, _) = with_unit(name);
    let is_between = |c: char| !c.is_alphanumeric();
    // A unit behind a name is one of samples.
    let is_one = |clock: &str, other: &str| {
        !other.is_empty() && others.contains(other) && known_as(clock, meaning) == Some(None)
    };
    let mut cuts = name.match_indices(is_between);
    cuts.any(|(at, between)| {
        let parts = [&name[..at], &name[at + between.len()..]];
        let [first, second] = parts.map(|part| part.trim_matches(is_between));
        is_one(first, second) || is_one(second, first)
    })
}

/// Whether what is called so is added to samples even where nothing scales them: an offset alone is a distance.
pub(super) fn is_added(name: &str) -> bool {
    !key(name).starts_with("offset")
}

/// Whether a column of this name counts the rows of a table.
pub(super) fn counts_rows(name: &str) -> bool {
    let words = name.split(|c: char| !c.is_alphanumeric());
    let mut words = words.filter(|word| !matches!(*word, "" | "0"));
    words.all(|word| known_as(word, Counter).is_some())
}

/// Hertz of a unit of rates: of `kHz`, `MSa/s`, `samples/s`.
pub(super) fn hertz(unit: &str) -> Option<f64> {
    const HERTZ: &str = "hz hertz samples/sec samples/s sa/s s/s sps 1/s s-1";
    if unit.trim() == "mHz" {
        return Some(1e-3);
    }
    let lower = unit.trim().to_lowercase();
    let prefix = HERTZ.split(' ').find_map(|name| lower.strip_suffix(name))?;
    match prefix.trim() {
        "" => Some(1.0),
        "k" | "kilo" => Some(1e3),
        "m" | "mega" => Some(1e6),
        "g" | "giga" => Some(1e9),
        _ => None,
    }
}

/// The quantity that a name, or else a unit, stands for.
pub(super) fn quantity(
    path: &str,
    standard_name: Option<&str>,
    unit: Option<&str>,
) -> Option<Quantity> {
    let last = last_name(path).to_ascii_lowercase();
    let names = [Some(last.as_str()), standard_name];
    let by_name = Quantity::ALL.into_iter().find(|quantity| {
        let (name, joined) = (quantity.name(), quantity.name().replace('_', ""));
        let mut names = names.into_iter().flatten();
        names.any(|one| one == name || one == joined)
    });
    by_name.or_else(|| of_unit(unit?))
}

/// The quantity that is measured in `unit`.
pub(super) fn of_unit(unit: &str) -> Option<Quantity> {
    let is_letter = |c: &char| !c.is_whitespace() && !"*^.".contains(*c);
    let spelled: String = unit.chars().filter(is_letter).collect();
    let bare = |units: &[&str]| {
        let prefixes = ["", "m", "u", "\u{b5}", "\u{3bc}", "n", "c", "k"];
        let is_prefixed = |unit: &&str| {
            let rest = spelled.strip_suffix(*unit);
            rest.is_some_and(|prefix| prefixes.contains(&prefix))
        };
        units.iter().any(is_prefixed)
    };
    match () {
        _ if bare(&["m/s", "ms-1", "m/sec"]) => Some(Quantity::Velocity),
        _ if bare(&["m/s2", "ms-2", "m/s\u{b2}"]) || spelled == "g" => Some(Quantity::Acceleration),
        _ if bare(&["m", "meter", "metre"]) => Some(Quantity::Displacement),
        _ if bare(&["strain/s", "1/s", "s-1", "/s"]) => Some(Quantity::StrainRate),
        _ if bare(&["N"]) => Some(Quantity::Force),
        _ => None,
    }
}
