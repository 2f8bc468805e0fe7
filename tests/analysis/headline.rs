//! What an analysis says first: measures that padding does not move, references, floors, the
//! passage of the front.

use ndarray::Array2;
use wavecascade::Field;
use wavecascade::analyze::{BandEdge, FrontWindow, Request, TimeRange};
use wavecascade::chain::{Chain, Simulation};

use test_support::fields::{TEMPORAL, analyzed, asking, noise, pulse, segments, struck};

/// `exp(-t)`, sampled: the cumulative spectrum up to f is `(2 / pi) atan(tan(pi f dt) / tanh(dt / 2))`,
/// and the effective bandwidth of a half Lorentzian of half width `1 / (2 pi)` is 1.
#[test]
fn val_closed_form_exponential_at_any_padding() {
    let dt = 1.0 / 256.0;
    let values = Array2::from_shape_fn((4096, 1), |(n, _)| (-dt * n as f64).exp());
    let mut field = Field::from_array(values);
    field.time.step = dt;
    let quantile = |level: f64| {
        let tangent = (0.5 * std::f64::consts::PI * level).tan();
        ((0.5 * dt).tanh() * tangent).atan() / (std::f64::consts::PI * dt)
    };
    for padding in [1_u32, 2, 4, 8, 16] {
        let request = asking(|it| it.pad_time = Some(4096 * padding as usize));
        let along = analyzed(&field, &request).along_space.unwrap();
        // Bins of 1/16 of the bandwidth are wide where nothing is padded; Nyquist's folds 4e-3.
        let coarse = if padding == 1 {
            5e-3
        } else {
            6.2e-3 / f64::from(padding)
        };
        for (found, right, tolerance) in [
            (along.median[0], quantile(0.5), coarse.max(4e-5)),
            (
                along.quantile_90[0],
                quantile(0.9),
                (0.13 * coarse).max(1e-5),
            ),
            (along.effective_bandwidth[0], 1.0, 4e-3),
        ] {
            let error = (found / right - 1.0).abs();
            assert!(
                error < tolerance,
                "padded {padding} times: {found} for {right}"
            );
        }
    }
}

/// A site of a struck dimer that the pulse has passed, padded up to 16 times: every measure but the
/// normalised entropy stays. Without f = 0 the centroid moved by a half.
#[test]
fn regress_padding_moves_no_measure_of_a_struck_chain() {
    let field = struck(60, 60.0, 1024).to_field();
    let measures = |padding: usize| {
        let request = Request {
            results: TEMPORAL,
            pad_time: Some(1024 * padding),
            band_edge_frequency: Some(0.12),
            ..Request::default()
        };
        let along = analyzed(&field, &request).along_space.unwrap();
        let of = |values: &Vec<f64>| values[10];
        [
            of(&along.centroid),
            of(&along.bandwidth),
            of(&along.effective_bandwidth),
            of(&along.quantile_90),
            of(&along.high_share),
        ]
    };
    let plain = measures(1);
    for padding in [2, 4, 8, 16] {
        for (m, (a, b)) in plain.into_iter().zip(measures(padding)).enumerate() {
            assert!(
                (b / a - 1.0).abs() < 0.01,
                "{m}, padded {padding} times: {a} {b}"
            );
        }
    }
}

#[test]
fn the_reference_of_a_run_lies_behind_what_is_struck() {
    let run = struck(60, 60.0, 1024);
    let analysis = analyzed(&run.to_field(), &Request::default());
    let edges = [analysis.frequency_edge, analysis.wavenumber_edge].map(Option::unwrap);
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
    let headline = analysis.headline_space;
    assert_eq!(headline.reference.unwrap().index, 3);
    let fourth = run.velocity.column(4);
    let largest = fourth.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let arrival = fourth.iter().position(|v| v.abs() > 0.01 * largest);
    assert_eq!(analysis.headline_time.reference.map(|s| s.index), arrival);
}

