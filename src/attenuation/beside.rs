//! Measured pulses beside computed ones.

use serde::Serialize;

use super::{Compared, MeasuredPoint};

/// Measured pulses over the abscissa of the curves: bodies, sites, or a key.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Measured {
    #[default]
    Nothing,
    /// Forces relative to those of the homogeneous chain.
    Forces(Vec<MeasuredPoint>),
    /// Of a field.
    Field {
        /// Largest velocities.
        velocities: Vec<MeasuredPoint>,
        /// When velocities are half of their largest for the last time before it.
        arrivals: Vec<MeasuredPoint>,
        /// Abscissae without a largest velocity within the record.
        without_peak: Vec<f64>,
    },
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
    /// Beside computed curves, between whose points there are lines.
    pub fn beside(&self, computed: &Computed) -> Beside {
        let mut beside = Beside::default();
        match self {
            Measured::Nothing => {}
            Measured::Forces(points) => {
                (beside.measured, beside.not_compared) = compare(points, &computed.forces);
            }
            Measured::Field {
                velocities,
                arrivals,
                without_peak,
            } => {
                (beside.measured, beside.not_compared) = compare(velocities, &computed.velocities);
                (beside.measured_arrivals, _) = compare(arrivals, &computed.arrivals);
                let on_curve = |at: &&f64| between(&computed.velocities, **at).is_some();
                beside.measured_without_peak =
                    without_peak.iter().filter(on_curve).copied().collect();
                let arrivals = beside.measured_arrivals.iter();
                let arrived: Vec<f64> = arrivals.map(|c| c.measured.at).collect();
                let places = beside.measured.iter().map(|c| c.measured.at);
                beside.measured_without_arrival =
                    places.filter(|at| !arrived.contains(at)).collect();
            }
        }
        beside
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
