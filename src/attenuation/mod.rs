//! Attenuation and transmission: what comes through a chain, against its length and its make.

mod chains;
mod fit;
mod follow;
mod golden;
mod high_band;
mod length;
mod marks;
mod measured;
mod members;
mod plan;
mod pulse;
mod transmission;

pub use chains::{ContactKind, Pattern, homogeneous};
pub use fit::{Criterion, Fit, Fits, Law, Length, Parameter, fit};
pub use length::{
    Attenuation, AttenuationCurve, AttenuationRequest, Named, Reach, Row, Stop, StopCause,
};
pub use marks::LocalizedMark;
pub use measured::{Compared, MeasuredPeak, MeasuredPoint, measured_peaks, read_curve};
pub use pulse::{FRONT, Located, Pulse, Pulses, Sense, pulses};
pub use transmission::{Extreme, Point, Transmission, TransmissionCurve, TransmissionRequest};
