//! A formula of the overlap.

use super::ContactLaw;
use crate::chain::lattice::refuse;
use crate::error::Result;
use crate::formula::{self, Node, Words};

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
        let [value, slope, _] = force.jet_at(0.0);
        if value != 0.0 || slope.is_nan() {
            let expected = "a formula of the overlap d that is 0 and has a slope at d = 0";
            return Err(refuse(
                "law",
                expected,
                format!("{value}, slope {slope}, of `{text}`"),
            ));
        }
        Ok(Expression { text, force })
    }
}

impl ContactLaw for Expression {
    fn text(&self) -> String {
        self.text.clone()
    }

    fn force(&self, delta: f64) -> f64 {
        self.force.at(delta)
    }

    fn stiffness(&self, delta: f64) -> f64 {
        self.force.jet_at(delta)[1]
    }

    fn bend(&self, delta: f64) -> f64 {
        self.force.jet_at(delta)[2]
    }
}
