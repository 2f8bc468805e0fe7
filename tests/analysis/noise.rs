//! The noise of each site against constructed fields whose noise is known, and what subtracting it leaves.

use ndarray::{Array1, Array2, s};
use test_support::estimate::{bicoherence, coherence, modes, spectrum};
use test_support::fields::{
    Congruential, TEMPORAL, analyzed, filtered, noise, option, red, segments, stepped, struck,
};
use test_support::{changed, lies, near, share};
use wavecascade::Field;
use wavecascade::analyze::{Moments, Request, Results, analyze};
use wavecascade::arrays::LargeArray;
use wavecascade::estimates::{NoiseFloor, NoiseSource, SpectrumEstimate};
use wavecascade::prepare::Window;

const SITES: usize = 200;
const TIMES: usize = 4096;

/// Root mean square of the noise of a site.
fn level(j: usize) -> f64 {
    0.02 * (1.0 + j as f64 / 50.0)
}

/// Motion with a spectrum that ends below a quarter of the axis, noise under a Gaussian of four samples, and white noise.
fn steady() -> [Array2<f64>; 2] {
    let both = noise(2 * TIMES + 48, SITES);
    let weights: Vec<f64> = (-24..=24)
        .map(|n: i32| (-0.5 * (f64::from(n) / 4.0).powi(2)).exp())
        .collect();
    let mut motion = Array2::zeros((TIMES, SITES));
    for (mut smooth, white) in motion.columns_mut().into_iter().zip(both.columns()) {
        let white = white.slice(s![..TIMES + 48]).to_vec();
        smooth.assign(&Array1::from(filtered(&white, &weights)));
    }
    let floor = both.slice(s![TIMES + 48.., ..]);
    let floor = Array2::from_shape_fn((TIMES, SITES), |(n, j)| level(j) * floor[[n, j]]);
    [motion, floor]
}

fn found(values: Array2<f64>, more: &str) -> SpectrumEstimate {
    let words = format!("segment=256 {more}");
    spectrum(&words, [&stepped(values, 0.5, 1.0)]).unwrap()
}

fn floor(values: Array2<f64>) -> NoiseFloor {
    found(values, "").noise.unwrap()
}

/// In 190 of 200 sites, with a standard deviation of 3.1, the interval holds the true density, of a step of 0.5.
fn assert_held(noise: &NoiseFloor) {
    assert_eq!(noise.known(), SITES);
    let held = noise.sites.iter().enumerate().filter(|(j, site)| {
        let site = site.unwrap();
        (site.low..site.high).contains(&(2.0 * 0.5 * level(*j).powi(2)))
    });
    let held = held.count();
    assert!((183..=197).contains(&held), "{held}");
}

#[test]
fn val_the_floor_of_steady_records_is_within_its_interval() {
    let [motion, white] = steady();
    let noise = floor(&motion + &white);
    assert_held(&noise);
    let one = noise.sites[0].unwrap();
    assert!(matches!(one.source, NoiseSource::Top { from } if (from - 0.5).abs() < 0.02));
    assert!(one.high / one.low < 1.25, "{one:?}");
    // A line at the top is none of it.
    let line = Array2::from_shape_fn((TIMES, 1), |(n, _)| 0.05 * (2.5 * n as f64).sin());
    let lines = floor(&motion + &white + &line);
    assert_eq!(lines.known(), SITES);
    let [with, without] = [&lines, &noise].map(|noise| noise.sites[100].unwrap().density);
    near(with / without, 1.0, 0.1);
}

#[test]
fn val_the_floor_before_the_arrival_is_within_its_interval() {
    let white = noise(TIMES, SITES);
    let values = Array2::from_shape_fn((TIMES, SITES), |(n, j)| {
        let t = n as f64 - 1200.0 - 4.0 * j as f64;
        (-(t / 20.0).powi(2)).exp() * (0.3 * t).cos() + level(j) * white[[n, j]]
    });
    let noise = floor(values);
    assert_held(&noise);
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
    let once = red(noise(TIMES, 48), 0.999);
    let twice = red(once.clone(), 0.999);
    for values in [once, twice] {
        for sites in [1, 4, 48] {
            let noise = floor(values.slice(s![.., ..sites]).to_owned());
            assert_eq!(noise.known(), 0, "{sites}: {:?}", noise.median());
        }
    }
    // Sawteeth with random slopes, f^-2.
    let teeth = Array2::from_shape_fn((TIMES, 16), |(n, j)| {
        let phase = n as f64 / (87.3 + j as f64) + 0.37 * j as f64;
        2.0 * (phase - phase.floor()) - 1.0
    });
    assert_eq!(floor(teeth).known(), 0, "sawteeth");
    let run = spectrum("", [&struck(40, 80.0, 1024).to_field()]).unwrap();
    assert_eq!(run.noise.unwrap().known(), 0);
}

