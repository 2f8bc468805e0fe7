//! The measured records: where in the chain they are, and their samples in the units of the scene.

use ndarray::Array2;

use crate::chain::Chain;
use crate::chain::scene::{SceneSource, Setup, Units};
use crate::field::{Axis, Quantity};
use crate::numeric::sorted;
use crate::transform::{RecordScratch, RecordTransform, fold};
use crate::{Error, Field, Result};

use super::key::ratio;
use super::shown::place;

/// By how much of the distance of bodies a site may be off a body.
const OFF: f64 = 0.05;

/// Fewest samples of a record and of all, for each unknown, that can be fitted.
const LEAST: usize = 8;

/// Samples whose squares, and those of their noise, are numbers.
const SIZES: std::ops::RangeInclusive<f64> = 1e-120..=1e120;

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
    /// the body that its name numbers, else at that of its own number, or where the field states positions and the
    /// scene the distance of its bodies, at that of its position.
    ///
    /// # Errors
    /// [`Error::Request`] and [`Error::Unfit`] for sites that are at no body, times before the start, units that do not
    /// belong to the scene's, a quantity that no run has, and too few samples; [`Error::Scene`].
    pub fn of(field: &Field, scene: &SceneSource, bodies: Option<&[usize]>) -> Result<Records> {
        let setup = &scene.setup().map_err(|error| scene.locate(error))?;
        let (time, length, sample, units) = scales_of(field, setup.units)?;
        let (n, m) = (field.n_times(), field.n_sites());
        let bodies = match bodies {
            Some(bodies) => {
                let expected = format!("{m} numbers, one for each site of the field");
                Error::require(bodies.len() == m, "bodies", expected, bodies.len())?;
                bodies.to_vec()
            }
            None => bodies_of(field, setup, length)?,
        };
        let mut records = Records {
            quantity: field.quantity,
            times: (0..n).map(|i| time * field.time.at(i)).collect(),
            bodies,
            values: Vec::new(),
            units,
        };
        // Before a large field is read.
        records.check(setup)?;
        let mut values = vec![0.0; n * m];
        field.read_site_major(0..n, 0..m, &mut values);
        let scaled = values.iter().map(|value| match value.is_finite() {
            true => value * sample,
            false => f64::NAN,
        });
        records.values = scaled.collect();
        let known = records.values.iter().filter(|value| value.is_finite());
        let largest = known.fold(0.0, |m: f64, value| m.max(value.abs()));
        let (low, high) = (SIZES.start(), SIZES.end());
        let expected = format!("samples of which the largest is {low:e} to {high:e}");
        let found = format!("{largest:e}");
        Error::require(SIZES.contains(&largest), "field", expected, found)?;
        Ok(records)
    }

    pub(super) fn check(&self, setup: &Setup) -> Result<()> {
        let count = places_in(&setup.simulation.chain, self.quantity);
        if let Some(body) = self.bodies.iter().find(|body| **body >= count) {
            let place = place(self.quantity);
            let expected = format!("a {place} of the chain, 0 to {}", count - 1);
            return Err(Error::request("bodies", expected, body.to_string()));
        }
        let is_twice = |i: &usize| self.bodies[..*i].contains(&self.bodies[*i]);
        if let Some(twice) = (1..self.bodies.len()).find(is_twice) {
            let found = format!("{} twice", self.bodies[twice]);
            return Err(Error::request("bodies", "each once", found));
        }
        if let Some(pair) = self.times.windows(2).find(|pair| pair[1] <= pair[0]) {
            let found = format!("{} after {}", pair[1], pair[0]);
            return Err(Error::request("field", "times that rise", found));
        }
        let is_after = self.times.last().is_some_and(|last| *last > 0.0);
        let expected =
            "samples after time 0, at which the run starts (`--t0` states the first one)";
        Error::require(is_after, "t0", expected, "none")
    }

    /// That there are enough samples for so many unknowns.
    pub(super) fn check_number(&self, unknowns: usize) -> Result<()> {
        let (known, least) = (self.known(), LEAST * unknowns.max(1));
        let expected = format!("{least} samples or more for {unknowns} unknowns");
        Error::require(known >= least, "free", expected, known)
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
        let steps = sorted(self.times.windows(2).map(|pair| pair[1] - pair[0]));
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
            let spectrum = transform.spectra_of_rows(record, 1, &mut scratch);
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

/// What times, lengths and samples of a field are multiplied by to be in the units of a scene, lengths `None` beside scenes
/// without units, and the units of times and samples; empty where the scene has none.
type Scales = (f64, Option<f64>, f64, [String; 2]);

/// # Errors
/// [`Error::Request`] for units that do not belong to the scene's, a field without a time step beside a scene in SI, and a
/// quantity that no run has.
fn scales_of(field: &Field, scene: Units) -> Result<Scales> {
    let name = |unit: &Option<String>| unit.clone().unwrap_or_default();
    if scene != Units::Si {
        return Ok((1.0, None, 1.0, [&field.time.unit, &field.unit].map(name)));
    }
    let expected = "the time step of the field, such as `--dt 1us`";
    let found = "none stated, and none known from the file";
    Error::require(field.time != Axis::index(), "dt", expected, found)?;
    let units = unit_of(field.quantity, scene)?;
    let size = |stated: &Option<String>, unit: &str| {
        let stated = stated.as_deref().unwrap_or(unit).replace('²', "^2");
        let known = (stated == unit).then_some(1.0);
        known.or_else(|| ratio(&stated, unit)).ok_or_else(|| {
            let expected = format!("a unit of what the scene has in {unit}");
            Error::request("unit", expected, stated)
        })
    };
    let [time, length] = [size(&field.time.unit, "s")?, size(&field.space.unit, "m")?];
    Ok((time, Some(length), size(&field.unit, &units[1])?, units))
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
        Quantity::StrainRate => {
            let expected = "a velocity, displacement, acceleration or force, which a run has";
            return Err(Error::request("quantity", expected, quantity.name()));
        }
    };
    Ok(match units {
        Units::Si => ["s", unit].map(str::to_owned),
        Units::None => Default::default(),
    })
}

