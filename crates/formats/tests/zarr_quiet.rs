//! What is printed where `zarrs` panics: nothing. Alone in its process, whose panics it counts.
#![cfg(feature = "zarr")]

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use wavecascade_formats::{Format, Options, open_directory};

static TOLD: AtomicUsize = AtomicUsize::new(0);

/// A chunk shorter than its checksum, on which `zarrs` panics in a thread of its own.
#[test]
fn regress_a_caught_panic_prints_nothing() {
    std::panic::set_hook(Box::new(|panic| {
        println!("{panic}");
        TOLD.fetch_add(1, Ordering::SeqCst);
    }));
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/zarr/v3.zarr/crc");
    let store = std::env::temp_dir().join(format!("zarr-quiet-{}.zarr", std::process::id()));
    fs::create_dir_all(store.join("c/0")).unwrap();
    fs::create_dir_all(store.join("c/1")).unwrap();
    for file in ["zarr.json", "c/0/0", "c/1/0"] {
        fs::copy(from.join(file), store.join(file)).unwrap();
    }
    for file in ["c/0/0", "c/1/0"] {
        fs::write(store.join(file), [1, 2]).unwrap();
    }
    let container = open_directory(Format::Zarr, &store, &Options::default()).unwrap();
    // A part of a chunk: the whole of it is refused without a panic.
    let mut out = vec![0; 2 * 3 * 8];
    let read = container.read(0, &[0..2, 0..3], &mut out);
    fs::remove_dir_all(&store).unwrap();
    let said = read.unwrap_err().to_string();
    assert!(said.contains("one that its decoder fails on"), "{said}");
    assert_eq!(TOLD.load(Ordering::SeqCst), 0);
    // Other panics are told, and so are those that come later.
    assert!(std::panic::catch_unwind(|| panic!("of a test")).is_err());
    assert_eq!(TOLD.load(Ordering::SeqCst), 1);
}