#[test]
fn val_what_is_subtracted_is_accounted_for() {
    let [motion, white] = steady();
    let (clean, with) = (found(motion.clone(), ""), found(&motion + &white, ""));
    let less = found(&motion + &white, "subtract-noise");
    let noise = less.noise.as_ref().unwrap();
    let left = noise.subtracted.as_ref().unwrap();
    let df = with.bins[1];
    for (j, clipped) in left.clipped_power.iter().enumerate() {
        let sum = |found: &SpectrumEstimate| found.spectrum.slice(s![1.., j]).sum() * df;
        // All bins but that at 0; Nyquist's counts half.
        let whole = noise.sites[j].unwrap().density * 127.5 * df;
        near(sum(&less) / (sum(&with) - whole + clipped), 1.0, 1e-12);
        // Of the truth, it is as far as the interval of the floor, beside what clipping adds. Motion and noise are correlated by
        // chance.
        let bias = sum(&less) - sum(&clean) - clipped;
        near(bias, 0.0, 0.15 * sum(&clean) * level(j));
        assert!(left.clipped_bins[j] > 20, "{}", left.clipped_bins[j]);
    }
    assert!(less.spectrum.iter().all(|s| *s >= 0.0));
    // Where the motion is far above the noise, its density is unbiased.
    let mean = |found: &SpectrumEstimate| found.spectrum.slice(s![2..12, ..]).sum();
    near(mean(&less) / mean(&clean), 1.0, 3e-3);
    // Where both are alike, most of the bias is gone.
    let at = |found: &SpectrumEstimate| found.spectrum.slice(s![22..28, 100..]).sum();
    let [before, after] = [&with, &less].map(|found| at(found) / at(&clean) - 1.0);
    assert!(before > 0.05, "{before} {after}");
    near(after, 0.0, 0.2 * before);
}

#[test]
fn val_centroids_and_shares_without_the_noise() {
    let [motion, white] = steady();
    let some = |values: &Array2<f64>| Field::from_array(values.slice(s![.., 150..]).to_owned());
    let request = |subtract_noise: bool| Request {
        results: TEMPORAL,
        band_edge_frequency: Some(0.1),
        subtract_noise,
        ..Request::default()
    };
    let both = some(&(&motion + &white));
    let of = |field: &Field, request: &Request| analyzed(field, request).along_space.unwrap();
    let (clean, with) = (
        of(&some(&motion), &request(false)),
        of(&both, &request(false)),
    );
    let (less, spectra) = analyze(&both, &request(true)).unwrap();
    let noise = less.noise.as_ref().unwrap();
    assert_eq!(noise.known(), 50);
    near(less.parseval.time.unwrap(), 0.0, 1e-12);
    let along = less.along_space.as_ref().unwrap();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let errors = |of: fn(&Moments) -> &Vec<f64>| {
        [&with, along].map(|found| mean(of(found)) / mean(of(&clean)) - 1.0)
    };
    // Periodograms have two degrees of freedom: where there is nothing but noise, what is above it stays.
    let [before, after] = errors(|m| &m.centroid);
    assert!(before > 0.05 && after < 0.5 * before, "{before} {after}");
    let [before, after] = errors(|m| &m.energy);
    near(after, 0.0, 0.5 * before);
    let left = noise.subtracted.as_ref().unwrap();
    let sum = spectra[&LargeArray::TEMPORAL_SPECTRUM].column(7).sum() / TIMES as f64;
    near(sum / along.energy[7], 1.0, 1e-12);
    let whole = noise.sites[7].unwrap().density / 2.0 * TIMES as f64;
    let rest = along.energy[7] - left.clipped_power[7] + whole;
    near(rest / with.energy[7], 1.0, 1e-12);
    // Noise that falls to the Nyquist frequency is not white, and not known; one site is left out.
    let mut coloured = &motion + &white;
    for n in 1..coloured.nrows() {
        coloured[[n, 180]] = motion[[n, 180]] + 0.5 * (white[[n, 180]] + white[[n - 1, 180]]);
    }
    let coloured = some(&coloured);
    let but_one = changed(request(true), |it| it.without_sites = vec![3, 3]);
    let rows = of(&coloured, &but_one);
    let undefined = (0..50).filter(|j| rows.centroid[*j].is_nan() && rows.high_share[*j].is_nan());
    assert_eq!(undefined.collect::<Vec<_>>(), [3, 30]);
    // Averages over segments clip less.
    let welch = changed(request(true), |it| {
        it.welch = Some(segments(256, 128));
        it.window_time = Window::Hann;
    });
    let averaged = of(&both, &welch);
    near(mean(&averaged.centroid) / mean(&clean.centroid), 1.0, 0.06);
    // S(k, f) keeps its noise; motion alone has none.
    let all = changed(request(true), |it| it.results = Results::ALL);
    let from_it = changed(request(true), |it| {
        it.reference_site = Some(30);
        it.band_edge_frequency = None;
    });
    for (request, field, refused) in [
        (all, &some(&white), "subtract-noise"),
        (request(true), &some(&motion), "subtract-noise"),
        (from_it, &coloured, "reference-site"),
    ] {
        assert_eq!(option(analyze(field, &request).unwrap_err()), refused);
    }
}

