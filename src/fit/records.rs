//! The measured records: where in the chain they are, and their samples in the units of the scene.

use ndarray::Array2;

use crate::chain::Chain;
use crate::chain::scene::{SceneSource, Setup, Units};
use crate::field::{Axis, Quantity};
use crate::measure::{self, Dimension};
use crate::transform::{RecordScratch, RecordTransform, fold};
use crate::{Error, Field, Result};

use super::key::refuse;
use super::shown::place;

/// By how much of the distance of bodies a site may be off a body.
const OFF: f64 = 0.05;

/// Fewest samples of a record and of all, for each unknown, that can be fitted.
const LEAST: usize = 8;

/// Records of a quantity at bodies, or of forces at contacts, of a chain.
///
/// Times rise and may be uneven; samples that are missing are NaN.
#[derive(Debug, Clone, PartialEq)]
pub struct Records {
    pub quantity: Quantity,
    /// Time 0 is the start of the run, in the unit of the scene.
    pub times: Vec<f64>,
    /// The body of each record; of a force its contact.
    pub bodies: Vec<usize>,
    /// One record after the other.
    pub values: Vec<f64>,
    /// Units of times and samples; empty where the scene has none.
    pub units: [String; 2],
}

impl Records {
    /// The records of a field of a scene's chain. `bodies` are those of the field's sites; by default each site is at
    /// the body of its number, or where the field states positions and the scene the distance of its bodies, at that of
    /// its position.
    ///
    /// # Errors
    /// [`Error::Request`] and [`Error::Unfit`] for sites that are at no body, times before the start, units that do not
    /// belong to the scene's, a quantity that no run has, and too few samples; [`Error::Scene`].
    pub fn of(field: &Field, scene: &SceneSource, bodies: Option<&[usize]>) -> Result<Records> {
        let setup = &scene.setup().map_err(|error| scene.locate(error))?;
        let scales = Scales::of(field, setup.units)?;
        let (n, m) = (field.n_times(), field.n_sites());
        let bodies = match bodies {
            Some(bodies) if bodies.len() == m => bodies.to_vec(),
            Some(bodies) => {
                let expected = format!("{m} numbers, one for each site of the field");
                return Err(Error::request("bodies", expected, bodies.len().to_string()));
            }
            None => bodies_of(field, setup, scales.length)?,
        };
        let mut values = vec![0.0; n * m];
        field.read_site_major(0..n, 0..m, &mut values);
        values.iter_mut().for_each(|value| {
            *value = match value.is_finite() {
                true => *value * scales.sample,
                false => f64::NAN,
            }
        });
        let records = Records {
            quantity: field.quantity,
            times: (0..n).map(|i| scales.time * field.time.at(i)).collect(),
            bodies,
            values,
            units: scales.units,
        };
        records.check(setup)?;
        Ok(records)
    }

    pub(super) fn check(&self, setup: &Setup) -> Result<()> {
        let count = places_in(&setup.simulation.chain, self.quantity);
        if let Some(body) = self.bodies.iter().find(|body| **body >= count) {
            let place = place(self.quantity);
            let expected = format!("a {place} of the chain, 0 to {}", count - 1);
            return Err(Error::request("bodies", expected, body.to_string()));
        }
        if let Some(twice) =
            (1..self.bodies.len()).find(|i| self.bodies[..*i].contains(&self.bodies[*i]))
        {
            let found = format!("{} twice", self.bodies[twice]);
            return Err(Error::request("bodies", "each once", found));
        }
        if let Some(i) = (1..self.times.len()).find(|i| self.times[*i] <= self.times[i - 1]) {
            let found = format!("{} after {}", self.times[i], self.times[i - 1]);
            return Err(Error::request("field", "times that rise", found));
        }
        match self.times.last() {
            Some(last) if *last > 0.0 => Ok(()),
            _ => {
                let expected =
                    "samples after time 0, at which the run starts (`--t0` states the first one)";
                Err(Error::request("t0", expected, "none"))
            }
        }
    }

