//! Findings that do not stop a run but that its user should know.

use serde_json::{Map, Value, json};

use super::Axes;
use super::quality::COMMON_SHARE;
use crate::field::Note;
use crate::measure::digits;
use crate::sheet;

/// How much louder than those beside it a site is that is too loud.
pub(super) const LOUD: f64 = 100.0;

/// Sites of a finding, by index in the file and by position.
#[derive(Debug, Clone, PartialEq)]
pub struct Sites {
    pub indices: Vec<usize>,
    pub positions: Vec<f64>,
    /// Unit of the positions; `None` where sites are counted.
    pub unit: Option<String>,
}

impl Sites {
    /// Rows of the range analyzed, the first of which is the site `first` of the file.
    pub(super) fn of(rows: &[usize], first: usize, axes: &Axes) -> Sites {
        let space = &axes.space;
        let is_counted = space.unit.is_none() && space.step == 1.0;
        Sites {
            indices: rows.iter().map(|j| first + j).collect(),
            positions: rows.iter().map(|j| space.at(*j)).collect(),
            unit: (!is_counted).then(|| axes.space_unit().to_owned()),
        }
    }

    /// The first few, in words: `3, 7 at 0.3, 0.7 m`.
    fn words(&self) -> String {
        let indices = some(self.indices.iter().map(usize::to_string).collect());
        let Some(unit) = &self.unit else {
            return indices;
        };
        let positions = some(self.positions.iter().map(|x| rounded(*x)).collect());
        format!("{indices} at {positions} {unit}")
    }
}

/// A finding about the data or the request, with its numbers.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// Share of energy in the top tenth of the frequency axis.
    AliasingTime { share: f64, above: f64 },
    /// Share of energy in the top tenth of the wavenumber axis.
    AliasingSpace { share: f64, above: f64 },
    /// Sites whose record is constant.
    DeadChannels { sites: Sites },
    /// Sites that sit on their largest or smallest value for runs of samples.
    SaturatedChannels { sites: Sites, longest: usize },
    /// Sites that are far quieter than both beside them, at most two neighbours; `ratio` is that of the quietest
    /// amplitude to the median.
    QuietChannels { sites: Sites, ratio: f64 },
    /// Sites that are far louder than those beside them: at most two neighbours; `ratio` is that of the
    /// loudest amplitude to the median.
    LoudChannels { sites: Sites, ratio: f64 },
    /// Sites with far more energy in the top tenth of the frequency axis than those beside them: at most two
    /// neighbours; `ratio` of these energies.
    NoisyChannels { sites: Sites, ratio: f64 },
    /// Sites from which on records are `ratios` times as large as those before them, noise included.
    GainSteps {
        sites: Sites,
        ratios: Vec<f64>,
        /// Half of their 95 % intervals.
        errors: Vec<f64>,
    },
    /// Sites whose records become `ratios` times as large at `times`, while those beside them do not.
    GainChanges {
        sites: Sites,
        times: Vec<f64>,
        time_unit: String,
        ratios: Vec<f64>,
    },
    /// Noise was subtracted from spectra along time: at how many sites, and bins that would have been negative.
    NoiseSubtracted {
        known: usize,
        sites: usize,
        clipped: usize,
        bins: usize,
    },
    /// Sites that were left out on request.
    SitesLeftOut { sites: Sites },
    /// Times at which all sites are zero, between others at which they are not: from the first to the
    /// last of them.
    ZeroTimes {
        times: usize,
        first: usize,
        last: usize,
    },
    /// Share of energy in the first `times`, at which the level is `ratio` times that of the second half
    /// of the record, while the rest is steady.
    StartUp {
        times: usize,
        share: f64,
        ratio: f64,
    },
    /// Share of energy common to all sites (k = 0), and the line that holds most of it, in `frequency_unit`.
    CommonMode {
        share: f64,
        /// The frequency of its line, if it is one, and half the distance of bins.
        line: Option<[f64; 2]>,
        frequency_unit: String,
    },
    /// Share of energy at f = 0.
    Static { share: f64 },
    /// Untapered records whose ends do not meet: mean step between last and first sample,
    /// relative to the records' root mean square.
    LeakageTime { step: f64 },
    /// The same for the profiles along x.
    LeakageSpace { step: f64 },
    /// Samples that were not finite and were filled or masked.
    Gaps {
        samples: u64,
        sites: usize,
        share: f64,
    },
    /// Energy in the first or the last twentieth of the record: a transient cut at its ends.
    TransientCut { first: f64, last: f64 },
    /// Squares of the amplitudes leave the number range; spectra are in units of `unit^2`.
    Unrepresentable { largest: f64, unit: f64 },
    /// The quantity is no velocity, so no kinetic energy can be followed.
    NoKineticEnergy,
    /// Nothing but zeros.
    NoEnergy,
    /// A doubtful conclusion about the file of the field.
    Reading { note: Note },
}

