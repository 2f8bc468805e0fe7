//! Contact laws against closed forms, against each other, and as scenes name them.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use test_support::contains_all;
use test_support::fields::{chain, fixed, spring};
use wavecascade::Error;
use wavecascade::chain::scene::SceneSource;
use wavecascade::chain::{
    Accuracy, Chain, ContactLaw, Ends, Jet, Law, Laws, Run, RunWarning, Scheme, Simulation,
};
use wavecascade::observer::Silent;
use wavecascade::report::RunFile;

fn free(n: usize, laws: impl Into<Laws>) -> Chain {
    chain(vec![1.0; n], vec![1.0; n - 1], laws, Ends::Free)
}

fn impact(chain: Chain, speed: f64, end: f64, tolerance: f64) -> Run {
    let mut simulation = Simulation::impact(chain, speed, end, 65);
    simulation.accuracy = Accuracy::Tolerance(tolerance);
    if simulation.chain.losses.any() {
        simulation.scheme = Scheme::RungeKutta;
    }
    simulation.run(&Silent).unwrap()
}

/// The largest difference of velocities of two runs.
fn apart(a: &Run, b: &Run) -> f64 {
    let pairs = a.velocity.iter().zip(&b.velocity);
    pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
}

/// A linear contact that only presses holds two bodies for half a period, `pi sqrt(mu / c)`, and then lets go of them.
#[test]
fn val_closed_form_a_linear_contact_that_opens() {
    let (c, speed) = (5.0f64, 2.0);
    let lasts = PI * (0.5 / c).sqrt();
    for law in [
        Law::Power { exponent: 1.0 },
        Law::expression("d").unwrap().one_sided().unwrap(),
    ] {
        let mut pair = free(2, law);
        pair.coefficient[0] = c;
        let run = impact(pair, speed, 4.0 * lasts, 1e-10);
        for (row, t) in run.velocity.rows().into_iter().zip(&run.time) {
            let half = 0.5 * speed * (PI * t / lasts).min(PI).cos();
            assert!((row[0] - 0.5 * speed - half).abs() < 2e-10, "{t}: {row}");
            assert!((row[1] - 0.5 * speed + half).abs() < 2e-10, "{t}: {row}");
        }
        let force = run.force.unwrap();
        assert!(force[[64, 0]] == 0.0 && force[[8, 0]] > 0.0);
    }
}

/// Two bodies under `F = a d^3` move as `cn`: their period is `4 K(1/2) / sqrt(2 a) / D` at the largest overlap D, and
/// under `F = sign(d) |d|^p` it is `4 D / v0` times the integral of `1 / sqrt(1 - u^{p+1})`.
#[test]
fn val_closed_form_periods_of_power_laws_that_pull() {
    // Integral of (1 - u^{p+1})^{-1/2} from 0 to 1: B(1/(p+1), 1/2) / (p+1).
    let beta = |p: f64| -> f64 {
        match p {
            1.0 => PI / 2.0,
            3.0 => 1.311_028_777_146_059_9,
            _ => unreachable!(),
        }
    };
    let laws = [
        (1.0, Law::two_sided_power(1.0)),
        (3.0, Law::two_sided_power(3.0)),
        (3.0, Law::polynomial(vec![0.0, 0.0, 1.0])),
        (3.0, Law::expression("k*d^3; k=1").unwrap()),
    ];
    for (p, law) in laws {
        let (c, speed) = (0.8f64, 1.3f64);
        // Reduced mass 1/2: v0^2 / 4 = c D^{p+1} / (p+1).
        let most = ((p + 1.0) * speed * speed / (4.0 * c)).powf(1.0 / (p + 1.0));
        let period = 4.0 * most / speed * beta(p);
        let mut pair = free(2, law.clone());
        pair.coefficient[0] = c;
        let mut bound = Simulation::impact(pair, speed, 2.0 * period, 3);
        bound.accuracy = Accuracy::Tolerance(1e-11);
        let run = bound.run(&Silent).unwrap();
        for row in run.velocity.rows() {
            assert!((row[0] - speed).abs() < 1e-10, "{law:?}: {row}");
            assert!(row[1].abs() < 1e-10, "{law:?}: {row}");
        }
    }
}

