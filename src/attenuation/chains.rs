//! The chains that are compared: scenes of any length, and the homogeneous chain beside each.

use serde::{Deserialize, Serialize};

use crate::Result;
use crate::chain::scene::{SceneSource, Setting, Setup};
use crate::chain::{Chain, Record, Simulation};

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

    /// The kind of a contact; all of a homogeneous chain are soft.
    pub fn of(chain: &Chain, contact: usize) -> ContactKind {
        let (low, high) = between_bodies(chain)
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| {
                (low.min(*c), high.max(*c))
            });
        match chain.coefficient[contact] {
            c if c == low => ContactKind::Soft,
            c if c == high => ContactKind::Stiff,
            _ => ContactKind::Other,
        }
    }
}

/// Coefficients of the contacts between two bodies, the striker and the wall left out; all of them
/// in chains too short to have any.
pub(super) fn between_bodies(chain: &Chain) -> &[f64] {
    let last = chain.n_sites() - 1;
    match chain.coefficient.get(1..last) {
        Some(inner) if !inner.is_empty() => inner,
        _ => &chain.coefficient,
    }
}

/// The simulation with the homogeneous chain in place of its own: contacts between bodies, and the
/// striker's and the wall's where they belong to the pattern, all have the least coefficient, and
/// bodies the mass of the first one. A striker and a wall of their own stay as they are.
pub fn homogeneous(simulation: &Simulation) -> Simulation {
    let mut reference = simulation.clone();
    let chain = &mut reference.chain;
    let inner = between_bodies(&simulation.chain);
    let soft = inner.iter().copied().fold(f64::INFINITY, f64::min);
    let last = chain.n_sites() - 1;
    for (j, c) in chain.coefficient.iter_mut().enumerate() {
        if (1..last).contains(&j) || inner.contains(c) {
            *c = soft;
        }
    }
    let masses = &simulation.chain.mass;
    let bodies = masses.get(1..).unwrap_or_default();
    if let Some(&body) = bodies.first() {
        for (j, m) in chain.mass.iter_mut().enumerate() {
            if j > 0 || bodies.contains(m) {
                *m = body;
            }
        }
    }
    reference
}

/// A scene that is asked about chains of different lengths.
#[derive(Debug, Clone)]
pub(super) struct Make {
    source: SceneSource,
    /// Whether the number of sites can be chosen.
    pub(super) extends: bool,
}

impl Make {
    /// # Errors
    /// [`crate::Error::Scene`] for what cannot be read.
    pub(super) fn new(source: SceneSource) -> Result<Make> {
        let typed = source.typed_keys()?;
        let extends = !FIXED.iter().any(|key| typed.iter().any(|k| k == key));
        Ok(Make { source, extends })
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

    /// With one key set by an option.
    pub(super) fn with(&self, key: &str, text: &str, option: &str) -> Make {
        let setting = Setting {
            source: format!("--{option} {key}"),
            ..setting(key, text)
        };
        Make {
            source: self.source.with([setting]),
            extends: self.extends,
        }
    }

    fn of<const N: usize>(&self, settings: [(&str, String); N]) -> Result<Setup> {
        let settings = settings.map(|(key, text)| setting(key, &text));
        let mut setup = self.source.with(settings).setup()?;
        setup.simulation.record = Record::default();
        Ok(setup)
    }
}

fn setting(key: &str, text: &str) -> Setting {
    Setting {
        key: key.to_owned(),
        text: text.to_owned(),
        source: format!("--{}", key.replace('_', "-")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_homogeneous_chain_keeps_a_wall_and_a_striker_of_their_own() {
        let mut chain = Chain::dimer(6, 3.0);
        let simulation = |chain: &Chain| Simulation::impact(chain.clone(), 1.0, 1.0, 2);
        let plain = homogeneous(&simulation(&chain)).chain;
        assert_eq!(plain.coefficient, [1.0; 6]);
        chain.coefficient[0] = 7.0;
        chain.coefficient[5] = 9.0;
        chain.mass[0] = 0.5;
        let own = homogeneous(&simulation(&chain)).chain;
        assert_eq!(own.coefficient, [7.0, 1.0, 1.0, 1.0, 1.0, 9.0]);
        assert_eq!(own.mass, [0.5, 1.0, 1.0, 1.0, 1.0, 1.0]);
        let kinds: Vec<ContactKind> = (0..6).map(|j| ContactKind::of(&chain, j)).collect();
        use ContactKind::{Other, Soft, Stiff};
        assert_eq!(kinds, [Other, Stiff, Soft, Stiff, Soft, Other]);
        chain.mass = vec![1.0, 2.0, 1.0, 2.0, 1.0, 2.0];
        assert_eq!(homogeneous(&simulation(&chain)).chain.mass, [2.0; 6]);
    }
}
