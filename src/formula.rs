//! Formulas of one variable, as they are typed, with exact derivatives.
//!
//! Numbers, the variable, constants, `pi`, `+ - * / ^`, brackets and functions, with the precedence of
//! Python: `-k^2` is `-(k^2)`, `2^3^2` is `2^9`. Faults name their place.

use std::collections::BTreeMap;
use std::f64::consts::{LN_10, PI};

use crate::error::{Error, Result};

/// Brackets, signs and powers within each other at most.
const DEPTH: usize = 100;

/// A value, and its first and second derivative along the variable.
pub(crate) type Jet = [f64; 3];

/// A function by its name: its value at x, and its first two derivatives there, where it is f.
struct Function {
    name: &'static str,
    value: fn(f64) -> f64,
    slopes: fn(x: f64, f: f64) -> [f64; 2],
}

const fn function(
    name: &'static str,
    value: fn(f64) -> f64,
    slopes: fn(f64, f64) -> [f64; 2],
) -> Function {
    Function {
        name,
        value,
        slopes,
    }
}

static FUNCTIONS: [Function; 14] = [
    function("sqrt", f64::sqrt, |x, f| [0.5 / f, -0.25 / (f * x)]),
    function("abs", f64::abs, |x, _| {
        [if x < 0.0 { -1.0 } else { 1.0 }, 0.0]
    }),
    function("sin", f64::sin, |x, f| [x.cos(), -f]),
    function("cos", f64::cos, |x, f| [-x.sin(), -f]),
    function("tan", f64::tan, |_, f| {
        [1.0 + f * f, 2.0 * f * (1.0 + f * f)]
    }),
    function("asin", f64::asin, |x, _| {
        let root = (1.0 - x * x).sqrt();
        [1.0 / root, x / root.powi(3)]
    }),
    function("acos", f64::acos, |x, _| {
        let root = (1.0 - x * x).sqrt();
        [-1.0 / root, -x / root.powi(3)]
    }),
    function("atan", f64::atan, |x, _| {
        let square = 1.0 + x * x;
        [1.0 / square, -2.0 * x / (square * square)]
    }),
    function("sinh", f64::sinh, |x, f| [x.cosh(), f]),
    function("cosh", f64::cosh, |x, f| [x.sinh(), f]),
    function("tanh", f64::tanh, |_, f| {
        [1.0 - f * f, -2.0 * f * (1.0 - f * f)]
    }),
    function("exp", f64::exp, |_, f| [f, f]),
    function("ln", f64::ln, |x, _| [1.0 / x, -1.0 / (x * x)]),
    function("log10", f64::log10, |x, _| {
        [1.0 / (LN_10 * x), -1.0 / (LN_10 * x * x)]
    }),
];

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

/// Operators that are typed as functions.
const NAMED: [(&str, Operator); 3] = [
    ("pow", Operator::Power),
    ("min", Operator::Least),
    ("max", Operator::Most),
];

impl Operator {
    fn value(self, a: f64, b: f64) -> f64 {
        match self {
            Operator::Plus => a + b,
            Operator::Minus => a - b,
            Operator::Times => a * b,
            Operator::Over => a / b,
            Operator::Power => a.powf(b),
            Operator::Least => a.min(b),
            Operator::Most => a.max(b),
        }
    }

    fn jet(self, a: Jet, b: Jet) -> Jet {
        let each = |f: fn(f64, f64) -> f64| [f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2])];
        match self {
            Operator::Plus => each(|a, b| a + b),
            Operator::Minus => each(|a, b| a - b),
            Operator::Times => [
                a[0] * b[0],
                a[1] * b[0] + a[0] * b[1],
                a[2] * b[0] + 2.0 * a[1] * b[1] + a[0] * b[2],
            ],
            Operator::Over => {
                let f = a[0] / b[0];
                let slope = (a[1] - f * b[1]) / b[0];
                [f, slope, (a[2] - 2.0 * slope * b[1] - f * b[2]) / b[0]]
            }
            Operator::Power => power(a, b),
            Operator::Least if b[0] < a[0] => b,
            Operator::Most if b[0] > a[0] => b,
            Operator::Least | Operator::Most => a,
        }
    }
}

