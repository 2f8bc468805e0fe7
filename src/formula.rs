//! Formulas of one variable, as they are typed, with exact derivatives.
//!
//! Numbers, the variable, constants, `pi`, `+ - * / ^`, brackets and functions, with the precedence of
//! Python: `-k^2` is `-(k^2)`, `2^3^2` is `2^9`. Faults name their place.

use std::collections::BTreeMap;
use std::f64::consts::{LN_10, PI};

use crate::error::{Error, Result};
use crate::numeric::Real;

/// Brackets, signs and right sides of operators within each other at most.
const DEPTH: usize = 200;

/// Places between the ends of a range at which breaks are looked for.
const PROBES: usize = 16;

/// A function: its name, its value at x, and its first two derivatives there, where it is f.
type Function = (&'static str, fn(f64) -> f64, fn(x: f64, f: f64) -> [f64; 2]);

static FUNCTIONS: [Function; 14] = [
    ("sqrt", f64::sqrt, |x, f| [0.5 / f, -0.25 / (f * x)]),
    ("abs", f64::abs, |x, _| [1f64.copysign(x), 0.0]),
    ("sin", f64::sin, |x, f| [x.cos(), -f]),
    ("cos", f64::cos, |x, f| [-x.sin(), -f]),
    ("tan", f64::tan, |_, f| {
        [1.0 + f * f, 2.0 * f * (1.0 + f * f)]
    }),
    ("asin", f64::asin, |x, _| of_arc_sine(x)),
    ("acos", f64::acos, |x, _| of_arc_sine(x).map(|slope| -slope)),
    ("atan", f64::atan, |x, _| {
        let square = 1.0 + x * x;
        [1.0 / square, -2.0 * x / (square * square)]
    }),
    ("sinh", f64::sinh, |x, f| [x.cosh(), f]),
    ("cosh", f64::cosh, |x, f| [x.sinh(), f]),
    ("tanh", f64::tanh, |_, f| {
        [1.0 - f * f, -2.0 * f * (1.0 - f * f)]
    }),
    ("exp", f64::exp, |_, f| [f, f]),
    ("ln", f64::ln, |x, _| of_logarithm(x)),
    ("log10", f64::log10, |x, _| {
        of_logarithm(x).map(|slope| slope / LN_10)
    }),
];

fn of_arc_sine(x: f64) -> [f64; 2] {
    let root = (1.0 - x * x).sqrt();
    [1.0 / root, x / root.powi(3)]
}

fn of_logarithm(x: f64) -> [f64; 2] {
    [1.0 / x, -1.0 / (x * x)]
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Operator {
    Plus,
    Minus,
    Times,
    Over,
    Power,
    Least,
    Most,
}

/// How operators are typed, and how strongly they bind between operands; 0 for those that are typed as functions.
static OPERATORS: [(&str, Operator, u8); 8] = [
    ("+", Operator::Plus, 1),
    ("-", Operator::Minus, 1),
    ("*", Operator::Times, 2),
    ("/", Operator::Over, 2),
    ("^", Operator::Power, 4),
    ("pow", Operator::Power, 0),
    ("min", Operator::Least, 0),
    ("max", Operator::Most, 0),
];

/// Between those of products and of powers: `-k^2` is `-(k^2)`.
const SIGN: u8 = 3;

impl Operator {
    fn of<N: Real>(self, a: N, b: N) -> N {
        match self {
            Operator::Plus => a + b,
            Operator::Minus => a - b,
            Operator::Times => a * b,
            Operator::Over => a / b,
            Operator::Power => {
                let (x, value) = (a.value(), a.value().powf(b.value()));
                let logarithm = a.through(x.ln(), || of_logarithm(x));
                (b * logarithm).through(value, || [value; 2])
            }
            Operator::Least | Operator::Most => match self.takes_second(a, b) {
                true => b,
                false => a,
            },
        }
    }

    /// Which argument the least or the most is.
    fn takes_second<N: Real>(self, a: N, b: N) -> bool {
        match self {
            Operator::Least => b.value() < a.value(),
            _ => b.value() > a.value(),
        }
    }
}

/// Constants of a formula by name.
pub type Constants = BTreeMap<String, f64>;

/// The name of the variable, and the option that faults name.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Words {
    pub(crate) variable: &'static str,
    pub(crate) option: &'static str,
}

/// A formula read.
#[derive(Debug, Clone)]
pub(crate) enum Node {
    Number(f64),
    Variable,
    /// A function by its place in the table.
    Function(usize, Box<Node>),
    Negative(Box<Node>),
    /// A constant power.
    Raised(Box<Node>, f64),
    Pair(Operator, Box<Node>, Box<Node>),
}

impl Node {
    /// The value, with derivatives where x has them.
    pub(crate) fn at<N: Real>(&self, x: N) -> N {
        self.with_sides(x, &mut |_| {})
    }

    /// The same; a function is told on which side of each kink of `abs`, `min` and `max` it is.
    fn with_sides<N: Real>(&self, x: N, side: &mut impl FnMut(bool)) -> N {
        match self {
            Node::Number(value) => N::constant(*value),
            Node::Variable => x,
            Node::Function(place, of) => {
                let ((name, value, slopes), inner) = (FUNCTIONS[*place], of.with_sides(x, side));
                if name == "abs" {
                    side(inner.value() < 0.0);
                }
                let value = value(inner.value());
                inner.through(value, || slopes(inner.value(), value))
            }
            Node::Negative(of) => -of.with_sides(x, side),
            Node::Raised(of, power) => of.with_sides(x, side).power(*power),
            Node::Pair(operator, a, b) => {
                let [a, b] = [a, b].map(|of| of.with_sides(x, side));
                if let Operator::Least | Operator::Most = operator {
                    side(operator.takes_second(a, b));
                }
                operator.of(a, b)
            }
        }
    }

    /// Where `abs`, `min` and `max` have kinks between two places, in the order from one to the other.
    pub(crate) fn breaks(&self, from: f64, to: f64) -> Vec<f64> {
        let sides = |x: f64| {
            let mut sides = 1u64;
            self.with_sides(x, &mut |side| sides = sides << 1 | u64::from(side));
            sides
        };
        let mut before = (from, sides(from));
        if before.1 == 1 {
            return Vec::new();
        }
        let mut breaks = Vec::new();
        for i in 1..=PROBES {
            let mut a = before;
            let mut b = from + (to - from) * i as f64 / PROBES as f64;
            before = (b, sides(b));
            while a.1 != before.1 {
                let middle = 0.5 * (a.0 + b);
                if middle == a.0 || middle == b {
                    breaks.push(b);
                    break;
                }
                match sides(middle) == a.1 {
                    true => a.0 = middle,
                    false => b = middle,
                }
            }
        }
        breaks
    }

    fn is_constant(&self) -> bool {
        match self {
            Node::Number(_) => true,
            Node::Variable => false,
            Node::Function(_, of) | Node::Negative(of) | Node::Raised(of, _) => of.is_constant(),
            Node::Pair(_, a, b) => a.is_constant() && b.is_constant(),
        }
    }

    fn pair(operator: Operator, a: Node, b: Node) -> Node {
        match operator == Operator::Power && b.is_constant() {
            true => Node::Raised(Box::new(a), b.at(0.0)),
            false => Node::Pair(operator, Box::new(a), Box::new(b)),
        }
    }
}

/// Reads `c=1, m=2.5`.
///
/// # Errors
/// [`Error::Request`] for a name that a formula knows otherwise, or a value that is no number.
pub(crate) fn parse_constants(text: &str, words: Words) -> Result<Constants> {
    let mut constants = Constants::new();
    let all = text.split(',').map(str::trim);
    for typed in all.filter(|typed| !typed.is_empty()) {
        let fault = |expected: &str| Error::request(words.option, expected, format!("`{typed}`"));
        let (name, value) = typed
            .split_once('=')
            .ok_or_else(|| fault("constants as NAME=NUMBER, separated by commas"))?;
        let (name, value) = (name.trim(), value.trim().parse::<f64>());
        if name == words.variable || !is_free(name) {
            let variable = words.variable;
            let expected = format!("the name of a constant, not {variable}, pi or a function's");
            return Err(fault(&expected));
        }
        match value {
            Ok(value) if value.is_finite() => constants.insert(name.into(), value),
            _ => return Err(fault("a finite number after =")),
        };
    }
    Ok(constants)
}

/// Whether a constant may have this name.
pub(crate) fn is_free(name: &str) -> bool {
    let is_word =
        name.starts_with(|c: char| c.is_alphabetic() || c == '_') && name.chars().all(is_of_name);
    let functions = FUNCTIONS.iter().map(|f| f.0);
    let mut known = functions.chain(OPERATORS.iter().map(|f| f.0));
    is_word && name != "pi" && !known.any(|known| known == name)
}

/// Reads a formula.
///
/// # Errors
/// [`Error::Request`] with the place of the fault and the known names.
pub(crate) fn parse(text: &str, constants: &Constants, words: Words) -> Result<Node> {
    let mut reader = Reader {
        text,
        at: 0,
        depth: 0,
        constants,
        words,
    };
    let root = reader.expression(0)?;
    match reader.peek() {
        None => Ok(root),
        Some(_) => Err(reader.fault("an operator (+ - * / ^) or the end")),
    }
}

fn is_of_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

struct Reader<'a> {
    text: &'a str,
    /// Byte that comes next.
    at: usize,
    depth: usize,
    constants: &'a Constants,
    words: Words,
}

