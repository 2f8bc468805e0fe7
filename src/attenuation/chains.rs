//! The chains that are compared: scenes of any length, and the homogeneous chain beside each.

use serde::{Deserialize, Serialize};

use crate::Result;
use crate::chain::scene::{SceneSource, Setting, Setup};
use crate::chain::{Chain, Record, Simulation};

/// Bodies of a chain that holds its pattern, however long the cell.
const LONG: usize = 48;

/// Keys of scenes that fix how many sites there are, or mean something else for another number.
const FIXED: [&str; 8] = [
    "coefficients",
    "coefficient_taper",
    "masses",
    "mass_taper",
    "velocities",
    "displacements",
    "mode",
    "defect",
];

/// Which contact of a dimer a force is in: soft and stiff ones carry different peaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ContactKind {
    /// Of the least coefficient between bodies.
    Soft,
    /// Of the largest one.
    Stiff,
    /// The striker's or the wall's, of a coefficient of its own, or one between the two.
    Other,
}

impl ContactKind {
    pub fn name(self) -> &'static str {
        match self {
            ContactKind::Soft => "soft",
            ContactKind::Stiff => "stiff",
            ContactKind::Other => "other",
        }
    }
}

/// What repeats along a chain, of which short chains do not hold all.
#[derive(Debug, Clone, PartialEq)]
pub struct Pattern {
    /// Coefficients of the contacts between two bodies.
    coefficients: Vec<f64>,
    /// Masses of the bodies behind the striker.
    masses: Vec<f64>,
}

impl Pattern {
    /// The pattern that a chain holds, its striker and its wall left out; of a chain too short to
    /// have contacts between bodies, all of its contacts.
    pub fn of(chain: &Chain) -> Pattern {
        let last = chain.n_sites() - 1;
        let coefficients = match chain.coefficient.get(1..last) {
            Some(inner) if !inner.is_empty() => inner,
            _ => &chain.coefficient,
        };
        Pattern {
            coefficients: coefficients.to_vec(),
            masses: chain.mass.get(1..).unwrap_or_default().to_vec(),
        }
    }

    fn extremes(&self) -> [f64; 2] {
        let all = self.coefficients.iter();
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| {
            (low.min(*c), high.max(*c))
        });
        [low, high]
    }

    /// Largest over smallest coefficient.
    pub fn stiffness_ratio(&self) -> f64 {
        let [low, high] = self.extremes();
        high / low
    }

    /// The kind of a contact of this coefficient; all of a homogeneous chain are soft.
    pub fn kind(&self, coefficient: f64) -> ContactKind {
        match self.extremes() {
            [low, _] if coefficient == low => ContactKind::Soft,
            [_, high] if coefficient == high => ContactKind::Stiff,
            _ => ContactKind::Other,
        }
    }

    /// The two coefficients and the two masses that alternate, each pair in order; `None` where
    /// others are among them.
    pub(super) fn alternating(&self) -> Option<[[f64; 2]; 2]> {
        let pair = |values: &[f64]| {
            let first = *values.first()?;
            let pair = [first, values.get(1).copied().unwrap_or(first)];
            let alternate = values.iter().enumerate().all(|(j, v)| *v == pair[j % 2]);
            alternate.then_some(pair)
        };
        Some([pair(&self.coefficients)?, pair(&self.masses)?])
    }
}

/// The simulation with the homogeneous chain in place of its own: contacts between bodies, and the
/// striker's and the wall's where they belong to the pattern, all have its least coefficient, and
/// bodies the mass of the first one. A striker and a wall of their own stay as they are.
pub fn homogeneous(simulation: &Simulation, pattern: &Pattern) -> Simulation {
    let mut reference = simulation.clone();
    let chain = &mut reference.chain;
    let [soft, _] = pattern.extremes();
    let last = chain.n_sites() - 1;
    for (j, c) in chain.coefficient.iter_mut().enumerate() {
        if (1..last).contains(&j) || pattern.coefficients.contains(c) {
            *c = soft;
        }
    }
    if let Some(&body) = pattern.masses.first() {
        for (j, m) in chain.mass.iter_mut().enumerate() {
            if j > 0 || pattern.masses.contains(m) {
                *m = body;
            }
        }
    }
    reference
}

