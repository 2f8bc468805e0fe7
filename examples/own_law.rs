//! A chain under a law of one's own: its run, what its budget moves, the coherence of two bodies, and a run that is stopped.

use std::sync::Arc;
use std::time::Instant;

use wavecascade::budget::{BudgetRequest, Motion, budget};
use wavecascade::chain::{Chain, ContactLaw, Jet, Law, Record, Simulation};
use wavecascade::estimates::{CoherenceRequest, coherence};
use wavecascade::field::Axis;
use wavecascade::observer::{Observer, Silent};
use wavecascade::{Error, Field};

/// `F = delta + delta^3`. The stiffness and the energy follow from the force.
#[derive(Debug)]
struct Stiffening;

impl ContactLaw for Stiffening {
    fn text(&self) -> String {
        "delta + delta^3".into()
    }

    fn force(&self, delta: Jet) -> Jet {
        delta + delta * delta * delta
    }
}

/// Ends work at a time.
struct Until(Instant);

impl Observer for Until {
    fn cancelled(&self) -> bool {
        Instant::now() >= self.0
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut chain = Chain::dimer(20, 2.0);
    chain.law = Law::Other(Arc::new(Stiffening)).into();
    let mut simulation = Simulation::impact(chain, 1.0, 40.0, 1025);
    simulation.record = Record::ALL;

    let run = simulation.run(&Silent)?;
    let (found, _) = budget(&Motion::of(&run)?, &BudgetRequest::default())?;
    println!("{:.4} of energy 1/2, {:?}", found.scale, found.direction());

    let mut field = Field::from_array(run.velocity.clone());
    field.time = Axis {
        origin: 0.0,
        step: 40.0 / 1024.0,
        unit: None,
    };
    let found = coherence(&[&field], &CoherenceRequest::default(), &Silent)?;
    println!("coherent with body 0: {:?}", found.is_coherent);

    let stopped = simulation.run(&Until(Instant::now()));
    assert!(matches!(stopped, Err(Error::Cancelled)));
    Ok(())
}