    /// That there are enough samples for so many unknowns.
    pub(super) fn check_number(&self, unknowns: usize) -> Result<()> {
        let known = self.known();
        if known < LEAST * unknowns.max(1) {
            let expected = format!(
                "{} samples or more for {unknowns} unknowns",
                LEAST * unknowns.max(1)
            );
            return Err(refuse(&expected, &known.to_string()));
        }
        Ok(())
    }

    /// Number of samples that are not missing.
    pub fn known(&self) -> usize {
        self.values.iter().filter(|value| value.is_finite()).count()
    }

    pub fn record(&self, site: usize) -> &[f64] {
        let n = self.times.len();
        &self.values[n * site..n * (site + 1)]
    }

    pub(super) fn is_known(&self) -> Vec<bool> {
        self.values.iter().map(|value| value.is_finite()).collect()
    }

    /// Values in place of the samples, 0 where these are missing.
    pub(super) fn masked(&self, values: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let all = values.into_iter().zip(&self.values);
        all.map(|(value, own)| if own.is_finite() { value } else { 0.0 })
            .collect()
    }

    /// Values in place of the samples as `(time, site)`.
    pub(super) fn plane(&self, values: &[f64]) -> Array2<f64> {
        let n = self.times.len();
        Array2::from_shape_fn((n, self.bodies.len()), |(i, j)| values[n * j + i])
    }

    /// The step of the times, their median where they are uneven.
    pub fn step(&self) -> f64 {
        let mut steps: Vec<f64> = self
            .times
            .windows(2)
            .map(|pair| pair[1] - pair[0])
            .collect();
        steps.sort_by(f64::total_cmp);
        steps.get(steps.len() / 2).copied().unwrap_or(1.0)
    }

    /// Root mean square of what is not missing.
    pub fn size(&self) -> f64 {
        let known = self.values.iter().filter(|value| value.is_finite());
        let squares: f64 = known.map(|value| value * value).sum();
        (squares / self.known().max(1) as f64).sqrt()
    }

    /// Power of records of sites in place of the samples, a sum over sites, at [`Records::frequencies`].
    pub(super) fn spectrum(&self, values: &[f64], sites: &[usize]) -> Vec<f64> {
        let n = self.times.len();
        let transform = RecordTransform::<f64>::new(&vec![1.0; n], n);
        let mut scratch = RecordScratch::default();
        let mut power = vec![0.0; n / 2 + 1];
        for &site in sites {
            let record = &values[n * site..n * (site + 1)];
            let (spectrum, _) = transform.transform(std::iter::once(record), &mut scratch);
            let pairs = power.iter_mut().zip(spectrum);
            pairs.for_each(|(p, z)| *p += z.norm_sqr());
        }
        power
    }

    /// Frequencies from 0 to the Nyquist frequency.
    pub fn frequencies(&self) -> Vec<f64> {
        let n = self.times.len();
        let whole = n as f64 * self.step();
        (0..=n / 2).map(|m| m as f64 / whole).collect()
    }

    /// One-sided power spectral density of a plane `(time, site)`, the mean over sites; missing samples count as 0.
    pub fn density(&self, plane: &Array2<f64>) -> Vec<f64> {
        let known = |v: &f64| if v.is_finite() { *v } else { 0.0 };
        let grid: Vec<f64> = plane.columns().into_iter().flatten().map(known).collect();
        let (n, sites) = plane.dim();
        let scale = self.step() / (n * sites) as f64;
        let power = self.spectrum(&grid, &(0..sites).collect::<Vec<_>>());
        let each = power.into_iter().enumerate();
        each.map(|(m, p)| p * fold(m, n) * scale).collect()
    }

    /// The records up to a time.
    pub(super) fn until(&self, end: f64) -> Records {
        let n = self.times.iter().filter(|t| **t <= end).count();
        let each = (0..self.bodies.len()).flat_map(|site| &self.record(site)[..n]);
        Records {
            values: each.copied().collect(),
            times: self.times[..n].to_vec(),
            ..self.clone()
        }
    }
}

/// What numbers of a field are multiplied by to be in the units of a scene.
#[derive(Debug, Clone, PartialEq)]
struct Scales {
    time: f64,
    /// `None` for scenes without units.
    length: Option<f64>,
    sample: f64,
    /// Of times and samples; empty where the scene has none.
    units: [String; 2],
}