/// A scene that is asked about chains of different lengths.
#[derive(Debug, Clone)]
pub(super) struct SceneTemplate {
    source: SceneSource,
    /// Whether the number of sites can be chosen.
    pub(super) extends: bool,
}

impl SceneTemplate {
    /// # Errors
    /// [`crate::Error::Scene`] for what cannot be read.
    pub(super) fn new(source: SceneSource) -> Result<SceneTemplate> {
        let typed = source.typed_keys()?;
        let extends = !FIXED.iter().any(|key| typed.iter().any(|k| k == key));
        Ok(SceneTemplate { source, extends })
    }

    pub(super) fn text(&self) -> Result<String> {
        self.source.whole_text()
    }

    /// The scene as it is.
    pub(super) fn setup(&self) -> Result<Setup> {
        self.of([("samples", "2".into())])
    }

    /// With a striker and `bodies` behind it.
    pub(super) fn with_bodies(&self, bodies: usize) -> Result<Setup> {
        let sites = (bodies + 1).to_string();
        self.of([("samples", "2".into()), ("sites", sites)])
    }

    /// What repeats along its chains, seen in one that is long enough to hold it.
    pub(super) fn pattern(&self) -> Result<Pattern> {
        let setup = self.setup()?;
        let bodies = setup.simulation.chain.n_sites() - 1;
        let setup = match self.extends && bodies < LONG {
            true => self.with_bodies(LONG)?,
            false => setup,
        };
        Ok(Pattern::of(&setup.simulation.chain))
    }

    /// With one key set by an option.
    pub(super) fn with(&self, key: &str, text: &str, option: &str) -> SceneTemplate {
        let setting = Setting::new(key, text, format!("--{option} {key}"));
        SceneTemplate {
            source: self.source.with([setting]),
            extends: self.extends,
        }
    }

    fn of<const N: usize>(&self, settings: [(&str, String); N]) -> Result<Setup> {
        let source = |key: &str| format!("--{}", key.replace('_', "-"));
        let settings = settings.map(|(key, text)| Setting::new(key, text, source(key)));
        let mut setup = self.source.with(settings).setup()?;
        setup.simulation.record = Record::default();
        Ok(setup)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_homogeneous_chain_keeps_a_wall_and_a_striker_of_their_own() {
        let mut chain = Chain::dimer(6, 3.0);
        let simulation = |chain: &Chain| Simulation::impact(chain.clone(), 1.0, 1.0, 2);
        let of = |chain: &Chain| homogeneous(&simulation(chain), &Pattern::of(chain)).chain;
        assert_eq!(of(&chain).coefficient, [1.0; 6]);
        chain.coefficient[0] = 7.0;
        chain.coefficient[5] = 9.0;
        chain.mass[0] = 0.5;
        assert_eq!(of(&chain).coefficient, [7.0, 1.0, 1.0, 1.0, 1.0, 9.0]);
        assert_eq!(of(&chain).mass, [0.5, 1.0, 1.0, 1.0, 1.0, 1.0]);
        let pattern = Pattern::of(&chain);
        let kinds: Vec<ContactKind> = chain.coefficient.iter().map(|c| pattern.kind(*c)).collect();
        use ContactKind::{Other, Soft, Stiff};
        assert_eq!(kinds, [Other, Stiff, Soft, Stiff, Soft, Other]);
        chain.mass = vec![1.0, 2.0, 1.0, 2.0, 1.0, 2.0];
        assert_eq!(of(&chain).mass, [2.0; 6]);
    }
}