/// The overlap of a bistable contact, `V = -d^2/2 + d^4/4`, started on the ridge with the speed v of two bodies of mass 1,
/// moves in both wells, or with `V < 0` in one: the largest overlap is that of equal energy.
#[test]
fn val_energy_turning_points_of_a_bistable_contact() {
    let law = Law::polynomial(vec![-1.0, 0.0, 1.0]);
    let mut pair = Simulation::impact(free(2, law.clone()), 0.0, 60.0, 12001);
    pair.accuracy = Accuracy::Tolerance(1e-10);
    for (start, speed) in [(0.0, 0.3), (0.5, 0.0)] {
        pair.displacement = vec![start, 0.0];
        pair.velocity = vec![0.5 * speed, -0.5 * speed];
        let run = pair.run(&Silent).unwrap();
        let x = run.displacement.as_ref().unwrap();
        let overlaps = x.rows().into_iter().map(|row| row[0] - row[1]);
        let [least, most] = overlaps.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], r| {
            [a.min(r), b.max(r)]
        });
        let energy = 0.25 * speed * speed + law.energy(1.0, 0.0, start);
        // -d^2/2 + d^4/4 = E.
        let turn = |sign: f64| (1.0 + sign * (1.0 + 4.0 * energy).sqrt()).sqrt();
        assert!((most - turn(1.0)).abs() < 2e-6, "{most} {}", turn(1.0));
        let expected = if start > 0.0 { turn(-1.0) } else { -turn(1.0) };
        assert!((least - expected).abs() < 2e-6, "{least} {expected}");
        assert!(run.report.energy_drift.unwrap() < 1e-11);
    }
}

/// A polynomial, its formula, a table of a line, and the law `spring` are the same motion.
#[test]
fn val_same_force_laws_that_are_one_in_other_words() {
    let run = |law: Law| impact(free(20, law), 0.7, 30.0, 1e-9);
    let expected = run(spring(0.25, 0.4));
    for law in [
        Law::polynomial(vec![1.0, -0.25, 0.4]),
        Law::expression("d - a*d^2 + b*d^3; a=0.25, b=0.4").unwrap(),
    ] {
        assert!(apart(&run(law), &expected) < 1e-9);
    }
    let linear = run(spring(0.0, 0.0));
    let table = Law::table(vec![-2.0, -1.0, 0.0, 3.0], vec![-2.0, -1.0, 0.0, 3.0]).unwrap();
    let tabled = run(table.clone());
    assert!(apart(&tabled, &linear) < 1e-9);
    assert_eq!(tabled.report.warnings, []);
    let narrow = Law::table(vec![-0.1, 0.0, 0.1], vec![-0.1, 0.0, 0.1]).unwrap();
    let warned = run(narrow).report.warnings;
    assert!(matches!(
        warned[..],
        [RunWarning::OutsideLaw {
            contact: 0,
            range: [-0.1, 0.1],
            ..
        }]
    ));
}

/// Forces, stiffnesses and energies of a table are those of SciPy's `PchipInterpolator` (1.17).
#[test]
fn val_scipy_a_table_is_a_monotone_cubic() {
    let overlap = vec![-2.0, -0.5, 0.0, 0.3, 1.1, 2.0];
    let law = Law::table(overlap, vec![-3.0, -0.4, 0.0, 0.9, 1.0, 4.0]).unwrap();
    for (at, [force, stiffness, energy]) in [
        (
            -1.3,
            [-1.5249973676155493, 1.7805399449035815, 0.8362072473936404],
        ),
        (
            -0.2,
            [-0.1868501656701071, 0.6626877404120806, 0.02090002056594434],
        ),
        (
            0.15,
            [0.48931183877458295, 4.098484455117804, 0.031502208817420656],
        ),
        (
            0.7,
            [0.9542214306722003, 0.058616956962190825, 0.516643404322349],
        ),
        (
            1.9,
            [3.5018774351137134, 4.9133275033825505, 2.456442447723286],
        ),
    ] {
        assert!((law.force(1.0, 0.0, at) - force).abs() < 2e-15, "{at}");
        assert!(
            (law.stiffness(1.0, 0.0, at) - stiffness).abs() < 5e-15,
            "{at}"
        );
        assert!((law.energy(1.0, 0.0, at) - energy).abs() < 2e-15, "{at}");
    }
}

