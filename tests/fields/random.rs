//! Random files, read as the programs that wrote them read them.

use std::path::Path;
use std::process::{Command, Output};
use std::time::{SystemTime, UNIX_EPOCH};

use test_support::place::Place;
use wavecascade::Field;
use wavecascade::field::{Layout, OpenOptions, TimeColumn};

/// Files of one run.
const COUNT: usize = 400;

/// `FILES_SEED` repeats a run.
fn seed() -> u64 {
    match std::env::var("FILES_SEED") {
        Ok(seed) => seed.parse().expect("FILES_SEED is a number"),
        Err(_) => {
            let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
            now.subsec_nanos().into()
        }
    }
}

/// A script of `tests/input_formats`, run by Python.
fn python(script: &str, words: &[&str]) -> std::io::Result<Output> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/input_formats");
    let python = std::env::var("PAGES_PYTHON").unwrap_or("python3".into());
    let mut command = Command::new(python);
    command.arg(folder.join(script)).args(words).output()
}

fn expected(path: &Path) -> Vec<f64> {
    let bytes = std::fs::read(path).unwrap();
    let values = bytes.chunks_exact(8).map(|b| b.try_into().unwrap());
    values.map(f64::from_le_bytes).collect()
}

/// NumPy reads `.npy`, `.npz` and text without gaps, pandas a table with names and gaps.
#[test]
fn val_random_files_are_read_as_numpy_and_pandas_read_them() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path().to_str().unwrap();
    let seed = seed();
    let made = python(
        "random_files.py",
        &[at, &seed.to_string(), &COUNT.to_string()],
    );
    let listed = match made {
        Ok(made) if made.status.success() => String::from_utf8(made.stdout).unwrap(),
        made => {
            println!("SKIPPED: random files, which need Python with numpy: {made:?}");
            return;
        }
    };
    println!("FILES_SEED={seed}");
    for line in listed.lines() {
        let [name, times, sites] = line.split(' ').collect::<Vec<_>>()[..] else {
            panic!("{line}");
        };
        let options = OpenOptions {
            layout: Some(Layout::TimeSite),
            time_column: match name.ends_with(".csv") {
                true => TimeColumn::None,
                false => TimeColumn::Detect,
            },
            ..OpenOptions::default()
        };
        let field = Field::open(folder.path().join(name), &options);
        let field = field.unwrap_or_else(|error| panic!("seed {seed}, {name}: {error}"));
        let shape = [field.n_times(), field.n_sites()];
        assert_eq!(
            shape,
            [times, sites].map(|n| n.parse::<usize>().unwrap()),
            "seed {seed}, {name}"
        );
        let mut found = vec![0.0; shape[0] * shape[1]];
        field.read_time_major(0..shape[0], 0..shape[1], &mut found);
        let wanted = expected(&folder.path().join(format!("{name}.f64")));
        for (index, (a, b)) in found.iter().zip(&wanted).enumerate() {
            let same = a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan();
            assert!(
                same,
                "seed {seed}, {name}, value {index}: {a:e} instead of {b:e}"
            );
        }
        assert_eq!(found.len(), wanted.len());
    }
}

/// Direct sums in long double, by NumPy: shapes with large prime lengths, both layouts, amplitudes
/// from 1e-300 to 1e300.
#[test]
fn val_random_spectra_are_direct_sums_in_long_double() {
    const SPECTRA: usize = 60;
    /// Relative to the peak.
    const BOUND: f64 = 2e-15;
    let place = Place::new();
    let at = place.folder().to_str().unwrap();
    let seed = seed();
    let words = ["make", at, &seed.to_string(), &SPECTRA.to_string()];
    let listed = match python("random_spectra.py", &words) {
        Ok(made) if made.status.success() => String::from_utf8(made.stdout).unwrap(),
        made => {
            println!("SKIPPED: random spectra, which need Python with numpy: {made:?}");
            return;
        }
    };
    println!("FILES_SEED={seed}");
    assert_eq!(listed.lines().count(), SPECTRA);
    for line in listed.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        let (file, out) = (format!("{}.npy", words[0]), format!("{}.result", words[0]));
        let line = format!(
            "analyze {file} --layout {} --dt 1 --dx 1 --figures none --out {out}",
            words[1]
        );
        let output = place.run(&line.split(' ').collect::<Vec<_>>());
        assert!(output.status.success(), "seed {seed}, {line}: {output:?}");
    }
    let compared = python("random_spectra.py", &["compare", at]).unwrap();
    assert!(compared.status.success(), "seed {seed}: {compared:?}");
    let said = String::from_utf8(compared.stdout).unwrap();
    println!("temporal and space-time, relative to the peak: {said}");
    let errors: Vec<f64> = said
        .split_whitespace()
        .map(|n| n.parse().unwrap())
        .collect();
    assert_eq!(errors.len(), 2, "seed {seed}: {said}");
    for error in errors {
        assert!(error <= BOUND, "seed {seed}: {error:e}");
    }
}

/// netCDF4 and SciPy, by xarray, beside NumPy: every array of an analysis, a filtered field in single
/// precision and a run.
#[test]
fn val_xarray_opens_what_is_written() {
    match python("xarray_opens.py", &["check"]) {
        Ok(checked) if checked.status.success() => {}
        checked => {
            println!(
                "SKIPPED: xarray, which needs Python with xarray, netCDF4 and scipy: {checked:?}"
            );
            return;
        }
    }
    let place = Place::new();
    place.save(
        "a.npy",
        &test_support::made::pulse(257, 48).mapv(|v| v as f32),
    );
    let scene = "sites = 24\nmaterial = \"steel\"\nshape = \"sphere\"\nradius = \"9 mm\"\n\
                 striker_velocity = \"1 m/s\"\nend_time = 1e-4\nsamples = 201\n";
    place.write("si.toml", scene);
    let axes = "--dt 10us --dx 2mm --unit m/s";
    for words in [
        format!("analyze a.npy {axes} --figures none --short-time-times 1e-3 --out zip"),
        format!(
            "analyze a.npy {axes} --figures none --short-time-times 1e-3 --out nc --format netcdf"
        ),
        format!("convert a.npy field.npz {axes}"),
        format!("convert a.npy field.nc {axes}"),
        "simulate si.toml --out run.npz".into(),
        "simulate si.toml --out run.nc".into(),
        "budget run.npz --from-samples --figures none --out bzip".into(),
        "budget run.npz --from-samples --figures none --out bnc --format netcdf".into(),
        "convert run.npz measured.npz".into(),
        "budget measured.npz --scene si.toml --noise 1e-5 --figures none --out mzip --quiet".into(),
        "budget measured.npz --scene si.toml --noise 1e-5 --figures none --out mnc --format netcdf --quiet"
            .into(),
    ] {
        place.good(&words.split(' ').collect::<Vec<_>>());
    }
    let at = place.folder().to_str().unwrap();
    let compared = python("xarray_opens.py", &[at]).unwrap();
    assert!(compared.status.success(), "{compared:?}");
    let count: usize = String::from_utf8(compared.stdout)
        .unwrap()
        .trim()
        .parse()
        .unwrap();
    assert!(count > 300, "{count}");
    println!("{count} arrays are the same to the bit");
}
