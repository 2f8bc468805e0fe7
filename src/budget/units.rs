//! Names of a budget's axes and quantities, with their units.

use crate::measure::cycles_per;
use crate::sheet::number;
use crate::unit::{compose, label};

/// Units of a chain; none for a chain without dimensions.
#[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize)]
pub struct BudgetUnits {
    pub time: Option<String>,
    pub length: Option<String>,
    pub energy: Option<String>,
}

impl BudgetUnits {
    /// Seconds, metres and joules.
    pub fn si() -> BudgetUnits {
        BudgetUnits {
            time: Some("s".into()),
            length: Some("m".into()),
            energy: Some("J".into()),
        }
    }

    pub(crate) fn time(&self) -> String {
        named("time", &self.time)
    }

    pub(crate) fn position(&self) -> String {
        let length = self.length.as_ref();
        length.map_or("position (sites)".into(), |unit| label("position", unit))
    }

    fn per_length(&self) -> String {
        let length = self.length.as_ref();
        length.map_or("rad per site".into(), |unit| format!("rad/{unit}"))
    }

    pub(crate) fn wavenumber(&self) -> String {
        label("wavenumber k", &self.per_length())
    }

    /// `k = 12.5 rad/m`.
    pub(super) fn at_wavenumber(&self, k: f64) -> String {
        format!("k = {} {}", number(k), self.per_length())
    }

    pub(crate) fn frequency(&self) -> String {
        match self.time.as_deref() {
            Some(unit) => label("frequency", &cycles_per(unit)),
            None => "frequency (cycles per unit of time)".into(),
        }
    }

    /// `what (J)`.
    pub fn energy(&self, what: &str) -> String {
        named(what, &self.energy)
    }

    /// `what (J/Hz)`.
    pub(crate) fn energy_per_frequency(&self, what: &str) -> String {
        let cycles = self.time.as_deref().map(cycles_per);
        ratio(what, &self.energy, &cycles)
    }

    /// `what (m/s)`.
    pub(crate) fn velocity(&self, what: &str) -> String {
        ratio(what, &self.length, &self.time)
    }

    /// `what (N)`.
    pub(crate) fn force(&self, what: &str) -> String {
        match (self.energy.as_deref(), self.length.as_deref()) {
            (Some("J"), Some("m")) => label(what, "N"),
            _ => ratio(what, &self.energy, &self.length),
        }
    }

    /// `what (J/s)`.
    pub(crate) fn power(&self, what: &str) -> String {
        ratio(what, &self.energy, &self.time)
    }
}

fn named(what: &str, unit: &Option<String>) -> String {
    label(what, unit.as_deref().unwrap_or_default())
}

/// With the unit of one over another, where both are known.
fn ratio(what: &str, over: &Option<String>, under: &Option<String>) -> String {
    match (over, under) {
        (Some(over), Some(under)) => label(what, &compose(&[over], &[under])),
        _ => what.into(),
    }
}
