//! A stationary record: Welch's method with a taper, scaled as a power spectral density.

use wavecascade::analyze;
use wavecascade::analyze::{Request, Results, Scaling, Welch};
use wavecascade::arrays::LargeArray;
use wavecascade::prepare::{Detrend, Window};
use wavecascade::reference::{Grid, WhiteNoise};

fn main() -> wavecascade::Result<()> {
    let noise = WhiteNoise {
        grid: Grid {
            n_times: 16_384,
            n_sites: 16,
            dt: 1e-3,
            dx: 0.5,
        },
        deviation: 2.0,
        seed: 7,
    };
    let request = Request {
        results: Results {
            temporal: true,
            ..Results::NONE
        },
        scaling: Scaling::Density,
        window_time: Window::Hann,
        detrend_time: Detrend::Mean,
        welch: Some(Welch {
            segment: 512,
            overlap: 256,
        }),
        ..Request::default()
    };

    let (analysis, spectra) = analyze(&noise.field(), &request)?;

    let gains = &analysis.conventions.window_time;
    println!(
        "{} segments, {} window, noise bandwidth {:.2} bins",
        analysis.conventions.segments, gains.name, gains.noise_bandwidth_bins
    );
    if let Some(density) = spectra[&LargeArray::TEMPORAL_SPECTRUM].mean() {
        // White noise of deviation 2 m/s spreads 4 m^2/s^2 over the 500 Hz up to Nyquist.
        println!(
            "density {density:.5} m^2/s^2/Hz, expected {:.5}",
            4.0 / 500.0
        );
        assert!((density / 0.008 - 1.0).abs() < 0.02);
    }
    Ok(())
}
