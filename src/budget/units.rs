//! Names of a budget's axes and quantities, with their units.

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
        match &self.length {
            Some(unit) => label("position", unit),
            None => "position (sites)".into(),
        }
    }

    pub(crate) fn wavenumber(&self) -> String {
        match &self.length {
            Some(unit) => label("wavenumber k", &format!("rad/{unit}")),
            None => "wavenumber k (rad per site)".into(),
        }
    }

    pub(crate) fn frequency(&self) -> String {
        match self.time.as_deref() {
            Some(unit) => label("frequency", &crate::measure::cycles_per(unit)),
            None => "frequency (cycles per unit of time)".into(),
        }
    }

    /// `what (J)`.
    pub fn energy(&self, what: &str) -> String {
        named(what, &self.energy)
    }

    /// `what (J/Hz)`.
    pub(crate) fn energy_per_frequency(&self, what: &str) -> String {
        match (&self.energy, &self.time) {
            (Some(energy), Some(time)) => label(
                what,
                &compose(&[energy], &[&crate::measure::cycles_per(time)]),
            ),
            _ => what.into(),
        }
    }

    /// `what (m/s)`.
    pub(crate) fn velocity(&self, what: &str) -> String {
        match (&self.length, &self.time) {
            (Some(length), Some(time)) => label(what, &compose(&[length], &[time])),
            _ => what.into(),
        }
    }

    /// `what (N)`.
    pub(crate) fn force(&self, what: &str) -> String {
        match (self.energy.as_deref(), self.length.as_deref()) {
            (Some("J"), Some("m")) => label(what, "N"),
            (Some(energy), Some(length)) => label(what, &compose(&[energy], &[length])),
            _ => what.into(),
        }
    }

    /// `what (J/s)`.
    pub(crate) fn power(&self, what: &str) -> String {
        match (&self.energy, &self.time) {
            (Some(energy), Some(time)) => label(what, &compose(&[energy], &[time])),
            _ => what.into(),
        }
    }
}

fn named(what: &str, unit: &Option<String>) -> String {
    label(what, unit.as_deref().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_a_chain_are_composed() {
        let si = BudgetUnits::si();
        assert_eq!(si.energy("energy"), "energy (J)");
        assert_eq!(si.power("flux"), "flux (J/s)");
        assert_eq!(si.energy_per_frequency("power flow"), "power flow (J/Hz)");
        assert_eq!(si.wavenumber(), "wavenumber k (rad/m)");
        assert_eq!(si.velocity("velocity"), "velocity (m/s)");
        assert_eq!(si.force("force"), "force (N)");
        let none = BudgetUnits::default();
        assert_eq!(none.power("flux"), "flux");
        assert_eq!(none.frequency(), "frequency (cycles per unit of time)");
    }
}