/// Toda's chain under a static force is Toda's chain of stiffer contacts; Hertz's among other laws is Hertz's.
#[test]
fn val_identity_precompression_and_cells() {
    let toda = |precompression: f64, factor: f64| {
        let mut chain = free(24, Law::toda(0.8));
        chain.ends = fixed(factor);
        chain.coefficient = vec![factor; 24];
        chain.precompression = precompression;
        impact(chain, 0.6, 30.0, 1e-10)
    };
    // e^{b d0} = 1 + b P / c.
    assert!(apart(&toda(2.0, 1.0), &toda(0.0, 1.0 + 0.8 * 2.0)) < 1e-10);
    for (precompression, dashpot) in [(0.0, 0.0), (0.3, 0.0), (0.0, 0.1)] {
        let of = |laws: Laws| {
            let mut chain = free(30, laws);
            chain.precompression = precompression;
            chain.losses.dashpot = dashpot;
            impact(chain, 1.0, 25.0, 1e-9)
        };
        let hertz = of(Law::Hertz.into());
        // Two-sided contacts that stay pressed, or none of which pulls: the general stepping.
        let cell = vec![Law::Hertz, Law::Power { exponent: 1.5 }];
        let mixed = of(Laws::cell(cell).unwrap());
        assert!(apart(&hertz, &mixed) < 1e-9, "{precompression}");
    }
}

/// Contacts that press, pull, open and soften in one chain: the energy closes to rounding of the tolerance, the fixed steps of
/// another method agree, and smaller steps keep the stated error.
#[test]
fn val_other_method_a_chain_of_many_laws() {
    let cell = vec![
        Law::Hertz,
        Law::polynomial(vec![1.0, 0.0, -0.1]),
        Law::Power { exponent: 1.0 },
        Law::expression("d + 0.2*d^3").unwrap(),
        Law::morse(0.7),
        Law::expression("2*d + d^2").unwrap().one_sided().unwrap(),
    ];
    for precompression in [0.0, 0.05] {
        let mut chain = free(19, Laws::cell(cell.clone()).unwrap());
        chain.precompression = precompression;
        let run = impact(chain.clone(), 0.8, 25.0, 1e-8);
        assert!(run.report.energy_drift.unwrap() < 1e-8);
        let fine = impact(chain.clone(), 0.8, 25.0, 1e-11);
        let off = apart(&run, &fine) / 0.8;
        assert!(off <= run.report.error.unwrap(), "{off:e} {:?}", run.report);
        assert!(off < 1e-8, "{off:e} {:?}", run.report);
        let mut steps = Simulation::impact(chain, 0.8, 25.0, 65);
        steps.scheme = Scheme::RungeKutta;
        steps.accuracy = Accuracy::Step(1e-3);
        let stepped = steps.run(&Silent).unwrap();
        let apart = apart(&stepped, &fine);
        assert!(apart < 1e-9, "{apart:e}");
    }
}

/// The linear chain of alternating stiffnesses about its static state: `F'(d0)` of each law.
#[test]
fn val_theory_small_waves_follow_the_stiffness_of_each_law() {
    let laws = [Law::morse(1.0), Law::polynomial(vec![2.0, 0.5])];
    let mut chain = free(2, Laws::cell(laws.to_vec()).unwrap());
    chain.precompression = 0.75;
    // Morse: e^x (e^x - 1) = 0.75 at e^x = 1.5, where F' = e^x (2 e^x - 1) = 3.
    let period = TAU * (0.5f64 / 3.0).sqrt();
    let speed = 1e-6;
    let run = impact(chain, speed, period, 1e-9);
    let last = run.velocity.row(64).to_vec();
    assert!((last[0] / speed - 1.0).abs() < 1e-6, "{last:?}");
    assert!(last[1].abs() < 1e-6 * speed, "{last:?}");
}

