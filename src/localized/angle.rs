//! Dimers of crossed cylinders.

use crate::Result;
use crate::chain::contact::{
    Ellipse, HertzContact, Material, angle_of_stiffness_ratio, stiffness_ratio,
};

/// Equal cylinders, crossed alternately at 90 degrees (soft contacts) and at an angle (stiff ones).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinders {
    /// The form of the contact ellipse that relates the angle to the stiffness ratio.
    pub ellipse: Ellipse,
    /// Radius in m, and material; the angle needs neither.
    pub body: Option<(f64, Material)>,
}

/// The angle of the stiff contacts.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Angle {
    pub ellipse: Ellipse,
    /// In degrees, 0 to 90.
    pub degrees: f64,
    /// Error in degrees that follows from that of the stiffness ratio.
    pub degrees_error: f64,
    /// Relative change of the stiffness ratio per 0.1 degrees: the required accuracy of the angle.
    pub ratio_change_per_tenth_degree: f64,
    /// Contact coefficients `[at 90 degrees, at the angle]` in N/m^1.5, if a material is given.
    pub coefficients: Option<[f64; 2]>,
}

impl Cylinders {
    /// The angle at which the stiff contacts are kappa times as stiff as those at 90 degrees, for a stiffness ratio of a
    /// relative error.
    ///
    /// # Errors
    /// As [`angle_of_stiffness_ratio`] and [`HertzContact::crossed_cylinders`].
    pub fn crossed_for(&self, kappa: f64, error: f64) -> Result<Angle> {
        // Ratios below 1 have no angle.
        let end = |kappa: f64| angle_of_stiffness_ratio(kappa.max(1.0), self.ellipse);
        let degrees = angle_of_stiffness_ratio(kappa, self.ellipse)?;
        let mut coefficients = None;
        if let Some((radius, material)) = self.body {
            let crossed =
                |angle: f64| HertzContact::crossed_cylinders(radius, material, angle, self.ellipse);
            coefficients = Some([crossed(90.0)?.coefficient, crossed(degrees)?.coefficient]);
        }
        // Towards smaller angles: the ratio has its minimum at 90 degrees.
        let aside = (degrees - 0.1).max(0.5 * degrees);
        Ok(Angle {
            ellipse: self.ellipse,
            degrees,
            degrees_error: 0.5 * (end(kappa * (1.0 - error))? - end(kappa * (1.0 + error))?),
            ratio_change_per_tenth_degree: stiffness_ratio(aside, self.ellipse)? / kappa - 1.0,
            coefficients,
        })
    }
}