/// `a^b`; where b is constant, powers of 0 have the derivatives that they have as limits.
fn power(a: Jet, b: Jet) -> Jet {
    let value = a[0].powf(b[0]);
    if b[1] == 0.0 && b[2] == 0.0 {
        let p = b[0];
        let times = |factor: f64, q: f64| match factor == 0.0 {
            true => 0.0,
            false => factor * a[0].powf(q),
        };
        let (first, second) = (times(p, p - 1.0), times(p * (p - 1.0), p - 2.0));
        // An infinite curvature times a slope of 0 is none.
        let bent = if a[1] == 0.0 {
            0.0
        } else {
            second * a[1] * a[1]
        };
        return [value, first * a[1], bent + first * a[2]];
    }
    let (ln, rate) = (a[0].ln(), a[1] / a[0]);
    let slope = b[1] * ln + b[0] * rate;
    let bend = b[2] * ln + 2.0 * b[1] * rate + b[0] * (a[2] / a[0] - rate * rate);
    [value, value * slope, value * (slope * slope + bend)]
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
    Pair(Operator, Box<Node>, Box<Node>),
}

impl Node {
    pub(crate) fn at(&self, x: f64) -> f64 {
        match self {
            Node::Number(value) => *value,
            Node::Variable => x,
            Node::Function(place, of) => (FUNCTIONS[*place].value)(of.at(x)),
            Node::Negative(of) => -of.at(x),
            Node::Pair(operator, a, b) => operator.value(a.at(x), b.at(x)),
        }
    }

    /// The value with its derivatives.
    pub(crate) fn jet_at(&self, x: f64) -> Jet {
        match self {
            Node::Number(value) => [*value, 0.0, 0.0],
            Node::Variable => [x, 1.0, 0.0],
            Node::Function(place, of) => {
                let [inner, slope, bend] = of.jet_at(x);
                let function = &FUNCTIONS[*place];
                let value = (function.value)(inner);
                let [first, second] = (function.slopes)(inner, value);
                [value, first * slope, second * slope * slope + first * bend]
            }
            Node::Negative(of) => of.jet_at(x).map(|part| -part),
            Node::Pair(operator, a, b) => operator.jet(a.jet_at(x), b.jet_at(x)),
        }
    }
}

