//! Tapers.

/// A taper, in its periodic (DFT-even) form.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
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
}

/// What a window does to a sine and to noise.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct WindowGains {
    /// Name with its parameter, as the command line takes it.
    pub name: String,
    /// `sum w / N`: what a sine's amplitude is multiplied by.
    pub coherent_gain: f64,
    /// `sum w^2 / N`: what a stationary signal's power is multiplied by.
    pub power_gain: f64,
    /// Equivalent noise bandwidth in bins, `N sum w^2 / (sum w)^2`.
    pub noise_bandwidth_bins: f64,
}
