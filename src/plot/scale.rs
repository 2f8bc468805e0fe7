//! From values to colours.

use super::scene::Color;
use super::style::{Colormap, Depth};
use super::ticks::{self, Notation, Tick};
use crate::unit::{in_decibels, scientific};

/// Colour of cells without a value.
pub(super) const NO_VALUE: Color = [0x9a, 0x9a, 0x9a];

/// Colours of a palette before the one of cells without a value.
const LEVELS: usize = 255;
const NO_VALUE_INDEX: u8 = LEVELS as u8;

/// Decades below the largest value that a logarithmic scale spans.
pub(crate) const DECADES: f64 = 8.0;

/// A colour scale that holds every value it was made for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ColorScale {
    /// Linear from `-limit` to `limit`, zero in the neutral middle.
    Diverging { limit: f64 },
    /// As the area sine of `v / least` from `-limit` to `limit`: linear up to about `least`,
    /// logarithmic beyond, both ways.
    Signed { limit: f64, least: f64 },
    /// Linear from `low` to `high`.
    Linear { low: f64, high: f64 },
    /// Logarithmic from `low` to `high`; all that is smaller has the lowest colour.
    Log {
        low: f64,
        high: f64,
        smaller: bool,
        /// Whether the bar is in decibels relative to `high`.
        decibels: bool,
    },
}

impl ColorScale {
    /// Symmetric about zero, out to the largest magnitude.
    pub fn diverging(values: impl Iterator<Item = f64>) -> Self {
        let limit = values
            .filter(|v| v.is_finite())
            .fold(0.0, |most: f64, v| most.max(v.abs()));
        ColorScale::Diverging {
            limit: if limit > 0.0 { limit } else { 1.0 },
        }
    }

    /// Logarithmic in both directions over this many decades below the largest magnitude.
    pub fn signed(values: impl Iterator<Item = f64>, decades: f64) -> Self {
        let limit = values
            .filter(|v| v.is_finite())
            .fold(0.0, |most: f64, v| most.max(v.abs()));
        let limit = if limit > 0.0 { limit } else { 1.0 };
        ColorScale::Signed {
            limit,
            least: limit * 10f64.powf(-decades),
        }
    }

    /// Linear between two values; diverging if they are symmetric about zero.
    pub fn between(low: f64, high: f64) -> Self {
        match low == -high {
            true => ColorScale::Diverging { limit: high },
            false => ColorScale::Linear { low, high },
        }
    }

    /// From the largest value as far down as `depth` says; the smallest positive value is at least a
    /// decade below.
    pub fn log(values: impl Iterator<Item = f64>, depth: Depth) -> Self {
        let (mut least, mut most, mut zeros) = (f64::INFINITY, 0.0f64, false);
        for value in values.filter(|v| v.is_finite()) {
            if value > 0.0 {
                least = least.min(value);
                most = most.max(value);
            } else {
                zeros = true;
            }
        }
        let high = if most > 0.0 { most } else { 1.0 };
        let low = match depth {
            Depth::Fitted if most == 0.0 => 0.1,
            Depth::Fitted => least.max(high * 10f64.powf(-DECADES)).min(high / 10.0),
            Depth::Decades(decades) => high * 10f64.powf(-decades),
            Depth::Decibels(db) => high * 10f64.powf(-db / 10.0),
        };
        ColorScale::Log {
            // Above zero, and below a largest value that is nearly zero itself.
            low: low.max(f64::MIN_POSITIVE).min(high / 2.0),
            high,
            smaller: zeros || least < low,
            decibels: matches!(depth, Depth::Decibels(_)),
        }
    }

    /// The colours that [`ColorScale::index`] points to.
    pub fn palette(&self, map: Colormap) -> Vec<Color> {
        (0..LEVELS)
            .map(|level| self.color(level, map))
            .chain([NO_VALUE])
            .collect()
    }

