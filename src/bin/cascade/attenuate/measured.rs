//! What was measured, beside what was computed.

use cascade::Error;
use cascade::attenuation::{Attenuation, Compared, MeasuredPoint, Row, measured_peaks, read_curve};
use cascade::plot::Overlay;

use super::{Attenuate, Where};

/// What was measured.
pub(super) enum Measured {
    Nothing,
    /// Relative forces over bodies.
    Forces(Vec<MeasuredPoint>),
    /// Largest velocities over sites.
    Velocities(Vec<MeasuredPoint>),
}

impl Measured {
    /// Beside the first curve, forces in the contacts that are fitted, and what is outside it.
    pub(super) fn beside(&self, attenuation: &Attenuation) -> (Vec<Compared>, Vec<f64>) {
        let Some(first) = attenuation.curves.first() else {
            return (Vec::new(), Vec::new());
        };
        let (points, curve): (_, Vec<(f64, f64)>) = match self {
            Measured::Nothing => return (Vec::new(), Vec::new()),
            Measured::Forces(points) => (points, attenuation.compared(&first.rows)),
            Measured::Velocities(points) => {
                let velocities = first.rows.iter();
                let of = |row: &Row| (row.bodies as f64, row.pulse.peak_velocity.value);
                (points, velocities.map(of).collect())
            }
        };
        let (mut compared, mut outside) = (Vec::new(), Vec::new());
        for point in points {
            match between(&curve, point.at) {
                Some(computed) => compared.push(point.compared_with(computed)),
                None => outside.push(point.at),
            }
        }
        (compared, outside)
    }

    pub(super) fn laid_over(&self) -> Overlay<'_> {
        match self {
            Measured::Nothing => Overlay::Nothing,
            Measured::Forces(points) => Overlay::Forces(points),
            Measured::Velocities(points) => Overlay::Velocities(points),
        }
    }
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

impl Attenuate {
    pub(super) fn measured(&self) -> Result<Measured, Error> {
        let Some(path) = &self.measured else {
            return Ok(Measured::Nothing);
        };
        if !self.measured_field {
            return Ok(Measured::Forces(read_curve(path)?));
        }
        if self.sense == Where::Wall {
            return Err(Error::Request {
                option: "measured-field",
                expected: "`--sense chain` or both: sites of a field are those of one chain".into(),
                found: "wall".into(),
            });
        }
        let options = cascade::field::OpenOptions::default();
        let peaks = measured_peaks(&cascade::Field::open(path, &options)?);
        let points = peaks.iter().map(|peak| MeasuredPoint {
            at: peak.site as f64,
            value: peak.velocity,
            error: Some(peak.velocity_error),
        });
        Ok(Measured::Velocities(points.collect()))
    }
}
