//! A formula of the overlap.

use super::ContactLaw;
use crate::error::{Error, Result};
use crate::formula::{self, Node, Words};
use crate::numeric::Jet;

const WORDS: Words = Words {
    variable: "d",
    option: "law",
};

/// `F = f(d)`, differentiated exactly.
#[derive(Debug)]
pub(super) struct Expression {
    text: String,
    force: Node,
}

impl Expression {
    pub(super) fn parse(text: &str) -> Result<Expression> {
        let (typed, constants) = text.split_once(';').unwrap_or((text, ""));
        let constants = formula::parse_constants(constants, WORDS)?;
        let force = formula::parse(typed.trim(), &constants, WORDS)?;
        let text = text.trim().to_owned();
        let Jet { value, slope, .. } = force.at(Jet::variable(0.0));
        let expected = "a formula of the overlap d that is 0 and has a slope at d = 0";
        let found = format!("{value}, slope {slope}, of `{text}`");
        Error::require(value == 0.0 && !slope.is_nan(), "law", expected, found)?;
        Ok(Expression { text, force })
    }
}

impl ContactLaw for Expression {
    fn text(&self) -> String {
        self.text.clone()
    }

    fn force(&self, delta: Jet) -> Jet {
        self.force.at(delta)
    }

    fn force_at(&self, delta: f64) -> f64 {
        self.force.at(delta)
    }

    fn breaks(&self, from: f64, to: f64) -> Vec<f64> {
        self.force.breaks(from, to)
    }
}
