//! Curves of attenuation and transmission: independence of irrelevant inputs, and known results.

use wavecascade::Error;
use wavecascade::attenuation::{
    Attenuation, AttenuationLaw, AttenuationRequest, ContactKind, Named, Reach, Sense, StopCause,
    Transmission, TransmissionRequest,
};
use wavecascade::chain::scene::{SceneSource, Setting};
use wavecascade::observer::{Observer, Silent};

fn scene(text: &str) -> SceneSource {
    SceneSource::new(None, text)
}

fn dimer(kappa: f64) -> Named {
    Named {
        name: format!("ratio {kappa}"),
        scene: scene(&format!("sites = 41\nstiffness_ratio = {kappa}")),
    }
}

fn request(chains: Vec<Named>) -> AttenuationRequest {
    AttenuationRequest {
        chains,
        length: 30,
        lengths: Some(vec![1, 2, 3, 10, 20, 30]),
        ..AttenuationRequest::default()
    }
}

fn run(request: &AttenuationRequest) -> Attenuation {
    request.run(None, &Silent).unwrap()
}

fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.unwrap().install(work)
}

fn text(of: &impl serde::Serialize) -> String {
    serde_json::to_string(of).unwrap()
}

/// Threads, the scene's samples and end time, and saved members change no bit.
#[test]
fn regress_curves_depend_on_nothing_else() {
    let chains = || vec![dimer(1.0), dimer(2.4)];
    let alone = with_threads(1, || run(&request(chains())));
    for threads in [2, 4] {
        assert_eq!(
            text(&with_threads(threads, || run(&request(chains())))),
            text(&alone)
        );
    }
    let mut sampled = chains();
    for named in &mut sampled {
        let settings = [("samples", "77"), ("end_time", "3.0"), ("record", "")];
        named.scene = named.scene.with(settings.map(|(key, text)| Setting {
            key: key.into(),
            text: text.into(),
            source: key.into(),
        }));
    }
    let other = run(&request(sampled));
    for (a, b) in alone.curves.iter().zip(&other.curves) {
        assert_eq!(text(&a.rows), text(&b.rows));
    }
    let place = tempfile::tempdir().unwrap();
    let kept = place.path().join("kept");
    let first = request(chains()).run(Some(&kept), &Silent).unwrap();
    let again = request(chains()).run(Some(&kept), &Silent).unwrap();
    assert!(first.computed > 0 && again.computed == 0);
    assert_eq!((text(&first), text(&again)), (text(&alone), text(&alone)));
    // A saved file with half of the members, in reverse order.
    let members = kept.join("members.jsonl");
    let lines = std::fs::read_to_string(&members).unwrap();
    let mut half: Vec<&str> = lines.lines().rev().step_by(2).collect();
    half.push("");
    std::fs::write(&members, half.join("\n")).unwrap();
    let mended = request(chains()).run(Some(&kept), &Silent).unwrap();
    assert!(mended.computed > 0 && mended.computed < first.computed);
    assert_eq!(text(&mended), text(&alone));
    // The order of the chains changes only the order of the curves.
    let swapped = run(&request(vec![dimer(2.4), dimer(1.0)]));
    assert_eq!(text(&swapped.curves[0].rows), text(&alone.curves[2].rows));
    // A file saved for another request is refused.
    let error = request(vec![dimer(3.0)])
        .run(Some(&kept), &Silent)
        .unwrap_err();
    assert!(error.is_usage(), "{error}");
    assert!(
        error.to_string().contains("it differs in scenes"),
        "{error}"
    );
}

