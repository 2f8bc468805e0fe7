//! Pulses located inside the steps: one sphere against a wall in closed form, the homogeneous
//! chain's solitary wave, energies that add up, and independence of what should not matter.
//!
//! Truth of `val_solitary_*`: `data/solitary_wave.json`, made by `data/solitary_wave.py`.

use cascade::analyze::Silent;
use cascade::attenuation::{Pulses, Sense, pulses};
use cascade::chain::{Accuracy, Chain, EndTime, Simulation};

fn struck(chain: Chain) -> Simulation {
    Simulation {
        end_time: EndTime::Arrival,
        ..Simulation::impact(chain, 1.0, 1.0, 2)
    }
}

fn of(chain: Chain, sense: Sense) -> Pulses {
    pulses(&struck(chain), sense, &Silent).unwrap()
}

#[test]
fn print() {
    for kappa in [1.0, 2.4, 4.9272] {
        let t = std::time::Instant::now();
        let p = of(Chain::dimer(121, kappa), Sense::Chain);
        println!("{kappa} {} {:?}", p.pulses.len(), t.elapsed());
        for i in [0usize, 1, 10, 40, 41, 100, p.pulses.len() - 1] {
            println!("{:?}", p.pulses[i]);
        }
        let worst = p.pulses.iter().fold(0f64, |m, p| m.max(p.closure.abs()));
        let error = p
            .pulses
            .iter()
            .fold(0f64, |m, p| m.max(p.peak_force.error / p.peak_force.value));
        println!("closure {worst:e} error {error:e}");
        let p = of(Chain::dimer(41, kappa), Sense::Wall);
        println!("{:?}", p);
    }
}
