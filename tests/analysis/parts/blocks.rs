//! Blocks of a record of which nothing else is at hand, and parts that were joined.

use super::*;
use test_support::contains_all;

/// A block of a record, with nothing before and behind it.
fn cut_out(whole: &Field, rows: std::ops::Range<usize>) -> Field {
    let sites = whole.n_sites();
    let mut samples = vec![0.0; rows.len() * sites];
    whole.read_time_major(rows.clone(), 0..sites, &mut samples);
    let values = Array2::from_shape_vec((rows.len(), sites), samples).unwrap();
    let mut block = Field::from_array(values);
    block.name.clone_from(&whole.name);
    // Coordinates of a block round otherwise; those of the first one count.
    let rounding = if rows.start > 0 { 1e-15 } else { 0.0 };
    block.time.step = whole.time.step * (1.0 + rounding);
    block.time.origin = whole.time.at(rows.start);
    block
}

/// Blocks of the segments between these, of one record.
fn blocks_of(
    whole: &Field,
    request: &DividedRequest,
    [length, hop]: [usize; 2],
    cuts: &[usize],
) -> Vec<Partial> {
    let record = whole.n_times();
    let block = |ends: &[usize]| {
        let first = ends[0] * hop;
        let rows = first..((ends[1] - 1) * hop + length).min(record);
        let place = BlockPlace { first, record };
        partial_of_block(&cut_out(whole, rows), place, request, &Silent).unwrap()
    };
    cuts.windows(2).map(block).collect()
}

#[test]
fn regress_blocks_are_those_of_the_whole() {
    let whole = &shots(1, 1013)[0];
    // Segments of 64 samples every 32: 30; every 43: 23.
    for (request, hop, cuts) in [
        (DividedRequest::from(welch(64, 32)), 32, vec![0, 1, 7, 30]),
        (multitaper(64).into(), 43, vec![0, 22, 23]),
        (referred(9, averaging(64, 32)), 32, vec![0, 13, 14, 30]),
    ] {
        let parts = blocks_of(whole, &request, [64, hop], &cuts);
        let one = Part::new(1, 1).unwrap();
        let expected = partial(&[whole], &request, one, &Silent).unwrap();
        let known = combined(std::slice::from_ref(&expected));
        assert_near(&known, &super::whole(&[whole], &request));
        assert_near(&combined(&parts), &known);
        // Joined from behind and from before.
        let behind = join(&parts[1..], None).unwrap();
        assert!(behind.bytes() <= parts[1..].iter().map(Partial::bytes).sum());
        assert_near(&combined(&[behind, parts[0].clone()]), &known);
        assert_near(&combined(&[join(&parts, None).unwrap()]), &known);
    }
}

#[test]
fn regress_blocks_that_do_not_fit_are_refused() {
    let whole = &shots(1, 500)[0];
    let request = DividedRequest::from(welch(64, 32));
    let said = |rows: std::ops::Range<usize>, first, record| {
        let block = cut_out(whole, rows);
        let place = BlockPlace { first, record };
        partial_of_block(&block, place, &request, &Silent).map_err(|error| error.to_string())
    };
    assert!(said(0..63, 0, 500).is_err() && said(0..94, 1, 500).is_err());
    assert_eq!(said(0..95, 1, 500).unwrap().about.range, [1, 2]);
    assert!(said(0..100, 401, 500).is_err());
    // A gap is named by its place in the record.
    let mut values = Array2::zeros((64, 11));
    values[[5, 3]] = f64::NAN;
    let place = BlockPlace {
        first: 320,
        record: 500,
    };
    let error = partial_of_block(&Field::from_array(values), place, &request, &Silent).unwrap_err();
    contains_all(&error.to_string(), &["time row 325, site 3"]);
    // A gap between blocks.
    let parts = blocks_of(whole, &request, [64, 32], &[0, 2, 4, 14]);
    let error = join(&[&parts[0], &parts[2]], None).unwrap_err().to_string();
    assert!(error.contains("no segments 2 to 3"), "{error}");
    let error = combine(&parts[1..], None, None).unwrap_err().to_string();
    assert!(error.contains("no segments 0 to 1"), "{error}");
}