impl Scales {
    /// # Errors
    /// [`Error::Request`] for units that do not belong to the scene's, a field without a time step beside a scene in SI, and a
    /// quantity that no run has.
    fn of(field: &Field, scene: Units) -> Result<Scales> {
        let name = |unit: &Option<String>| unit.clone().unwrap_or_default();
        let stated = field.unit.as_deref();
        if scene != Units::Si {
            return Ok(Scales {
                time: 1.0,
                length: None,
                sample: 1.0,
                units: [name(&field.time.unit), name(&field.unit)],
            });
        }
        if field.time == Axis::index() {
            let expected = "the time step of the field, such as `--dt 1us`";
            return Err(Error::request(
                "dt",
                expected,
                "none stated, and none known from the file",
            ));
        }
        let units = unit_of(field.quantity, scene)?;
        let sample = match field.quantity {
            Quantity::Velocity => size::<measure::Speed>(stated)?,
            Quantity::Displacement => size::<measure::Length>(stated)?,
            Quantity::Force => size::<measure::Force>(stated)?,
            _ if matches!(stated, None | Some("m/s^2" | "m/s²")) => 1.0,
            _ => {
                return Err(Error::request(
                    "unit",
                    "accelerations in m/s^2",
                    name(&field.unit),
                ));
            }
        };
        Ok(Scales {
            time: size::<measure::Time>(field.time.unit.as_deref())?,
            length: Some(size::<measure::Length>(field.space.unit.as_deref())?),
            sample,
            units,
        })
    }
}

/// Number of places in a chain at which a quantity can be measured.
pub(super) fn places_in(chain: &Chain, quantity: Quantity) -> usize {
    match quantity {
        Quantity::Force => chain.n_contacts(),
        _ => chain.n_sites(),
    }
}

/// Units of times and of samples of a quantity beside a scene; empty where it has none.
pub(super) fn unit_of(quantity: Quantity, units: Units) -> Result<[String; 2]> {
    let unit = match quantity {
        Quantity::Velocity => "m/s",
        Quantity::Displacement => "m",
        Quantity::Force => "N",
        Quantity::Acceleration => "m/s^2",
        Quantity::StrainRate => return Err(no_run_has(quantity)),
    };
    let both = ["s", unit].map(str::to_owned);
    Ok(if units == Units::Si {
        both
    } else {
        Default::default()
    })
}

fn size<D: Dimension>(unit: Option<&str>) -> Result<f64> {
    let Some(unit) = unit else {
        return Ok(1.0);
    };
    measure::size::<D>(unit).ok_or_else(|| {
        let expected = format!(
            "{} in one of {} beside a scene in SI",
            D::NAME,
            measure::units::<D>()
        );
        Error::request("unit", expected, unit.to_owned())
    })
}

fn no_run_has(quantity: Quantity) -> Error {
    let expected = "a velocity, displacement, acceleration or force, which a run has";
    Error::request("quantity", expected, quantity.name())
}

fn bodies_of(field: &Field, setup: &Setup, length: Option<f64>) -> Result<Vec<usize>> {
    let is_counted = field.space.unit.is_none() && field.space.step == 1.0;
    let pitch = match (is_counted, setup.pitch, length) {
        (false, Some(pitch), Some(length)) => pitch / length,
        (false, ..) => return Err(no_positions(field)),
        _ => 1.0,
    };
    let body = |site: usize| {
        let place = field.space.at(site) / pitch;
        let body = place.round();
        match (place - body).abs() <= OFF && body >= 0.0 {
            true => Ok(body as usize),
            false => {
                let expected = format!(
                    "sites at bodies, which are {pitch} apart from 0 on, or `--bodies 3,7,11`"
                );
                Err(Error::request(
                    "bodies",
                    expected,
                    format!("one at {}", field.space.at(site)),
                ))
            }
        }
    };
    (0..field.n_sites()).map(body).collect()
}

fn no_positions(field: &Field) -> Error {
    let expected = "the bodies of the field's sites, such as `--bodies 3,7,11`: the scene states no distance of bodies";
    Error::request(
        "bodies",
        expected,
        format!("positions in {}", field.space.space_unit()),
    )
}
