//! Comparison of measured with computed pulses.

use serde::Serialize;
use wavecascade::Error;
use wavecascade::attenuation::{Attenuation, Compared, MeasuredPoint, measured_peaks, read_curve};
use wavecascade::plot::Overlay;

use super::{Attenuate, Where};
use crate::analyze::print_notes;

/// Measured pulses.
#[derive(Debug)]
pub(super) enum MeasuredPulses {
    Nothing,
    /// Relative forces over bodies.
    Forces(Vec<MeasuredPoint>),
    Field {
        /// Largest velocities and arrivals over sites.
        curves: [Vec<MeasuredPoint>; 2],
        /// Sites behind the struck one that have no largest velocity within the record.
        without_peak: Vec<f64>,
    },
}

/// Measured and computed pulses.
#[derive(Debug, Default, Serialize)]
pub(super) struct Beside {
    /// Relative forces, or of a field largest velocities.
    pub(super) measured: Vec<Compared>,
    /// Of a field: when velocities are half of their largest for the last time before it.
    pub(super) measured_arrivals: Vec<Compared>,
    /// Abscissae outside the computed curve.
    pub(super) not_compared: Vec<f64>,
    /// Sites of a field on the computed curve, behind the struck one, that have no largest velocity
    /// within the record.
    pub(super) measured_without_peak: Vec<f64>,
    /// Sites that have one, but no arrival, measured or computed.
    pub(super) measured_without_arrival: Vec<f64>,
}

impl MeasuredPulses {
    /// Beside the first curve; forces in the contacts that are fitted.
    pub(super) fn beside(&self, attenuation: &Attenuation) -> Beside {
        let mut beside = Beside::default();
        let Some(first) = attenuation.curves.first() else {
            return beside;
        };
        match self {
            MeasuredPulses::Nothing => {}
            MeasuredPulses::Forces(points) => {
                let curve = attenuation.compared(&first.rows);
                (beside.measured, beside.not_compared) = compare(points, &curve);
            }
            MeasuredPulses::Field {
                curves: [velocities, arrivals],
                without_peak,
            } => {
                let computed = first.velocities();
                (beside.measured, beside.not_compared) = compare(velocities, &computed);
                (beside.measured_arrivals, _) = compare(arrivals, &first.arrivals());
                let on_curve = |at: &&f64| between(&computed, **at).is_some();
                beside.measured_without_peak =
                    without_peak.iter().filter(on_curve).copied().collect();
                let arrivals = beside.measured_arrivals.iter();
                let arrived: Vec<f64> = arrivals.map(|c| c.measured.at).collect();
                let sites = beside.measured.iter().map(|c| c.measured.at);
                beside.measured_without_arrival =
                    sites.filter(|at| !arrived.contains(at)).collect();
            }
        }
        beside
    }

    pub(super) fn laid_over(&self) -> Overlay<'_> {
        match self {
            MeasuredPulses::Nothing => Overlay::Nothing,
            MeasuredPulses::Forces(points) => Overlay::Forces(points),
            MeasuredPulses::Field {
                curves: [velocities, arrivals],
                ..
            } => Overlay::Field([velocities, arrivals]),
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

impl Attenuate {
    pub(super) fn measured(&self) -> Result<MeasuredPulses, Error> {
        let Some(path) = &self.measured else {
            return Ok(MeasuredPulses::Nothing);
        };
        if !self.measured_field {
            return Ok(MeasuredPulses::Forces(read_curve(path)?));
        }
        if self.sense == Where::Wall {
            return Err(Error::Request {
                option: "measured-field",
                expected: "`--sense chain` or both: sites of a field are those of one chain".into(),
                found: "wall".into(),
            });
        }
        let options = wavecascade::field::OpenOptions::default();
        let field = wavecascade::Field::open(path, &options)?;
        print_notes(&field, self.how.quiet);
        let peaks = measured_peaks(&field);
        field.check_unchanged()?;
        let points = peaks.iter().map(|peak| peak.points(peak.site as f64));
        let (velocities, arrivals): (_, Vec<_>) = points.unzip();
        let arrivals = arrivals.into_iter().flatten().collect();
        // The struck body moves fastest when it is struck, which is no peak.
        let has_none = |site: &usize| peaks.binary_search_by_key(site, |peak| peak.site).is_err();
        let without_peak = (1..field.n_sites()).filter(has_none);
        Ok(MeasuredPulses::Field {
            curves: [velocities, arrivals],
            without_peak: without_peak.map(|site| site as f64).collect(),
        })
    }
}