    fn color(&self, level: usize, map: Colormap) -> Color {
        let signed = matches!(
            self,
            ColorScale::Diverging { .. } | ColorScale::Signed { .. }
        );
        let gradient = match map {
            // Black is the least value, as in the coloured maps.
            Colormap::Gray => return [(level * 255 / (LEVELS - 1)) as u8; 3],
            _ if signed => colorous::PURPLE_ORANGE,
            Colormap::Viridis => colorous::VIRIDIS,
            Colormap::Cividis => colorous::CIVIDIS,
            Colormap::Inferno => colorous::INFERNO,
            Colormap::Magma => colorous::MAGMA,
            Colormap::Plasma => colorous::PLASMA,
        };
        gradient.eval_rational(level, LEVELS).into_array()
    }

    /// Position of `value` along the scale, 0 to 1; `None` unless finite.
    pub fn share(&self, value: f64) -> Option<f64> {
        if !value.is_finite() {
            return None;
        }
        let share = match *self {
            ColorScale::Diverging { limit } => 0.5 + 0.5 * (value / limit),
            ColorScale::Signed { limit, least } => {
                0.5 + 0.5 * (value / least).asinh() / (limit / least).asinh()
            }
            ColorScale::Linear { low, high } => (value - low) / (high - low),
            ColorScale::Log { low, .. } if value <= low => 0.0,
            ColorScale::Log { low, high, .. } => {
                (value.log10() - low.log10()) / (high.log10() - low.log10())
            }
        };
        Some(share.clamp(0.0, 1.0))
    }

    /// Index into [`ColorScale::palette`].
    pub fn index(&self, value: f64) -> u8 {
        match self.share(value) {
            Some(share) => (share * (LEVELS - 1) as f64).round() as u8,
            None => NO_VALUE_INDEX,
        }
    }

    pub(super) fn ticks(&self, count: usize) -> Vec<Tick> {
        match *self {
            ColorScale::Diverging { limit } => {
                ticks::linear(-limit, limit, count, Notation::of(-limit, limit))
            }
            ColorScale::Signed { limit, least } => {
                let up = ticks::logarithmic(2.0 * least, limit, count.div_ceil(2));
                let down = up.iter().rev().map(|tick| Tick {
                    value: -tick.value,
                    text: format!("−{}", tick.text),
                });
                let zero = Tick {
                    value: 0.0,
                    text: "0".into(),
                };
                down.chain([zero]).chain(up.iter().cloned()).collect()
            }
            ColorScale::Linear { low, high } => {
                ticks::linear(low, high, count, Notation::of(low, high))
            }
            ColorScale::Log {
                low,
                high,
                decibels: true,
                ..
            } => {
                let depth = decibels(low, high);
                let ticks = ticks::linear(depth, 0.0, count, Notation::of(depth, 0.0));
                let at = |tick: Tick| Tick {
                    value: high * 10f64.powf(tick.value / 10.0),
                    text: tick.text,
                };
                ticks.into_iter().map(at).collect()
            }
            ColorScale::Log { low, high, .. } => ticks::logarithmic(low, high, count),
        }
    }

    /// Meaning of the lowest colour, if it covers more than one value.
    pub fn lowest_text(&self) -> Option<String> {
        match *self {
            ColorScale::Log {
                low,
                high,
                smaller: true,
                decibels: true,
            } => {
                let depth = format!("{:.0}", decibels(low, high));
                Some(format!("≤ {}", depth.replace('-', "−")))
            }
            ColorScale::Log {
                low, smaller: true, ..
            } => Some(format!("≤ {}", scientific(low, 1))),
            _ => None,
        }
    }