/// A law of the library's user: its force alone.
#[derive(Debug)]
struct Stiffening;

impl ContactLaw for Stiffening {
    fn text(&self) -> String {
        "stiffening".into()
    }

    fn force(&self, delta: Jet) -> Jet {
        delta + delta * delta * delta
    }
}

#[test]
fn val_same_force_an_own_law() {
    let [own, known] = [
        Law::Other(Arc::new(Stiffening)),
        Law::polynomial(vec![1.0, 0.0, 1.0]),
    ];
    let run = |law: &Law| impact(free(12, law.clone()), 0.7, 20.0, 1e-10);
    assert!(apart(&run(&own), &run(&known)) < 1e-10);
    for (d0, r) in [(0.0, 0.4), (0.5, -0.3), (0.5, 1e-3)] {
        let of = |law: &Law| [law.stiffness(1.0, d0, r), law.energy(1.0, d0, r)];
        let pairs = of(&own).into_iter().zip(of(&known));
        assert!(pairs.into_iter().all(|(a, b)| (a / b - 1.0).abs() < 1e-14));
    }
}

/// Energies of laws with kinks and of steep ones: closed forms, and those of the same law in other words.
#[test]
fn val_closed_form_energies_of_formulas() {
    let energy = |law: &str, d0: f64, r: f64| Law::expression(law).unwrap().energy(1.0, d0, r);
    let close = |found: f64, known: f64| {
        assert!((found / known - 1.0).abs() < 1e-13, "{found} {known}");
    };
    close(energy("min(d, 0.3)", 0.0, 1.0), 0.045 + 0.21);
    close(energy("max(d, -0.2)", 0.0, -1.0), 0.02 + 0.16);
    close(energy("max(d, 0)^1.5", 0.0, 0.7), 0.4 * 0.7f64.powf(2.5));
    close(energy("d + abs(d)", 0.5, -2.0), -0.25 + 2.0);
    let lennard_jones = |u: f64| u.powi(12) / 12.0 - u.powi(6) / 6.0 + 1.0 / 12.0;
    for d in [-0.5, 0.1, 0.6, 0.9] {
        let found = energy("(1/(1-d))^13 - (1/(1-d))^7", 0.0, d);
        close(found, lennard_jones(1.0 / (1.0 - d)));
    }
    for (d0, r) in [(0.7, 0.01), (0.7, -0.05), (0.7, 0.4)] {
        let terms = Law::polynomial(vec![1.0, -0.2, 0.3]);
        close(
            energy("d - 0.2*d^2 + 0.3*d^3", d0, r),
            terms.energy(1.0, d0, r),
        );
        let formula = Law::expression("d - 0.2*d^2 + 0.3*d^3").unwrap();
        close(formula.force(1.0, d0, r), terms.force(1.0, d0, r));
    }
}

/// A motion that runs away in finite time ends with an error that says where.
#[test]
fn motions_that_run_away_are_refused() {
    for (law, sites, speed) in [
        (spring(0.25, 0.0), 8, 3.0),
        (Law::polynomial(vec![1.0, 1.0]), 2, 3.0),
        (Law::expression("d - d^3").unwrap(), 2, 3.0),
    ] {
        let mut simulation = Simulation::impact(free(sites, law), speed, 50.0, 65);
        simulation.accuracy = Accuracy::Tolerance(1e-8);
        let error = simulation.run(&Silent).unwrap_err().to_string();
        println!("{error}");
        assert!(
            error.contains("contact ") && error.contains("overlap"),
            "{error}"
        );
    }
}

fn setup(text: &str) -> Result<Laws, Error> {
    let scene = SceneSource::new(None, format!("sites = 12\nend_time = 5.0\n{text}"));
    scene.setup().map(|setup| setup.simulation.chain.law)
}

