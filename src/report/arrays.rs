//! The small arrays of `spectra.npz`: axes, measures along x and t, short-time spectra.

use super::Archive;
use crate::analyze::{Analysis, ShortTimeSpectra};
use crate::error::Result;

/// Appends everything of `analysis` that is an array to `archive`, under the names of the manual.
///
/// # Errors
/// [`crate::Error::Write`].
pub fn write_small_arrays(analysis: &Analysis, archive: &Archive) -> Result<()> {
    let line = |name: &str, values: &[f64]| archive.append(name, &[values.len()], values);
    let axes = &analysis.axes;
    line("time", &axes.times())?;
    line("position", &axes.positions())?;
    line("frequency", &axes.frequency)?;
    line("wavenumber", &axes.wavenumber)?;
    line("wavenumber_signed", &axes.wavenumber_signed)?;
    for (what, moments) in [
        ("frequency", &analysis.along_space),
        ("wavenumber", &analysis.along_time),
    ] {
        let Some(m) = moments else { continue };
        line(&format!("{what}_centroid"), &m.centroid)?;
        line(&format!("{what}_bandwidth"), &m.bandwidth)?;
        line(
            &format!("{what}_effective_bandwidth"),
            &m.effective_bandwidth,
        )?;
        line(&format!("{what}_entropy"), &m.entropy)?;
        line(&format!("{what}_participation"), &m.participation)?;
        line(&format!("{what}_zero_share"), &m.zero_share)?;
        line(&format!("{what}_median"), &m.median)?;
        line(&format!("{what}_90"), &m.quantile_90)?;
        line(&format!("low_{what}_share"), &m.low_share)?;
        line(&format!("high_{what}_share"), &m.high_share)?;
        line(&format!("{what}_energy"), &m.energy)?;
    }
    if let Some(front) = &analysis.front {
        line("front_arrival", &front.arrival)?;
        line("low_frequency_share_front", &front.low_share)?;
        line("high_frequency_share_front", &front.high_share)?;
    }
    if let Some([plus, minus]) = &analysis.direction_by_frequency {
        line("toward_plus_x_share", plus)?;
        line("toward_minus_x_share", minus)?;
    }
    if let [first, ..] = &analysis.dispersion[..] {
        line("dispersion_wavenumber", &first.wavenumber)?;
        let branches: Vec<&Vec<f64>> = analysis
            .dispersion
            .iter()
            .flat_map(|curve| &curve.branches)
            .collect();
        let shape = [branches.len(), first.wavenumber.len()];
        let values: Vec<f64> = branches.into_iter().flatten().copied().collect();
        archive.append("dispersion_frequency", &shape, &values)?;
    }
    let short = [
        (
            "short_time",
            "frequency",
            "time",
            "position",
            &analysis.short_time,
        ),
        (
            "short_space",
            "wavenumber",
            "position",
            "time",
            &analysis.short_space,
        ),
    ];
    for (name, bins, frames, at, spectra) in short {
        let Some(spectra) = spectra else { continue };
        let names = [bins, frames, at].map(|axis| format!("{name}_{axis}"));
        write_short(archive, &format!("{name}_spectrum"), &names, spectra)?;
    }
    Ok(())
}

fn write_short(
    archive: &Archive,
    name: &str,
    [bins, frames, at]: &[String; 3],
    spectra: &ShortTimeSpectra,
) -> Result<()> {
    let stacked = spectra.stacked();
    let (n, m, s) = stacked.dim();
    // A new array is contiguous, in order.
    archive.append(name, &[n, m, s], stacked.as_slice().unwrap_or_default())?;
    archive.append(bins, &[m], &spectra.bins)?;
    archive.append(frames, &[s], &spectra.frames)?;
    let places: Vec<f64> = spectra.spectra.iter().map(|one| one.at).collect();
    archive.append(at, &[n], &places)
}
