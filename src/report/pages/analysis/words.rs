//! Titles, captions and definitions.

use maud::Markup;

use crate::analyze::{Analysis, Scaling, ShortTimeSpectra};
use crate::report::page;

/// A share as a percentage.
pub(super) fn percent(share: f64) -> String {
    match share.is_finite() {
        true => format!("{:.2} %", 100.0 * share),
        false => "undefined (no energy)".into(),
    }
}

pub(super) fn title(id: &str) -> &'static str {
    match id {
        "field" => "Field v(t, x)",
        "temporal" => "Temporal spectrum S(f, x)",
        "spatial" => "Spatial spectrum S(k, t)",
        "spacetime" => "Space-time spectrum S(k, f)",
        "flux" => "Kinetic flux surrogate Π_K(k, t)",
        "short-time" => "Short-time spectrum",
        "short-space" => "Short-space spectrum",
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
             the dashed line is the edge between the low and the high band."
        }
        "spatial" => {
            "Which wavenumbers the field holds at each time. A cascade spreads to the right as \
             time goes on; the dashed line is the edge between the low and the high band."
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
            "Centroid, median and 90 % frequency of each site, the shares of energy in the two \
             bands, over the whole record and over the passage of the front, and the energy itself. \
             Content that moves up while energy stays is a cascade."
        }
        "along-t" => {
            "Centroid, median and 90 % wavenumber at each time, the shares of energy in the two \
             bands, and the energy itself. A wall or the end of the record shows as a step."
        }
        _ => {
            "Share of the energy that travels each way. What is missing to 1 has no direction: it \
             lies on f = 0, on k = 0 or on a Nyquist line."
        }
    }
}

pub(super) fn how_to_read(analysis: &Analysis) -> Markup {
    let scaling = match analysis.conventions.scaling {
        Scaling::Energy => {
            "Energy spectral density of a transient: its integral is the sum of squares times the \
             sample spacing."
        }
        Scaling::Density => "Power spectral density: its integral is the mean square.",
        Scaling::Spectrum => "Power spectrum: a sine of amplitude A peaks at A²/2.",
    };
    let definitions = [
        (
            "Moved share",
            "The largest difference of two cumulative spectra: the share of energy that lies above a frequency at \
             one place and below it at the other (up), or the reverse (down).",
        ),
        (
            "Front, tail",
            "The front is the energy within ten widths of the pulse from each arrival on; the tail is what follows.",
        ),
        (
            "Launch, travel, settled",
            "The front of a struck chain has settled at the first bodies from which no later ones differ; the launch \
             is the way there, the travel the way from there on.",
        ),
        ("Spectra", scaling),
        (
            "Frequency and wavenumber",
            "f counts cycles, k counts rad; k a / π = 1 is the Nyquist wavenumber of sites spaced \
             a apart.",
        ),
        (
            "Direction",
            "Waves exp(i (k x − ω t)): for f > 0, k > 0 travels towards +x.",
        ),
        (
            "Centroid, median, 90 %",
            "The mean of f (or k) weighted by energy, every bin counted; where the cumulative energy \
             reaches 50 % and 90 %, read off at the ends of bins, each of which stands for half a bin \
             to both sides.",
        ),
        (
            "Effective bandwidth",
            "exp(− ∫ p ln p df) of the spectrum p of unit integral: the width of a flat spectrum of the \
             same entropy.",
        ),
        (
            "Bands",
            "The low band ends at the band edge, stated above; the high band is the rest.",
        ),
        (
            "Front passage",
            "Shares over a window of the same length at all sites, from each arrival on (the magnitude \
             first exceeds a hundredth of the site's largest). Shares of the whole record depend on how \
             long it is.",
        ),
        (
            "Parseval residual",
            "Energy in the transform domain over energy of the prepared samples, less 1.",
        ),
        (
            "Flux surrogate",
            "Π_K(k, t) = − d/dt of the kinetic energy in wavenumbers up to k.",
        ),
        (
            "Undefined",
            "A site or time with less than a millionth of the largest energy, or less than the noise \
             where that is known, has no centroid and no shares: a gap in the curves.",
        ),
    ];
    page::how_to_read(&definitions)
}
