//! Attenuation and transmission: the pulse that passes a chain, against its length and its
//! parameters.

mod beside;
mod chains;
mod curve;
mod extremum;
mod fit;
mod follow;
mod followed;
mod high_band;
mod least_squares;
mod length;
mod marks;
mod measured;
mod members;
mod pulse;
mod transmission;

pub use beside::{Beside, Computed, Measured};
pub use chains::ContactKind;
pub use curve::{Attenuation, AttenuationCurve, CurveRow, Reach, Stop, StopCause};
pub use fit::{AttenuationLaw, Criterion, Fit, Fits, Parameter, fit};
pub use followed::{Curves, Followed};
pub use length::{AttenuationRequest, Named};
pub use marks::LocalizedMark;
pub use measured::{Compared, MeasuredPeak, MeasuredPoint, measured_peaks, read_curve};
pub use pulse::{FRONT, Located, Pulse, Pulses, Sense, pulses};
pub use transmission::{
    Transmission, TransmissionCurve, TransmissionExtremum, TransmissionPoint, TransmissionRequest,
};
