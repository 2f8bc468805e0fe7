//! Titles and captions of curves and short-time maps.

use crate::analyze::ShortTimeSpectra;

pub(super) fn title(id: &str) -> &'static str {
    match id {
        "short-time" => "Short-time spectrum",
        "short-space" => "Short-space spectrum",
        "profile-along-x" => "Energy moved in frequency, along x",
        "profile-in-time" => "Energy moved in wavenumber, in time",
        "moved-along-x" => "Cumulative spectra C(f) along x",
        _ => "Cumulative spectra C(k) in time",
    }
}

pub(super) fn short_caption(id: &str, spectra: &ShortTimeSpectra) -> String {
    let (what, unit) = match id {
        "short-time" => ("this site's record: when each frequency arrives", "samples"),
        _ => (
            "the profile at this time: where each wavenumber is",
            "sites",
        ),
    };
    format!(
        "Spectra of short pieces of {what}. Segments of {} {unit}, {} apart, window {}.",
        spectra.segment, spectra.hop, spectra.window.name
    )
}

pub(super) fn curve_caption(id: &str) -> &'static str {
    match id {
        "profile-along-x" => {
            "The share of the energy that lies above a frequency at a group of sites and below it at the first one \
             (up), or the reverse (down), with 95 % intervals. A curve that rises and falls is a move that comes back."
        }
        "profile-in-time" => {
            "The share of the energy that lies above a wavenumber at some times and below it at the first ones (up), or the \
             reverse (down), with 95 % intervals, while the wave is inside."
        }
        "moved-along-x" => {
            "The gap between bold curves is what moved. A curve to the right of another has \
             its energy at higher frequency; curves that coincide have moved nothing. Colours run along x, from blue to \
             orange; thin curves are other groups of sites. Energy is that of the front window of a pulse, or of \
             the record of a steady field, noise subtracted, each group's total being 1."
        }
        "moved-in-time" => {
            "The gap between bold curves is what moved. They are averages over times at which the wave is inside. \
             A curve to the right of another has its energy at higher wavenumber. Colours run in time, from blue to \
             orange."
        }
        "along-x" => {
            "Centroid, median and 90 % frequency of each site, and its energy, over the whole record."
        }
        "along-t" => {
            "Centroid, median and 90 % wavenumber at each time, and the energy. A wall or the end of the record shows as \
             a step."
        }
        _ => {
            "Share of the energy that travels each way. What is missing to 1 has no direction: it \
             lies on f = 0, on k = 0 or on a Nyquist line."
        }
    }
}
