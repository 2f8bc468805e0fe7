//! Random files, read as the programs that wrote them read them.

use std::path::Path;
use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

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

fn expected(path: &Path) -> Vec<f64> {
    let bytes = std::fs::read(path).unwrap();
    let values = bytes.chunks_exact(8).map(|b| b.try_into().unwrap());
    values.map(f64::from_le_bytes).collect()
}

/// NumPy reads `.npy`, `.npz` and text without gaps, pandas a table with names and gaps.
#[test]
fn val_random_files_are_read_as_numpy_and_pandas_read_them() {
    let folder = tempfile::tempdir().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/input_formats/random_files.py");
    let python = std::env::var("PAGES_PYTHON").unwrap_or("python3".into());
    let seed = seed();
    let made = Command::new(python)
        .args([script.as_os_str(), folder.path().as_os_str()])
        .args([seed.to_string(), COUNT.to_string()])
        .output();
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