/// Noise a thousandth of the pulse, before it comes and where it has not come.
#[test]
fn the_reference_of_a_field_is_the_first_with_a_tenth_of_the_energy() {
    let (n_times, n_sites) = (600, 40);
    let moving = Array2::from_shape_fn((n_times, n_sites), |(n, j)| {
        let t = n as f64 - 200.0 - 8.0 * (j as f64 - 10.0);
        if j < 10 {
            0.0
        } else {
            (-(t / 9.0).powi(2)).exp()
        }
    });
    let values = moving + 1e-3 * noise(n_times, n_sites);
    let energy = |row: ndarray::ArrayView1<f64>| row.iter().map(|v| v * v).sum::<f64>();
    let first = |energies: Vec<f64>| {
        let largest = energies.iter().fold(0.0, |m: f64, &e| m.max(e));
        energies.iter().position(|&e| e >= 0.1 * largest).unwrap()
    };
    let site = first(values.columns().into_iter().map(energy).collect());
    let time = first(values.rows().into_iter().map(energy).collect());
    assert!(site == 10 && time > 150);
    let analysis = analyzed(&Field::from_array(values), &Request::default());
    let at = |edge: Option<BandEdge>| match edge {
        Some(BandEdge::Reference { index, .. }) => index,
        other => panic!("{other:?}"),
    };
    assert_eq!(at(analysis.frequency_edge), site);
    assert_eq!(at(analysis.wavenumber_edge), time);
    // A tenth of the energy lies above the edge at the reference, no more and no less.
    let shares = [analysis.headline_space, analysis.headline_time];
    for headline in shares {
        let share = headline.reference.unwrap().high_share.unwrap();
        assert!((share - 0.1).abs() < 1e-12, "{share}");
    }
}

#[test]
fn what_has_too_little_energy_is_undefined_and_not_the_last() {
    // Energies 1, 1e-4, ..., of which those below 1e-6 are undefined.
    let field = |factor: f64| {
        let pulse = pulse(400, 6, 20);
        let mut values = Array2::zeros((400, 6));
        pulse.read_time_major(0..400, 0..6, values.as_slice_mut().unwrap());
        for (j, mut column) in values.columns_mut().into_iter().enumerate() {
            column *= factor.powi(j as i32);
        }
        Field::from_array(values)
    };
    let analysis = analyzed(&field(0.01), &Request::default());
    let along = analysis.along_space.unwrap();
    let defined: Vec<bool> = along.centroid.iter().map(|c| c.is_finite()).collect();
    assert_eq!(defined, [true, true, false, false, false, false]);
    assert!(along.energy.iter().all(|e| *e > 0.0));
    assert!(along.high_share[2].is_nan() && along.effective_bandwidth[5].is_nan());
    assert_eq!(analysis.headline_space.last.unwrap().index, 1);
    assert!(analysis.front.unwrap().high_share[3].is_nan());

    // Below the noise where that is known; energies fall by 4.
    let plain = analyzed(&field(0.5), &Request::default());
    let energy = plain.along_space.unwrap().energy;
    // Noise with two fifths of site 3's energy is more than half of site 4's.
    let noise = (0.4 * energy[3] / 400.0).sqrt();
    let request = asking(|it| it.noise = Some(noise));
    let analysis = analyzed(&field(0.5), &request);
    let known = analysis.along_space.unwrap().centroid;
    let known: Vec<bool> = known.iter().map(|c| c.is_finite()).collect();
    assert_eq!(known, [true, true, true, true, false, false]);
}