/// Records whose common amplitude is steady, steps, is modulated, or is that of bursts. Unrelated ones have no coherent sites and modes and no
/// coupled triples, nor peaks; with a common signal all sites are coherent, in one mode.
#[test]
fn val_construction_a_common_amplitude_is_no_relation() {
    let amplitudes: [fn(f64, f64) -> f64; 4] = [
        |_, _| 1.0,
        |t, _| if t < 0.8 { 1.0 } else { 3.0 },
        |t, _| 1.0 + 0.8 * (19.0 * t).sin(),
        |_, chance| if chance > 0.3 { 3.0 } else { 1.0 },
    ];
    for (kind, amplitude) in amplitudes.into_iter().enumerate() {
        let (mut found, mut peaks, mut held) = ([[0; 2]; 3], 0, Vec::new());
        for seed in 0..16 {
            let white = Congruential(7 + 1931 * seed).white(4096, 9);
            for (i, common) in [0.0, 0.7].into_iter().enumerate() {
                let values = Array2::from_shape_fn((4096, 8), |(n, j)| {
                    let level = amplitude(n as f64 / 4096.0, white[[n / 256 * 256, 8]]);
                    level * (white[[n, j]] + common * white[[n, 8]])
                });
                let field = [&stepped(values, 1.0, 1.0)];
                if i == 0 {
                    let spectrum = spectrum("segment=128", field).unwrap();
                    peaks += spectrum.peaks().unwrap().len();
                    let at = |n: usize| amplitude(n as f64 / 4096.0, white[[n / 256 * 256, 8]]);
                    let density = (0..4096).map(|n| 2.0 * at(n).powi(2)).sum::<f64>() / 4096.0;
                    let ends = spectrum.low.iter().zip(&spectrum.high);
                    let ends = ends.filter(|(low, _)| low.is_finite());
                    held.extend(ends.map(|(low, high)| (*low..=*high).contains(&density)));
                    let tapers = coherence("tapers=4:7", field).unwrap();
                    found[0][0] += tapers.coherent_sites().count();
                }
                let sites = coherence("segment=128", field).unwrap();
                found[0][i] += sites.coherent_sites().count();
                let modes = modes("segment=128", field).unwrap();
                found[1][i] += modes.coherent_frequencies().unwrap();
                let triples = bicoherence("segment=128", field).unwrap();
                found[2][i] += usize::from(triples.above(triples.map_level().unwrap()) > 0);
            }
        }
        let [[sites, followers], [modes, motions], [triples, _]] = found;
        lies(share(held), 0.92..0.985);
        let is_right = sites <= 3 && modes <= 2 && triples <= 3 && followers == 112;
        assert!(
            is_right && motions > 900 && peaks <= 4,
            "{kind}: {found:?} {peaks}"
        );
    }
}
