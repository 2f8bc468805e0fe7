//! Pages of a field larger than memory that stay with the program, by the system's own account.
#![cfg(target_os = "linux")]

use std::fs;

use ndarray::Array2;
use ndarray_npy::write_npy;
use wavecascade::analyze::{Request, Results, plan, run};
use wavecascade::arrays::Nowhere;
use wavecascade::field::OpenOptions;
use wavecascade::observer::Silent;
use wavecascade::{Error, Field};

/// A line of the process's state, in bytes.
fn resident(which: &str) -> u64 {
    let state = fs::read_to_string("/proc/self/status").unwrap();
    let line = state.lines().find(|line| line.starts_with(which)).unwrap();
    let number = line.split_whitespace().nth(1).unwrap();
    number.parse::<u64>().unwrap() << 10
}

/// Rows of many sites, looked at one by one, and records of few, read ahead: in the least memory that is
/// accepted, a part of the field. One test, since another would count with it.
#[test]
fn pages_of_a_large_field_are_let_go() {
    for (n_times, n_sites) in [(640, 33_000), (21_000, 1000)] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("large.npy");
        let value = |(n, j): (usize, usize)| (n * 31 + j * 7) as f64 % 11.0 - 5.0;
        write_npy(&path, &Array2::from_shape_fn((n_times, n_sites), value)).unwrap();
        let field = Field::open(&path, &OpenOptions::default()).unwrap();
        let request = |memory| Request {
            results: Results {
                temporal: n_sites == 1000,
                spatial: n_sites != 1000,
                ..Results::NONE
            },
            threads: Some(1),
            memory: Some(memory),
            maps: false,
            ..Request::default()
        };
        let mut least = 1;
        while let Err(Error::Memory { needed, .. }) = plan(&field, &request(least)) {
            assert!(needed > least);
            least = needed;
        }
        let planned = plan(&field, &request(least)).unwrap();
        assert!(planned.streams() && least < 8 * (n_times * n_sites) as u64 / 2);
        // From here on the highest counts.
        fs::write("/proc/self/clear_refs", "5").unwrap();
        let before = resident("VmRSS");
        run(&field, &planned, &Nowhere, &Silent).unwrap();
        let more = resident("VmHWM").saturating_sub(before);
        assert!(more <= least, "{n_times} x {n_sites}: {more} of {least}");
        // Had it nothing mapped, this would have measured nothing.
        assert!(more > 4 << 20, "{n_times} x {n_sites}: {more}");
    }
}
