//! Short-time spectra of all channels of a recording: the bin of the largest power, segment by segment.
//!
//! `cargo run -p column-fft --example spectrogram`

use std::f64::consts::PI;

use column_fft::{Complex, FftError, ShortTimeColumns};
use ndarray::{Array2, Array3, s};

fn main() -> Result<(), FftError> {
    let (times, channels, length, hop) = (4096, 64, 256, 512);
    // Chirps: channel c rises c times as fast as channel 1.
    let chirp = |(n, c): (usize, usize)| {
        let t = n as f64 / times as f64;
        (PI * 8.0 * c as f64 * t * t).sin()
    };
    let recording = Array2::from_shape_fn((times, channels), chirp);
    let hann: Vec<f64> = (0..length)
        .map(|n| (PI * n as f64 / length as f64).sin().powi(2))
        .collect();

    let plan = ShortTimeColumns::<f64>::new(&hann, hop)?;
    let shape = (plan.segments(times), plan.bins(), channels);
    let mut spectra = Array3::<Complex<f64>>::default(shape);
    plan.process_in_parallel(recording.view(), spectra.view_mut())?;

    for (segment, spectra) in spectra.outer_iter().enumerate() {
        let column = spectra.slice(s![.., 63]);
        let powers = column.iter().map(|x| x.norm_sqr()).enumerate();
        let largest = powers.max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((bin, _)) = largest {
            println!("segment {segment}: channel 63 is loudest in bin {bin}");
        }
    }
    Ok(())
}
