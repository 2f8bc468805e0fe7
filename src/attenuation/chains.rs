//! The chains that are compared: scenes of any length, and their homogeneous reference chains.

use serde::{Deserialize, Serialize};

use crate::Result;
use crate::chain::scene::{SceneSource, Setting, Setup};
use crate::chain::{Chain, Record, Simulation};

/// Bodies of a chain that is long enough to hold its pattern, for any cell length.
const LONG: usize = 48;

/// Scene keys that fix the number of sites, or whose meaning depends on it.
const FIXED: [&str; 10] = [
    "coefficients",
    "coefficient_taper",
    "masses",
    "mass_taper",
    "velocities",
    "displacements",
    "resonator_displacements",
    "resonator_velocities",
    "mode",
    "defect",
];

/// Kind of a contact in a dimer: soft and stiff contacts carry different peak forces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ContactKind {
    /// With the smallest coefficient between bodies.
    Soft,
    /// With the largest coefficient between bodies.
    Stiff,
    /// With any other coefficient: the striker's or the wall's own, or an intermediate one.
    Other,
}

/// The repeating pattern of a chain. Short chains do not hold all of it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pattern {
    /// Coefficients of the contacts between two bodies.
    coefficients: Vec<f64>,
    /// Masses of the bodies behind the striker.
    masses: Vec<f64>,
}

impl Pattern {
    /// The pattern of a chain without its striker and wall. A chain too short to have contacts
    /// between bodies contributes all of its contacts.
    pub(super) fn of(chain: &Chain) -> Pattern {
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
    pub(super) fn stiffness_ratio(&self) -> f64 {
        let [low, high] = self.extremes();
        high / low
    }

    /// The kind of a contact with this coefficient; in a homogeneous chain all are soft.
    pub(super) fn kind(&self, coefficient: f64) -> ContactKind {
        match self.extremes() {
            [low, _] if coefficient == low => ContactKind::Soft,
            [_, high] if coefficient == high => ContactKind::Stiff,
            _ => ContactKind::Other,
        }
    }

    /// The two alternating coefficients and the two alternating masses, in order; `None` for any
    /// other pattern.
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

/// The simulation with its chain replaced by the homogeneous reference. Contacts between bodies get
/// the smallest coefficient of the pattern, and bodies the mass of the first one. The striker and
/// the contacts of the striker and the wall change only if their values belong to the pattern.
pub(super) fn homogeneous(simulation: &Simulation, pattern: &Pattern) -> Simulation {
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

/// A scene from which chains of different lengths are built.
#[derive(Debug, Clone)]
pub(super) struct SceneTemplate {
    source: SceneSource,
    /// Whether the number of sites can be chosen.
    pub(super) extends: bool,
}

impl SceneTemplate {
    /// # Errors
    /// [`crate::Error::Scene`] for a scene that cannot be read.
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

    /// The scene with a striker and `bodies` bodies behind it.
    pub(super) fn with_bodies(&self, bodies: usize) -> Result<Setup> {
        let sites = (bodies + 1).to_string();
        self.of([("samples", "2".into()), ("sites", sites)])
    }

    /// The pattern of its chains, taken from one that is long enough to hold it.
    pub(super) fn pattern(&self) -> Result<Pattern> {
        let setup = self.setup()?;
        let bodies = setup.simulation.chain.n_sites() - 1;
        let setup = match self.extends && bodies < LONG {
            true => self.with_bodies(LONG)?,
            false => setup,
        };
        Ok(Pattern::of(&setup.simulation.chain))
    }

    /// The scene with one key set by an option.
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
        (chain.coefficient[0], chain.coefficient[5]) = (7.0, 9.0);
        chain.mass[0] = 0.5;
        assert_eq!(of(&chain).coefficient, [7.0, 1.0, 1.0, 1.0, 1.0, 9.0]);
        assert_eq!(of(&chain).mass, [0.5, 1.0, 1.0, 1.0, 1.0, 1.0]);
        use ContactKind::{Other, Soft, Stiff};
        let kind = |j: usize| Pattern::of(&chain).kind(chain.coefficient[j]);
        let kinds = [0, 1, 2, 3, 4, 5].map(kind);
        assert_eq!(kinds, [Other, Stiff, Soft, Stiff, Soft, Other]);
        chain.mass = vec![1.0, 2.0, 1.0, 2.0, 1.0, 2.0];
        assert_eq!(of(&chain).mass, [2.0; 6]);
    }
}
