//! Panels of curves, written as PNG and SVG: what the figure scripts share.

use std::path::Path;

#[allow(unused_imports)] // each script uses a part of them
pub use cascade::plot::{Curve, Panel, around};
use cascade::plot::{Format, draw_panels};

/// Draws the panels in rows of `columns` into `figures/out/<name>.png` and `.svg`.
pub fn save(
    name: &str,
    columns: usize,
    panels: &[Panel],
) -> Result<(), Box<dyn std::error::Error>> {
    let out = Path::new(env!("CARGO_MANIFEST_DIR")).join("figures/out");
    for format in [Format::Png, Format::Svg] {
        let file = out.join(format!("{name}.{}", format.extension()));
        let part = file.with_extension("part");
        std::fs::write(&part, draw_panels(name, columns, panels, format)?)?;
        std::fs::rename(&part, &file)?;
        println!("{}", file.display());
    }
    Ok(())
}
