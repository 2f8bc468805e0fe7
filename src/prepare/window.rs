//! Tapers.

use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;
use std::sync::{Mutex, PoisonError};

use super::slepian;
use crate::numeric::cos_turns;

/// A taper, in its periodic (DFT-even) form.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Window {
    #[default]
    None,
    Hann,
    Hamming,
    BlackmanHarris,
    FlatTop,
    Tukey {
        /// Share of the length inside the cosine tapers, 0 to 1.
        taper: f64,
    },
    Kaiser {
        beta: f64,
    },
    /// The zeroth discrete prolate spheroidal (Slepian) sequence.
    Dpss {
        /// Time-bandwidth product NW.
        time_bandwidth: f64,
    },
    /// The samples of one segment, as they are given.
    Samples(Given),
}

/// Samples of a window, kept for the life of the process, so that windows are copied as names are.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(into = "Vec<f64>", try_from = "Vec<f64>")]
pub struct Given(&'static [f64]);

impl From<Given> for Vec<f64> {
    fn from(given: Given) -> Vec<f64> {
        given.0.to_vec()
    }
}

impl TryFrom<Vec<f64>> for Given {
    type Error = WindowError;

    fn try_from(samples: Vec<f64>) -> Result<Given, WindowError> {
        static KEPT: Mutex<Vec<&[f64]>> = Mutex::new(Vec::new());
        let sum: f64 = samples.iter().sum();
        if !(sum.is_finite() && sum > 0.0) {
            return Err(WindowError {
                expected: "samples with a positive sum".into(),
                found: format!("{} with the sum {sum}", samples.len()),
            });
        }
        let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = kept.iter().find(|known| ***known == samples[..]) {
            return Ok(Given(known));
        }
        let samples: &[f64] = samples.leak();
        kept.push(samples);
        Ok(Given(samples))
    }
}

/// What a window does to a sine and to noise.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct WindowGains {
    /// Name with its parameter, in the form of the command line.
    pub name: String,
    /// `sum w / N`: what a sine's amplitude is multiplied by.
    pub coherent_gain: f64,
    /// `sum w^2 / N`: what a stationary signal's power is multiplied by.
    pub power_gain: f64,
    /// Equivalent noise bandwidth in bins, `N sum w^2 / (sum w)^2`.
    pub noise_bandwidth_bins: f64,
}

/// A window's name or parameter that is none.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("expected {expected}, found {found}")]
pub struct WindowError {
    pub expected: String,
    pub found: String,
}

const NAMES: &str = "none, hann, hamming, blackman-harris, flat-top, tukey:SHARE, kaiser:BETA, \
                     dpss:NW or samples:W,W,..";
/// Windows without a parameter, by name: `a_k` of `w = sum_k (-1)^k a_k cos(2 pi k j / n)`.
const PLAIN: [(&str, Window, &[f64]); 5] = [
    ("none", Window::None, &[1.0]),
    ("hann", Window::Hann, &[0.5, 0.5]),
    ("hamming", Window::Hamming, &[0.54, 0.46]),
    (
        "blackman-harris",
        Window::BlackmanHarris,
        &[0.35875, 0.48829, 0.14128, 0.01168],
    ),
    (
        "flat-top",
        Window::FlatTop,
        &[
            0.21557895,
            0.41663158,
            0.277263158,
            0.083578947,
            0.006947368,
        ],
    ),
];

impl Window {
    /// Of segments, short-time spectra and ridges, unless another is stated.
    pub const USUAL: Window = Window::Hann;

    /// The samples `w[j]`, `j = 0..n`, with `w[j] == w[n - j]` bit for bit and `w[n / 2] = 1` for
    /// even n (flat-top: 1.000000003, the sum of its coefficients).
    ///
    /// - cosine sums: `w = sum_k (-1)^k a_k cos(2 pi k j / n)`
    /// - Tukey: `sin^2(pi j / (taper n))` for `j <= taper n / 2`, then 1
    /// - Kaiser: `I0(beta sqrt(1 - (2 j / n - 1)^2)) / I0(beta)`
    /// - dpss: the zeroth Slepian sequence of length n + 1, largest sample 1
    ///   (`(n + 1)^2 / ((n + 1)^2 + NW)` for odd n), its last sample left out
    ///
    /// Parameters are those that [`Window::validate`] accepts.
    ///
    /// Source: Harris, Proc. IEEE 66, 51 (1978); Slepian (1978), see [`slepian`]; equal to
    /// `scipy.signal.get_window(name, n)`.
    pub fn samples(&self, n: usize) -> Vec<f64> {
        if let Window::Samples(Given(given)) = self
            && given.len() == n
        {
            return given.to_vec();
        }
        if n <= 1 {
            return vec![1.0; n];
        }
        let half = self.first_half(n);
        (0..n).map(|j| half[j.min(n - j)]).collect()
    }

