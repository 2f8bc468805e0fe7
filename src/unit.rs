//! Labels of results: a quantity and its unit, composed of the units of samples and axes.

/// A label: `time (s)`, `power spectral density [(m/s)²/Hz]`, `share` for no unit.
///
/// A unit that has brackets of its own stands in square ones.
pub(crate) fn label(name: &str, unit: &str) -> String {
    match (unit.is_empty(), unit.contains('(')) {
        (true, _) => name.into(),
        (false, false) => format!("{name} ({unit})"),
        (false, true) => format!("{name} [{unit}]"),
    }
}

/// Name and unit of a [`label`]; the unit is empty where it has none.
pub(crate) fn split(label: &str) -> (&str, &str) {
    let parts = [(" (", ')'), (" [", ']')]
        .into_iter()
        .find_map(|(open, close)| label.strip_suffix(close)?.rsplit_once(open));
    parts.unwrap_or((label, ""))
}

/// A label of values that are shown divided by `10^exponent`: the power stands before the unit.
pub(crate) fn in_powers_of_ten(label_of_values: &str, exponent: i32) -> String {
    if exponent == 0 {
        return label_of_values.into();
    }
    let (name, unit) = split(label_of_values);
    label(name, &times(&power_of_ten(exponent), unit))
}

/// A label of powers in decibels relative to a value: `power spectral density [dB re 5.0·10⁻¹
/// (m/s)²/Hz]`.
#[cfg(feature = "figures")]
pub(crate) fn in_decibels(label_of_powers: &str, reference: f64) -> String {
    let (name, unit) = split(label_of_powers);
    let reference = times(&scientific(reference, 1), unit);
    label(name, &format!("dB re {reference}"))
}

/// A product of units over a product of units: `(m/s)² s/Hz`, `(m/s)²/(Hz · rad/m)`, `1/Hz`.
///
/// Empty factors are units of quantities without one and count as 1; empty for no unit at all.
pub(crate) fn compose(over: &[&str], under: &[&str]) -> String {
    let factors = |units: &[&str]| -> Vec<String> {
        let units = units.iter().filter(|unit| !unit.is_empty());
        units.map(|unit| raised(unit)).collect()
    };
    let (over, under) = (factors(over), factors(under));
    // A quotient is a factor of its own: `(m/s) s`, but `m/s` where it stands alone.
    let alone = over.len() + under.len() == 1;
    let over: Vec<String> = match alone {
        true => over,
        false => over.iter().map(|unit| bracketed(unit)).collect(),
    };
    let over = over.join(" ");
    let under = match &under[..] {
        [] => return over,
        [unit] => bracketed(unit),
        units => format!("({})", units.join(" · ")),
    };
    match over.is_empty() {
        true => format!("1/{under}"),
        false => format!("{over}/{under}"),
    }
}

/// Symbols of units that take a metric prefix, and others that do not.
const PREFIXED: &str = "m g s A K mol cd Hz N Pa J W C V F \u{3a9} \u{2126} ohm S Wb T H lm lx Bq Gy Sv kat rad sr eV \
    bar L cal gal dyn erg sec var VA \u{3b5} \u{3f5} bit strain Nm Ns Pas Vs gn";
const PLAIN: &str = "in ft yd mi mil thou min hr h yr deg lb lbf lbs kip oz psi ksi kn kt kts kmh kph mps mph fps fpm \
    rpm dB Np px ppm ppb au ct cts lsb adu arb ue re pk pp rms kgf gf amu torr mmhg atm inhg ips \u{e5}ngstr\u{f6}m \
    sqrt log ln log10 abs feet inches nd dl na degC degF";
/// Names of units, in the singular, which take a prefix in full (`microstrain`).
const NAMES: &str = "meter metre second gram gramme newton pascal joule watt volt ampere amp ohm hertz radian degree kelvin \
    celsius fahrenheit strain litre liter tonne ton inch foot yard mile minute hour day week month year count digit bit \
    byte pixel sample cycle period phase unit step site cell frame line fringe tesla gauss weber henry farad coulomb \
    siemens mole candela lumen lux electronvolt dyne erg knot percent permil decibel neper turn rev revolution wavelength \
    angstrom bohr hartree rydberg particle atom body bead grain diameter radius mass length time velocity speed \
    acceleration displacement force stress energy channel trace shot point tick bin clock index gravity gee arbitrary dimensionless \
    nondimensional unitless none norm normalized normalised unknown scaled relative ratio fraction rate square squared \
    cubic per of peak full scale";
