//! Pulses located inside the steps: one sphere against a wall in closed form, the solitary wave of
//! the homogeneous chain, energy balance, and independence of irrelevant inputs.
//!
//! Reference of `val_solitary_*`: `data/solitary_wave.json`, made by `data/solitary_wave.py`.

use test_support::fields::losses;
use wavecascade::Error;
use wavecascade::attenuation::{FRONT, Located, Pulses, Sense, pulses};
use wavecascade::chain::{Accuracy, Chain, EndTime, Ends, Law, Scheme, Simulation};
use wavecascade::observer::Silent;

fn struck(chain: Chain) -> Simulation {
    let lossy = chain.losses.any();
    Simulation {
        end_time: EndTime::Arrival,
        scheme: match lossy {
            true => Scheme::RungeKutta,
            false => Scheme::Nystrom,
        },
        ..Simulation::impact(chain, 1.0, 1.0, 2)
    }
}

fn of(chain: Chain, sense: Sense) -> Pulses {
    pulses(&struck(chain), sense, &Silent).unwrap()
}

/// `integral from a to 1 of dz / sqrt(1 - z^(5/2))` by Simpson's rule in `z = 1 - s^2`.
fn collision_time(a: f64) -> f64 {
    let (n, end) = (4000, (1.0 - a).sqrt());
    let rate = |i: usize| {
        let s = end * i as f64 / n as f64;
        match i {
            0 => 2.0 / 2.5f64.sqrt(),
            _ => 2.0 * s / (1.0 - (1.0 - s * s).powf(2.5)).sqrt(),
        }
    };
    let sum: f64 = (0..=n)
        .map(|i| rate(i) * [1.0, 4.0, 2.0][if i == 0 || i == n { 0 } else { 1 + (i + 1) % 2 }])
        .sum();
    sum * end / (3.0 * n as f64)
}

/// A sphere against a wall: `x_m = (5 m v^2 / (4 c))^(2/5)`, `F_m = c x_m^(3/2)`, and times by
/// quadrature of energy conservation.
#[test]
fn val_hertz_collision_with_a_wall() {
    let mut chain = Chain::dimer(1, 1.0);
    let (m, c, v) = (1.7, 3.1, 0.6);
    chain.mass[0] = m;
    chain.coefficient[0] = c;
    let mut simulation = struck(chain);
    simulation.velocity[0] = v;
    let found = pulses(&simulation, Sense::Wall, &Silent).unwrap();
    let pulse = found.pulses[0];
    let deepest = (1.25 * m * v * v / c).powf(0.4);
    let unit = deepest / v;
    let share = |force: f64| collision_time(force.powf(2.0 / 3.0));
    let expected = [
        (pulse.peak_force, c * deepest.powf(1.5), 1e-13),
        (pulse.peak_time, unit * collision_time(0.0), 1e-12),
        (
            pulse.arrival_time,
            unit * (collision_time(0.0) - share(FRONT)),
            1e-12,
        ),
        (pulse.width, 2.0 * unit * share(0.5), 1e-12),
    ];
    for (found, truth, tolerance) in expected {
        let off = (found.value / truth - 1.0).abs();
        assert!(off < tolerance, "{found:?} {truth} {off:e}");
    }
    assert_eq!(
        pulse.peak_velocity,
        Located {
            value: v,
            error: 0.0
        }
    );
    assert_eq!(pulse.velocity_rise_time, None, "it moves from the start");
}

