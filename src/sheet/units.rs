//! Units of what is composed of samples and axes.

use super::Role;
use crate::field::Axis;
use crate::measure::cycles_per;
use crate::unit::{compose, label, square};

/// Units of the axes and of the samples.
pub(crate) struct Units {
    pub time: String,
    pub space: String,
    pub frequency: String,
    pub wavenumber: String,
    pub velocity: String,
    sample: String,
}

impl Units {
    /// Those of arrays: empty for those that are not known, and for what is composed of them alone.
    pub fn of(time: &Axis, space: &Axis, sample: Option<&str>) -> Units {
        let [time, space] = [time, space].map(|axis| axis.unit.clone().unwrap_or_default());
        Units::new(time, space, sample)
    }

    /// Those of sentences and charts: an axis without a unit counts samples or sites.
    pub fn in_words(time: &Axis, space: &Axis, sample: Option<&str>) -> Units {
        Units::new(time.time_unit(), space.space_unit(), sample)
    }

    fn new(time: String, space: String, sample: Option<&str>) -> Units {
        Units {
            frequency: known(&[&time], cycles_per(&time)),
            wavenumber: known(&[&space], format!("rad/{space}")),
            velocity: known(&[&time, &space], compose(&[&space], &[&time])),
            sample: sample.unwrap_or_default().to_owned(),
            time,
            space,
        }
    }

    pub fn unit(&self, role: Role) -> &str {
        match role {
            Role::Time => &self.time,
            Role::Position => &self.space,
            Role::Frequency => &self.frequency,
            Role::Wavenumber => &self.wavenumber,
        }
    }

    /// `frequency f (Hz)`.
    pub fn label(&self, role: Role) -> String {
        let [name, symbol] = role.words();
        label(&format!("{name} {symbol}"), self.unit(role))
    }

    /// Of the square of the samples over units of `bins`, times one of `length`.
    pub fn density(&self, bins: &[&str], length: &str) -> String {
        compose(&[&square(&self.sample), length], bins)
    }

    /// `power spectral density [(m/s)²/Hz]`.
    pub fn density_label(&self, bins: &[Role]) -> String {
        let bins: Vec<&str> = bins.iter().map(|role| self.unit(*role)).collect();
        label("power spectral density", &self.density(&bins, ""))
    }

    /// Of the derivative of the samples along x.
    pub fn gradient(&self) -> String {
        let units = [&self.sample[..], &self.space];
        known(&units, compose(&units[..1], &units[1..]))
    }

    /// Of the third power of the samples.
    pub fn cubed(&self) -> String {
        known(&[&self.sample], format!("({})³", self.sample))
    }

    /// One over that of the samples.
    pub fn over_sample(&self) -> String {
        compose(&[], &[&self.sample])
    }
}

/// What is composed of these units, empty if one is not known.
fn known(units: &[&str], composed: String) -> String {
    match units.contains(&"") {
        true => String::new(),
        false => composed,
    }
}
