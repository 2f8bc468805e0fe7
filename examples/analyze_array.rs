//! An array of one's own, its axes stated, analyzed in memory.

use ndarray::Array2;
use wavecascade::analyze::Request;
use wavecascade::arrays::LargeArray;
use wavecascade::field::Axis;
use wavecascade::{Field, analyze};

fn main() -> wavecascade::Result<()> {
    // A pulse that travels towards +x at 340 m/s and spreads on the way.
    let (dt, dx, speed) = (1e-4, 0.1, 340.0);
    let pulse = Array2::from_shape_fn((2048, 128), |(n, j)| {
        let width = 1e-3 + 2e-5 * j as f64;
        let s = (n as f64 * dt - j as f64 * dx / speed - 0.05) / width;
        (1.0 - s * s) * (-0.5 * s * s).exp()
    });
    let mut field = Field::from_array(pulse);
    field.time = Axis {
        origin: 0.0,
        step: dt,
        unit: Some("s".into()),
    };
    field.space = Axis {
        origin: 0.0,
        step: dx,
        unit: Some("m".into()),
    };

    let (analysis, spectra) = analyze(&field, &Request::default())?;

    if let (Some(direction), Some(along)) = (&analysis.direction, &analysis.along_space) {
        println!("share of energy towards +x  {:.4}", direction.toward_plus_x);
        println!(
            "frequency centroid          {:.1} Hz at the first site, {:.1} Hz at the last",
            along.centroid[0], along.centroid[127]
        );
        assert!(direction.toward_plus_x > 0.95);
        assert!(along.centroid[127] < along.centroid[0]);
    }
    let spectrum = &spectra[&LargeArray::SPACETIME_SPECTRUM];
    println!("S(k, f) is {:?}", spectrum.dim());
    Ok(())
}