#[test]
fn an_edge_beside_zero_is_none() {
    let values = Array2::from_shape_fn((256, 4), |(n, j)| {
        1.0 + 0.01 * (0.9 * n as f64 + j as f64).sin()
    });
    let field = Field::from_array(values);
    for pad_time in [None, Some(4096)] {
        let request = asking(|it| it.pad_time = pad_time);
        let analysis = analyzed(&field, &request);
        let Some(BandEdge::Unresolved { index, bin, .. }) = analysis.frequency_edge else {
            panic!("{:?}", analysis.frequency_edge);
        };
        assert_eq!((index, bin), (0, 1.0 / 256.0));
        let along = analysis.along_space.unwrap();
        assert!(along.high_share.iter().all(|share| share.is_nan()));
        assert!(along.centroid[0] < 0.02);
        let said = analysis
            .warnings
            .iter()
            .any(|w| w.code == "static" && w.numbers["share"].as_f64() > Some(0.99));
        assert!(said, "{:?}", analysis.warnings);
    }
    // What is given stays an edge.
    let request = asking(|it| it.band_edge_frequency = Some(0.1));
    let analysis = analyzed(&field, &request);
    assert_eq!(
        analysis.frequency_edge,
        Some(BandEdge::Given { value: 0.1 })
    );
    assert!(analysis.along_space.unwrap().high_share[0] > 0.0);
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

#[test]
fn a_front_that_does_not_fit_or_arrive_has_no_shares() {
    let field = pulse(300, 30, 12);
    let analysis = analyzed(&field, &asking(|it| it.front_window = Some(100.0)));
    let front = analysis.front.unwrap();
    let fit = front.fits.iter().filter(|fits| **fits).count();
    assert!((10..20).contains(&fit), "{fit}");
    assert_eq!(front.headline.last.map(|spot| spot.index), Some(fit - 1));
    let long = asking(|it| it.front_window = Some(301.0));
    let front = analyzed(&field, &long).front.unwrap();
    assert_eq!(front.length, None);
    assert!(front.high_share.iter().all(|share| share.is_nan()));
    let front = analyzed(&Field::from_array(noise(500, 20)), &Request::default()).front;
    assert_eq!(front.unwrap().length, None);
}

/// Long windows, for which there is no room beside whole records, and segments of Welch's method.
#[test]
fn shares_at_the_front_do_not_depend_on_how_they_are_held() {
    let field = pulse(700, 30, 12);
    let shares = |request: &Request| analyzed(&field, request).front.unwrap().high_share;
    let long = Request {
        front_window: Some(300.0),
        band_edge_frequency: Some(0.05),
        ..Request::default()
    };
    let welch = Request {
        welch: Some(segments(128, 64)),
        ..long.clone()
    };
    let (a, b) = (shares(&long), shares(&welch));
    assert!(a[0] > 0.0);
    for (a, b) in a.iter().zip(&b) {
        assert!(
            a.to_bits() == b.to_bits() || (a / b - 1.0).abs() < 1e-14,
            "{a} {b}"
        );
    }
}

#[test]
fn a_lone_site_has_no_wavenumbers_and_a_lone_time_no_frequencies() {
    let line = |shape: (usize, usize)| {
        Field::from_array(Array2::from_shape_fn(shape, |(n, j)| {
            (1.0 + (n + j) as f64).sin()
        }))
    };
    let analysis = analyzed(&line((64, 1)), &Request::default());
    assert_eq!(analysis.wavenumber_edge, Some(BandEdge::Undefined));
    let in_time = analysis.along_time.unwrap().centroid;
    assert!(in_time.iter().all(|c| c.is_nan()));
    assert!(analysis.along_space.unwrap().centroid[0] > 0.0);
    let analysis = analyzed(&line((1, 64)), &Request::default());
    assert_eq!(analysis.frequency_edge, Some(BandEdge::Undefined));
    let in_space = analysis.along_space.unwrap().centroid;
    assert!(in_space.iter().all(|c| c.is_nan()));
}

/// The front has not reached the end: no cascade is announced there. The last site held 1e-22 of the
/// largest energy, and a high share of 99.95 % was printed of it.
#[test]
fn a_site_that_the_wave_has_not_reached_is_not_the_last() {
    let field = struck(60, 48.0, 1024).to_field();
    let request = asking(|it| it.reference_site = Some(10));
    let analysis = analyzed(&field, &request);
    let along = analysis.along_space.as_ref().unwrap();
    assert!(along.centroid[59].is_nan() && along.high_share[59].is_nan());
    let headline = analysis.headline_space;
    assert!((30..55).contains(&headline.last.unwrap().index));
    // Where the record's end does not cut the passage of the front, nothing moves up much.
    assert!(headline.largest.unwrap().high_share.unwrap() < 0.2);
    assert_eq!(analysis.warnings, []);

    // A record so short that its end cuts the passage at the reference, too.
    let short = analyzed(&struck(60, 36.0, 1024).to_field(), &request);
    assert!(short.headline_space.largest.is_none());
}
