//! The noise of each site against constructed fields whose noise is known, and what subtracting it leaves.

use ndarray::{Array2, s};
use test_support::changed;
use test_support::fields::{TEMPORAL, noise, segments, struck};
use wavecascade::Field;
use wavecascade::analyze::{Request, Results, analyze};
use wavecascade::estimates::{
    Averaging, NoiseFloor, NoiseSource, SpectrumEstimate, SpectrumRequest, spectrum,
};
use wavecascade::observer::Silent;

const SITES: usize = 200;
const TIMES: usize = 4096;

/// Noise under a Gaussian of this width in samples: no energy at the top of the axis.
fn smooth(values: &Array2<f64>, width: f64) -> Array2<f64> {
    let reach = (6.0 * width) as isize;
    let kernel: Vec<f64> = (-reach..=reach)
        .map(|n| (-0.5 * (n as f64 / width).powi(2)).exp())
        .collect();
    let power: f64 = kernel.iter().map(|w| w * w).sum();
    let times = values.nrows() - 2 * reach as usize;
    let mut out = Array2::zeros((times, values.ncols()));
    for (lag, weight) in kernel.iter().enumerate() {
        out.scaled_add(
            weight / power.sqrt(),
            &values.slice(s![lag..lag + times, ..]),
        );
    }
    out
}

/// Root mean square of the noise of a site.
fn level(j: usize) -> f64 {
    0.02 * (1.0 + j as f64 / 50.0)
}

/// Motion with a spectrum that ends below a quarter of the axis, and white noise.
fn steady() -> [Array2<f64>; 2] {
    let both = noise(2 * TIMES + 48, SITES);
    let motion = smooth(&both.slice(s![..TIMES + 48, ..]).to_owned(), 4.0);
    let floor = both.slice(s![TIMES + 48.., ..]);
    let floor = Array2::from_shape_fn((TIMES, SITES), |(n, j)| level(j) * floor[[n, j]]);
    [motion, floor]
}

fn found(values: Array2<f64>, subtract_noise: bool) -> SpectrumEstimate {
    let mut field = Field::from_array(values);
    field.time.step = 0.5;
    let request = SpectrumRequest {
        averaging: changed(Averaging::default(), |it| it.segment = Some(256)),
        subtract_noise,
        ..SpectrumRequest::default()
    };
    spectrum(&[&field], &request, &Silent).unwrap()
}

/// In how many of the sites the interval holds the true density, of a step of 0.5.
fn held(noise: &NoiseFloor) -> usize {
    let holds = |(j, site): (usize, &Option<_>)| {
        let site: &wavecascade::estimates::SiteNoise = site.as_ref().unwrap();
        (site.low..site.high).contains(&(2.0 * 0.5 * level(j).powi(2)))
    };
    noise
        .sites
        .iter()
        .enumerate()
        .filter(|site| holds(*site))
        .count()
}

#[test]
fn val_the_floor_of_steady_records_is_within_its_interval() {
    let [motion, floor] = steady();
    let noise = found(&motion + &floor, false).noise.unwrap();
    assert_eq!(noise.known(), SITES);
    let held = held(&noise);
    // 190 of 200, with a standard deviation of 3.1.
    assert!((183..=197).contains(&held), "{held}");
    let one = noise.sites[0].unwrap();
    assert!(matches!(one.source, NoiseSource::Top { from } if (from - 0.5).abs() < 0.02));
    assert!(one.high / one.low < 1.25, "{one:?}");
    // A line at the top is none of it.
    let mut with_line = &motion + &floor;
    for (n, mut row) in with_line.rows_mut().into_iter().enumerate() {
        row.mapv_inplace(|v| v + 0.05 * (2.5 * n as f64).sin());
    }
    let lines = found(with_line, false).noise.unwrap();
    assert_eq!(lines.known(), SITES);
    let change = lines.sites[100].unwrap().density / noise.sites[100].unwrap().density - 1.0;
    assert!(change.abs() < 0.1, "{change}");
}