#[test]
fn scenes_name_laws() {
    let same = |text: &str, law: Law| {
        let found = setup(text).unwrap();
        assert_eq!(found.only(), Some(&law), "{text}");
        let named = format!("law = \"{}\"", law.text());
        assert_eq!(setup(&named).unwrap().only(), Some(&law), "{named}");
    };
    same("", Law::Hertz);
    same(
        "law = \"power\"\nexponent = 1",
        Law::Power { exponent: 1.0 },
    );
    same(
        "law = \"two-sided power\"\nexponent = 2.5",
        Law::two_sided_power(2.5),
    );
    same("law = \"toda\"\nsteepness = 0.5", Law::toda(0.5));
    same(
        "law = \"polynomial 1 -0.3 0.05\"",
        Law::polynomial(vec![1.0, -0.3, 0.05]),
    );
    let beta = spring(0.0, 0.5);
    same("law = \"spring\"\nbeta = 0.5", beta.clone());
    same(
        "law = \"one-sided spring\"\nbeta = 0.5",
        beta.clone().one_sided().unwrap(),
    );
    let formula = Law::expression("d - alpha*d^2; alpha=0.3").unwrap();
    same("law = \"d - alpha*d^2\"\nalpha = 0.3", formula);
    let table = Law::table(vec![-1.0, 0.0, 2.0], vec![-2.0, 0.0, 1.0]).unwrap();
    same("law = \"table -1 -2, 0 0, 2 1\"", table);
    let cell = setup("laws = [\"d - 0.1*d^3\", \"hertz\"]\nends = \"fixed\"").unwrap();
    assert_eq!(cell.of(3), &Law::Hertz);
    assert_eq!(cell.before_first(), &Law::Hertz);
    assert_eq!(cell.text(), "d - 0.1*d^3 | hertz");
    let own = setup("law = \"spring\"\n[[defect]]\ncontact = 5\nlaw = \"hertz\"").unwrap();
    assert_eq!((own.of(5), own.of(4) == &Law::Hertz), (&Law::Hertz, false));
}

/// A measured law in a table beside the scene, in units of the laboratory; the run holds its values and no file's name.
#[test]
fn a_run_names_no_files() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write(
        "contact.csv",
        "force [N], overlap [um]\n-2, -1000\n0, 0\n3, 1000\n",
    );
    let text = "sites = 4\nunits = \"si\"\nmasses = [1.0, 1.0, 1.0, 1.0]\nlaw_file = \"contact.csv\"\n\
                striker_velocity = 0.01\nend_time = 0.1\nsamples = 9\n";
    write("scene.toml", text);
    let mut setup = SceneSource::read(&scene).unwrap().setup().unwrap();
    let measured = Law::table(vec![-1e-3, 0.0, 1e-3], vec![-2.0, 0.0, 3.0]).unwrap();
    assert_eq!(setup.simulation.chain.law.only(), Some(&measured));
    let run = setup.simulation.run(&Silent).unwrap();
    let path = folder.path().join("run.npz");
    RunFile::write(&path, false, &setup, &run, &Silent).unwrap();
    std::fs::remove_file(folder.path().join("contact.csv")).unwrap();
    let read = RunFile::read(&path).unwrap();
    assert_eq!(read.setup.simulation.chain.law.only(), Some(&measured));
    for key in [
        "law_file = \"contact.csv\"",
        "state = \"run.npz\"",
        "drive = \"force\"\ndrive_file = \"x.csv\"",
    ] {
        let text = text.replace("striker_velocity = 0.01\n", "");
        setup.text = text.replace("law_file = \"contact.csv\"", key);
        let error = RunFile::write(&path, true, &setup, &run, &Silent).unwrap_err();
        contains_all(&error.to_string(), &["a run carries the values of files"]);
    }
    write("scene.toml", &format!("law = \"hertz\"\n{text}"));
    let error = SceneSource::read(&scene).unwrap().setup().unwrap_err();
    contains_all(&error.to_string(), &["one key of `law_file` and `law`"]);
}
