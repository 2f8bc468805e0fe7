//! Localized waves, and how pulses attenuate.

mod attenuation_curves;
mod attenuation_pulse;
mod direct;
mod waves;
