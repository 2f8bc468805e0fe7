//! Averages in parts are those of the whole but for rounding, however the segments are cut.

mod blocks;

use ndarray::Array2;
use test_support::fields::averaging;
use test_support::{changed, contains_all};
use wavecascade::estimates::{
    Averaging, BlockPlace, Coherence, CoherenceRequest, Combined, DividedRequest, Part, Partial,
    SpectrumEstimate, SpectrumRequest, Tapers, coherence, combine, join, partial, partial_of_block,
    spectrum,
};
use wavecascade::observer::Silent;
use wavecascade::prepare::{Detrend, Gaps};
use wavecascade::{Error, Field};

/// Noise with a slow swing and an offset, 11 sites of an odd number of samples.
fn shots(count: usize, samples: usize) -> Vec<Field> {
    let shot = |shot: usize| {
        let values = Array2::from_shape_fn((samples, 11), |(n, j)| {
            let hashed = (n * 7919 + j * 104_729 + shot * 1_299_709) as u64;
            let mixed = hashed.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
            let noise = mixed as f64 / f64::from(1 << 24) - 0.5;
            3.0 + j as f64 * noise + (0.01 * n as f64).sin()
        });
        let mut field = Field::from_array(values);
        field.time.step = 1e-3;
        field.name = format!("shot{shot}");
        field
    };
    (0..count).map(shot).collect()
}

fn welch(segment: usize, overlap: usize) -> SpectrumRequest {
    SpectrumRequest {
        averaging: averaging(segment, overlap),
        has_jackknife: false,
        ..SpectrumRequest::default()
    }
}

fn multitaper(segment: usize) -> SpectrumRequest {
    SpectrumRequest {
        averaging: slepian(segment, segment / 3, 3.0, 4),
        ..welch(segment, 0)
    }
}

fn parts_of(fields: &[&Field], request: &DividedRequest, of: usize) -> Vec<Partial> {
    let part = |number| {
        let part = Part::new(number, of).unwrap();
        partial(fields, request, part, &Silent).unwrap()
    };
    (1..=of).map(part).collect()
}

/// The numbers of what parts make.
fn combined(parts: &[Partial]) -> Vec<f64> {
    match combine(parts, None, None).unwrap() {
        Combined::Spectrum(found) => spectrum_numbers(&found),
        Combined::Coherence(found) => coherence_numbers(&found),
    }
}

/// That numbers are the same but for rounding; those of delays and intervals follow from others.
#[track_caller]
fn assert_near(a: &[f64], b: &[f64]) {
    assert_eq!(a.len(), b.len());
    let is_near = |(a, b): (&f64, &f64)| {
        (a - b).abs() <= 1e-12 * b.abs().max(1e-300) || (a.is_nan() && b.is_nan())
    };
    let far = a.iter().zip(b).find(|pair| !is_near(*pair));
    assert!(far.is_none(), "{far:?}");
}

fn spectrum_numbers(found: &SpectrumEstimate) -> Vec<f64> {
    let test = found.line_test.as_ref().map(|test| &test.statistic);
    let arrays = [&found.spectrum, &found.degrees, &found.low, &found.high];
    let arrays = arrays.into_iter().chain(test).flatten();
    let segments = found.independence.segments as f64;
    arrays
        .chain(&found.steadiness)
        .chain(&[segments])
        .copied()
        .collect()
}

fn coherence_numbers(found: &Coherence) -> Vec<f64> {
    let delays = found.delays.iter().flatten();
    let numbers = delays.flat_map(|delay| [delay.delay, delay.error]);
    let arrays = [
        &found.coherence,
        &found.phase,
        &found.phase_interval,
        &found.spectrum,
    ];
    let arrays = arrays.into_iter().flatten().copied();
    let numbers = arrays.chain(numbers);
    numbers.chain([found.independence.steadiness]).collect()
}

/// The numbers of the whole.
fn whole(fields: &[&Field], request: &DividedRequest) -> Vec<f64> {
    match request {
        DividedRequest::Spectrum(it) => spectrum_numbers(&spectrum(fields, it, &Silent).unwrap()),
        DividedRequest::Coherence(it) => {
            coherence_numbers(&coherence(fields, it, &Silent).unwrap())
        }
    }
}

fn referred(reference: usize, averaging: Averaging) -> DividedRequest {
    let request = CoherenceRequest {
        reference,
        averaging,
        ..CoherenceRequest::default()
    };
    request.into()
}

fn slepian(segment: usize, overlap: usize, nw: f64, count: usize) -> Averaging {
    Averaging {
        tapers: Tapers::Slepian { nw, count },
        ..averaging(segment, overlap)
    }
}

#[test]
fn regress_parts_are_those_of_the_whole() {
    let untouched = changed(welch(40, 39), |it| it.averaging.detrend = Detrend::None);
    for (records, samples, request) in [
        (1, 1001, welch(64, 32).into()),
        (3, 777, welch(50, 17).into()),
        (1, 1203, multitaper(128).into()),
        (2, 501, multitaper(501).into()),
        (1, 300, untouched.into()),
        (1, 1001, referred(9, averaging(60, 31))),
        (3, 301, referred(0, averaging(60, 31))),
        (2, 501, referred(0, slepian(60, 31, 2.0, 3))),
    ] {
        let fields = shots(records, samples);
        let fields: Vec<&Field> = fields.iter().collect();
        let expected = whole(&fields, &request);
        // Of two records of one segment each there are no more parts.
        let is_whole = matches!(&request, DividedRequest::Spectrum(it) if it.averaging.segment == Some(samples));
        let most = if is_whole { records } else { 7 };
        for of in [1, 2, 3, 7].into_iter().filter(|of| *of <= most) {
            let mut parts = parts_of(&fields, &request, of);
            parts.rotate_left(of / 2);
            parts.reverse();
            assert_near(&combined(&parts), &expected);
        }
        if let DividedRequest::Spectrum(it) = &request {
            let without = spectrum(&fields, it, &Silent).unwrap();
            assert!(without.jackknife.iter().all(|v| v.is_nan()));
            let with = changed(it.clone(), |it| it.has_jackknife = true);
            assert_near(&whole(&fields, &with.into()), &expected);
        }
    }
}