/// The pulse in a homogeneous chain approaches the solitary wave of the impact: its force, speed
/// and width. Transients die out on the way.
#[test]
fn val_solitary_wave_of_the_homogeneous_chain() {
    #[derive(serde::Deserialize)]
    struct Wave {
        period: f64,
        modes: Vec<f64>,
        largest_overlap: f64,
        speed_after_impact: f64,
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/solitary_wave.json");
    let wave: Wave = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let overlap = |xi: f64| -> f64 {
        let k = std::f64::consts::TAU / wave.period;
        let modes = wave.modes.iter().enumerate();
        modes.map(|(m, a)| a * (k * m as f64 * xi).cos()).sum()
    };
    let c = wave.speed_after_impact;
    let force = c.powi(6) * wave.largest_overlap.powf(1.5);
    // Half of the peak force, at xi = low, by bisection.
    let (mut low, mut high) = (0.0, 2.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let part = (overlap(middle) / wave.largest_overlap).powf(1.5);
        if part > 0.5 {
            low = middle;
        } else {
            high = middle;
        }
    }
    let width = 2.0 * low / c;
    // The velocity of site n is the sum of the rates of all overlaps from contact n on. It is
    // largest when the wave is halfway between contacts n - 1 and n.
    let rate = |xi: f64| -> f64 {
        let k = std::f64::consts::TAU / wave.period;
        let modes = wave.modes.iter().enumerate();
        let slope = |(m, a): (usize, &f64)| -a * k * m as f64 * (k * m as f64 * xi).sin();
        match xi.abs() < 0.5 * wave.period {
            true => modes.map(slope).sum(),
            false => 0.0,
        }
    };
    let velocity = |xi: f64| (0..20).map(|n| rate(xi - f64::from(n))).sum::<f64>();
    let (mut early, mut late) = (-2.0, -0.5);
    for _ in 0..60 {
        let middle = 0.5 * (early + late);
        match velocity(middle) < 0.5 * velocity(-0.5) {
            true => early = middle,
            false => late = middle,
        }
    }
    let rise = (-0.5 - early) / c;
    let found = of(Chain::dimer(150, 1.0), Sense::Chain);
    let at = |n: usize| found.pulses[n];
    for n in [80, 100, 120] {
        let off = (at(n).peak_force.value / force - 1.0).abs();
        assert!(off < 3e-13, "contact {n}: {off:e}");
        let off = (at(n).width.value / width - 1.0).abs();
        assert!(off < 2e-12, "contact {n}: width {off:e}");
        let moving = at(n).velocity_rise_time.unwrap();
        let off = ((at(n).velocity_time.value - moving.value) / rise - 1.0).abs();
        assert!(off < 2e-12, "contact {n}: rise {off:e}");
        let taken = at(n + 1).arrival_time.value - at(n).arrival_time.value;
        let off = (taken * c - 1.0).abs();
        assert!(off < 1e-12, "contact {n}: speed {off:e}");
    }
    // Two-sided check: at contact 20 the wave has not settled.
    let early = (at(20).peak_force.value / force - 1.0).abs();
    assert!((1e-9..1e-4).contains(&early), "{early:e}");
}

fn hard_chains() -> Vec<(&'static str, Chain)> {
    let dimer = |kappa| Chain::dimer(61, kappa);
    let with = |change: &dyn Fn(&mut Chain)| {
        let mut chain = dimer(2.4);
        change(&mut chain);
        chain
    };
    vec![
        ("homogeneous", dimer(1.0)),
        ("dispersive", dimer(2.4)),
        ("localized", dimer(4.9272)),
        ("stiff", dimer(300.0)),
        (
            "mass dimer",
            with(&|c| c.mass.iter_mut().step_by(2).for_each(|m| *m = 0.3)),
        ),
        ("pressed", with(&|c| c.precompression = 0.01)),
        (
            "power law",
            with(&|c| c.law = Law::Power { exponent: 2.0 }.into()),
        ),
        (
            "free end",
            with(&|c| {
                c.ends = Ends::Free;
                c.coefficient.pop();
            }),
        ),
        ("drag", with(&|c| c.losses.drag = 0.02)),
        ("dashpot", with(&|c| c.losses.dashpot = 0.03)),
        ("tangent", with(&|c| c.losses.tangent = 0.05)),
        (
            "all losses",
            with(&|c| c.losses = losses([0.01, 0.01, 0.01])),
        ),
    ]
}

/// Energy passed, left behind and lost sum to the input energy to 1e-11, at every contact of all
/// kinds of chains, and on the wall.
#[test]
fn val_energy_passed_and_behind_is_the_input() {
    for (name, chain) in hard_chains() {
        let walled = chain.ends == Ends::Wall;
        let mut found = of(chain.clone(), Sense::Chain).pulses;
        assert!(found.len() > 45, "{name}: {}", found.len());
        if walled {
            found.extend(of(chain, Sense::Wall).pulses);
        }
        let worst = found.iter().fold(0.0f64, |m, p| m.max(p.closure.abs()));
        assert!(worst > 0.0 && worst < 1e-11, "{name}: {worst:e}");
        let lossy = ["drag", "dashpot", "tangent", "all losses"].contains(&name);
        assert_eq!(found[40].energy_lost > 0.0, lossy, "{name}");
    }
}

/// The stated errors cover the difference from runs at a hundredth of the tolerance. Forces are off
/// by at most 2e-11 of their value, times by 1e-8 of the interval of 4096 samples.
#[test]
fn regress_errors_stated_are_kept() {
    for (name, chain) in hard_chains() {
        let sense = Sense::Chain;
        let found = of(chain.clone(), sense);
        let mut finer = struck(chain);
        finer.accuracy = Accuracy::Tolerance(1e-11);
        let finer = pulses(&finer, sense, &Silent).unwrap();
        let sample = found.end_time / 4096.0;
        let (mut worst_force, mut worst_time) = (0.0f64, 0.0f64);
        for (a, b) in found.pulses.iter().zip(&finer.pulses) {
            let force = (a.peak_force.value / b.peak_force.value - 1.0).abs();
            let time = (a.arrival_time.value - b.arrival_time.value).abs() / sample;
            let time = time
                .max((a.width.value - b.width.value).abs() / sample)
                .max((a.peak_time.value - b.peak_time.value).abs() / sample);
            let moving = a.velocity_rise_time.zip(b.velocity_rise_time);
            let time = moving.map_or(time, |(a, b)| time.max((a.value - b.value).abs() / sample));
            worst_force = worst_force.max(force);
            worst_time = worst_time.max(time);
            let stated = a.peak_force.error + 3e-12 * a.peak_force.value;
            let off = (a.peak_force.value - b.peak_force.value).abs();
            assert!(off <= stated, "{name} {}: {off:e} {stated:e}", a.contact);
        }
        let moving = |p: &&wavecascade::attenuation::Pulse| p.velocity_rise_time.is_some();
        assert_eq!(
            found.pulses.iter().filter(moving).count(),
            found.pulses.len() - 1
        );
        assert!(worst_force < 2e-11, "{name}: {worst_force:e}");
        assert!(worst_time < 1e-8, "{name}: {worst_time:e}");
    }
}

/// Peaks between the samples of a run, located by another method, are the same.
#[test]
fn regress_peaks_of_a_sampled_run() {
    let chain = Chain::dimer(61, 2.4);
    let found = of(chain.clone(), Sense::Chain);
    let run = Simulation::impact(chain, 1.0, found.end_time, 16384);
    let run = run.run(&Silent).unwrap();
    for contact in [0, 1, 20, 41] {
        let sampled = run.peak_force(contact).unwrap();
        let off = (sampled.value / found.pulses[contact].peak_force.value - 1.0).abs();
        assert!(off < 2e-14, "contact {contact}: {off:e}");
        let late = (sampled.time - found.pulses[contact].peak_time.value).abs();
        assert!(late < 5e-8, "contact {contact}: {late:e}");
    }
    // Interpolate the rise of the velocity by the parabola through three samples.
    for site in [1, 20, 41] {
        let v = run.velocity.column(site);
        let top = (0..v.len()).max_by(|a, b| v[*a].total_cmp(&v[*b])).unwrap();
        let half = 0.5 * found.pulses[site].peak_velocity.value;
        let i = (0..top).rev().find(|i| v[*i] < half).unwrap();
        let (step, bend) = (v[i + 1] - v[i], v[i + 2] - 2.0 * v[i + 1] + v[i]);
        let line = (half - v[i]) / step;
        let share = line + 0.5 * bend / step * line * (1.0 - line);
        let time = run.time[i] + share * (run.time[i + 1] - run.time[i]);
        let late = (time - found.pulses[site].velocity_rise_time.unwrap().value).abs();
        assert!(late < 4e-8, "site {site}: {late:e}");
    }
    let last = run.time.len() - 1;
    let passed = run.energy_passed.as_ref().unwrap()[[last, 20]];
    let off = (passed / found.pulses[20].energy_passed.value - 1.0).abs();
    assert!(off < 2e-12, "{off:e}");
}

/// At twice the impact speed forces grow by `2^(6/5)`, times shrink by `2^(1/5)`, energies grow by
/// 4.
#[test]
fn val_hertz_scaling_with_the_impact() {
    let slow = of(Chain::dimer(61, 2.4), Sense::Chain);
    let mut fast = struck(Chain::dimer(61, 2.4));
    fast.velocity[0] = 2.0;
    let fast = pulses(&fast, Sense::Chain, &Silent).unwrap();
    let ratio = |a: Located, b: Located| a.value / b.value;
    for n in [1, 20, 50] {
        let (a, b) = (fast.pulses[n], slow.pulses[n]);
        let [rise, slow_rise] = [a, b].map(|pulse| pulse.velocity_rise_time.unwrap());
        let shorter = 2f64.powf(-0.2);
        for (found, truth, tolerance) in [
            (ratio(a.peak_force, b.peak_force), 2f64.powf(1.2), 2e-14),
            (ratio(a.peak_velocity, b.peak_velocity), 2.0, 5e-13),
            (ratio(a.arrival_time, b.arrival_time), shorter, 3e-15),
            (ratio(a.width, b.width), shorter, 1e-13),
            (ratio(rise, slow_rise), shorter, 1e-13),
            (ratio(a.energy_passed, b.energy_passed), 4.0, 3e-11),
        ] {
            let off = (found / truth - 1.0).abs();
            assert!(off < tolerance, "{n}: {found} {truth} {off:e}");
        }
    }
}

/// A curve ends before a reflection enters: its values are those of a chain twice as long, to the
/// last bit.
#[test]
fn regress_no_reflection_enters() {
    let short = of(Chain::dimer(41, 2.4), Sense::Chain);
    let long = of(Chain::dimer(82, 2.4), Sense::Chain);
    let len = short.pulses.len();
    assert!((30..41).contains(&len), "{len}");
    for (a, b) in short.pulses.iter().zip(&long.pulses) {
        for (a, b) in [
            (a.peak_force, b.peak_force),
            (a.width, b.width),
            (a.arrival_time, b.arrival_time),
        ] {
            assert_eq!(a, b);
        }
        assert_eq!(a.velocity_rise_time, b.velocity_rise_time);
    }
}

#[test]
fn what_has_no_front_is_refused() {
    let mut periodic = Chain::dimer(10, 2.0);
    periodic.ends = Ends::Periodic;
    let mut free = Chain::dimer(10, 2.0);
    free.ends = Ends::Free;
    free.coefficient.pop();
    let mut moving = struck(Chain::dimer(10, 2.0));
    moving.velocity[9] = 1.0;
    for (simulation, sense, named) in [
        (struck(periodic), Sense::Chain, "ends"),
        (struck(free), Sense::Wall, "ends"),
        (moving, Sense::Chain, "velocities"),
    ] {
        let error = pulses(&simulation, sense, &Silent).unwrap_err();
        assert!(
            matches!(&error, Error::Request { option, .. } if *option == named),
            "{error}"
        );
    }
    // The curve of a chain whose losses absorb the pulse ends where the pulse does.
    let mut eaten = Chain::dimer(60, 2.0);
    eaten.losses.drag = 2.0;
    let eaten = of(eaten, Sense::Chain);
    assert!(!eaten.pulses.is_empty() && eaten.pulses.len() < 59);
}

/// A contact under load at the start has its arrival at time 0.
#[test]
fn a_contact_pressed_from_the_start_begins_there() {
    let mut simulation = struck(Chain::dimer(40, 2.0));
    simulation.displacement[0] = 0.5;
    let found = pulses(&simulation, Sense::Chain, &Silent).unwrap();
    assert!(found.pulses.len() > 30, "{}", found.pulses.len());
    assert_eq!(found.pulses[0].arrival_time.value, 0.0);
    assert!(found.pulses[0].peak_force.value > 0.5f64.powf(1.5));
    assert!(found.pulses[1].arrival_time.value > 0.0);
}
