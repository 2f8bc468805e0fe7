//! Peak forces between samples.

use test_support::scenes::{rows, run, simulation, within};
use wavecascade::observer::Silent;

/// A body that strikes a wall stops where its contact holds all its energy:
/// `delta = (5 m v^2 / 4 c)^{2/5}`, `F = c delta^{3/2}`.
#[test]
fn val_energy_a_body_against_a_wall() {
    let delta = (1.25 * 0.3 * 1.7 * 1.7 / 40.0f64).powf(0.4);
    let exact = 40.0 * delta * delta.sqrt();
    for (samples, bound) in [(41, 1e-7), (81, 2e-9), (641, 1e-13)] {
        let run = run(&format!(
            "sites = 1\nmasses = [0.3]\ncoefficients = [40.0]\nstriker_velocity = 1.7\nend_time = 0.9\nsamples = {samples}\n\
             tolerance = 1e-12"
        ));
        let off = run.peak_force(0).unwrap().value / exact - 1.0;
        assert!(off.abs() < bound, "{samples}: {off:e}");
    }
}

/// An eighth of the time between samples takes most of 8^6 off the error, with each force that can act on a site beside the contact.
#[test]
fn val_convergence_peaks_of_sixth_order() {
    let lossy = "dashpot = 0.02\ntangent = 0.01\ndrag = 0.03";
    let wave = "drive_waveform = 'half-sine'\ndrive_amplitude = 2.0\ndrive_duration = 3.0\nstriker_velocity = 1.0";
    for keys in [
        "ends = 'wall'".to_owned(),
        lossy.to_owned(),
        format!("drive = 'force'\n{wave}"),
        format!("ends = 'fixed'\nleft_wall_coefficient = 2.0\ndrive = 'wall'\n{wave}\n{lossy}"),
        "ends = 'periodic'".to_owned(),
        "ground_cell = [2.0]".to_owned(),
        "resonator_mass = 0.5\nresonator_stiffness = 1.0".to_owned(),
    ] {
        let peaks = |samples: usize| {
            let run = run(&format!(
                "sites = 6\nstiffness_ratio = 1.5\nend_time = 12.0\ntolerance = 1e-12\nsamples = {samples}\n{keys}"
            ));
            [0, 2].map(|contact| run.peak_force(contact).unwrap().value)
        };
        let (fine, coarse, better) = (peaks(1921), peaks(61), peaks(481));
        for i in 0..2 {
            let off = [coarse[i], better[i]].map(|peak| (peak - fine[i]).abs());
            println!("{keys:?} {i}: {off:?}");
            assert!(off[0] < 2e-6 && off[1] < 5e-12, "{keys} {i}: {off:?}");
        }
    }
}

#[test]
fn no_peak_without_what_it_needs() {
    let it = simulation("sites = 4\nend_time = 3.0\nsamples = 8\nrecord = ['force']");
    assert_eq!(it.run(&Silent).unwrap().peak_force(0), None);
}

/// Of chains that end when the front reaches the last site: the force at the wall has peaked by the end that the run
/// names, which is not far behind it.
#[test]
fn regress_the_end_behind_the_peak_at_a_wall() {
    let mut shares = Vec::new();
    for [text] in rows(include_str!("arrivals.txt")) {
        let of = |more: &str| {
            run(&format!(
                "samples = 4000\nestimate_error = false\n{text}\n{more}"
            ))
        };
        let first = of("");
        let arrival = first.time[first.time.len() - 1];
        let end = first.end_behind_wall_peak().unwrap();
        let second = of(&format!("end_time = {end:?}"));
        let peak = second.peak_force(second.chain.n_contacts() - 1).unwrap();
        assert!(peak.time < 0.999 * end, "{text}: {} of {end}", peak.time);
        assert!(end < 2.0 * arrival, "{text}: {end} behind {arrival}");
        shares.push((peak.time - arrival) / (end - arrival));
    }
    shares.sort_by(f64::total_cmp);
    within(shares[0], 0.2..0.3, &shares);
    within(shares[shares.len() - 1], 0.65..0.75, &shares);
}
