//! Peak forces between samples.

use test_support::fields::{fixed, losses};
use wavecascade::chain::scene::SceneSource;
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
    let wave = Waveform::half_sine(2.0, 3.0);
    let lossy = losses([0.02, 0.01, 0.03]);
    let none = Losses::default();
    let fixed = fixed(2.0);
    for (name, ends, drive, losses) in [
        ("wall", Ends::Wall, None, none),
        ("lossy", Ends::Wall, None, lossy),
        ("pushed", Ends::Wall, Some(Drive::Force(wave.clone())), none),
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
            s.drive = drive.clone();
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

/// Of chains that end when the front reaches the last site: the force at the wall has peaked by the end that the run
/// names, which is not far behind it.
#[test]
fn regress_the_end_behind_the_peak_at_a_wall() {
    let mut spread: [f64; 2] = [f64::INFINITY, 0.0];
    for text in [
        "sites = 10",
        "sites = 60",
        "sites = 200",
        "sites = 40\nstiffness_ratio = 2.398",
        "sites = 80\nstiffness_ratio = 4.9272",
        "sites = 40\nmass_ratio = 0.3428",
        "sites = 40\nmass_taper = 0.1",
        "sites = 40\nmass_taper = 4.0",
        "sites = 40\nwall_coefficient = 0.1",
        "sites = 40\nwall_coefficient = 20.0",
        "sites = 40\nstriker_mass = 4.0",
        "sites = 40\nprecompression = 0.1",
        "sites = 40\nprecompression = 10.0",
        "sites = 120\nprecompression = 1.0",
        "sites = 40\nlaw = \"spring\"",
        "sites = 40\ndashpot = 0.05",
        "sites = 40\nmass_spread = 0.3\nseed = 3",
        "sites = 24\nmaterial = \"steel\"\nshape = \"sphere\"\nradius = \"9 mm\"\nstriker_velocity = 1.0",
    ] {
        let of = |more: &str| {
            let source = SceneSource::new(
                None,
                format!("samples = 4000\nestimate_error = false\n{text}\n{more}"),
            );
            source.setup().unwrap().simulation.run(&Silent).unwrap()
        };
        let first = of("");
        let arrival = first.time[first.time.len() - 1];
        let end = first.end_behind_wall_peak().unwrap();
        let second = of(&format!("end_time = {end:?}"));
        let wall = second.chain.n_contacts() - 1;
        let peak = second.peak_force(wall).unwrap();
        assert!(peak.time < 0.999 * end, "{text}: {} of {end}", peak.time);
        assert!(end < 2.0 * arrival, "{text}: {end} behind {arrival}");
        let share = (peak.time - arrival) / (end - arrival);
        spread = [spread[0].min(share), spread[1].max(share)];
    }
    println!("peaks at {spread:.2?} of the way from the arrival to the end");
    assert!((0.2..0.3).contains(&spread[0]), "{spread:?}");
    assert!((0.65..0.75).contains(&spread[1]), "{spread:?}");
}