/// By the numbers in the names of the sites, which differ; else by positions.
fn bodies_of(field: &Field, setup: &Setup, length: Option<f64>) -> Result<Vec<usize>> {
    let named: Option<Vec<usize>> = field.channels.iter().map(|name| number_in(name)).collect();
    let is_whole = |named: &Vec<usize>| named.len() == field.n_sites();
    let is_once = |named: &Vec<usize>| (1..named.len()).all(|i| !named[..i].contains(&named[i]));
    if let Some(named) = named.filter(|named| is_whole(named) && is_once(named)) {
        return Ok(named);
    }
    let is_counted = field.space.unit.is_none() && field.space.step == 1.0;
    let pitch = match (is_counted, setup.pitch, length) {
        (true, ..) => Some(1.0),
        (false, pitch, length) => pitch.zip(length).map(|(pitch, length)| pitch / length),
    };
    let body = |site: usize| {
        let place = pitch.map(|pitch| field.space.at(site) / pitch);
        let body = place.map(f64::round).filter(|body| *body >= 0.0);
        let near = |(place, body): &(f64, f64)| (place - body).abs() <= OFF;
        let body = place.zip(body).filter(near).map(|(_, body)| body as usize);
        body.ok_or_else(|| {
            let apart = pitch.map_or("the scene states no distance of bodies".into(), |pitch| {
                format!("bodies are {pitch} apart from 0 on")
            });
            let expected = format!("sites at bodies, or them, as `--bodies 3,7,11`: {apart}");
            let (place, unit) = (field.space.at(site), field.space.space_unit());
            Error::request("bodies", expected, format!("one at {place} in {unit}"))
        })
    };
    (0..field.n_sites()).map(body).collect()
}

/// Words whose numbers are those of bodies; numbers of channels, sensors and points are not.
const BODIES: [&str; 13] = [
    "body", "bead", "site", "particle", "cylinder", "sphere", "ball", "grain", "mass", "node", "v",
    "u", "velocity",
];

/// The whole number behind a word: 4 of `body 4`, `v4` and `bead_4 (m/s)`, none of `CH4`.
fn number_in(name: &str) -> Option<usize> {
    let name = name.split(['(', '[']).next()?.trim().to_lowercase();
    let word = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let number = name[word.len()..].parse().ok()?;
    let is_body = BODIES.contains(&word.trim_end_matches([' ', '_', '-']));
    is_body.then_some(number)
}
