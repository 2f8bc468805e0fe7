//! Recipes of fields: formulas as tables of tests write them.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::measured::Normal;

/// A formula that was read: of the values of its variables.
pub type Function = Arc<dyn Fn(&[f64]) -> f64 + Send + Sync>;

type OfTwo = fn(f64, f64) -> f64;
type OfOne = fn(f64) -> f64;

/// Operators, how strongly they bind, and what they make; `<` makes 1 or 0.
const BETWEEN: [(&str, u8, OfTwo); 7] = [
    ("<", 0, |a, b| f64::from(u8::from(a < b))),
    ("+", 1, |a, b| a + b),
    ("-", 1, |a, b| a - b),
    ("*", 2, |a, b| a * b),
    ("/", 2, |a, b| a / b),
    ("%", 2, f64::rem_euclid),
    ("^", 4, f64::powf),
];

/// Between those of products and of powers: `-k^2` is `-(k^2)`.
const SIGN: u8 = 3;

const OF_ONE: [(&str, OfOne); 7] = [
    ("sqrt", f64::sqrt),
    ("abs", f64::abs),
    ("sin", f64::sin),
    ("cos", f64::cos),
    ("tan", f64::tan),
    ("exp", f64::exp),
    ("floor", f64::floor),
];

/// Functions by name; `normal(seed)` is a normal number of variance 1.
pub struct Recipes(pub BTreeMap<String, Function>);

impl Default for Recipes {
    fn default() -> Recipes {
        let mut all = BTreeMap::<String, Function>::new();
        for (name, of) in OF_ONE {
            all.insert(name.into(), Arc::new(move |v| of(v[0])));
        }
        all.insert("min".into(), Arc::new(|v| v[0].min(v[1])));
        all.insert("max".into(), Arc::new(|v| v[0].max(v[1])));
        let normal = |v: &[f64]| Normal(v[0].to_bits()).draw();
        all.insert("normal".into(), Arc::new(normal));
        Recipes(all)
    }
}

impl Recipes {
    /// A formula of these variables.
    pub fn read(&self, text: &str, variables: &[&str]) -> Function {
        let mut reader = Reader {
            rest: text,
            variables: variables.to_vec(),
            functions: &self.0,
        };
        let all = reader.expression(0);
        assert!(reader.rest.trim().is_empty(), "{} in {text}", reader.rest);
        all
    }

    /// Adds `name(a, b) = formula`.
    pub fn add(&mut self, definition: &str) {
        let (head, formula) = definition.split_once(") = ").expect(definition);
        let (name, variables) = head.split_once('(').expect(definition);
        let variables: Vec<&str> = variables.split(", ").collect();
        let read = self.read(formula, &variables);
        self.0.insert(name.into(), read);
    }
}

/// Reads by precedence climbing.
struct Reader<'a> {
    rest: &'a str,
    variables: Vec<&'a str>,
    functions: &'a BTreeMap<String, Function>,
}

impl<'a> Reader<'a> {
    fn takes(&mut self, wanted: &str) -> bool {
        self.rest = self.rest.trim_start();
        let rest = self.rest.strip_prefix(wanted);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    /// An expression whose operators bind at least so strongly.
    fn expression(&mut self, least: u8) -> Function {
        let mut left = match self.takes("-") {
            true => {
                let of = self.expression(SIGN);
                Arc::new(move |v: &[f64]| -of(v))
            }
            false => self.operand(),
        };
        let binds = |it: &&(&str, u8, _)| it.1 >= least;
        while let Some((_, strength, of)) = BETWEEN.iter().filter(binds).find(|it| self.takes(it.0))
        {
            let (a, b) = (left, self.expression(strength + 1));
            left = Arc::new(move |v| of(a(v), b(v)));
        }
        left
    }

    /// The number or name that comes next.
    fn word(&mut self) -> &'a str {
        let text = self.rest.trim_start();
        let is_number = text.starts_with(|c: char| c.is_ascii_digit());
        let mut before = ' ';
        let end = text.find(|c: char| {
            let is_sign = is_number && before == 'e' && "+-".contains(c);
            before = c;
            !(c.is_alphanumeric() || "._".contains(c) || is_sign)
        });
        let (word, rest) = text.split_at(end.unwrap_or(text.len()));
        self.rest = rest;
        word
    }

    /// `sum(i, 1, 9, formula of i)`, behind its bracket.
    fn sum(&mut self) -> Function {
        let name = self.word();
        assert!(self.takes(","), "sum over {name}");
        let ends = [(); 2].map(|()| {
            let end = self.expression(0);
            assert!(self.takes(","), "sum over {name}");
            end
        });
        self.variables.push(name);
        let of = self.arguments().remove(0);
        self.variables.pop();
        Arc::new(move |v| {
            let [from, to] = [0, 1].map(|i| ends[i](v) as i64);
            let mut all = [v, &[0.0]].concat();
            let term = |i: i64| {
                all[v.len()] = i as f64;
                of(&all)
            };
            (from..=to).map(term).sum()
        })
    }

    /// A number, a variable, a function of arguments, or an expression in brackets.
    fn operand(&mut self) -> Function {
        if self.takes("(") {
            return self.arguments().remove(0);
        }
        let word = self.word();
        if let Ok(number) = word.parse() {
            return Arc::new(move |_| number);
        }
        if let Some(place) = self.variables.iter().position(|name| *name == word) {
            return Arc::new(move |v| v[place]);
        }
        if word == "pi" {
            return Arc::new(|_| std::f64::consts::PI);
        }
        assert!(self.takes("("), "{word:?} before {:?}", self.rest);
        if word == "sum" {
            return self.sum();
        }
        let of = self.functions.get(word).expect(word).clone();
        let arguments = self.arguments();
        Arc::new(move |v| {
            let mut values = [0.0; 8];
            values
                .iter_mut()
                .zip(&arguments)
                .for_each(|(value, one)| *value = one(v));
            of(&values[..arguments.len()])
        })
    }

    /// Expressions between commas, and the bracket that closes them.
    fn arguments(&mut self) -> Vec<Function> {
        let mut all = vec![self.expression(0)];
        while self.takes(",") {
            all.push(self.expression(0));
        }
        assert!(self.takes(")"), "no ) before {:?}", self.rest);
        all
    }
}
