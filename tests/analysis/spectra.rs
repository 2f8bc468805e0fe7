//! Spectra of fields from elsewhere against NumPy 2.4.6, SciPy 1.17.1 and xrft 1.0.1.
//!
//! The references lie beside the repository with a README that states each call; here the sign
//! of k, cycles and rad, and the two sides of the frequency axis are brought together.

use std::f64::consts::TAU;
use std::fs::File;

use ndarray::{Array2, ArrayD, Axis, Ix2, IxDyn, OwnedRepr};
use ndarray_npy::NpzReader;
use test_support::fields::{asking, segments};
use test_support::shared::shared_data;
use test_support::{changed, lies, near, worst};
use wavecascade::analyze::{Analysis, Request, Scaling, TimeRange};
use wavecascade::arrays::{Arrays, LargeArray, Precision};
use wavecascade::field::OpenOptions;
use wavecascade::prepare::{Detrend, Window};
use wavecascade::{Field, analyze};

/// Reached: 3.8e-15 of the peak, over all references.
const TOLERANCE: f64 = 6e-15;

const BURGERS: &str = "burgers_sine";
const SHOT: &str = "dispersion_event";

/// Fields with the length of the segments of their reference.
const CASES: [(&str, usize); 3] = [(BURGERS, 32), (SHOT, 512), ("mine_das_velocity", 128)];

fn opened(name: &str, file: &str) -> Option<File> {
    Some(File::open(shared_data(&format!("{name}/{file}"))?).unwrap())
}

fn meta(name: &str) -> serde_json::Value {
    serde_json::from_reader(opened(name, "meta.json").unwrap()).unwrap()
}

/// `FILE/ARRAY` of a case.
fn theirs(name: &str, place: &str) -> ArrayD<f64> {
    let (file, array) = place.split_once('/').unwrap();
    let mut npz = NpzReader::new(opened(name, file).unwrap()).unwrap();
    npz.by_name::<OwnedRepr<f64>, IxDyn>(array).unwrap()
}

/// A two-sided `(nt, nx)` spectrum as `numpy.fft` lays it out, in cycles, as ours: one-sided in
/// f, ascending in k = -k_numpy, per rad.
fn as_ours(two_sided: ArrayD<f64>) -> Array2<f64> {
    let two_sided = two_sided.into_dimensionality::<Ix2>().unwrap();
    let (nt, nx) = two_sided.dim();
    Array2::from_shape_fn((nt / 2 + 1, nx), |(m, i)| {
        let k = i as i64 - (nx / 2) as i64;
        let column = (-k).rem_euclid(nx as i64) as usize;
        let doubled = if m == 0 || 2 * m == nt { 1.0 } else { 2.0 };
        doubled * two_sided[[m, column]] / TAU
    })
}

/// Largest difference relative to the reference's peak.
fn apart<'a>(
    ours: impl IntoIterator<Item = &'a f64>,
    theirs: impl IntoIterator<Item = &'a f64> + Clone,
) -> f64 {
    let peak = worst(theirs.clone().into_iter().map(|v| v.abs()));
    let pairs = ours.into_iter().zip(theirs);
    worst(pairs.map(|(a, b)| (a - b).abs())) / peak
}

fn density() -> Request {
    asking(|it| it.scaling = Scaling::Density)
}

fn without_mean() -> Request {
    changed(density(), |it| it.detrend_field_mean = true)
}

/// The field, if the references are there.
fn field(name: &str) -> Option<Field> {
    let path = shared_data(&format!("{name}/field.npy"))?;
    let meta = meta(name);
    let options = OpenOptions {
        dt: meta["dt"].as_f64().map(Into::into),
        dx: meta["dx"].as_f64().map(Into::into),
        ..OpenOptions::default()
    };
    Some(Field::open(&path, &options).unwrap())
}

fn run(name: &str, request: &Request) -> Option<(Analysis, Arrays)> {
    let (analysis, spectra) = analyze(&field(name)?, request).unwrap();
    let p = analysis.parseval;
    if request.precision == Precision::F64 {
        let residuals = [p.time, p.space, p.spacetime].into_iter().flatten();
        lies(worst(residuals.map(f64::abs)), 0.0..2e-15);
    }
    Some((analysis, spectra))
}

/// Of every case whose references are there.
fn each(request: &Request, check: impl Fn(&str, Analysis, Arrays)) {
    for (name, _) in CASES {
        if let Some((analysis, spectra)) = run(name, request) {
            check(name, analysis, spectra);
        }
    }
}

#[test]
fn val_scipy_periodogram_along_time_and_space() {
    let request = changed(density(), |it| it.detrend_time = Detrend::Mean);
    each(&request, |name, analysis, spectra| {
        let of = |array: &str| theirs(name, &format!("ref_periodogram.npz/{array}"));
        let temporal = &spectra[&LargeArray::TEMPORAL_SPECTRUM];
        let mean = temporal.mean_axis(Axis(1)).unwrap();
        lies(apart(&mean, &of("Pt_mean_over_x")), 0.0..TOLERANCE);
        lies(apart(&analysis.axes.frequency, &of("f")), 0.0..1e-15);
    });
    let request = changed(density(), |it| it.detrend_space = Detrend::Mean);
    each(&request, |name, analysis, spectra| {
        let of = |array: &str| theirs(name, &format!("ref_periodogram.npz/{array}"));
        let spatial = &spectra[&LargeArray::SPATIAL_SPECTRUM];
        let mean = spatial.mean_axis(Axis(0)).unwrap() * TAU;
        lies(apart(&mean, &of("Pk_mean_over_t")), 0.0..TOLERANCE);
        let k = of("k") * TAU;
        lies(apart(&analysis.axes.wavenumber, &k), 0.0..1e-15);
    });
}