/// Error of a frequency, as a part of it, up to which it is not said.
const KNOWN: f64 = 0.01;

impl Warning {
    /// Stable name, for programs.
    pub fn code(&self) -> &'static str {
        match self {
            Warning::AliasingTime { .. } => "aliasing-time",
            Warning::AliasingSpace { .. } => "aliasing-space",
            Warning::DeadChannels { .. } => "dead-channels",
            Warning::SaturatedChannels { .. } => "saturated-channels",
            Warning::QuietChannels { .. } => "quiet-channels",
            Warning::LoudChannels { .. } => "loud-channels",
            Warning::NoisyChannels { .. } => "noisy-channels",
            Warning::GainSteps { .. } => "gain-steps",
            Warning::GainChanges { .. } => "gain-changes",
            Warning::SitesLeftOut { .. } => "sites-left-out",
            Warning::NoiseSubtracted { .. } => "noise-subtracted",
            Warning::ZeroTimes { .. } => "zero-times",
            Warning::StartUp { .. } => "start-up",
            Warning::CommonMode { .. } => "common-mode",
            Warning::Static { .. } => "static",
            Warning::LeakageTime { .. } => "leakage-time",
            Warning::LeakageSpace { .. } => "leakage-space",
            Warning::Gaps { .. } => "gaps",
            Warning::TransientCut { .. } => "transient-cut",
            Warning::Unrepresentable { .. } => "unrepresentable",
            Warning::NoKineticEnergy => "no-kinetic-energy",
            Warning::NoEnergy => "no-energy",
            Warning::Reading { note } => note.code(),
        }
    }

    /// Whether it is not known which axis is time.
    pub(crate) fn is_of_layout(&self) -> bool {
        matches!(
            self,
            Warning::Reading {
                note: Note::Wide { .. }
            }
        )
    }

    /// Whether most of the energy lies in a line that all sites have in common.
    pub(super) fn is_hum(&self) -> bool {
        matches!(self, Warning::CommonMode { share, line: Some(_), .. } if *share > 0.5)
    }

    /// Takes the line from what is common to all sites: pulses hum at no frequency. Whether the warning holds of them.
    pub(super) fn is_of_pulses(&mut self) -> bool {
        match self {
            Warning::CommonMode { share, line, .. } => {
                *line = None;
                *share > COMMON_SHARE
            }
            _ => true,
        }
    }

    /// Whether it is about single channels.
    pub(super) fn is_of_channels(&self) -> bool {
        matches!(
            self,
            Warning::Gaps { .. }
                | Warning::DeadChannels { .. }
                | Warning::QuietChannels { .. }
                | Warning::SaturatedChannels { .. }
                | Warning::LoudChannels { .. }
                | Warning::NoisyChannels { .. }
                | Warning::GainSteps { .. }
                | Warning::GainChanges { .. }
        )
    }

    /// One sentence with the numbers.
    pub fn message(&self) -> String {
        match self {
            Warning::AliasingTime { share, above } => format!(
                "{} of the energy lies above frequency {}, in the top tenth below Nyquist",
                percent(*share),
                rounded(*above)
            ),
            Warning::AliasingSpace { share, above } => format!(
                "{} of the energy lies above wavenumber {}, in the top tenth below Nyquist",
                percent(*share),
                rounded(*above)
            ),
            Warning::DeadChannels { sites } => match sites.indices.len() {
                1 => format!("the record of site {} is constant", sites.words()),
                n => format!("{n} of the records are constant: sites {}", sites.words()),
            },
            Warning::SaturatedChannels { sites, longest } => format!(
                "{} of the records stay on their extreme value for up to {longest} samples: sites {}",
                sites.indices.len(),
                sites.words()
            ),
            Warning::QuietChannels { sites, ratio } => format!(
                "{} of the sites are less than 1/{LOUD} as loud as both beside them, down to {} of the median: \
                 sites {}",
                sites.indices.len(),
                rounded(*ratio),
                sites.words()
            ),
            Warning::LoudChannels { sites, ratio } if sites.indices.len() == 1 => format!(
                "site {} is more than {LOUD} times as loud as those beside it, {} times the median",
                sites.words(),
                rounded(*ratio)
            ),
            Warning::LoudChannels { sites, ratio } => format!(
                "{} of the sites are more than {LOUD} times as loud as those beside them, up to {} times \
                 the median: sites {}",
                sites.indices.len(),
                rounded(*ratio),
                sites.words()
            ),
            Warning::NoisyChannels { sites, ratio } => format!(
                "{} of the sites have up to {} times the energy of those beside them in the top tenth below \
                 Nyquist: sites {}",
                sites.indices.len(),
                rounded(*ratio),
                sites.words()
            ),
            Warning::GainSteps {
                sites,
                ratios,
                errors,
            } => {
                let ratios = ratios.iter().zip(errors);
                let ratios = ratios.map(|(ratio, error)| sheet::with_half(*ratio, *error, ""));
                format!(
                    "the gain changes along x: x {} from site {} on",
                    some(ratios.collect()),
                    sites.words()
                )
            }
            Warning::GainChanges {
                sites,
                times,
                time_unit,
                ratios,
            } => format!(
                "the gain changes in time: x {} at {} {time_unit}, site {}",
                some(ratios.iter().map(|r| short(*r)).collect()),
                some(times.iter().map(|t| short(*t)).collect()),
                sites.words()
            ),
            Warning::NoiseSubtracted {
                known,
                sites,
                clipped,
                bins,
            } => format!(
                "noise is subtracted at {known} of {sites} sites, where it is known; {clipped} of {bins} bins were \
                 below it and are 0, which leaves a part of it: front windows, short-time spectra and spectra along \
                 space keep all of it"
            ),
            Warning::SitesLeftOut { sites } => {
                let which = match sites.indices.len() {
                    1 => format!("site {} is left out", sites.words()),
                    many => format!("{many} sites are left out: {}", sites.words()),
                };
                format!(
                    "{which}; spectra along space, which need sites at even distances, are not computed"
                )
            }
            Warning::ZeroTimes { times, first, last } => format!(
                "all sites are zero at {times} times between others, from row {first} to row {last}"
            ),
            Warning::StartUp {
                times,
                share,
                ratio,
            } => format!(
                "{} of the energy lies in the first {times} samples, where it is {} times that of the second \
                 half of the record",
                percent(*share),
                rounded(*ratio)
            ),
            Warning::CommonMode {
                share,
                line: Some([line, half]),
                frequency_unit,
            } => {
                let error = match half > &(KNOWN * line) {
                    true => format!(
                        " ± {}",
                        short(format!("{half:.0e}").parse().unwrap_or(*half))
                    ),
                    false => String::new(),
                };
                format!(
                    "{}{error} {frequency_unit} common to all sites (k = 0) holds {:.0} % of the energy",
                    short(*line),
                    100.0 * share
                )
            }
            Warning::CommonMode { share, .. } => format!(
                "{} of the energy is common to all sites (k = 0)",
                percent(*share)
            ),
            Warning::Static { share } => format!(
                "{} of the energy lies at f = 0: means of the records, not their motion, decide centroids",
                percent(*share)
            ),
            Warning::LeakageTime { step } => format!(
                "untapered records jump from their last to their first sample by {step:.3} of their \
                 root mean square; the jump leaks over all frequencies"
            ),
            Warning::LeakageSpace { step } => format!(
                "untapered profiles jump from the last to the first site by {step:.3} of their root \
                 mean square; the jump leaks over all wavenumbers"
            ),
            Warning::Gaps {
                samples,
                sites,
                share,
            } => format!(
                "{samples} samples at {} were not finite ({} of the field)",
                match sites {
                    1 => "one site".into(),
                    _ => format!("{sites} sites"),
                },
                percent(*share)
            ),
            Warning::TransientCut { first, last } => format!(
                "{} of the energy lies in the first and {} in the last twentieth of the record",
                percent(*first),
                percent(*last)
            ),
            Warning::Unrepresentable { largest, unit } => format!(
                "squares of amplitudes up to {} leave the number range; spectra are in units of \
                 (2^{})^2, 2^{1} being {}",
                rounded(*largest),
                unit.log2().round(),
                rounded(*unit)
            ),
            Warning::NoKineticEnergy => {
                "the quantity is not a velocity, so no kinetic flux surrogate is given".into()
            }
            Warning::NoEnergy => "the prepared field is zero everywhere".into(),
            Warning::Reading { note } => note.message(),
        }
    }

    /// What the user can do about it.
    pub fn advice(&self) -> &'static str {
        match self {
            Warning::AliasingTime { .. } => {
                "sample faster, or low-pass before sampling; energy above Nyquist folds down"
            }
            Warning::AliasingSpace { .. } => {
                "measure at sites closer together; wavenumbers beyond Nyquist fold and may seem to \
                 travel backwards"
            }
            Warning::DeadChannels { .. } | Warning::QuietChannels { .. } => {
                "check the sensors; leave the sites out of spectra along time with `--without-sites`"
            }
            Warning::NoisyChannels { .. } => {
                "check the sensors; if it is noise, leave the sites out with `--without-sites`"
            }
            Warning::NoiseSubtracted { .. } => {
                "`summary.json` has the noise of each site with its interval, and what clipping added"
            }
            Warning::SitesLeftOut { .. } => {
                "for the wavenumbers of the sites that are left save them with their positions, and bring them to even \
                 ones with `--resample cubic`"
            }
            Warning::SaturatedChannels { .. } => {
                "lower the gain or the amplitude; clipping makes harmonics that are not there"
            }
            Warning::LoudChannels { .. } => {
                "check their gains and units: their energy decides spectra and directions; leave them out \
                 with `--without-sites`, or scale them first"
            }
            Warning::GainSteps { .. } | Warning::GainChanges { .. } => {
                "scale the records before energies of sites are compared"
            }
            Warning::ZeroTimes { .. } => {
                "where the recording dropped out, state `nan` there and `--gaps interpolate`"
            }
            Warning::StartUp { .. } => {
                "if it is the instrument that settles, begin later with `--times FROM:`"
            }
            Warning::CommonMode { .. } => {
                "if it is noise of the instrument, remove it with `--detrend-space mean`"
            }
            Warning::Static { .. } => {
                "if they are offsets of the instrument, remove them with `--detrend-time mean`"
            }
            Warning::LeakageTime { .. } => {
                "for a stationary record use `--window-time hann` or remove the trend; for a \
                 transient record until it has died down"
            }
            Warning::LeakageSpace { .. } => {
                "use `--window-space hann`, or remove the trend with `--detrend-space linear`"
            }
            Warning::Gaps { .. } => "read spectra of these sites with care",
            Warning::TransientCut { .. } => {
                "record from before the arrival until the motion has died down; a cut transient \
                 has no energy spectrum of its own"
            }
            Warning::Unrepresentable { .. } => {
                "change the unit of the field so that amplitudes come near 1"
            }
            Warning::NoKineticEnergy => {
                "differentiate or integrate to the velocity first, or leave the flux out with `--only`"
            }
            Warning::NoEnergy => "check the range, the layout and the detrending",
            Warning::Reading { note } => note.advice().unwrap_or_default(),
        }
    }

    /// The same for a sheet.
    pub(crate) fn described(&self) -> sheet::Warning {
        sheet::Warning {
            code: self.code(),
            numbers: Some(self.numbers()),
            ..sheet::Warning::new(self.message(), self.advice())
        }
    }

    /// The numbers behind the message.
    pub fn numbers(&self) -> Map<String, Value> {
        let value = match self {
            Warning::AliasingTime { share, above } | Warning::AliasingSpace { share, above } => {
                json!({"share": share, "above": above})
            }
            Warning::Static { share } => json!({"share": share}),
            Warning::DeadChannels { sites } | Warning::SitesLeftOut { sites } => {
                json!({"sites": sites.indices, "positions": sites.positions})
            }
            Warning::NoiseSubtracted {
                known,
                sites,
                clipped,
                bins,
            } => json!({"known": known, "sites": sites, "clipped": clipped, "bins": bins}),
            Warning::SaturatedChannels { sites, longest } => {
                json!({"sites": sites.indices, "positions": sites.positions, "longest": longest})
            }
            Warning::QuietChannels { sites, ratio }
            | Warning::LoudChannels { sites, ratio }
            | Warning::NoisyChannels { sites, ratio } => {
                json!({"sites": sites.indices, "positions": sites.positions, "ratio": ratio})
            }
            Warning::ZeroTimes { times, first, last } => {
                json!({"times": times, "first": first, "last": last})
            }
            Warning::StartUp {
                times,
                share,
                ratio,
            } => json!({"times": times, "share": share, "ratio": ratio}),
            Warning::CommonMode { share, line, .. } => {
                let [line, error] = [0, 1].map(|i| line.map(|line| line[i]));
                json!({"share": share, "line": line, "line_error": error})
            }
            Warning::GainSteps {
                sites,
                ratios,
                errors,
            } => json!({
                "sites": sites.indices,
                "positions": sites.positions,
                "ratios": ratios,
                "ratio_errors": errors,
            }),
            Warning::GainChanges {
                sites,
                times,
                ratios,
                ..
            } => json!({
                "sites": sites.indices,
                "positions": sites.positions,
                "times": times,
                "ratios": ratios,
            }),
            Warning::LeakageTime { step } | Warning::LeakageSpace { step } => {
                json!({"step": step})
            }
            Warning::Gaps {
                samples,
                sites,
                share,
            } => json!({"samples": samples, "sites": sites, "share": share}),
            Warning::TransientCut { first, last } => json!({"first": first, "last": last}),
            Warning::Unrepresentable { largest, unit } => {
                json!({"largest": largest, "unit": unit})
            }
            Warning::NoKineticEnergy | Warning::NoEnergy | Warning::Reading { .. } => json!({}),
        };
        match value {
            Value::Object(map) => map,
            _ => Map::new(),
        }
    }
}

/// The first few.
fn some(words: Vec<String>) -> String {
    let more = if words.len() > 8 { ", ..." } else { "" };
    format!("{}{more}", words[..words.len().min(8)].join(", "))
}

/// Three digits of a number, whatever its size.
fn short(value: f64) -> String {
    digits(format!("{value:.2e}").parse().unwrap_or(value))
}

/// Four digits of a number, whatever its size.
fn rounded(value: f64) -> String {
    digits(format!("{value:.3e}").parse().unwrap_or(value))
}

fn percent(share: f64) -> String {
    format!("{:.3} %", 100.0 * share)
}