const PREFIXES: &str = "y z a f p n u \u{b5} \u{3bc} m c d da h k M G T P E Z Y";
const LONG_PREFIXES: &str = "femto pico nano micro milli centi deci deca hecto kilo mega giga tera";

/// The first word of a unit that is no unit, as `bananas/s` has one. A letter with or without an index (`a`, `v0`) is a
/// symbol of the problem. Case tells nothing here: devices write `KHZ` and `volts`.
pub(crate) fn unknown_word(unit: &str) -> Option<&str> {
    let words = unit.split(|c: char| !c.is_alphanumeric());
    words
        .map(|word| word.trim_matches(char::is_numeric))
        .find(|word| word.chars().count() > 1 && !is_known(&word.to_lowercase()))
}

/// Whether a word in lower case is a unit.
fn is_known(word: &str) -> bool {
    let is_in =
        |list: &str, word: &str| list.split_whitespace().any(|it| it.to_lowercase() == word);
    let with = |prefixes: &str, list: &str, word: &str| {
        let mut rests = prefixes.split_whitespace();
        let is_rest = |prefix: &str| {
            let rest = word.strip_prefix(&prefix.to_lowercase());
            rest.is_some_and(|rest| is_in(list, rest))
        };
        is_in(list, word) || rests.any(is_rest)
    };
    let singular = word.strip_suffix('s').unwrap_or(word);
    is_in(PLAIN, word)
        || with(PREFIXES, PREFIXED, word)
        || [word, singular]
            .iter()
            .any(|word| with(LONG_PREFIXES, NAMES, word))
}

/// The square of a unit: `(m/s)²`; empty for none.
pub(crate) fn square(unit: &str) -> String {
    match unit {
        "" => String::new(),
        // What has a superscript or a root is a factor, but no base.
        _ if unit
            .chars()
            .all(|c| c.is_alphabetic() || c.is_ascii_digit()) =>
        {
            format!("{unit}²")
        }
        _ => format!("({})²", raised(unit)),
    }
}

/// `10⁻²¹ (m/s)²/Hz`, `10³/Hz`.
pub(crate) fn times(factor: &str, unit: &str) -> String {
    match unit.strip_prefix("1/") {
        Some(under) => format!("{factor}/{under}"),
        None if unit.is_empty() => factor.into(),
        None => format!("{factor} {unit}"),
    }
}

/// `10` with a raised exponent.
pub(crate) fn power_of_ten(exponent: i32) -> String {
    format!("10{}", superscript(&exponent.to_string()))
}

/// A positive value with so many digits after the first: `3.2·10⁻⁸`.
pub(crate) fn scientific(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$e}");
    match text.split_once('e') {
        Some((digits, exponent)) => format!("{digits}·10{}", superscript(exponent)),
        None => text,
    }
}

fn superscript(digits: &str) -> String {
    const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raise = |c: char| c.to_digit(10).map_or('⁻', |digit| RAISED[digit as usize]);
    digits.chars().map(raise).collect()
}

/// A unit with the exponents that were typed `^2` or `^-1` raised.
fn raised(unit: &str) -> String {
    let mut parts = unit.split('^');
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let sign = usize::from(part.starts_with('-'));
        let digits = part[sign..].bytes().take_while(u8::is_ascii_digit).count();
        let (exponent, rest) = part.split_at(sign + digits);
        match digits {
            0 => out.extend(["^", exponent]),
            _ => out.push_str(&superscript(exponent)),
        }
        out.push_str(rest);
    }
    out
}

