//! Archives that are damaged, lie about what they hold or leave the choice open.

use test_support::fields::reading;
use test_support::hostile::{BOTH, Folder, fault, fault_with, npy, npy_f64, npz, refusal};
use wavecascade::error::InputFault;
use wavecascade::field::OpenOptions;
use wavecascade::{Error, Field};
use zip::CompressionMethod;

/// That an archive is refused with these words.
fn refused(bytes: impl AsRef<[u8]>, words: &[&str]) {
    let said = fault("field.npz", bytes).to_string();
    assert!(words.iter().all(|words| said.contains(words)), "{said}");
}

#[test]
fn npz_that_is_damaged() {
    let field = npy_f64("(4, 2)", (0..8).map(f64::from));
    let mut end = b"PK\x05\x06".to_vec();
    end.extend([0; 4]);
    end.extend([0xfe; 12]);
    end.extend([0; 2]);
    let mut damaged = vec![
        b"not an archive".to_vec(),
        end.clone(),
        [&b"PK\x03\x04"[..], &[0; 1000], &end].concat(),
        [&b"PK\x03\x04"[..], &end.repeat(3000)].concat(),
    ];
    for method in BOTH {
        let whole = npz(method, &[("velocity.npy", &field)]);
        damaged.extend([30, whole.len() / 2, whole.len() - 1].map(|len| whole[..len].to_vec()));
    }
    for bytes in damaged {
        refused(bytes, &["a whole zip archive"]);
    }
    let empty = npz(CompressionMethod::Stored, &[]);
    refused(empty, &["expected one array v(t, x), found none"]);
}

#[test]
fn npz_bytes_that_changed() {
    let field = npy_f64("(40, 2)", (0..80).map(f64::from));
    let mut stored = npz(CompressionMethod::Stored, &[("velocity.npy", &field)]);
    let at = stored.windows(8).position(|w| w == 7f64.to_le_bytes());
    stored[at.unwrap() + 3] ^= 1;
    refused(stored, &["member \"velocity\"", "checksum"]);
    let whole = npz(CompressionMethod::Deflated, &[("velocity.npy", &field)]);
    for at in 200..240 {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x10;
        refused(bytes, &["member \"velocity\""]);
    }
}

/// Damage of coordinates and of units is no lack of them.
#[test]
fn regress_npz_coordinates_that_changed() {
    let field = npy_f64("(40, 2)", (0..80).map(|n| f64::from(n % 7)));
    let times = npy_f64("(40,)", (0..40).map(f64::from));
    for name in ["t.npy", "x.npy", "time.npy"] {
        let members = [("v.npy", &field[..]), (name, &times[..])];
        for method in BOTH {
            let whole = npz(method, &members);
            // The samples of the last member, before the directory.
            let directory = whole.windows(4).position(|w| w == b"PK\x01\x02").unwrap();
            let local = whole[..directory]
                .windows(4)
                .rposition(|w| w == b"PK\x03\x04")
                .unwrap();
            let extra = usize::from(whole[local + 28]);
            let from = local + 30 + name.len() + extra;
            for at in from..directory {
                let mut bytes = whole.clone();
                bytes[at] ^= 0x10;
                let folder = Folder::new();
                let path = folder.write("field.npz", bytes);
                // Another stream may stand for the same bytes.
                if let Ok(field) = Field::open(path, &OpenOptions::default()) {
                    let axes = [&field.time, &field.space].map(|axis| (axis.origin, axis.step));
                    assert_eq!(axes, [(0.0, 1.0); 2]);
                    let said = &field.notes[0].text;
                    assert!(said.contains("its "), "{name} {method}, {at}: {said}");
                }
            }
            // Encrypted, by the flag of both headers.
            let mut bytes = whole.clone();
            bytes[local + 6] |= 1;
            let entry = whole.windows(4).rposition(|w| w == b"PK\x01\x02").unwrap();
            bytes[entry + 8] |= 1;
            refused(bytes, &["encrypted"]);
        }
    }
}

#[test]
fn npz_member_that_is_not_what_its_header_says() {
    let short = npy_f64("(4, 2)", (0..7).map(f64::from));
    let long = npy_f64("(4, 2)", (0..9).map(f64::from));
    let terabytes = npy_f64("(1000000, 1000000)", (0..8).map(f64::from));
    for (bytes, what) in [
        (&short, "the file is truncated"),
        (&long, "8 bytes behind the array"),
        (&terabytes, "the file is truncated"),
    ] {
        let stored = npz(CompressionMethod::Stored, &[("a.npy", bytes)]);
        refused(stored, &["member \"a\"", what]);
        let deflated = npz(CompressionMethod::Deflated, &[("a.npy", bytes)]);
        refused(deflated, &["member \"a\"", "once inflated"]);
    }
}

#[test]
fn npz_bomb_stays_within_its_header_and_the_memory_allowed() {
    let header = npy("<f8", "(4, 2)", &[]);
    let bomb = [&header[..], &vec![0; 64 << 20]].concat();
    let archive = npz(CompressionMethod::Deflated, &[("velocity.npy", &bomb)]);
    let expected = header.len() as u64 + 64;
    let inflated = format!("expected {expected} bytes once inflated");
    refused(&archive, &[&inflated]);

    let mut lying = archive.clone();
    let size = (bomb.len() as u32).to_le_bytes();
    while let Some(at) = lying.windows(4).position(|window| window == size) {
        lying[at..at + 4].copy_from_slice(&(expected as u32).to_le_bytes());
    }
    refused(lying, &["larger"]);

    let large = npy("<f8", "(1024, 1024)", &vec![0; 8 << 20]);
    let archive = npz(CompressionMethod::Deflated, &[("velocity.npy", &large)]);
    let options = reading(|it| it.memory = Some(1 << 20));
    match refusal("field.npz", archive, &options) {
        Error::Memory {
            needed, allowed, ..
        } => assert_eq!((needed, allowed), (large.len() as u64, 1 << 20)),
        other => panic!("{other}"),
    }
}

#[test]
fn npz_members_are_listed_where_the_choice_is_open() {
    let matrix = npy_f64("(2, 1)", [0.0, 1.0]);
    let record = npy_f64("(2,)", [0.0, 1.0]);
    let members: &[(&str, &[u8])] = &[
        ("a.npy", &matrix),
        ("b.npy", &matrix),
        ("t.npy", &record),
        ("note.txt", b"hello"),
        ("torn.npy", &matrix[..9]),
    ];
    for method in BOTH {
        let archive = npz(method, members);
        let all = "found a (2, 1), b (2, 1), t (2), torn (unreadable)";
        refused(&archive, &["expected one array v(t, x)", all]);

        let options = reading(|it| it.variable = Some("c".into()));
        let fault = fault_with("field.npz", &archive, &options);
        assert!(matches!(
            fault,
            InputFault::NoSuchVariable { name, variables } if name == "c" && variables.len() == 4
        ));
    }
}
