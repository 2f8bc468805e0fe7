//! Measured pulses beside computed ones.

use serde::Serialize;

use super::{Compared, MeasuredPoint};

/// Measured pulses over the abscissa of the curves: bodies, sites, or a key.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Measured {
    /// Forces relative to those of the homogeneous chain.
    pub forces: Vec<MeasuredPoint>,
    /// Of a field: largest velocities, and when velocities are half of these for the last time before.
    pub velocities: Vec<MeasuredPoint>,
    pub arrivals: Vec<MeasuredPoint>,
    /// Abscissae without a largest velocity within the record.
    pub without_peak: Vec<f64>,
}

/// Measured and computed pulses.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Beside {
    /// Relative forces, or of a field largest velocities.
    pub measured: Vec<Compared>,
    /// Arrivals of a field.
    pub measured_arrivals: Vec<Compared>,
    /// Abscissae outside the computed curve.
    pub not_compared: Vec<f64>,
    /// Abscissae on the computed curve that have no largest velocity within the record.
    pub measured_without_peak: Vec<f64>,
    /// Those that have one, but no arrival, measured or computed.
    pub measured_without_arrival: Vec<f64>,
}

/// Computed points over the abscissa.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Computed {
    pub forces: Vec<(f64, f64)>,
    pub velocities: Vec<(f64, f64)>,
    pub arrivals: Vec<(f64, f64)>,
}

impl Measured {
    /// Forces alone.
    pub fn of_forces(forces: Vec<MeasuredPoint>) -> Measured {
        Measured {
            forces,
            ..Measured::default()
        }
    }

    /// Beside computed curves, between whose points there are lines.
    pub fn beside(&self, computed: &Computed) -> Beside {
        let (forces, no_forces) = compare(&self.forces, &computed.forces);
        let (velocities, no_velocities) = compare(&self.velocities, &computed.velocities);
        let (arrivals, _) = compare(&self.arrivals, &computed.arrivals);
        let on_curve = |at: &&f64| between(&computed.velocities, **at).is_some();
        let has_none = |at: &f64| arrivals.iter().all(|c| c.measured.at != *at);
        let places = velocities.iter().map(|c| c.measured.at);
        Beside {
            measured_without_peak: self.without_peak.iter().filter(on_curve).copied().collect(),
            measured_without_arrival: places.filter(has_none).collect(),
            measured: [forces, velocities].concat(),
            not_compared: [no_forces, no_velocities].concat(),
            measured_arrivals: arrivals,
        }
    }
}

/// Points beside a curve, and the abscissae of those outside it.
fn compare(points: &[MeasuredPoint], curve: &[(f64, f64)]) -> (Vec<Compared>, Vec<f64>) {
    let (mut compared, mut outside) = (Vec::new(), Vec::new());
    for point in points {
        match between(curve, point.at) {
            Some(computed) => compared.push(point.compared_with(computed)),
            None => outside.push(point.at),
        }
    }
    (compared, outside)
}

/// A curve at an abscissa, by a line between the places on either side of it.
fn between(curve: &[(f64, f64)], at: f64) -> Option<f64> {
    if let Some(place) = curve.iter().find(|place| place.0 == at) {
        return Some(place.1);
    }
    let pair = curve
        .windows(2)
        .find(|pair| pair[0].0 < at && at < pair[1].0)?;
    let share = (at - pair[0].0) / (pair[1].0 - pair[0].0);
    Some(pair[0].1 + share * (pair[1].1 - pair[0].1))
}