/// A unit as a factor of a product: a quotient or a product in brackets.
fn bracketed(unit: &str) -> String {
    let mut depth = 0;
    let is_composed = unit.chars().any(|c| {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            _ => {}
        }
        depth == 0 && matches!(c, '/' | ' ' | '*' | '·')
    });
    match is_composed {
        true => format!("({unit})"),
        false => unit.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_definition_words_that_are_no_unit() {
        let known = "m/s;(m/s);\u{b5}\u{3b5}/s;\u{3bc}m/s;counts;V;a.u.;mm/s^2;s**-1;m.s^-1;M/S;KHz;nm/s;v0;c_1;\
            sqrt(m/c);a;%;1;-;\u{b0};mV/(m/s);volts;microstrain;nstrain/s;strain/s/Hz;rad;Angstrom/ps;\u{c5}/fs;g;gn;\
            cm\u{b2};m^-1;in/s;counts/s;rad/s*m;Nm;;m s-2;m s**-1;dB re 1 m/s;arb. units;kg m^-1;meters per second";
        for unit in known.split(';') {
            assert_eq!(unknown_word(unit), None, "{unit}");
        }
        let units = ["banana", "bananas/s", "mm/second/furlong", "meter/sceond"];
        let words = ["banana", "bananas", "furlong", "sceond"].map(Some);
        assert_eq!(units.map(unknown_word), words);
    }

    /// Factors and divisors between commas.
    #[test]
    fn units_are_composed_as_the_field_writes_them() {
        for row in "(m/s)², | Hz, | (m/s)²/Hz
            (m/s)²,s | Hz, | (m/s)² s/Hz
            (m/s)², | rad/m, | (m/s)²/(rad/m)
            (m/s)²,m | rad/m, | (m/s)² m/(rad/m)
            (m/s)², | Hz,rad/m | (m/s)²/(Hz · rad/m)
            (m/s)²,s,m | Hz,rad/m | (m/s)² s m/(Hz · rad/m)
            (m/s)²,min | cycles/min, | (m/s)² min/(cycles/min)
            ,s | Hz, | s/Hz
            , | Hz, | 1/Hz
            , | ,rad/m | 1/(rad/m)
            ,, | , |
            J, | s, | J/s
            m/s^2, | , | m/s²
            m/s^2,s | , | (m/s²) s
            kg m^-1,s | , | (kg m⁻¹) s
            sqrt(m/c),a | , | sqrt(m/c) a"
            .lines()
        {
            let parts: Vec<&str> = row.split('|').map(str::trim).collect();
            let [over, under] = [parts[0], parts[1]].map(|of| of.split(',').collect::<Vec<_>>());
            assert_eq!(compose(&over, &under), parts[2], "{row}");
        }
        let squares = ["m/s", "v0", "N", "m/s^2", "1/s", "sqrt(m/c)", "m^2", ""].map(square);
        let expected = "(m/s)² v0² N² (m/s²)² (1/s)² (sqrt(m/c))² (m²)² ";
        assert_eq!(squares.join(" "), expected);
        assert_eq!(raised("m^a/s^-^2"), "m^a/s^-²");
    }

    #[test]
    fn labels_hold_their_unit_in_brackets_that_do_not_nest() {
        for (name, unit, whole) in [
            ("time", "s", "time (s)"),
            ("share", "", "share"),
            ("density", "(m/s)²/Hz", "density [(m/s)²/Hz]"),
            ("k a  (a: spacing)", "rad", "k a  (a: spacing) (rad)"),
        ] {
            assert_eq!(label(name, unit), whole);
            assert_eq!(split(whole), (name, unit));
        }
        assert_eq!(split("f(x)"), ("f(x)", ""));
    }

    #[test]
    fn powers_stand_before_the_unit() {
        for (of, exponent, whole) in [
            ("frequency (Hz)", 3, "frequency (10³ Hz)"),
            ("density [(m/s)²/Hz]", -21, "density [10⁻²¹ (m/s)²/Hz]"),
            ("density (1/Hz)", -3, "density (10⁻³/Hz)"),
            ("site", 3, "site (10³)"),
            ("site", 0, "site"),
        ] {
            assert_eq!(in_powers_of_ten(of, exponent), whole);
        }
        assert_eq!(scientific(3.16e-8, 1), "3.2·10⁻⁸");
        #[cfg(feature = "figures")]
        for (of, whole) in [
            ("density [(m/s)²/Hz]", "density [dB re 5.0·10⁻¹ (m/s)²/Hz]"),
            ("density (1/Hz)", "density (dB re 5.0·10⁻¹/Hz)"),
            ("energy", "energy (dB re 5.0·10⁻¹)"),
        ] {
            assert_eq!(in_decibels(of, 0.5), whole);
        }
    }
}
