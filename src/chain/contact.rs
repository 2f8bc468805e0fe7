//! The Hertz contact of two curved bodies: coefficient, ellipse, and the angle that gives a ratio.
//!
//! A contact of relative principal curvatures `A <= B` presses with `F = beta delta^{3/2}`. Its
//! ellipse of semi-axes `a >= b` follows, with `lambda = ln(B / A) / 2` and `w = ln(a / b)`, from
//!
//! ```text
//! lambda = w - atanh rho(w)                                     (exact)
//! w = 4 lambda / 3                                              (approximate: b/a = (A/B)^{2/3})
//! beta = (4/3) E* R^{1/2} M(w) [1 - rho(w)^2]^{1/4},   R = 1 / (2 sqrt(A B)),
//! ```
//!
//! `1/E* = (1 - nu_1^2)/Y_1 + (1 - nu_2^2)/Y_2`. `M` and `rho` stand for the complete elliptic
//! integrals: `M = (pi/2) e^{w/2} / K`, `rho = (2D - K) / K`, `D = (K - E) / (1 - b^2/a^2)`.
//! For two cylinders of radius R crossed at alpha, `lambda = -ln tan(alpha/2)` and the radius is
//! `R / sin(alpha)`; with the approximate ellipse this is the published form for cylinder chains.
//!
//! Sources: K. L. Johnson, *Contact Mechanics* (1985), section 4.2; R. Chaunsali, M. Toles,
//! J. Yang, E. Kim, *Extreme control of impulse transmission by cylinder-based nonlinear phononic
//! crystals*, equation 1.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::elliptic::ellipse_integrals;
use crate::numeric::root;
use crate::{Error, Result};

/// An isotropic elastic material.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Young's modulus in Pa.
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Density in kg/m^3.
    pub density: f64,
}

impl Material {
    /// Fused quartz, as in Chaunsali et al.
    pub const QUARTZ: Material = Material {
        young: 72e9,
        poisson: 0.17,
        density: 2200.0,
    };
    /// Stainless steel 316, as in C. Daraio et al., Physical Review E 73 (2006) 026610.
    pub const STEEL: Material = Material {
        young: 193e9,
        poisson: 0.3,
        density: 8000.0,
    };
    /// Polytetrafluoroethylene, as in C. Daraio et al., Physical Review E 73 (2006) 026610.
    pub const PTFE: Material = Material {
        young: 1.46e9,
        poisson: 0.46,
        density: 2200.0,
    };

    /// A material of the table by its name: `quartz`, `steel` or `ptfe`.
    pub fn named(name: &str) -> Option<Material> {
        match name {
            "quartz" => Some(Material::QUARTZ),
            "steel" => Some(Material::STEEL),
            "ptfe" => Some(Material::PTFE),
            _ => None,
        }
    }

    fn check(&self) -> Result<()> {
        positive("young", self.young)?;
        positive("density", self.density)?;
        let expected = "Poisson's ratio above -1, at most 0.5";
        let is_one = self.poisson > -1.0 && self.poisson <= 0.5;
        Error::require(is_one, "poisson", expected, self.poisson)
    }
}

/// The surface of a body where it touches another one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    pub material: Material,
    /// Principal curvatures in 1/m, positive where convex; the first is along the body's axis.
    pub curvature: [f64; 2],
}

impl Surface {
    pub fn sphere(radius: f64, material: Material) -> Self {
        Surface {
            material,
            curvature: [1.0 / radius, 1.0 / radius],
        }
    }

    pub fn cylinder(radius: f64, material: Material) -> Self {
        Surface {
            material,
            curvature: [0.0, 1.0 / radius],
        }
    }

    pub fn flat(material: Material) -> Self {
        Surface {
            material,
            curvature: [0.0, 0.0],
        }
    }
}

/// How the aspect ratio of the contact ellipse is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Ellipse {
    /// From the transcendental equation of Hertz's theory.
    Exact,
    /// `b/a = (A/B)^{2/3}`, which the published stiffness ratios of cylinder chains use.
    #[default]
    Approximate,
}

/// A Hertz contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HertzContact {
    /// beta in N/m^{3/2}: `F = beta delta^{3/2}`.
    pub coefficient: f64,
    /// `b/a`, minor over major semi-axis.
    pub aspect: f64,
}

impl HertzContact {
    /// The contact of two surfaces whose axes are `angle_deg` apart.
    ///
    /// Angles in degrees, any sign; beyond 90 they fold back.
    ///
    /// # Errors
    /// [`crate::Error::Request`] for a value that is not finite or not physical, and for surfaces that
    /// touch along a line or conform.
    pub fn new(
        first: &Surface,
        second: &Surface,
        angle_deg: f64,
        ellipse: Ellipse,
    ) -> Result<HertzContact> {
        first.material.check()?;
        second.material.check()?;
        let (sine, cosine) = folded_sin_cos(angle_deg)?;
        let ([p1, q1], [p2, q2]) = (first.curvature, second.curvature);
        let (d1, d2) = (p1 - q1, p2 - q2);
        let half_sum = 0.25 * (p1 + q1 + p2 + q2);
        let half_difference = 0.25 * ((d1 + d2) * cosine).hypot((d1 - d2) * sine);
        let product = 0.25
            * (p1 * q1
                + p2 * q2
                + (p1 * q2 + q1 * p2) * cosine * cosine
                + (p1 * p2 + q1 * q2) * sine * sine);
        let in_a_point = half_sum > 0.0 && product > 0.0 && product.is_finite();
        let found = format!(
            "curvatures {p1:e}, {q1:e} and {p2:e}, {q2:e} at {angle_deg:e} degrees, \
             which touch along a line or conform"
        );
        let expected = "surfaces that touch in a point";
        Error::require(in_a_point, "curvature", expected, found)?;
        let mean = product.sqrt();
        let shape = CurvatureIntegrals::of(half_difference / mean, ellipse);
        let compliance = |m: &Material| (1.0 - m.poisson * m.poisson) / m.young;
        let modulus = 1.0 / (compliance(&first.material) + compliance(&second.material));
        Ok(HertzContact {
            coefficient: 4.0 / 3.0 * modulus * (0.5 / mean).sqrt() * shape.form_factor(),
            aspect: (-shape.w).exp(),
        })
    }