/// Reads `c=1, m=2.5`.
///
/// # Errors
/// [`Error::Request`] for a name that a formula knows otherwise, or a value that is no number.
pub(crate) fn parse_constants(text: &str, words: Words) -> Result<Constants> {
    let mut constants = Constants::new();
    for typed in text
        .split(',')
        .map(str::trim)
        .filter(|typed| !typed.is_empty())
    {
        let fault = |expected: &str| Error::Request {
            option: words.option,
            expected: expected.into(),
            found: format!("`{typed}`"),
        };
        let (name, value) = typed
            .split_once('=')
            .ok_or_else(|| fault("constants as NAME=NUMBER, separated by commas"))?;
        let (name, value) = (name.trim(), value.trim().parse::<f64>());
        if name == words.variable || !is_free(name) {
            let expected = format!(
                "the name of a constant, not {}, pi or a function's",
                words.variable
            );
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
    let functions = FUNCTIONS.iter().map(|f| f.name);
    let named = NAMED.iter().map(|f| f.0);
    is_word && name != "pi" && !functions.chain(named).any(|known| known == name)
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
    let root = reader.sum()?;
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

    fn take(&mut self, wanted: char) -> bool {
        let found = self.peek() == Some(wanted);
        if found {
            self.at += wanted.len_utf8();
        }
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
        Error::Request {
            option: self.words.option,
            expected: expected.into(),
            found: format!("{found} at character {place} of `{}`", self.text),
        }
    }

    fn word(&self) -> &str {
        let rest = &self.text[self.at..];
        &rest[..rest.find(|c| !is_of_name(c)).unwrap_or(rest.len())]
    }

    fn sum(&mut self) -> Result<Node> {
        let mut left = self.product()?;
        loop {
            let operator = match self.peek() {
                Some('+') => Operator::Plus,
                Some('-') => Operator::Minus,
                _ => return Ok(left),
            };
            self.at += 1;
            left = Node::Pair(operator, Box::new(left), Box::new(self.product()?));
        }
    }

    fn product(&mut self) -> Result<Node> {
        let mut left = self.signed()?;
        loop {
            let operator = match self.peek() {
                Some('*') => Operator::Times,
                Some('/') => Operator::Over,
                _ => return Ok(left),
            };
            self.at += 1;
            left = Node::Pair(operator, Box::new(left), Box::new(self.signed()?));
        }
    }

    fn signed(&mut self) -> Result<Node> {
        self.depth += 1;
        if self.depth > DEPTH {
            return Err(self.fault("a formula less deeply nested"));
        }
        let node = if self.take('-') {
            Node::Negative(Box::new(self.signed()?))
        } else if self.take('+') {
            self.signed()?
        } else {
            self.power()?
        };
        self.depth -= 1;
        Ok(node)
    }

    fn power(&mut self) -> Result<Node> {
        let base = self.operand()?;
        match self.take('^') {
            true => Ok(Node::Pair(
                Operator::Power,
                Box::new(base),
                Box::new(self.signed()?),
            )),
            false => Ok(base),
        }
    }

    fn operand(&mut self) -> Result<Node> {
        match self.peek() {
            Some('(') => {
                self.at += 1;
                let inner = self.sum()?;
                self.close(inner)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if is_of_name(c) => self.named(),
            _ => Err(self.fault("a number, a name or (")),
        }
    }

    fn close(&mut self, inner: Node) -> Result<Node> {
        match self.take(')') {
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
        match typed.parse() {
            Ok(value) => {
                self.at += typed.len();
                Ok(Node::Number(value))
            }
            Err(_) => Err(self.fault_at(
                "a number, with * between it and a name",
                &format!("`{typed}`"),
                self.at,
            )),
        }
    }

    fn named(&mut self) -> Result<Node> {
        let name = self.word().to_owned();
        let start = self.at;
        self.at += name.len();
        let known = match &name[..] {
            _ if name == self.words.variable => Some(Node::Variable),
            "pi" => Some(Node::Number(PI)),
            _ => self.constants.get(&name).copied().map(Node::Number),
        };
        if let Some(node) = known {
            return Ok(node);
        }
        let function = FUNCTIONS.iter().position(|f| f.name == name);
        let operator = NAMED.iter().find(|f| f.0 == name).map(|f| f.1);
        if function.is_none() && operator.is_none() {
            return Err(self.fault_at(&self.known_names(), &format!("`{name}`"), start));
        }
        if !self.take('(') {
            return Err(self.fault(&format!("( after {name}")));
        }
        let first = self.sum()?;
        let node = match (function, operator) {
            (Some(place), _) => Node::Function(place, Box::new(first)),
            (None, Some(operator)) => {
                if !self.take(',') {
                    return Err(self.fault(&format!("a second argument of {name} after a comma")));
                }
                Node::Pair(operator, Box::new(first), Box::new(self.sum()?))
            }
            (None, None) => first,
        };
        self.close(node)
    }

    fn known_names(&self) -> String {
        let constants: Vec<&str> = self.constants.keys().map(String::as_str).collect();
        let constants = match constants.is_empty() {
            true => "a constant (set by `; NAME=NUMBER` after the formula)".to_owned(),
            false => format!(
                "a constant ({}; others are set by `; NAME=NUMBER` after the formula)",
                constants.join(", ")
            ),
        };
        let functions: Vec<&str> = FUNCTIONS.iter().map(|f| f.name).collect();
        format!(
            "{}, pi, {constants} or a function ({}, pow, min, max)",
            self.words.variable,
            functions.join(", ")
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WORDS: Words = Words {
        variable: "k",
        option: "dispersion",
    };

    fn value(text: &str, k: f64) -> f64 {
        let constants = Constants::from([("c".into(), 4.0), ("a".into(), 0.5)]);
        parse(text, &constants, WORDS).unwrap().at(k)
    }

    #[test]
    fn formulas_have_the_precedence_of_python() {
        for (text, k, expected) in [
            ("-k^2", 3.0, -9.0),
            ("2^3^2", 0.0, 512.0),
            ("2^-1", 0.0, 0.5),
            ("8/4/2", 0.0, 1.0),
            ("1 - 2 - 3", 0.0, -4.0),
            ("2*sqrt(c)*abs(sin(k/2))", 1.0, 4.0 * 0.5f64.sin()),
            ("1.5e-3 * 2E+3", 0.0, 3.0),
            ("pow(k, 2) + min(1, 2) - max(a, c)", 3.0, 6.0),
            ("--k + +1", 2.0, 3.0),
            ("cos(pi)", 0.0, -1.0),
            ("ln(exp(2))", 0.0, 2.0),
        ] {
            assert!((value(text, k) - expected).abs() < 1e-15, "{text}");
        }
        assert!(value("sqrt(k)", -1.0).is_nan());
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
            (
                "k*\u{3c9}",
                "`\u{3c9}` at character 3",
                "k, pi, a constant (a",
            ),
            ("1..2", "`1..2` at character 1", "a number"),
            ("k $ 2", "`$` at character 3", "an operator"),
        ] {
            let constants = Constants::from([("a".into(), 0.5)]);
            match parse(text, &constants, WORDS) {
                Err(Error::Request {
                    expected: e,
                    found: f,
                    ..
                }) => {
                    assert!(f.starts_with(found), "{text}: {f}");
                    assert!(e.contains(expected), "{text}: {e}");
                }
                other => panic!("{text}: {other:?}"),
            }
        }
        let deep = "(".repeat(5000);
        assert!(parse(&deep, &Constants::new(), WORDS).is_err());
    }

    #[test]
    fn constants_do_not_hide_functions() {
        assert!(is_free("c1") && is_free("K") && is_free("_x"));
        assert!(
            !is_free("pi") && !is_free("sin") && !is_free("pow") && !is_free("1c") && !is_free("")
        );
    }

    /// Five-point differences of every function and operator.
    #[test]
    fn val_calculus_jets_are_derivatives() {
        let none = Constants::new();
        let functions = FUNCTIONS
            .iter()
            .map(|f| format!("{}(0.3 + 0.4*k^2)", f.name));
        let others = [
            "k^3 - 2/k",
            "pow(2 + k, k)",
            "-k*min(k, 2)*max(k, 0.1)",
            "(1 + k)^1.5",
        ];
        for text in functions.chain(others.map(str::to_owned)) {
            let node = parse(&text, &none, WORDS).unwrap();
            for k in [0.4, 0.9] {
                let h = 1e-3;
                let at = |i: f64| node.jet_at(k + i * h);
                let [value, slope, bend] = at(0.0);
                assert_eq!(value.to_bits(), node.at(k).to_bits(), "{text}");
                let along = |part: usize| {
                    let near = at(1.0)[part] - at(-1.0)[part];
                    (8.0 * near - (at(2.0)[part] - at(-2.0)[part])) / (12.0 * h)
                };
                assert!(
                    (along(0) - slope).abs() < 1e-9 * slope.abs().max(1.0),
                    "{text}"
                );
                assert!(
                    (along(1) - bend).abs() < 1e-8 * bend.abs().max(1.0),
                    "{text}"
                );
            }
        }
    }
}