    /// Samples 0 to `n / 2`.
    fn first_half(&self, n: usize) -> Vec<f64> {
        let each = |sample: &dyn Fn(usize) -> f64| (0..=n / 2).map(sample).collect();
        match *self {
            Window::Tukey { taper } => each(&|j| {
                let tapered = taper * n as f64;
                match 2.0 * j as f64 >= tapered {
                    true => 1.0,
                    false => (PI * (j as f64 / tapered)).sin().powi(2),
                }
            }),
            Window::Kaiser { beta } => {
                let largest = bessel_i0_scaled(beta);
                each(&|j| {
                    let (j, n) = (j as f64, n as f64);
                    let root = (4.0 * j * (n - j)).sqrt() / n;
                    let descent = beta * ((n - 2.0 * j) / n).powi(2) / (1.0 + root);
                    bessel_i0_scaled(beta * root) / largest * (-descent).exp()
                })
            }
            Window::Dpss { time_bandwidth } => {
                let mut half = slepian::taper_half(n + 1, time_bandwidth);
                if n % 2 == 1 {
                    let square = (n as f64 + 1.0).powi(2);
                    let between = square / (square + time_bandwidth);
                    half.iter_mut().for_each(|w| *w *= between);
                }
                half
            }
            // Samples of another length are no window, which `validate` says.
            _ => {
                let cosines = self.plain().map_or(&[1.0][..], |(_, _, cosines)| cosines);
                each(&|j| cosine_sum(cosines, j, n))
            }
        }
    }

    fn plain(&self) -> Option<&'static (&'static str, Window, &'static [f64])> {
        PLAIN.iter().find(|(_, window, _)| window == self)
    }

    /// The gains of the window's `n` samples, at least one.
    pub fn gains(&self, n: usize) -> WindowGains {
        let samples = self.samples(n);
        let length = n as f64;
        let sum: f64 = samples.iter().sum();
        let squares: f64 = samples.iter().map(|w| w * w).sum();
        WindowGains {
            name: self.to_string(),
            coherent_gain: sum / length,
            power_gain: squares / length,
            noise_bandwidth_bins: length * squares / (sum * sum),
        }
    }

    /// Whether the parameter makes sense for `n` samples.
    ///
    /// # Errors
    /// [`WindowError`] for a taper outside 0 to 1, a beta outside 0 to 1e6, a time-bandwidth
    /// product that is not above 0 and below `(n + 1) / 2`, and samples of another number.
    pub fn validate(&self, n: usize) -> Result<(), WindowError> {
        let (is_valid, expected, found) = match *self {
            Window::Tukey { taper } => {
                let is_share = (0.0..=1.0).contains(&taper);
                (is_share, "a tapered share from 0 to 1".into(), taper)
            }
            Window::Kaiser { beta } => {
                let is_beta = (0.0..=1e6).contains(&beta);
                (is_beta, "a beta from 0 to 1e6".into(), beta)
            }
            Window::Dpss { time_bandwidth } => {
                let limit = (n as f64 + 1.0) / 2.0;
                let is_valid = n <= 1 || time_bandwidth > 0.0 && time_bandwidth < limit;
                let expected = format!("a time-bandwidth product above 0 and below {limit}");
                (is_valid, expected, time_bandwidth)
            }
            Window::Samples(Given(given)) => {
                let is_valid = n == usize::MAX || n == given.len();
                let expected = format!("{n} samples of a window");
                (is_valid, expected, given.len() as f64)
            }
            _ => return Ok(()),
        };
        let found = found.to_string();
        is_valid
            .then_some(())
            .ok_or(WindowError { expected, found })
    }
}