    /// Two equal cylinders crossed at `angle_deg` degrees.
    ///
    /// # Errors
    /// As [`HertzContact::new`].
    pub fn crossed_cylinders(
        radius: f64,
        material: Material,
        angle_deg: f64,
        ellipse: Ellipse,
    ) -> Result<HertzContact> {
        positive("radius", radius)?;
        let surface = Surface::cylinder(radius, material);
        HertzContact::new(&surface, &surface, angle_deg, ellipse)
    }
}

/// `beta(angle) / beta(90 degrees)` of two equal crossed cylinders; never below 1.
///
/// # Errors
/// [`crate::Error::Request`] for an angle that is not finite or a multiple of 180 degrees.
pub fn stiffness_ratio(angle_deg: f64, ellipse: Ellipse) -> Result<f64> {
    let (sine, cosine) = folded_sin_cos(angle_deg)?;
    let found = format!("{angle_deg} degrees");
    let expected = "cylinders that are not parallel";
    Error::require(sine != 0.0, "angle", expected, found)?;
    Ok(CurvatureIntegrals::of(cosine / sine, ellipse).form_factor() / sine.sqrt())
}

/// The angle in degrees, 0 to 90, at which crossed cylinders have this stiffness ratio to 90.
///
/// The inverse of [`stiffness_ratio`], to a few units in the last place, also as the ratio tends
/// to 1, where the angle leaves 90 degrees like the square root of `ratio - 1`.
///
/// # Errors
/// [`crate::Error::Request`] for a ratio below 1 or above 1e60.
pub fn angle_of_stiffness_ratio(ratio: f64, ellipse: Ellipse) -> Result<f64> {
    let (is_one, found) = ((1.0..=1e60).contains(&ratio), format!("{ratio:e}"));
    Error::require(is_one, "stiffness-ratio", "a ratio of 1 to 1e60", found)?;
    let target = (ratio - 1.0).ln_1p().sqrt();
    let excess = |w: f64| {
        let shape = CurvatureIntegrals::of_ellipse(w, ellipse);
        let crossing = 0.5 * (2.0 * (0.5 * shape.lambda).sinh().powi(2)).ln_1p();
        (shape.ln_form_factor() + crossing).sqrt() - target
    };
    let lambda = CurvatureIntegrals::of_ellipse(root::between(0.0, 600.0, excess), ellipse).lambda;
    Ok(if lambda < 1.0 {
        90.0 - 2.0 * (0.5 * lambda).tanh().atan().to_degrees()
    } else {
        2.0 * (-lambda).exp().atan().to_degrees()
    })
}

/// What the curvatures' ratio alone decides.
struct CurvatureIntegrals {
    lambda: f64,
    w: f64,
    mean_excess: f64,
    rho: f64,
}

impl CurvatureIntegrals {
    /// From `sinh(lambda) = (B - A) / (2 sqrt(A B))`.
    fn of(sinh_lambda: f64, ellipse: Ellipse) -> CurvatureIntegrals {
        let lambda = sinh_lambda.asinh();
        let w = match ellipse {
            Ellipse::Approximate => 4.0 / 3.0 * lambda,
            Ellipse::Exact if lambda == 0.0 => 0.0,
            Ellipse::Exact => root::between(lambda, 4.0 / 3.0 * lambda * (1.0 + 1e-12), |w| {
                w - ellipse_integrals(w).rho.atanh() - lambda
            }),
        };
        CurvatureIntegrals {
            lambda,
            ..CurvatureIntegrals::of_ellipse(w, ellipse)
        }
    }

    fn of_ellipse(w: f64, ellipse: Ellipse) -> CurvatureIntegrals {
        let integrals = ellipse_integrals(w);
        CurvatureIntegrals {
            lambda: match ellipse {
                Ellipse::Approximate => 0.75 * w,
                Ellipse::Exact => w - integrals.rho.atanh(),
            },
            w,
            mean_excess: integrals.mean_excess,
            rho: integrals.rho,
        }
    }

    /// `M (1 - rho^2)^{1/4}`.
    fn form_factor(&self) -> f64 {
        (1.0 + self.mean_excess) * ((1.0 - self.rho) * (1.0 + self.rho)).sqrt().sqrt()
    }

    fn ln_form_factor(&self) -> f64 {
        self.mean_excess.ln_1p() + 0.25 * ((-self.rho).ln_1p() + self.rho.ln_1p())
    }
}

/// Sine and cosine of an angle in degrees folded to 0..90, exact at both ends.
fn folded_sin_cos(angle_deg: f64) -> Result<(f64, f64)> {
    let expected = "a finite angle in degrees";
    Error::require(angle_deg.is_finite(), "angle", expected, angle_deg)?;
    let angle = angle_deg.abs() % 180.0;
    let folded = if angle > 90.0 { 180.0 - angle } else { angle };
    Ok(if folded <= 45.0 {
        folded.to_radians().sin_cos()
    } else {
        let (sine, cosine) = (90.0 - folded).to_radians().sin_cos();
        (cosine, sine)
    })
}

fn positive(option: &'static str, value: f64) -> Result<()> {
    let is_one = value > 0.0 && value.is_finite();
    Error::require(is_one, option, "a positive number", value)
}
