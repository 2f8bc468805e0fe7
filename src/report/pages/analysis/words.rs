//! Titles and captions of pictures.

use crate::analyze::ShortTimeSpectra;

pub(super) fn title(id: &str) -> &'static str {
    match id {
        "field" => "Field v(t, x)",
        "temporal" => "Temporal spectrum S(f, x)",
        "spatial" => "Spatial spectrum S(k, t)",
        "spacetime" => "Space-time spectrum S(k, f)",
        "flux" => "Kinetic flux surrogate Π_K(k, t)",
        "short-time" => "Short-time spectrum",
        "short-space" => "Short-space spectrum",
        "profile-along-x" => "Energy moved in frequency, along x",
        "profile-in-time" => "Energy moved in wavenumber, in time",
        "moved-along-x" => "Cumulative spectra C(f) along x",
        "moved-in-time" => "Cumulative spectra C(k) in time",
        "along-x" => "Frequency content along x",
        "along-t" => "Wavenumber content along t",
        _ => "Direction of travel at each frequency",
    }
}

/// What a map shows, and what to look for.
pub(super) fn shows(id: &str) -> &'static str {
    match id {
        "field" => {
            "The samples themselves. Slopes are speeds: a steeper band is slower. Look for the \
             leading pulse, what it leaves behind, and reflections."
        }
        "temporal" => {
            "Which frequencies each site sees. A cascade fills the top of the picture as x grows; \
             the dashed line is the frequency past which energy moves."
        }
        "spatial" => {
            "Which wavenumbers the field holds at each time. A cascade spreads to the right as \
             time goes on; the dashed line is the wavenumber past which energy moves."
        }
        "spacetime" => {
            "Energy by wavenumber and frequency: the right half travels towards +x, the left half \
             towards −x. Ridges are dispersion curves, gaps are band gaps; in a chain with a \
             cell of two sites, folding shows a few per cent of a one-way wave on the other side."
        }
        _ => {
            "Rate at which kinetic energy leaves the wavenumbers up to k, from velocity alone: \
             positive towards high k. It counts exchange with contact energy too, so read it as \
             a surrogate and compare it with an exact budget where one can be had."
        }
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