/// `sum_k (-1)^k a_k cos(2 pi k j / n)`.
fn cosine_sum(coefficients: &[f64], j: usize, n: usize) -> f64 {
    let n = n as u64;
    let terms = coefficients.iter().zip(0..);
    let terms = terms.map(|(a, k)| a * cos_turns(2 * k * j as u64 + k * n, 2 * n));
    terms.sum()
}

/// `exp(-x) I0(x)` for `x >= 0`: both series have terms above 0 only.
///
/// Source: DLMF 10.25.2 up to x = 40, 10.40.1 beyond.
fn bessel_i0_scaled(x: f64) -> f64 {
    let (mut term, mut sum, mut k) = (1.0, 1.0, 0.0);
    let near = x <= 40.0;
    while term > 0.1 * f64::EPSILON * sum {
        k += 1.0;
        term *= match near {
            true => (0.5 * x / k).powi(2),
            false => (2.0 * k - 1.0).powi(2) / (8.0 * k * x),
        };
        sum += term;
    }
    match near {
        true => sum * (-x).exp(),
        false => sum / (2.0 * PI * x).sqrt(),
    }
}

/// The form of the command line: a name, and after a colon its parameter if it has one.
impl fmt::Display for Window {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Window::Tukey { taper } => write!(f, "tukey:{taper}"),
            Window::Kaiser { beta } => write!(f, "kaiser:{beta}"),
            Window::Dpss { time_bandwidth } => write!(f, "dpss:{time_bandwidth}"),
            Window::Samples(Given(given)) => write!(f, "{} samples as given", given.len()),
            plain => f.write_str(plain.plain().map_or("", |(name, ..)| name)),
        }
    }
}

/// Reads what [`Display`](fmt::Display) writes, but given samples, which are `samples:0,0.5,1,0.5`; the parameter may be left out: `tukey` is
/// `tukey:0.25`, `kaiser` is `kaiser:14`, `dpss` is `dpss:4`.
impl FromStr for Window {
    type Err = WindowError;

    fn from_str(text: &str) -> Result<Self, WindowError> {
        let error = |expected: &str| WindowError {
            expected: expected.into(),
            found: format!("`{text}`"),
        };
        let words = text.split_once(':');
        let (name, parameter) = words.map_or((text, None), |(name, rest)| (name, Some(rest)));
        let number = |default: f64| match parameter.map(str::parse) {
            Some(number) => number.map_err(|_| error("a number after the colon")),
            None => Ok(default),
        };
        if let Some((_, window, _)) = PLAIN.iter().find(|(known, ..)| *known == name) {
            return match parameter {
                Some(_) => Err(error("a window without a parameter")),
                None => Ok(*window),
            };
        }
        let window = match name {
            "tukey" => number(0.25).map(|taper| Window::Tukey { taper })?,
            "kaiser" => number(14.0).map(|beta| Window::Kaiser { beta })?,
            "dpss" => number(4.0).map(|time_bandwidth| Window::Dpss { time_bandwidth })?,
            "samples" => {
                let digits = parameter.unwrap_or_default().split(',');
                let samples: Option<Vec<f64>> = digits.map(|one| one.trim().parse().ok()).collect();
                let samples = samples.ok_or_else(|| error("numbers after the colon"))?;
                Window::Samples(samples.try_into()?)
            }
            _ => return Err(error(NAMES)),
        };
        window.validate(usize::MAX)?;
        Ok(window)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_definition_samples_that_are_given_are_the_window() {
        let samples = Window::Hann.samples(8);
        let words: Vec<String> = samples.iter().map(f64::to_string).collect();
        let text = format!("samples:{}", words.join(","));
        let window: Window = text.parse().unwrap();
        assert_eq!(window.samples(8), samples);
        let gains = |window: Window| WindowGains {
            name: String::new(),
            ..window.gains(8)
        };
        assert_eq!(gains(window), gains(Window::Hann));
        // Kept once.
        assert_eq!(window, text.parse().unwrap());
        let found = window.validate(9).unwrap_err().found;
        assert_eq!(found, "8");
        for refused in ["samples:", "samples:1,x", "samples:0,0", "samples:1,nan"] {
            assert!(refused.parse::<Window>().is_err(), "{refused}");
        }
        let copied: Window =
            serde_json::from_str(&serde_json::to_string(&window).unwrap()).unwrap();
        assert_eq!(copied, window);
    }
}
