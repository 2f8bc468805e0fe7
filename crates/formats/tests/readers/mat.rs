//! MATLAB files of versions 4 to 7 against SciPy's reader.

use super::common::{compare_all, directory};
use wavecascade_formats::Format;

#[test]
fn val_scipy_every_array() {
    compare_all("mat", 6);
}

#[test]
fn regress_formats_are_told_apart() {
    let bytes = std::fs::read(directory("mat").join("v4.mat")).unwrap();
    assert_eq!(Format::detect("a.mat", &bytes), Some(Format::Mat4));
    assert_eq!(Format::detect("a.dat", &bytes), None);
    let mut bytes = std::fs::read(directory("mat").join("v5.mat")).unwrap();
    assert_eq!(Format::detect("a", &bytes), Some(Format::Mat5));
    bytes[..19].copy_from_slice(b"MATLAB 7.3 MAT-file");
    bytes[124..126].copy_from_slice(&[0, 2]);
    assert_eq!(Format::detect("a", &bytes), None);
}