#[test]
fn val_scipy_welch() {
    for (name, segment) in CASES {
        let request = Request {
            detrend_time: Detrend::Mean,
            window_time: Window::Hann,
            welch: Some(segments(segment, segment / 2)),
            ..density()
        };
        if let Some((_, spectra)) = run(name, &request) {
            let theirs = theirs(name, "ref_welch.npz/P");
            let temporal = &spectra[&LargeArray::TEMPORAL_SPECTRUM];
            lies(apart(temporal, &theirs), 0.0..TOLERANCE);
        }
    }
}

/// In single precision 1e-7 to 3.3e-7 are reached, its rounding and not that of double.
#[test]
fn val_numpy_and_xrft_spacetime() {
    let double = (Precision::F64, 0.0..TOLERANCE);
    for (window, place, (precision, within)) in [
        (Window::None, "ref_fk_numpy.npz/S", double.clone()),
        (Window::None, "ref_xrft.npz/S_boxcar", double.clone()),
        (Window::Hann, "ref_xrft.npz/S_hann", double),
        (
            Window::None,
            "ref_fk_numpy.npz/S",
            (Precision::F32, 5e-8..5e-7),
        ),
    ] {
        let request = Request {
            window_time: window,
            window_space: window,
            precision,
            ..without_mean()
        };
        each(&request, |name, _, spectra| {
            let theirs = as_ours(theirs(name, place));
            let spacetime = &spectra[&LargeArray::SPACETIME_SPECTRUM];
            lies(apart(spacetime, &theirs), within.clone());
        });
    }
}

/// The split into directions, against the sums of NumPy's spectrum stated with each field.
#[test]
fn val_numpy_direction_split() {
    each(&without_mean(), |name, analysis, _| {
        let split = &meta(name)["reference_summary"]["fk_direction_global_mean_removed_boxcar"];
        let theirs = |part: &str| split[part].as_f64().unwrap() / split["total"].as_f64().unwrap();
        let d = analysis.direction.unwrap();
        near(d.toward_plus_x, theirs("toward_plus_x"), 2e-14);
        near(d.toward_minus_x, theirs("toward_minus_x"), 2e-14);
        near(d.undirected, theirs("axis_or_nyquist"), 2e-14);
        // The odd profile of Burgers' equation stands: both directions carry the same.
        let ratio = d.toward_plus_x / d.toward_minus_x;
        assert!(name != BURGERS || (ratio - 1.0).abs() < 1e-12);
    });
}

/// The source is on the left: everything travels to +x, in the band of the Rayleigh wave.
#[test]
fn val_numpy_shot_gather_travels_towards_plus_x() {
    let request = changed(without_mean(), |it| it.direction_band = Some((5.0, 90.0)));
    let Some((analysis, spectra)) = run(SHOT, &request) else {
        return;
    };
    let theirs = as_ours(theirs(SHOT, "ref_fk_numpy.npz/S"));
    assert_eq!(spectra[&LargeArray::SPACETIME_SPECTRUM].dim(), (1251, 101));
    let (mut plus, mut all) = (0.0, 0.0);
    for (f, row) in analysis.axes.frequency.iter().zip(theirs.outer_iter()) {
        if (5.0..=90.0).contains(f) {
            all += row.sum();
            plus += row.iter().skip(51).sum::<f64>();
        }
    }
    let toward_plus_x = analysis.direction.unwrap().toward_plus_x;
    assert!(toward_plus_x > 0.95, "{toward_plus_x}");
    near(toward_plus_x, plus / all, 1e-14);
}

/// The steepening sine: energy leaves the low band for ever higher wavenumbers.
#[test]
fn val_burgers_surrogate_is_minus_the_change_of_energy() {
    let Some((_, spectra)) = run(BURGERS, &Request::default()) else {
        return;
    };
    let flux = &spectra[&LargeArray::KINETIC_FLUX_SURROGATE];
    // Cumulative over k of the reference's energy spectrum.
    let mut energy = theirs(BURGERS, "ref_budget.npz/E");
    energy.accumulate_axis_inplace(Axis(1), |below, e| *e += below);
    // The reference is a mean over x of v^2 / 2, ours an integral over 16 units of length.
    for n in 1..flux.nrows() - 1 {
        for (k, flux) in flux.row(n).iter().enumerate() {
            let change = (energy[[n + 1, k]] - energy[[n - 1, k]]) / (2.0 * 0.05);
            near(*flux, -16.0 * change, 1e-12);
        }
    }
}

#[test]
fn val_numpy_time_range_until_arrival_keeps_reflections_out() {
    let Some(field) = field(SHOT) else { return };
    let request = Request {
        times: TimeRange::UntilArrival { threshold: 0.05 },
        ..density()
    };
    // np.argmax(abs(v[:, -1]) > 0.05 * abs(v).max())
    assert_eq!(analyze(&field, &request).unwrap().0.axes.n_times, 1000);
}
