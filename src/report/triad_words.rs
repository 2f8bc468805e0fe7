//! What triads say, in sentences.

use super::{number, percent};
use crate::budget::Triads;

/// Name and sentence of each finding: the flux, the triads that carry it, what is not of triads.
pub fn triad_sentences(found: &Triads) -> Vec<(String, String)> {
    let unit = match &found.units.length {
        Some(unit) => format!("rad/{unit}"),
        None => "rad per site".into(),
    };
    let at = found.locality.at;
    let (flux, error) = (found.flux[at], found.flux_error());
    let of_energy = |energy: f64| percent(energy.abs() / found.energy);
    let mut sentences = Vec::new();
    let mut say = |name: &str, text: String| sentences.push((name.to_owned(), text));
    let beyond = percent(found.share_beyond());
    if !found.is_quadratic() {
        say(
            "triads",
            format!(
                "none are stated: terms beyond the quadratic one moved {beyond} as much energy as it did, so that the \
                 law has no useful expansion at these amplitudes"
            ),
        );
    } else if !found.is_resolved() {
        say(
            "flux",
            format!(
                "none is resolved: the largest, {} of the energy, is not ten times its error, {}",
                of_energy(flux),
                of_energy(error)
            ),
        );
    } else {
        let towards = if flux > 0.0 { "larger" } else { "smaller" };
        say(
            "flux",
            format!(
                "largest past k = {} {unit}: {} of the energy, towards {towards} wavenumbers (error {})",
                number(found.wavenumber[at]),
                of_energy(flux),
                of_energy(error)
            ),
        );
        let within = |factor| percent(found.locality.share_below(factor));
        say(
            "locality",
            format!(
                "triads whose wavenumbers are within a factor of 4 carry {} of it, within 8 {}",
                within(4.0),
                within(8.0)
            ),
        );
    }
    if found.is_quadratic() {
        let text = match found.beyond {
            Some(_) => format!("terms beyond the quadratic one moved {beyond} as much energy"),
            None => "the force has no other terms".into(),
        };
        say("expansion", text);
    }
    let unexplained = found.unexplained();
    let most = unexplained
        .iter()
        .fold(0.0, |m: f64, value| m.max(value.abs()));
    say(
        "balance",
        format!(
            "no wavenumber changed by more than {} of the energy for other reasons (losses, drives, ends, sampling)",
            of_energy(most)
        ),
    );
    sentences
}
