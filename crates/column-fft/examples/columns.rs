//! Spectra of all columns of a slice, and back.
//!
//! `cargo run -p column-fft --example columns --no-default-features`

use std::f64::consts::TAU;

use column_fft::{ColumnFftPlanner, Columns, ColumnsMut, Complex, FftError};

fn main() -> Result<(), FftError> {
    // Column c holds a cosine of c periods.
    let (rows, columns) = (1000, 40);
    let wave = |i: usize| {
        let (n, c) = (i / columns, i % columns);
        (TAU * (n * c % rows) as f64 / rows as f64).cos()
    };
    let signal: Vec<f64> = (0..rows * columns).map(wave).collect();

    let mut planner = ColumnFftPlanner::<f64>::new();
    let forward = planner.plan_fft_forward(rows)?;
    let inverse = planner.plan_fft_inverse(rows)?;
    let bins = forward.bins();
    println!(
        "{:?} by {:?}, relative error {:.1e}",
        forward.algorithm(),
        forward.instruction_set(),
        forward.expected_error()
    );

    let mut scratch = forward.make_scratch(columns);
    let mut spectra = vec![Complex::default(); bins * columns];
    forward.process_with_scratch(
        Columns::new(&signal, rows, columns, columns)?,
        ColumnsMut::new(&mut spectra, bins, columns, columns)?,
        &mut scratch,
    )?;
    // All of column 7 is in bin 7: half of N of it.
    println!("bin 7 of column 7: {:.3}", spectra[7 * columns + 7]);

    let mut again = vec![0.0; rows * columns];
    inverse.process(
        Columns::new(&spectra, bins, columns, columns)?,
        ColumnsMut::new(&mut again, rows, columns, columns)?,
    )?;
    let apart = |(a, b): (&f64, &f64)| (a / rows as f64 - b).abs();
    let largest = again.iter().zip(&signal).map(apart).fold(0.0, f64::max);
    println!("there and back: {largest:.1e} apart");
    assert!(largest < 1e-14);
    Ok(())
}
