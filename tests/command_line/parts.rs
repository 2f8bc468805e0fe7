//! `--part` and `--merge` as a stranger runs them.

use std::fs;

use test_support::fields::noise;
use test_support::place::Place;

#[test]
fn regress_what_is_no_part_is_refused() {
    let place = Place::new();
    place.save("field.npy", &noise(400, 3));
    place.says("coherence field.npy --segment 64 --part 1/1 --out part");
    // A part that was damaged.
    let path = place.path("part/part.npz");
    let mut bytes = fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&path, bytes).unwrap();
    place.refuses_for(1, "coherence --merge part --out out", "part.npz");
}