/// Masked samples leave as much in all parts, which withhold intervals as the whole does; without it all 363 would be stated.
#[test]
fn regress_parts_of_filled_records_have_the_intervals_of_the_whole() {
    let mut samples = vec![0.0; 4000 * 11];
    shots(1, 4000)[0].read_time_major(0..4000, 0..11, &mut samples);
    samples.iter_mut().step_by(149).for_each(|v| *v = f64::NAN);
    let field = Field::from_array(Array2::from_shape_vec((4000, 11), samples).unwrap());
    let request = changed(welch(64, 32), |it| it.gaps = Gaps::Mask);
    let whole = spectrum(&[&field], &request, &Silent).unwrap();
    let parts = parts_of(&[&field], &request.into(), 3);
    let Combined::Spectrum(joined) = combine(&parts, None, None).unwrap() else {
        panic!("spectra");
    };
    let stated = |found: &SpectrumEstimate| {
        let high = found.high.iter().filter(|v| v.is_finite());
        [high.clone().count() as f64, high.sum::<f64>()]
    };
    let [whole, joined] = [&whole, &joined].map(stated);
    assert!(whole[0] > 10.0 && whole[0] < 340.0, "{whole:?}");
    for (a, b) in whole.into_iter().zip(joined) {
        assert!((a / b - 1.0).abs() < 0.25, "{a} {b}");
    }
}

/// Samples outside of a part are not read: here they are not finite.
#[test]
fn regress_a_part_reads_its_own_samples_alone() {
    let whole = shots(1, 1000);
    let mut values = Array2::from_elem((1000, 11), f64::NAN);
    let mut samples = vec![0.0; 11_000];
    whole[0].read_time_major(0..1000, 0..11, &mut samples);
    // Of 30 segments of 64 samples every 32, segments 10 to 19 reach samples 320 to 671.
    for n in 320..672 {
        for j in 0..11 {
            values[[n, j]] = samples[n * 11 + j];
        }
    }
    let mut cut = Field::from_array(values);
    (cut.time.step, cut.name) = (1e-3, "shot0".into());
    let request = DividedRequest::from(welch(64, 32));
    let part = Part::new(2, 3).unwrap();
    let found = partial(&[&cut], &request, part, &Silent).unwrap();
    assert_eq!(found.about.range, [10, 20]);
    assert_eq!(
        found,
        partial(&[&whole[0]], &request, part, &Silent).unwrap()
    );
    // A gap at the cut cannot be filled from one side.
    samples[671 * 11 + 4] = f64::NAN;
    let mut gappy = Field::from_array(Array2::from_shape_vec((1000, 11), samples).unwrap());
    gappy.time.step = 1e-3;
    let filled = changed(welch(64, 32), |it| it.gaps = Gaps::Interpolate);
    let error = partial(&[&gappy], &filled.into(), part, &Silent).unwrap_err();
    contains_all(&error.to_string(), &["time row 671, site 4"]);
}

#[test]
fn regress_what_is_missing_twice_or_foreign_is_named() {
    let fields = shots(1, 500);
    let fields: Vec<&Field> = fields.iter().collect();
    let request = DividedRequest::from(welch(64, 32));
    let parts = parts_of(&fields, &request, 5);
    let foreign = parts_of(&fields, &welch(64, 30).into(), 5);
    let said = |parts: &[&Partial]| {
        let parts: Vec<Partial> = parts.iter().map(|part| (*part).clone()).collect();
        let error = combine(&parts, None, None).unwrap_err();
        assert!(matches!(
            error,
            Error::Request {
                option: "merge",
                ..
            }
        ));
        error.to_string()
    };
    let [a, b, c, d, e] = &parts[..] else {
        panic!("five parts");
    };
    assert!(
        said(&[a, c, d]).contains("no part 2/5"),
        "{}",
        said(&[a, c, d])
    );
    assert!(said(&[b, d, e]).contains("no part 1/5"));
    assert!(said(&[a, b, c, d]).contains("no part 5/5"));
    assert!(said(&[a, b, b, c, d, e]).contains("in part 2/5 and part 2/5"));
    let text = said(&[a, b, c, d, &foreign[4]]);
    contains_all(&text, &["overlap 30 in place of 32 in part 5/5"]);
    assert!(said(&[]).contains("none"));
    // Parts of different cuts may be combined.
    let halves = parts_of(&fields, &request, 2);
    let quarters = parts_of(&fields, &request, 4);
    combine(
        &[halves[1].clone(), quarters[0].clone(), quarters[1].clone()],
        None,
        None,
    )
    .unwrap();
    // What no part can hold.
    let part = Part::new(1, 2).unwrap();
    for refused in [
        changed(welch(64, 32), |it| it.has_jackknife = true),
        SpectrumRequest {
            along: wavecascade::estimates::FieldAxis::Space,
            ..welch(8, 4)
        },
        welch(500, 0),
    ] {
        let error = partial(&fields, &refused.into(), part, &Silent).unwrap_err();
        assert!(matches!(error, Error::Request { .. }), "{error}");
    }
    assert!(Part::new(0, 2).is_err() && Part::new(3, 2).is_err());
}
