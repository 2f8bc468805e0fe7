//! From values to places along an axis, and to colours.

use super::scene::Color;
use super::style::{Colormap, Depth};
use super::ticks::{self, Notation, Tick};
use crate::unit::{in_decibels, scientific};

/// Colour of cells without a value.
pub(super) const NO_VALUE: Color = [0x9a, 0x9a, 0x9a];

/// Colours of a palette before the one of cells without a value.
const LEVELS: usize = 255;
const NO_VALUE_INDEX: u8 = LEVELS as u8;

/// Decades below the largest value that a logarithmic scale of colours spans.
pub(crate) const DECADES: f64 = 8.0;

/// What values are in between the ends of a scale.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Linear,
    Logarithmic,
    /// The same of powers, read relative to the upper end.
    Decibels,
    /// As the area sine of `v / least`: linear up to about `least`, logarithmic beyond, both ways.
    Signed {
        least: f64,
    },
}

/// From one end of an axis, or of a colour bar, to the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale {
    pub low: f64,
    pub high: f64,
    kind: Kind,
    /// Whether the lowest colour is that of smaller values, too.
    holds_smaller: bool,
}

impl Scale {
    /// A linear one; an empty or undefined range is widened to one unit.
    pub fn linear(low: f64, high: f64) -> Scale {
        let (low, high) = match (low.is_finite() && high.is_finite(), low < high) {
            (true, true) => (low, high),
            (true, false) => (low - 0.5, low + 0.5),
            (false, _) => (0.0, 1.0),
        };
        Scale {
            low,
            high,
            kind: Kind::Linear,
            holds_smaller: false,
        }
    }

    /// Between positive ends.
    pub fn logarithmic(low: f64, high: f64) -> Scale {
        Scale {
            kind: Kind::Logarithmic,
            ..Scale::linear(low, high)
        }
    }

    /// Logarithmic in both directions over this many decades below the limit.
    pub fn signed(limit: f64, decades: f64) -> Scale {
        let limit = if limit > 0.0 { limit } else { 1.0 };
        let least = limit * 10f64.powf(-decades);
        Scale {
            kind: Kind::Signed { least },
            ..Scale::linear(-limit, limit)
        }
    }

    /// From the largest of these values as far down as `depth` says; the smallest positive value is at least a decade below.
    pub fn fitted(values: impl Iterator<Item = f64>, depth: Depth) -> Scale {
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
        Scale {
            // Above zero, and below a largest value that is nearly zero itself.
            low: low.max(f64::MIN_POSITIVE).min(high / 2.0),
            high,
            kind: match depth {
                Depth::Decibels(_) => Kind::Decibels,
                _ => Kind::Logarithmic,
            },
            holds_smaller: zeros || least < low,
        }
    }

    /// Whether it is symmetric about zero, which is the neutral middle of its colours.
    pub fn is_signed(&self) -> bool {
        self.low == -self.high
    }

    pub fn is_logarithmic(&self) -> bool {
        self.kind != Kind::Linear
    }

    /// Place of `value` between the ends, 0 to 1; `None` where it cannot be placed.
    pub fn place(&self, value: f64) -> Option<f64> {
        let (low, high) = (self.low, self.high);
        let share = match self.kind {
            Kind::Linear => (value - low) / (high - low),
            Kind::Logarithmic | Kind::Decibels => {
                (value.log10() - low.log10()) / (high.log10() - low.log10())
            }
            Kind::Signed { least } => 0.5 + 0.5 * (value / least).asinh() / (high / least).asinh(),
        };
        share.is_finite().then_some(share)
    }

    /// The same of a colour, that of the nearer end beyond them; `None` unless finite.
    pub fn share(&self, value: f64) -> Option<f64> {
        let share = self.place(value.clamp(self.low, self.high))?;
        Some(share.clamp(0.0, 1.0))
    }

    /// Index into [`palette`].
    pub fn index(&self, value: f64) -> u8 {
        match self.share(value).filter(|_| value.is_finite()) {
            Some(share) => (share * (LEVELS - 1) as f64).round() as u8,
            None => NO_VALUE_INDEX,
        }
    }

    pub fn palette(&self, map: Colormap) -> Vec<Color> {
        palette(self.is_signed(), map)
    }