    /// `quantity` with what the colours do to it.
    pub fn label(&self, quantity: &str) -> String {
        match *self {
            ColorScale::Diverging { limit } => {
                format!(
                    "{}, linear scale",
                    Notation::of(-limit, limit).label(quantity)
                )
            }
            ColorScale::Linear { low, high } => Notation::of(low, high).label(quantity),
            ColorScale::Signed { .. } => format!("{quantity}, signed log scale"),
            ColorScale::Log {
                high,
                decibels: true,
                ..
            } => in_decibels(quantity, high),
            ColorScale::Log { low, high, .. } => match (high.log10() - low.log10()).round() {
                1.0 => format!("{quantity}, log scale over 1 decade"),
                decades => format!("{quantity}, log scale over {decades} decades"),
            },
        }
    }
}

/// Of powers, `low` relative to `high`.
fn decibels(low: f64, high: f64) -> f64 {
    10.0 * (low / high).log10()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_finite_value_lies_on_the_scale() {
        let values = [-3.0, 0.0, 2.0, f64::NAN];
        let scale = ColorScale::diverging(values.into_iter());
        assert_eq!(scale, ColorScale::Diverging { limit: 3.0 });
        assert_eq!(values.map(|v| scale.index(v)), [0, 127, 212, 255]);
    }

    #[test]
    fn signed_scales_are_even_and_spread_small_values() {
        let scale = ColorScale::signed([-100.0, 3.0].into_iter(), 4.0);
        let share = |value| scale.share(value).unwrap();
        assert_eq!([share(-100.0), share(0.0), share(100.0)], [0.0, 0.5, 1.0]);
        assert!((share(3.0) + share(-3.0) - 1.0).abs() < 1e-12);
        // A decade is a decade: about a tenth of the scale.
        let decade = share(10.0) - share(1.0);
        assert!((decade - 0.5 * 10f64.ln() / 2e4f64.ln()).abs() < 2e-6);
        let texts: Vec<String> = scale.ticks(6).into_iter().map(|tick| tick.text).collect();
        assert_eq!(texts.len() % 2, 1);
        assert_eq!(texts[texts.len() / 2], "0");
    }

    #[test]
    fn log_scales_state_what_lies_below() {
        let scale = ColorScale::log([0.0, 1e-12, 1e3].into_iter(), Depth::Fitted);
        assert_eq!(scale.share(1e3), Some(1.0));
        assert_eq!(scale.share(0.0), Some(0.0));
        assert!((scale.share(1e-1).unwrap() - 0.5).abs() < 1e-12);
        assert!(matches!(scale, ColorScale::Log { smaller: true, .. }));
    }

    #[test]
    fn scales_span_what_they_are_told() {
        let texts = |depth| -> Vec<String> {
            let scale = ColorScale::log([1e-9, 0.5].into_iter(), depth);
            scale.ticks(4).into_iter().map(|tick| tick.text).collect()
        };
        assert_eq!(texts(Depth::Decades(3.0)), ["10⁻³", "10⁻²", "10⁻¹"]);
        assert_eq!(texts(Depth::Decibels(60.0)), ["−60", "−40", "−20", "0"]);
        let scale = ColorScale::log([1e-9, 0.5].into_iter(), Depth::Decibels(60.0));
        assert_eq!(scale.lowest_text().as_deref(), Some("≤ −60"));
        assert_eq!(
            scale.label("power [(m/s)²/Hz]"),
            "power [dB re 5.0·10⁻¹ (m/s)²/Hz]"
        );
        assert!((scale.share(0.5e-3).unwrap() - 0.5).abs() < 1e-12);
    }

    #[test]
    fn nothing_to_scale_is_no_division_by_zero() {
        for values in [vec![], vec![0.0], vec![f64::NAN]] {
            assert_eq!(
                ColorScale::diverging(values.iter().copied()).share(0.0),
                Some(0.5)
            );
            assert_eq!(
                ColorScale::log(values.iter().copied(), Depth::Fitted).share(0.0),
                Some(0.0)
            );
        }
        assert_eq!(
            ColorScale::log([5.0].into_iter(), Depth::Fitted).share(5.0),
            Some(1.0)
        );
    }
}
