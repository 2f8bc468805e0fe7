//! Units of what is composed of samples and axes.

use crate::field::Axis;
use crate::unit::{compose, square};

/// Units of the axes and of the samples; empty for those that are not known, and for what is composed of them
/// alone.
pub(crate) struct Units {
    pub time: String,
    pub space: String,
    pub frequency: String,
    pub wavenumber: String,
    pub velocity: String,
    sample: String,
}

impl Units {
    pub fn of(time: &Axis, space: &Axis, sample: Option<&str>) -> Units {
        let [time, space] = [time, space].map(|axis| axis.unit.clone().unwrap_or_default());
        let known = |unit: &str, composed: String| match unit.is_empty() {
            true => String::new(),
            false => composed,
        };
        Units {
            frequency: known(&time, crate::measure::cycles_per(&time)),
            wavenumber: known(&space, format!("rad/{space}")),
            velocity: match time.is_empty() || space.is_empty() {
                true => String::new(),
                false => compose(&[&space], &[&time]),
            },
            sample: sample.unwrap_or_default().to_owned(),
            time,
            space,
        }
    }

    /// Of the square of the samples over a unit of `bins`, times one of `length`.
    pub fn density(&self, bins: &str, length: &str) -> String {
        compose(&[&square(&self.sample), length], &[bins])
    }

    /// Of the derivative of the samples along x.
    pub fn gradient(&self) -> String {
        match self.sample.is_empty() || self.space.is_empty() {
            true => String::new(),
            false => compose(&[&self.sample], &[&self.space]),
        }
    }

    /// Of the third power of the samples.
    pub fn cubed(&self) -> String {
        match &self.sample[..] {
            "" => String::new(),
            sample => format!("({sample})³"),
        }
    }

    /// One over that of the samples.
    pub fn over_sample(&self) -> String {
        match &self.sample[..] {
            "" => String::new(),
            sample => compose(&[], &[sample]),
        }
    }
}