/// The homogeneous chain is its own reference. The localized dimer settles and the dispersive one
/// falls, at both lengths, before a wall as within the chain.
#[test]
fn val_paper_localized_settles_and_dispersive_falls() {
    let mut request = request(vec![dimer(1.0), dimer(2.4), dimer(4.9272)]);
    request.length = 100;
    request.target = Some(0.4);
    let found = run(&request);
    assert!(found.failed.is_empty());
    let curve = |i: usize| &found.curves[i];
    let force = |i: usize, n: usize| {
        let row = curve(i).rows.iter().find(|row| row.bodies == n);
        row.unwrap().relative_force.unwrap()
    };
    assert!(
        curve(0)
            .rows
            .iter()
            .all(|row| row.relative_force == Some(1.0))
    );
    assert_eq!(
        curve(0).fits.as_ref().unwrap().chosen().law,
        AttenuationLaw::Level
    );
    let settled = (force(4, 100) / force(4, 60) - 1.0).abs();
    assert!(settled < 1e-7, "{settled:e}");
    assert!((force(4, 100) - 0.725919).abs() < 1e-6);
    let reach = curve(4).reach;
    assert!(matches!(reach, Some(Reach::Never { .. })), "{reach:?}");
    // Beyond 60 bodies the largest force moves from pulse to pulse.
    for n in [0, 20, 40] {
        assert!(force(2, n + 20) < 0.75 * force(2, n), "{n}");
    }
    assert!((0.2..0.36).contains(&force(2, 100)));
    let Some(Reach::Within { bodies }) = curve(2).reach else {
        panic!("{:?}", curve(2).reach);
    };
    assert!(force(2, bodies) <= 0.4, "{bodies}");
    assert!(force(2, bodies - 2) > 0.4, "{bodies}");
    assert!((50..56).contains(&bodies), "{bodies}");
    for (i, sense) in [(2, Sense::Chain), (3, Sense::Wall)] {
        assert_eq!(curve(i).sense, sense);
        assert!(curve(i).stop.is_none());
    }
    // Shares of the high band: only the dispersive chain keeps one along the way.
    let share = |i: usize| curve(i).rows[20].high_share.unwrap();
    assert!(share(2) > 3.0 * share(4).abs() && share(2) > 3.0 * share(0).abs());
    assert_eq!(curve(2).rows[20].kind, ContactKind::Soft);
    assert_eq!(curve(2).rows[21].kind, ContactKind::Stiff);
}

/// The length that reaches a target is one that was run, up to half as long again as was asked for.
#[test]
fn val_construction_lengths_beyond_the_curve_are_run() {
    // By simulation of longer chains: 0.4 after 52 bodies, 0.2 within no 198.
    for (bodies, target, expected) in [
        (60, 0.4, Reach::Within { bodies: 52 }),
        (44, 0.4, Reach::Within { bodies: 52 }),
        (24, 0.4, Reach::Beyond { bodies: 36 }),
        (60, 0.2, Reach::Beyond { bodies: 90 }),
    ] {
        let mut request = request(vec![dimer(2.398)]);
        (request.length, request.target) = (bodies, Some(target));
        request.senses = vec![Sense::Chain];
        assert_eq!(run(&request).curves[0].reach, Some(expected), "{bodies}");
    }
}

/// A scene that lists its coefficients has a fixed length: its curve reports where it stops.
#[test]
fn a_curve_of_a_chain_of_fixed_length_stops_and_says_where() {
    let list: Vec<String> = (0..31).map(|j| ["1.0", "2.4"][j % 2].to_owned()).collect();
    let text = format!("sites = 31\ncoefficients = [{}]", list.join(", "));
    let named = Named {
        name: "listed".into(),
        scene: scene(&text),
    };
    let found = run(&request(vec![named, dimer(2.4)]));
    let (listed, free) = (&found.curves[0], &found.curves[2]);
    let stop = listed.stop.unwrap();
    assert_eq!(stop.cause, StopCause::Reflection);
    let stopped = stop.bodies;
    assert!((20..31).contains(&stopped), "{stopped}");
    assert!(listed.rows.len() == stopped, "{stopped}");
    assert_eq!(free.stop, None);
    for (a, b) in listed.rows.iter().zip(&free.rows) {
        let off = a.pulse.peak_force.value / b.pulse.peak_force.value - 1.0;
        assert_eq!(off, 0.0, "{}", a.bodies);
    }
}

