//! Names of a budget's axes and quantities, with their units.

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
            Some(unit) => format!("position ({unit})"),
            None => "position (sites)".into(),
        }
    }

    pub(crate) fn wavenumber(&self) -> String {
        match &self.length {
            Some(unit) => format!("wavenumber k (rad/{unit})"),
            None => "wavenumber k (rad per site)".into(),
        }
    }

    pub(crate) fn frequency(&self) -> String {
        match self.time.as_deref() {
            Some(unit) => format!("frequency ({})", crate::measure::cycles_per(unit)),
            None => "frequency (cycles per unit of time)".into(),
        }
    }

    /// `what (J)`.
    pub fn energy(&self, what: &str) -> String {
        named(what, &self.energy)
    }

    /// `what (J/s)`.
    pub(crate) fn power(&self, what: &str) -> String {
        match (&self.energy, &self.time) {
            (Some(energy), Some(time)) => format!("{what} ({energy}/{time})"),
            _ => what.into(),
        }
    }
}

fn named(what: &str, unit: &Option<String>) -> String {
    match unit {
        Some(unit) => format!("{what} ({unit})"),
        None => what.into(),
    }
}
