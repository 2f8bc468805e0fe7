//! Options of `cascade analyze` that would have no effect.

use wavecascade::Error;
use wavecascade::prepare::Window;

use crate::args::{Analyze, ResultArg};
use crate::figure_args::FigureArg;

/// That no option is for results that `--only` leaves out.
pub fn refuse_without_effect(typed: &Analyze) -> Result<(), Error> {
    use ResultArg::{Flux, ShortTime, Spacetime, Spatial, Temporal};
    let Analyze {
        spectra,
        bands,
        short_time,
        ..
    } = typed;
    let only = &typed.work.only;
    if typed.figures.figures.contains(&FigureArg::None)
        && let Some(option) = typed.show.typed().next()
    {
        return Err(Error::Request {
            option,
            expected: "figures to show it: it has no effect without".into(),
            found: "`--figures none`".into(),
        });
    }
    let short = &[ShortTime][..];
    let along_time = &[Temporal, Spacetime][..];
    // Short-space spectra are of times that are asked for.
    let along_space_or_short = match short_time.short_time_times.is_empty() {
        true => &[Spatial, Spacetime, Flux][..],
        false => &[Spatial, Spacetime, Flux, ShortTime],
    };
    let along_space = &[Spatial, Spacetime, Flux][..];
    let options = [
        ("segment", spectra.segment.is_some(), along_time),
        ("pad-time", spectra.pad_time.is_some(), along_time),
        ("pad-space", spectra.pad_space.is_some(), along_space),
        (
            "reference-site",
            bands.reference_site.is_some(),
            &[Temporal],
        ),
        (
            "band-edge-frequency",
            bands.band_edge_frequency.is_some(),
            &[Temporal],
        ),
        ("reference-time", bands.reference_time.is_some(), &[Spatial]),
        (
            "band-edge-wavenumber",
            bands.band_edge_wavenumber.is_some(),
            &[Spatial],
        ),
        (
            "direction-band",
            bands.direction_band.is_some(),
            &[Spacetime],
        ),
        (
            "dispersion",
            !typed.dispersion.dispersion.is_empty(),
            &[Spacetime],
        ),
        (
            "show-frequency",
            typed.show.show_frequency.is_some(),
            &[Temporal, Spacetime, ShortTime],
        ),
        (
            "show-wavenumber",
            typed.show.show_wavenumber.is_some(),
            along_space_or_short,
        ),
        (
            "short-time-sites",
            !short_time.short_time_sites.is_empty(),
            short,
        ),
        (
            "short-time-times",
            !short_time.short_time_times.is_empty(),
            short,
        ),
        (
            "short-time-segment",
            short_time.short_time_segment.is_some(),
            short,
        ),
        ("short-time-hop", short_time.short_time_hop.is_some(), short),
        (
            "short-time-window",
            short_time.short_time_window != Window::USUAL,
            short,
        ),
    ];
    let is_useless = |results: &[ResultArg]| {
        !only.is_empty() && !results.iter().any(|result| only.contains(result))
    };
    let useless = options
        .into_iter()
        .find(|(_, typed, results)| *typed && is_useless(results));
    match useless {
        None => Ok(()),
        Some((option, _, results)) => Err(Error::Request {
            option,
            expected: format!(
                "{} among `--only`: it has no effect on others",
                names(results)
            ),
            found: names(only),
        }),
    }
}

fn names(results: &[ResultArg]) -> String {
    use clap::ValueEnum;
    let values = results.iter().filter_map(ResultArg::to_possible_value);
    let names: Vec<String> = values
        .map(|value| format!("`{}`", value.get_name()))
        .collect();
    names.join(" or ")
}