fn transmission(over: &str, vary: &[&str]) -> Transmission {
    let mut request = TransmissionRequest::new(scene("sites = 21\nstiffness_ratio = 2.0"), over);
    request.vary = vary.iter().map(|v| (*v).to_owned()).collect();
    request.run(None, &Silent).unwrap()
}

/// The minimum between two localized ratios is the same from any grid, and no grid value is below
/// it. The localized ratios are those of the travelling-wave equation.
#[test]
fn val_extremes_are_located_and_not_read_off_a_grid() {
    let coarse = transmission("stiffness_ratio=1:16:9log", &[]);
    let fine = transmission("stiffness_ratio=1.3:12:31", &[]);
    let least = |t: &Transmission| {
        let mut minima = t.curves[0].extremes.iter().filter(|e| !e.is_maximum);
        let first = minima.next().copied().unwrap();
        assert!(minima.next().is_none());
        first
    };
    let (a, b) = (least(&coarse), least(&fine));
    let off = (a.point.value - b.point.value).abs();
    assert!(
        off < 1e-5 && off <= 4.0 * (a.value_error + b.value_error),
        "{off:e} {a:?}"
    );
    let off = (a.point.relative_force - b.point.relative_force).abs();
    assert!(off < 5e-12, "{off:e}");
    let lowest = fine.curves[0].points.iter().map(|p| p.relative_force);
    assert!(lowest.fold(f64::INFINITY, f64::min) >= b.point.relative_force);
    let marks: Vec<(usize, f64)> = coarse.curves[0]
        .localized
        .iter()
        .map(|m| (m.order, m.value))
        .collect();
    assert_eq!(marks.len(), 3);
    for ((order, value), (n, truth)) in
        marks
            .iter()
            .zip([(1, 1.0), (2, 4.927_226_808_384), (3, 14.622_100_247_347)])
    {
        assert_eq!(*order, n);
        assert!((value / truth - 1.0).abs() < 1e-12, "{order}: {value}");
    }
}

/// Other lengths and losses give curves of their own, the same for any number of threads.
#[test]
fn regress_combinations_and_threads() {
    let vary = ["sites=11,21", "tangent=0,0.05"];
    let alone = with_threads(1, || transmission("stiffness_ratio=1:8:5", &vary));
    let together = with_threads(4, || transmission("stiffness_ratio=1:8:5", &vary));
    assert_eq!(text(&alone), text(&together));
    assert_eq!(alone.curves.len(), 4);
    let force = |i: usize| alone.curves[i].points[2].peak_force.value;
    assert!(force(1) < force(0) && force(3) < force(2));
    let speed = alone.curves[0].points[0];
    assert!((speed.mean_speed * speed.time_of_flight.value - 10.0).abs() < 1e-14);
}

/// A cancelled computation stops, and saves its results where it has a directory.
#[test]
fn an_observer_stops_it() {
    struct Stop;
    impl Observer for Stop {
        fn cancelled(&self) -> bool {
            true
        }
    }
    let place = tempfile::tempdir().unwrap();
    let request = request(vec![dimer(2.4)]);
    assert!(matches!(request.run(None, &Stop), Err(Error::Cancelled)));
    let stopped = request.run(Some(&place.path().join("kept")), &Stop);
    assert!(
        matches!(stopped, Err(Error::Paused { known: 0, .. })),
        "{stopped:?}"
    );
}

