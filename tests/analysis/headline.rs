//! What an analysis says first: the reference of a run, and the
//! passage of the front.

use wavecascade::analyze::{BandEdge, FrontWindow, Request, TimeRange};
use wavecascade::chain::{Chain, Simulation};

use test_support::fields::{analyzed, pulse, struck};

#[test]
fn the_reference_of_a_run_lies_behind_what_is_struck() {
    let run = struck(60, 60.0, 1024);
    let analysis = analyzed(&run.to_field(), &Request::default());
    let edges = [analysis.along_space, analysis.along_time].map(|of| of.unwrap().edge);
    let places = edges.map(|edge| match edge {
        BandEdge::Reference { index, .. } | BandEdge::Unresolved { index, .. } => index,
        other => panic!("{other:?}"),
    });
    // When the tenth body first moves at a hundredth of its largest velocity.
    let tenth = run.velocity.column(10);
    let largest = tenth.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let arrival = tenth.iter().position(|v| v.abs() > 0.01 * largest).unwrap();
    assert_eq!(places, [1, arrival]);

    // Three bodies start; a chain of eight, whose quarter is two.
    let mut simulation = Simulation::impact(Chain::dimer(8, 2.0), 1.0, 6.0, 256);
    simulation.velocity[2] = 0.5;
    let run = simulation.run(&wavecascade::observer::Silent).unwrap();
    let analysis = analyzed(&run.to_field(), &Request::default());
    let headline = analysis.along_space.unwrap().headline;
    assert_eq!(headline.reference.unwrap().index, 3);
    let fourth = run.velocity.column(4);
    let largest = fourth.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let arrival = fourth.iter().position(|v| v.abs() > 0.01 * largest);
    let headline = analysis.along_time.unwrap().headline;
    assert_eq!(headline.reference.map(|s| s.index), arrival);
}

/// Of a pulse that travels unchanged shares at the front are the same at all sites, and those of an
/// analysis of these times alone.
#[test]
fn val_shares_at_the_front_are_those_of_its_times() {
    let field = pulse(700, 30, 12);
    let request = |window| Request {
        band_edge_frequency: Some(0.05),
        front_window: window,
        ..Request::default()
    };
    let analysis = analyzed(&field, &request(Some(120.0)));
    let front = analysis.front.unwrap();
    assert_eq!(
        front.length,
        Some(FrontWindow {
            window: 120.0,
            samples: 120,
            pulse_width: None
        })
    );
    for (j, fits) in front.fits.iter().enumerate() {
        let start = front.arrival[j];
        assert_eq!(start, front.arrival[0] + 12.0 * j as f64);
        assert_eq!(*fits, start + 120.0 <= 700.0);
        assert_eq!(front.high_share[j].is_nan(), !fits);
    }
    let fit = front.fits.iter().filter(|fits| **fits).count();
    assert_eq!((fit, front.fits.len()), (30, 30));
    for share in &front.high_share {
        assert!((share / front.high_share[0] - 1.0).abs() < 1e-13);
    }
    let part = Request {
        sites: Some(7..8),
        times: TimeRange::Interval {
            from: front.arrival[7],
            to: front.arrival[7] + 119.0,
        },
        ..request(Some(100.0))
    };
    let alone = analyzed(&field, &part).along_space.unwrap().high_share[0];
    assert!((front.high_share[7] / alone - 1.0).abs() < 1e-12, "{alone}");

    // Ten widths of the pulse, which is symmetric.
    let by_pulse = analyzed(&field, &request(None)).front.unwrap();
    let FrontWindow {
        samples,
        pulse_width,
        ..
    } = by_pulse.length.expect("a pulse");
    let shape = |t: f64| (-(t / 6.0_f64).powi(2)).exp() * (1.0 + 0.4 * (1.1 * t).cos()) / 1.4;
    let width = pulse_width.unwrap();
    assert_eq!(samples, (10.0 * width).round() as usize);
    // Linear between samples, of which there are few here.
    assert!((shape(0.5 * width) / 0.5 - 1.0).abs() < 0.05, "{width}");
}