    pub(super) fn ticks(&self, count: usize) -> Vec<Tick> {
        let linear = |low, high| ticks::linear(low, high, count, Notation::of(low, high));
        match self.kind {
            Kind::Linear => linear(self.low, self.high),
            Kind::Logarithmic => ticks::logarithmic(self.low, self.high, count),
            Kind::Decibels => {
                let mut ticks = linear(self.decibels(), 0.0);
                for tick in &mut ticks {
                    tick.value = self.high * 10f64.powf(tick.value / 10.0);
                }
                ticks
            }
            Kind::Signed { least } => {
                let up = ticks::logarithmic(2.0 * least, self.high, count.div_ceil(2));
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
        }
    }

    /// Meaning of the lowest colour, if it covers more than one value.
    pub fn lowest_text(&self) -> Option<String> {
        let lowest = match self.kind {
            Kind::Decibels => format!("{:.0}", self.decibels()).replace('-', "−"),
            _ => scientific(self.low, 1),
        };
        self.holds_smaller.then(|| format!("≤ {lowest}"))
    }

    /// `label` as that of an axis, with the powers of ten that its ticks leave out.
    pub fn axis_label(&self, label: &str) -> String {
        match self.kind {
            Kind::Linear => Notation::of(self.low, self.high).label(label),
            _ => label.into(),
        }
    }

    /// `quantity` with what the colours do to it.
    pub fn color_label(&self, quantity: &str) -> String {
        let label = self.axis_label(quantity);
        match self.kind {
            Kind::Linear if self.is_signed() => format!("{label}, linear scale"),
            Kind::Linear => label,
            Kind::Signed { .. } => format!("{label}, signed log scale"),
            Kind::Decibels => in_decibels(quantity, self.high),
            Kind::Logarithmic => match (self.high.log10() - self.low.log10()).round() {
                1.0 => format!("{label}, log scale over 1 decade"),
                decades => format!("{label}, log scale over {decades} decades"),
            },
        }
    }

    /// Of powers, the lower end relative to the upper one.
    fn decibels(&self) -> f64 {
        10.0 * (self.low / self.high).log10()
    }
}

/// The colours of a scale, and last that of cells without a value.
pub(crate) fn palette(is_signed: bool, map: Colormap) -> Vec<Color> {
    let color = |level: usize| {
        let gradient = match map {
            // Black is the least value, as in the coloured maps.
            Colormap::Gray => return [(level * 255 / (LEVELS - 1)) as u8; 3],
            _ if is_signed => colorous::PURPLE_ORANGE,
            Colormap::Viridis => colorous::VIRIDIS,
            Colormap::Cividis => colorous::CIVIDIS,
            Colormap::Inferno => colorous::INFERNO,
            Colormap::Magma => colorous::MAGMA,
            Colormap::Plasma => colorous::PLASMA,
        };
        gradient.eval_rational(level, LEVELS).into_array()
    };
    (0..LEVELS).map(color).chain([NO_VALUE]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_finite_value_lies_on_the_scale() {
        let values = [-3.0, 0.0, 2.0, f64::NAN];
        let scale = Scale::linear(-3.0, 3.0);
        assert_eq!(values.map(|v| scale.index(v)), [0, 127, 212, 255]);
    }

    #[test]
    fn signed_scales_are_even_and_spread_small_values() {
        let scale = Scale::signed(100.0, 4.0);
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
        let scale = Scale::fitted([0.0, 1e-12, 1e3].into_iter(), Depth::Fitted);
        assert_eq!(scale.share(1e3), Some(1.0));
        assert_eq!(scale.share(0.0), Some(0.0));
        assert!((scale.share(1e-1).unwrap() - 0.5).abs() < 1e-12);
        assert!(scale.lowest_text().is_some());
    }

    #[test]
    fn scales_span_what_they_are_told() {
        let texts = |depth| -> Vec<String> {
            let scale = Scale::fitted([1e-9, 0.5].into_iter(), depth);
            scale.ticks(4).into_iter().map(|tick| tick.text).collect()
        };
        assert_eq!(texts(Depth::Decades(3.0)), ["10⁻³", "10⁻²", "10⁻¹"]);
        assert_eq!(texts(Depth::Decibels(60.0)), ["−60", "−40", "−20", "0"]);
        let scale = Scale::fitted([1e-9, 0.5].into_iter(), Depth::Decibels(60.0));
        assert_eq!(scale.lowest_text().as_deref(), Some("≤ −60"));
        assert_eq!(
            scale.color_label("power [(m/s)²/Hz]"),
            "power [dB re 5.0·10⁻¹ (m/s)²/Hz]"
        );
        assert!((scale.share(0.5e-3).unwrap() - 0.5).abs() < 1e-12);
    }

    #[test]
    fn nothing_to_scale_is_no_division_by_zero() {
        for values in [vec![], vec![0.0], vec![f64::NAN]] {
            assert_eq!(
                Scale::fitted(values.iter().copied(), Depth::Fitted).share(0.0),
                Some(0.0)
            );
        }
        assert_eq!(
            Scale::fitted([5.0].into_iter(), Depth::Fitted).share(5.0),
            Some(1.0)
        );
    }
}