#[test]
fn val_the_floor_before_the_arrival_is_within_its_interval() {
    let floor = noise(TIMES, SITES);
    let values = Array2::from_shape_fn((TIMES, SITES), |(n, j)| {
        let t = n as f64 - 1200.0 - 4.0 * j as f64;
        (-(t / 20.0).powi(2)).exp() * (0.3 * t).cos() + level(j) * floor[[n, j]]
    });
    let noise = found(values, false).noise.unwrap();
    assert_eq!(noise.known(), SITES);
    let held = held(&noise);
    assert!((183..=197).contains(&held), "{held}");
    let samples = |j: usize| match noise.sites[j].unwrap().source {
        NoiseSource::LeadIn { samples } => samples,
        NoiseSource::Top { .. } => 0,
    };
    // Most of what there is: 1150 samples at the first site, 1950 at the last.
    assert!((900..1150).contains(&samples(0)), "{}", samples(0));
    assert!((1600..1950).contains(&samples(SITES - 1)));
}

/// Spectra that fall as a power of the frequency, one of them flattened at its end by the sampling; a chain at
/// rest before the front.
#[test]
fn val_a_cascade_is_no_noise() {
    let white = noise(TIMES, 48);
    let walk = |values: &Array2<f64>, keep: f64| {
        let mut out = values.clone();
        for n in 1..TIMES {
            let before = out.row(n - 1).to_owned();
            out.row_mut(n).scaled_add(keep, &before);
        }
        out
    };
    let once = walk(&white, 0.999);
    let twice = walk(&once, 0.999);
    for (what, values) in [("walk", &once), ("smoother", &twice)] {
        for sites in [1, 4, 48] {
            let noise = found(values.slice(s![.., ..sites]).to_owned(), false)
                .noise
                .unwrap();
            assert_eq!(noise.known(), 0, "{what} {sites}: {:?}", noise.median());
        }
    }
    // Sawteeth with random slopes, f^-2.
    let teeth = Array2::from_shape_fn((TIMES, 16), |(n, j)| {
        let phase = n as f64 / (87.3 + j as f64) + 0.37 * j as f64;
        2.0 * (phase - phase.floor()) - 1.0
    });
    let known = found(teeth, false).noise.unwrap().known();
    assert_eq!(known, 0, "sawteeth");
    let run = struck(40, 80.0, 1024).to_field();
    let noise = spectrum(&[&run], &SpectrumRequest::default(), &Silent)
        .unwrap()
        .noise
        .unwrap();
    assert_eq!(noise.known(), 0, "{:?}", noise.median());
}

#[test]
fn val_what_is_subtracted_is_accounted_for() {
    let [motion, floor] = steady();
    let [clean, with] = [motion.clone(), &motion + &floor].map(|v| found(v, false));
    let less = found(&motion + &floor, true);
    let noise = less.noise.as_ref().unwrap();
    let left = noise.subtracted.as_ref().unwrap();
    let df = with.bins[1];
    let mut worst = [0.0_f64; 2];
    for j in 0..SITES {
        let sum = |found: &SpectrumEstimate| found.spectrum.slice(s![1.., j]).sum() * df;
        // All bins but that at 0; Nyquist's counts half.
        let whole = noise.sites[j].unwrap().density * 127.5 * df;
        let rest = sum(&with) - whole + left.clipped_power[j];
        worst[0] = worst[0].max((sum(&less) / rest - 1.0).abs());
        // Of the truth, it is as far as the interval of the floor, beside what clipping adds.
        let bias = sum(&less) - sum(&clean) - left.clipped_power[j];
        worst[1] = worst[1].max(bias.abs() / (sum(&clean) * level(j)));
        assert!(left.clipped_bins[j] > 20, "{}", left.clipped_bins[j]);
        assert!(less.spectrum.column(j).iter().all(|s| *s >= 0.0));
    }
    assert!(worst[0] < 1e-12, "{worst:?}");
    // Motion and noise are correlated by chance.
    assert!(worst[1] < 0.15, "{worst:?}");
    // Where the motion is far above the noise, its density is unbiased.
    let mean = |found: &SpectrumEstimate| found.spectrum.slice(s![2..12, ..]).sum();
    assert!((mean(&less) / mean(&clean) - 1.0).abs() < 3e-3);
    // Where both are alike, most of the bias is gone.
    let at = |found: &SpectrumEstimate| found.spectrum.slice(s![22..28, 100..]).sum();
    let [before, after] = [&with, &less].map(|found| at(found) / at(&clean) - 1.0);
    assert!(before > 0.05, "{before} {after}");
    assert!(after.abs() < 0.2 * before, "{before} {after}");
}

