//! Peak forces between samples.

use wavecascade::chain::{Accuracy, Chain, Drive, Ends, Losses, Scheme, Simulation, Waveform};
use wavecascade::observer::Silent;

/// A body that strikes a wall stops where its contact holds all its energy:
/// `delta = (5 m v^2 / 4 c)^{2/5}`, `F = c delta^{3/2}`.
#[test]
fn val_energy_a_body_against_a_wall() {
    let mut chain = Chain::dimer(1, 1.0);
    chain.mass[0] = 0.3;
    chain.coefficient[0] = 40.0;
    let speed = 1.7;
    let delta = (1.25 * 0.3 * speed * speed / 40.0f64).powf(0.4);
    let exact = 40.0 * delta * delta.sqrt();
    for (samples, bound) in [(41, 1e-7), (81, 2e-9), (641, 1e-13)] {
        let mut s = Simulation::impact(chain.clone(), speed, 0.9, samples);
        s.accuracy = Accuracy::Tolerance(1e-12);
        let run = s.run(&Silent).unwrap();
        let peak = run.peak_force(0).unwrap();
        let off = peak.value / exact - 1.0;
        let sampled = run
            .force
            .as_ref()
            .unwrap()
            .iter()
            .fold(0.0f64, |m, f| m.max(*f));
        println!("{samples}: {off:e}, sampled {:e}", sampled / exact - 1.0);
        assert!(off.abs() < bound, "{samples}: {off:e}");
    }
}

/// An eighth of the time between samples takes most of 8^6 off the error, with each force that can act on a site beside the contact.
#[test]
fn val_convergence_peaks_of_sixth_order() {
    let wave = Waveform::HalfSine {
        amplitude: 2.0,
        duration: 3.0,
    };
    let lossy = Losses {
        dashpot: 0.02,
        tangent: 0.01,
        drag: 0.03,
    };
    let none = Losses::default();
    let fixed = Ends::Fixed {
        left_coefficient: 2.0,
    };
    for (name, ends, drive, losses) in [
        ("wall", Ends::Wall, None, none),
        ("lossy", Ends::Wall, None, lossy),
        ("pushed", Ends::Wall, Some(Drive::Force(wave)), none),
        ("driven", fixed, Some(Drive::Wall(wave)), lossy),
        ("ring", Ends::Periodic, None, none),
    ] {
        let peak = |samples: usize| {
            let chain = Chain {
                ends,
                losses,
                ..Chain::dimer(6, 1.5)
            };
            let mut s = Simulation::impact(chain, 1.0, 12.0, samples);
            s.drive = drive;
            s.scheme = if losses.any() {
                Scheme::RungeKutta
            } else {
                Scheme::Nystrom
            };
            s.accuracy = Accuracy::Tolerance(1e-12);
            let run = s.run(&Silent).unwrap();
            [0, 2].map(|contact| run.peak_force(contact).unwrap())
        };
        let (fine, [a, b]) = (peak(1921), [peak(61), peak(481)]);
        for i in 0..2 {
            let off = [a[i], b[i]].map(|p| (p.value - fine[i].value).abs());
            println!("{name} {i}: {off:?}");
            assert!(off[0] < 2e-6 && off[1] < 5e-12, "{name} {i}: {off:?}");
        }
    }
}

#[test]
fn no_peak_without_what_it_needs() {
    let mut s = Simulation::impact(Chain::dimer(4, 1.0), 1.0, 3.0, 8);
    s.record.displacement = false;
    assert_eq!(s.run(&Silent).unwrap().peak_force(0), None);
}
