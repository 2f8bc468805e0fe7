//! MATLAB files of versions 4 to 7 against SciPy's reader.

use super::common::file;
use wavecascade_formats::Format;

#[test]
fn regress_formats_are_told_apart() {
    let bytes = file("mat", "v4.mat");
    assert_eq!(Format::detect("a.mat", &bytes), Some(Format::Mat4));
    assert_eq!(Format::detect("a.dat", &bytes), None);
    let mut bytes = file("mat", "v5.mat");
    assert_eq!(Format::detect("a", &bytes), Some(Format::Mat5));
    bytes[..19].copy_from_slice(b"MATLAB 7.3 MAT-file");
    bytes[124..126].copy_from_slice(&[0, 2]);
    assert_eq!(Format::detect("a", &bytes), None);
}