/// Relative forces on a wall behind one, two and three bodies, against chains built by hand. The
/// reference is the homogeneous chain of the whole pattern, of which such short chains hold only a
/// part.
#[test]
fn val_walls_behind_few_bodies() {
    use wavecascade::attenuation::pulses;
    use wavecascade::chain::{Chain, EndTime, Simulation};

    let mut asked = request(vec![dimer(4.9272)]);
    asked.senses = vec![Sense::Wall];
    asked.lengths = Some(vec![1, 2, 3]);
    let found = run(&asked);
    let kinds = [ContactKind::Stiff, ContactKind::Soft, ContactKind::Stiff];
    assert!((found.curves[0].stiffness_ratio - 4.9272).abs() < 1e-12);
    for (row, kind) in found.curves[0].rows.iter().zip(kinds) {
        let force = |kappa: f64| {
            let chain = Chain::dimer(row.bodies + 1, kappa);
            let simulation = Simulation {
                end_time: EndTime::Arrival,
                ..Simulation::impact(chain, 1.0, 1.0, 2)
            };
            let found = pulses(&simulation, Sense::Wall, &Silent).unwrap();
            found.pulses[0].peak_force.value
        };
        let truth = force(4.9272) / force(1.0);
        let off = (row.relative_force.unwrap() / truth - 1.0).abs();
        assert!(off < 1e-12, "{}: {off:e}", row.bodies);
        assert_eq!(row.kind, kind, "{}", row.bodies);
        assert!((truth - 1.0).abs() > 0.01);
    }
    // The same with a striker and a wall of other material: the homogeneous chain is its own
    // reference.
    let text = "sites = 9\nmaterial = \"quartz\"\nradius = \"9 mm\"\nlength = \"18 mm\"\nangle = 90.0\n\
                second_angle = 90.0\nstriker_radius = \"9 mm\"\nstriker_velocity = 0.88\n\
                wall_material = \"steel\"\nwall_radius = \"20 mm\"";
    asked.chains = vec![Named {
        name: "own".into(),
        scene: scene(text),
    }];
    let found = run(&asked);
    let rows = &found.curves[0].rows;
    assert_eq!(rows.len(), 3);
    assert!(rows.iter().all(|row| row.relative_force == Some(1.0)));
    assert!(rows.iter().all(|row| row.kind == ContactKind::Other));
}

/// Hertz scaling: the relative force does not depend on the impact speed. Rounding may make the
/// stepper repeat a step at one speed and not at another; no extreme of that is reported.
#[test]
fn val_hertz_scaling_has_no_extremes() {
    let request = TransmissionRequest::new(
        scene("sites = 10\nstiffness_ratio = 3.0"),
        "striker_velocity=1:2:8",
    );
    let curve = &request.run(None, &Silent).unwrap().curves[0];
    assert_eq!(curve.points.len(), 8);
    assert!(curve.extremes.is_empty(), "{:?}", curve.extremes);
    for point in &curve.points {
        let off = (point.relative_force / curve.points[0].relative_force - 1.0).abs();
        assert!(off < 5e-13, "{}: {off:e}", point.value);
    }
}

/// Where losses absorb the pulse nothing arrives, and the result says so.
#[test]
fn what_does_not_arrive_is_listed() {
    let request =
        TransmissionRequest::new(scene("sites = 60\nstiffness_ratio = 2.0"), "drag=0,0.001,2");
    let curve = &request.run(None, &Silent).unwrap().curves[0];
    assert_eq!((curve.points.len(), &curve.nothing_at[..]), (2, &[2.0][..]));
    let mut eaten = self::request(vec![dimer(2.0)]);
    eaten.chains[0].scene = scene("sites = 41\nstiffness_ratio = 2.0\ndrag = 2.0");
    eaten.senses = vec![Sense::Chain];
    let found = run(&eaten);
    let stop = found.curves[0].stop.unwrap();
    assert_eq!(stop.cause, StopCause::Faded);
}

/// The localized ratios of high orders are marked as far as the abscissa goes.
#[test]
fn val_travelling_wave_equation_marks_up_to_order_19() {
    let request = TransmissionRequest {
        locate: false,
        ..TransmissionRequest::new(
            scene("sites = 5\nstiffness_ratio = 2.0"),
            "stiffness_ratio=1:2000:4log",
        )
    };
    let curve = &request.run(None, &Silent).unwrap().curves[0];
    let orders: Vec<usize> = curve.localized.iter().map(|m| m.order).collect();
    assert_eq!(orders, (1..=19).collect::<Vec<_>>());
    assert!((curve.localized[17].value / 1440.05492 - 1.0).abs() < 1e-9);
    assert!(curve.unresolved_orders.is_empty());
}