impl Reader<'_> {
    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }

    fn take(&mut self, wanted: &str) -> bool {
        let found = self.peek().is_some() && self.text[self.at..].starts_with(wanted);
        self.at += if found { wanted.len() } else { 0 };
        found
    }

    /// What comes next is not `expected`.
    fn fault(&mut self, expected: &str) -> Error {
        let found = match self.peek() {
            None => "the end".into(),
            Some(c) if is_of_name(c) => format!("`{}`", self.word()),
            Some(c) => format!("`{c}`"),
        };
        self.fault_at(expected, &found, self.at)
    }

    fn fault_at(&self, expected: &str, found: &str, at: usize) -> Error {
        let place = self.text[..at].chars().count() + 1;
        let found = format!("{found} at character {place} of `{}`", self.text);
        Error::request(self.words.option, expected, found)
    }

    fn word(&self) -> &str {
        let rest = &self.text[self.at..];
        &rest[..rest.find(|c| !is_of_name(c)).unwrap_or(rest.len())]
    }

    /// An expression whose operators bind at least so strongly (precedence climbing).
    fn expression(&mut self, least: u8) -> Result<Node> {
        self.depth += 1;
        if self.depth > DEPTH {
            return Err(self.fault("a formula less deeply nested"));
        }
        let mut left = if self.take("-") {
            Node::Negative(Box::new(self.expression(SIGN)?))
        } else if self.take("+") {
            self.expression(SIGN)?
        } else {
            self.operand()?
        };
        let binds = |operator: &&(_, _, u8)| operator.2 >= least.max(1);
        let between = || OPERATORS.iter().filter(binds);
        while let Some((_, operator, strength)) = between().find(|it| self.take(it.0)) {
            // Powers are read from the right, and their exponents may have a sign.
            let of_right = match operator {
                Operator::Power => SIGN,
                _ => strength + 1,
            };
            left = Node::pair(*operator, left, self.expression(of_right)?);
        }
        self.depth -= 1;
        Ok(left)
    }

    fn operand(&mut self) -> Result<Node> {
        match self.peek() {
            Some('(') => {
                self.at += 1;
                let inner = self.expression(0)?;
                self.close(inner)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if is_of_name(c) => self.named(),
            _ => Err(self.fault("a number, a name or (")),
        }
    }

    fn close(&mut self, inner: Node) -> Result<Node> {
        match self.take(")") {
            true => Ok(inner),
            false => Err(self.fault("an operator (+ - * / ^) or )")),
        }
    }

    fn number(&mut self) -> Result<Node> {
        let rest = &self.text[self.at..];
        let mut before = ' ';
        let end = rest.find(|c: char| {
            let goes_on = is_of_name(c) || c == '.' || "+-".contains(c) && "eE".contains(before);
            before = c;
            !goes_on
        });
        let typed = &rest[..end.unwrap_or(rest.len())];
        let Ok(value) = typed.parse() else {
            let expected = "a number, with * between it and a name";
            return Err(self.fault_at(expected, &format!("`{typed}`"), self.at));
        };
        self.at += typed.len();
        Ok(Node::Number(value))
    }

    fn named(&mut self) -> Result<Node> {
        let name = self.word().to_owned();
        let start = self.at;
        self.at += name.len();
        if name == self.words.variable {
            return Ok(Node::Variable);
        }
        let constant = self.constants.get(&name).copied();
        if let Some(value) = constant.or_else(|| (name == "pi").then_some(PI)) {
            return Ok(Node::Number(value));
        }
        let function = FUNCTIONS.iter().position(|f| f.0 == name);
        let operator = OPERATORS.iter().find(|f| f.0 == name).map(|f| f.1);
        if function.is_none() && operator.is_none() {
            return Err(self.fault_at(&self.known_names(), &format!("`{name}`"), start));
        }
        if !self.take("(") {
            return Err(self.fault(&format!("( after {name}")));
        }
        let mut node = self.expression(0)?;
        if let Some(place) = function {
            node = Node::Function(place, Box::new(node));
        } else if let Some(operator) = operator {
            if !self.take(",") {
                return Err(self.fault(&format!("a second argument of {name} after a comma")));
            }
            node = Node::pair(operator, node, self.expression(0)?);
        }
        self.close(node)
    }

    fn known_names(&self) -> String {
        let constants: Vec<&str> = self.constants.keys().map(String::as_str).collect();
        let known = match &constants[..] {
            [] => String::new(),
            known => known.join(", ") + "; others are ",
        };
        let functions: Vec<&str> = FUNCTIONS.iter().map(|f| f.0).collect();
        format!(
            "{}, pi, a constant ({known}set by `; NAME=NUMBER` after the formula) or a function ({}, pow, min, max)",
            self.words.variable,
            functions.join(", ")
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Jet;

    const WORDS: Words = Words {
        variable: "k",
        option: "dispersion",
    };

    fn read(text: &str) -> Result<Node> {
        parse(
            text,
            &Constants::from([("c".into(), 4.0), ("a".into(), 0.5)]),
            WORDS,
        )
    }

    #[test]
    fn formulas_have_the_precedence_of_python() {
        // Formula, k, value.
        for row in "-k^2; 3; -9 | 2^3^2; 0; 512 | 2^-1; 0; 0.5 | 8/4/2; 0; 1 | 1 - 2 - 3; 0; -4 | --k + +1; 2; 3
            | 2*sqrt(c)*abs(sin(k/2)); 1; 1.917702154416812 | 1.5e-3 * 2E+3; 0; 3 | cos(pi); 0; -1 | ln(exp(2)); 0; 2
            | pow(k, 2) + min(1, 2) - max(a, c); 3; 6"
            .split('|')
        {
            let parts: Vec<&str> = row.split(';').collect();
            let [k, expected] = [1, 2].map(|i| parts[i].trim().parse::<f64>().unwrap());
            let off = read(parts[0]).unwrap().at(k) - expected;
            assert!(off.abs() < 1e-15, "{row}");
        }
        assert!(read("sqrt(k)").unwrap().at(-1.0).is_nan());
    }

    #[test]
    fn faults_name_their_place_and_what_is_known() {
        for (text, found, expected) in [
            ("2*sqrt(q/m)", "`q` at character 8 of `2*sqrt(q/m)`", "sqrt"),
            ("k+", "the end at character 3", "a number, a name or ("),
            ("", "the end at character 1", "a number"),
            ("(k", "the end at character 3", ")"),
            ("k)", "`)` at character 2", "the end"),
            ("2 k", "`k` at character 3", "an operator"),
            ("2k", "`2k` at character 1", "a number, with *"),
            ("sin k", "`k` at character 5", "( after sin"),
            ("pow(k)", "`)` at character 6", "a second argument"),
            ("k*\u{3c9}", "`\u{3c9}` at character 3", "k, pi, a cons"),
            ("1..2", "`1..2` at character 1", "a number"),
            ("k $ 2", "`$` at character 3", "an operator"),
        ] {
            let error = read(text).unwrap_err().to_string();
            let (e, f) = error.split_once(", found ").unwrap();
            assert!(
                f.starts_with(found) && e.contains(expected),
                "{text}: {error}"
            );
        }
        assert!(read(&"(".repeat(5000)).is_err());
        // Constants do not hide functions.
        assert!(["c1", "K", "_x"].into_iter().all(is_free));
        assert!(!["pi", "sin", "pow", "1c", ""].into_iter().any(is_free));
    }

    #[test]
    fn val_closed_form_kinks() {
        let node = read("min(k, 0.3) + abs(k + 1/7)*max(k^2, 4)").unwrap();
        let known = [0.3, -1.0 / 7.0, -2.0];
        let breaks = node.breaks(1.0, -3.0);
        let is_near = |(a, b): (&f64, f64)| (a / b - 1.0).abs() < 1e-15;
        assert!(breaks.len() == 3, "{breaks:?}");
        assert!(breaks.iter().zip(known).all(is_near), "{breaks:?}");
        assert!(node.breaks(0.0, 0.2).is_empty());
    }

    /// Five-point differences of every function and operator.
    #[test]
    fn val_calculus_jets_are_derivatives() {
        let functions = FUNCTIONS.map(|f| format!("{}(0.3 + 0.4*k^2)", f.0));
        let others = "k^3 - 2/k; pow(2 + k, k); -k*min(k, 2)*max(k, 0.1); (1 + k)^1.5";
        for text in functions
            .iter()
            .map(String::as_str)
            .chain(others.split("; "))
        {
            let node = read(text).unwrap();
            for k in [0.4, 0.9] {
                let at = |i: f64| node.at(Jet::variable(k + i * 1e-3));
                let Jet { value, slope, bend } = at(0.0);
                assert_eq!(value.to_bits(), node.at(k).to_bits(), "{text}");
                let near = [-2.0, -1.0, 1.0, 2.0].map(at);
                let check = |of: fn(Jet) -> f64, known: f64, most: f64| {
                    let [a, b, c, d] = near.map(of);
                    let found = (8.0 * (c - b) - (d - a)) / 12e-3;
                    assert!(
                        (found - known).abs() < most * known.abs().max(1.0),
                        "{text}"
                    );
                };
                check(|jet| jet.value, slope, 1e-9);
                check(|jet| jet.slope, bend, 1e-8);
            }
        }
    }
}