#[test]
fn val_centroids_and_shares_without_the_noise() {
    let [motion, floor] = steady();
    let some = |values: &Array2<f64>| values.slice(s![.., 150..]).to_owned();
    let request = |subtract_noise: bool| Request {
        results: TEMPORAL,
        band_edge_frequency: Some(0.1),
        subtract_noise,
        ..Request::default()
    };
    let of = |values: Array2<f64>, subtract: bool| {
        analyze(&Field::from_array(values), &request(subtract)).unwrap()
    };
    let clean = of(some(&motion), false).0.along_space.unwrap();
    let with = of(some(&(&motion + &floor)), false).0.along_space.unwrap();
    let (less, spectra) = of(some(&(&motion + &floor)), true);
    let noise = less.noise.as_ref().unwrap();
    assert_eq!(noise.known(), 50);
    assert!(less.parseval.time.unwrap().abs() < 1e-12);
    let along = less.along_space.as_ref().unwrap();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let errors = |of: fn(&wavecascade::analyze::Moments) -> &Vec<f64>| {
        let truth = mean(of(&clean));
        [&with, along].map(|found| (mean(of(found)) - truth) / truth)
    };
    // Periodograms have two degrees of freedom: where there is nothing but noise, what is above it stays.
    let [before, after] = errors(|m| &m.centroid);
    assert!(before > 0.05 && after < 0.5 * before, "{before} {after}");
    let [before, after] = errors(|m| &m.energy);
    assert!(after.abs() < 0.5 * before, "{before} {after}");
    let left = noise.subtracted.as_ref().unwrap();
    let sum = spectra.temporal.unwrap().column(7).sum() / TIMES as f64;
    assert!((sum / along.energy[7] - 1.0).abs() < 1e-12);
    let whole = noise.sites[7].unwrap().density / 2.0 * TIMES as f64;
    let rest = along.energy[7] - left.clipped_power[7] + whole;
    assert!((rest / with.energy[7] - 1.0).abs() < 1e-12);
    // Noise that falls to the Nyquist frequency is not white, and not known; one site is left out.
    let mut coloured = &motion + &floor;
    for n in 1..coloured.nrows() {
        coloured[[n, 180]] = motion[[n, 180]] + 0.5 * (floor[[n, 180]] + floor[[n - 1, 180]]);
    }
    let but_one = changed(request(true), |it| it.without_sites = vec![3, 3]);
    let (compared, _) = analyze(&Field::from_array(some(&coloured)), &but_one).unwrap();
    let rows = compared.along_space.as_ref().unwrap();
    let undefined = rows.centroid.iter().filter(|centroid| centroid.is_nan());
    assert_eq!(undefined.count(), 2);
    for site in [3, 30] {
        assert!(rows.high_share[site].is_nan() && rows.centroid[site].is_nan());
    }
    // Averages over segments clip less.
    let welch = Request {
        welch: Some(segments(256, 128)),
        window_time: wavecascade::prepare::Window::Hann,
        ..request(true)
    };
    let (averaged, _) = analyze(&Field::from_array(some(&(&motion + &floor))), &welch).unwrap();
    let centroid = mean(&averaged.along_space.unwrap().centroid) / mean(&clean.centroid) - 1.0;
    assert!(centroid.abs() < 0.06, "{centroid}");

    let option = |request: &Request, values: Array2<f64>| {
        let error = analyze(&Field::from_array(values), request).unwrap_err();
        test_support::fields::option(error)
    };
    // S(k, f) keeps its noise; motion alone has none.
    let all = changed(request(true), |it| it.results = Results::ALL);
    assert_eq!(option(&all, some(&floor)), "subtract-noise");
    assert_eq!(option(&request(true), some(&motion)), "subtract-noise");
    let from_it = Request {
        reference_site: Some(30),
        band_edge_frequency: None,
        ..request(true)
    };
    assert_eq!(option(&from_it, some(&coloured)), "reference-site");
}
