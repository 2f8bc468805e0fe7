//! Formulas of k, as they are typed.
//!
//! Numbers, `k`, constants, `pi`, `+ - * / ^`, brackets and functions, with the precedence of
//! Python: `-k^2` is `-(k^2)`, `2^3^2` is `2^9`. Faults name their place.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use crate::error::{Error, Result};

/// Brackets, signs and powers within each other at most.
const DEPTH: usize = 100;

type Unary = fn(f64) -> f64;
type Binary = fn(f64, f64) -> f64;

const UNARY: [(&str, Unary); 14] = [
    ("sqrt", f64::sqrt),
    ("abs", f64::abs),
    ("sin", f64::sin),
    ("cos", f64::cos),
    ("tan", f64::tan),
    ("asin", f64::asin),
    ("acos", f64::acos),
    ("atan", f64::atan),
    ("sinh", f64::sinh),
    ("cosh", f64::cosh),
    ("tanh", f64::tanh),
    ("exp", f64::exp),
    ("ln", f64::ln),
    ("log10", f64::log10),
];
const BINARY: [(&str, Binary); 3] = [("pow", f64::powf), ("min", f64::min), ("max", f64::max)];

/// Constants of a formula by name.
pub type Constants = BTreeMap<String, f64>;

/// A formula read.
#[derive(Debug, Clone)]
pub(super) enum Node {
    Number(f64),
    Wavenumber,
    Unary(fn(f64) -> f64, Box<Node>),
    Binary(fn(f64, f64) -> f64, Box<Node>, Box<Node>),
}

impl Node {
    pub(super) fn at(&self, k: f64) -> f64 {
        match self {
            Node::Number(value) => *value,
            Node::Wavenumber => k,
            Node::Unary(function, of) => function(of.at(k)),
            Node::Binary(function, a, b) => function(a.at(k), b.at(k)),
        }
    }
}

/// Whether a constant may have this name.
pub(super) fn is_free(name: &str) -> bool {
    let is_word =
        name.starts_with(|c: char| c.is_alphabetic() || c == '_') && name.chars().all(is_of_name);
    let functions = UNARY.iter().map(|f| f.0).chain(BINARY.iter().map(|f| f.0));
    is_word
        && !["k", "pi"]
            .into_iter()
            .chain(functions)
            .any(|known| known == name)
}

/// Reads a formula.
///
/// # Errors
/// [`Error::Request`] with the place of the fault and the known names.
pub(super) fn parse(text: &str, constants: &Constants) -> Result<Node> {
    let mut reader = Reader {
        text,
        at: 0,
        depth: 0,
        constants,
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
            option: "dispersion",
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
            let function: fn(f64, f64) -> f64 = match self.peek() {
                Some('+') => |a, b| a + b,
                Some('-') => |a, b| a - b,
                _ => return Ok(left),
            };
            self.at += 1;
            left = Node::Binary(function, Box::new(left), Box::new(self.product()?));
        }
    }

    fn product(&mut self) -> Result<Node> {
        let mut left = self.signed()?;
        loop {
            let function: fn(f64, f64) -> f64 = match self.peek() {
                Some('*') => |a, b| a * b,
                Some('/') => |a, b| a / b,
                _ => return Ok(left),
            };
            self.at += 1;
            left = Node::Binary(function, Box::new(left), Box::new(self.signed()?));
        }
    }

    fn signed(&mut self) -> Result<Node> {
        self.depth += 1;
        if self.depth > DEPTH {
            return Err(self.fault("a formula less deeply nested"));
        }
        let node = if self.take('-') {
            Node::Unary(|a| -a, Box::new(self.signed()?))
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
            true => Ok(Node::Binary(
                f64::powf,
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
            "k" => Some(Node::Wavenumber),
            "pi" => Some(Node::Number(PI)),
            _ => self.constants.get(&name).copied().map(Node::Number),
        };
        if let Some(node) = known {
            return Ok(node);
        }
        let unary = UNARY.iter().find(|f| f.0 == name);
        let binary = BINARY.iter().find(|f| f.0 == name);
        if unary.is_none() && binary.is_none() {
            return Err(self.fault_at(&self.known_names(), &format!("`{name}`"), start));
        }
        if !self.take('(') {
            return Err(self.fault(&format!("( after {name}")));
        }
        let first = self.sum()?;
        let node = match (unary, binary) {
            (Some(&(_, function)), _) => Node::Unary(function, Box::new(first)),
            (None, Some(&(_, function))) => {
                if !self.take(',') {
                    return Err(self.fault(&format!("a second argument of {name} after a comma")));
                }
                Node::Binary(function, Box::new(first), Box::new(self.sum()?))
            }
            (None, None) => first,
        };
        self.close(node)
    }

    fn known_names(&self) -> String {
        let constants: Vec<&str> = self.constants.keys().map(String::as_str).collect();
        let functions: Vec<&str> = UNARY.iter().map(|f| f.0).collect();
        format!(
            "k, pi, a constant ({}; others are set by `; NAME=NUMBER` after the formula) or a \
             function ({}, pow, min, max)",
            constants.join(", "),
            functions.join(", ")
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str, k: f64) -> f64 {
        let constants = Constants::from([("c".into(), 4.0), ("a".into(), 0.5)]);
        parse(text, &constants).unwrap().at(k)
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
            match parse(text, &constants) {
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
        assert!(parse(&deep, &Constants::new()).is_err());
    }

    #[test]
    fn constants_do_not_hide_functions() {
        assert!(is_free("c1") && is_free("K") && is_free("_x"));
        assert!(
            !is_free("k") && !is_free("sin") && !is_free("pow") && !is_free("1c") && !is_free("")
        );
    }
}
