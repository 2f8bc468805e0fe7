//! The space-time spectrum of a struck harmonic lattice.
//!
//! Equation: unit masses and springs, `v_j(0)` = 1 at site 0 and 0 elsewhere, so that
//! `v_j(t) = J_2j(2 t)` and waves obey `omega = 2 sin(k / 2)`.
//! Command: `cargo run --release -p figures --bin lattice_impact`; under a second.
//! Shows: the energy lies on the dispersion curve at k > 0, up to the band edge `omega = 2`; 95 % of
//! it travels towards +x. Nothing propagates above the edge: the rest leaks from the ends of the
//! record, evenly to both sides. The dashed curve is the dispersion relation that the field's
//! sidecar states.
//! Asserts: the ridge lies on the dispersion curve, to a bin of frequency and what a bin of
//! wavenumber moves it.

use std::f64::consts::PI;

use wavecascade::analyze::{Request, Results};
use wavecascade::arrays::LargeArray;
use wavecascade::field::OpenOptions;
use wavecascade::plot::{Format, Style, figures_of};
use wavecascade::sheet::Describe;
use wavecascade::{Field, analyze};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let root = figures::root();
    let path = root.join("examples/data/lattice_impact.npy");
    let field = Field::open(path, &OpenOptions::default())?;
    let request = Request {
        results: Results {
            spacetime: true,
            ..Results::NONE
        },
        ..Request::default()
    };
    let (analysis, spectra) = analyze(&field, &request)?;

    let spectrum = &spectra[&LargeArray::SPACETIME_SPECTRUM];
    let axes = &analysis.axes;
    let mut farthest = 0.0f64;
    for (&k, column) in axes.wavenumber_signed.iter().zip(spectrum.columns()) {
        if !(0.3..2.8).contains(&k) {
            continue;
        }
        let mut ridge = (0, 0.0);
        for (m, &p) in column.iter().enumerate() {
            if p > ridge.1 {
                ridge = (m, p);
            }
        }
        let expected = (k / 2.0).sin() / PI;
        farthest = farthest.max((axes.frequency[ridge.0] - expected).abs());
    }
    // One bin of frequency; half a bin of k moves the curve by at most dk / (4 pi).
    let allowed = axes.frequency[1] + axes.wavenumber[1] / (4.0 * PI);
    println!("ridge within {farthest:.4} of the dispersion curve, allowed {allowed:.4}");
    assert!(farthest < allowed);

    let out = root.join("figures/out");
    let (sheet, style) = (analysis.describe(), Style::screen());
    let figures = figures_of(&analysis, &sheet, &analysis.name, "analyze", &style);
    let figure = figures
        .iter()
        .find(|figure| figure.name() == "spacetime-spectrum");
    let figure = figure.ok_or("nothing to draw")?;
    for (format, extension) in [(Format::Png, "png"), (Format::Svg, "svg")] {
        let named = out.join(format!("lattice_impact.{extension}"));
        std::fs::rename(figure.save(&out, format)?, &named)?;
        println!("{}", named.display());
    }
    Ok(())
}
