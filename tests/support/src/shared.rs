//! What several tests share.

use std::io::Write;
use std::path::PathBuf;

use wavecascade::transform::direct_sums;

/// [`direct_sums`] as pairs of real and imaginary part.
pub fn dft_dd(x: &[f64], bins: &[usize]) -> Vec<(f64, f64)> {
    let sums = direct_sums(x, bins);
    sums.into_iter().map(|z| (z.re, z.im)).collect()
}

/// A file of the fields from elsewhere, which lie beside the repository; `None`, said loudly,
/// where they are absent.
pub fn shared_data(name: &str) -> Option<PathBuf> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let path = root.join(name);
    if path.exists() {
        return Some(path);
    }
    // Not by `eprintln!`, which is captured where a test passes.
    let _ = writeln!(
        std::io::stderr(),
        "\n*** NOT TESTED: {} is absent, so nothing is compared with it. ***\n",
        path.display()
    );
    None
}
