//! The bodies of an SI scene: their material and shape, and the contacts and masses that follow.

use std::f64::consts::PI;

use super::check::Check;
use super::{MaterialTyped, Scene, Shape};
use crate::chain::contact::{HertzContact, Material, Surface};
use crate::error::Result;

/// Equal bodies.
#[derive(Clone, Copy)]
pub(super) struct Bodies<'a> {
    check: Check<'a>,
    material: Material,
    shape: Shape,
    radius: f64,
}

impl<'a> Bodies<'a> {
    /// The bodies of a scene with a material.
    pub(super) fn new(check: Check<'a>) -> Result<Bodies<'a>> {
        let scene = check.scene;
        let radius = check.need("radius", scene.radius, "the radius of the bodies")?;
        Ok(Bodies {
            check,
            material: material(check)?,
            shape: scene.shape.unwrap_or_default(),
            radius: radius.value,
        })
    }

    pub(super) fn shape(&self) -> Shape {
        self.shape
    }

    /// Distance of neighbours, `2 R`.
    pub(super) fn pitch(&self) -> f64 {
        2.0 * self.radius
    }

    /// Mass of a body: `pi R^2 L rho` or `4 pi R^3 rho / 3`.
    pub(super) fn mass(&self) -> Result<f64> {
        let (r, density) = (self.radius, self.material.density);
        match self.shape {
            Shape::Sphere => Ok(sphere_mass(r, density)),
            Shape::Cylinder => {
                let expected = "the length of the cylinders, or their masses";
                let length = self.check.need("length", self.scene().length, expected)?;
                Ok(PI * r * r * length.value * density)
            }
        }
    }

    /// Coefficient of two bodies at this angle.
    pub(super) fn coefficient(&self, key: &str, angle: f64) -> Result<f64> {
        let surface = self.surface();
        self.contact(key, &surface, &surface, angle)
    }

    /// Mass and coefficient of the spherical striker, if it is one.
    pub(super) fn striker(&self) -> Result<Option<(f64, f64)>> {
        let Some(radius) = self.scene().striker_radius else {
            return Ok(None);
        };
        let material = self.or_other(self.scene().striker_material);
        let sphere = Surface::sphere(radius.value, material);
        // A sphere looks the same from all sides.
        let coefficient = self.contact("striker_radius", &sphere, &self.surface(), 90.0)?;
        let mass = sphere_mass(radius.value, material.density);
        Ok(Some((mass, coefficient)))
    }

    /// Coefficient of the contact with the wall, if anything is typed about it.
    pub(super) fn wall(&self) -> Result<Option<f64>> {
        let scene = self.scene();
        if scene.wall_radius.is_none() && scene.wall_material.is_none() {
            return Ok(None);
        }
        let material = self.or_other(scene.wall_material);
        let surface = match scene.wall_radius {
            Some(radius) => Surface::sphere(radius.value, material),
            None if self.shape == Shape::Cylinder => {
                let expected = "the radius by which the wall touches a cylinder in a point";
                return Err(self.check.fault("wall_radius", expected, "nothing"));
            }
            None => Surface::flat(material),
        };
        self.contact("wall_radius", &self.surface(), &surface, 90.0)
            .map(Some)
    }

    fn scene(&self) -> &'a Scene {
        self.check.scene
    }

    fn surface(&self) -> Surface {
        match self.shape {
            Shape::Cylinder => Surface::cylinder(self.radius, self.material),
            Shape::Sphere => Surface::sphere(self.radius, self.material),
        }
    }

    fn contact(&self, key: &str, first: &Surface, second: &Surface, angle: f64) -> Result<f64> {
        let ellipse = self.scene().ellipse.unwrap_or_default();
        let contact = HertzContact::new(first, second, angle, ellipse);
        let contact = contact.map_err(|error| self.check.named(error, key))?;
        if !(contact.coefficient > 0.0 && contact.coefficient.is_finite()) {
            let expected = "bodies whose contact is neither rigid nor loose";
            let found = format!("the coefficient {}", contact.coefficient);
            return Err(self.check.fault(key, expected, found));
        }
        Ok(contact.coefficient)
    }

    fn or_other(&self, named: Option<MaterialTyped>) -> Material {
        named.map_or(self.material, MaterialTyped::material)
    }
}

fn sphere_mass(radius: f64, density: f64) -> f64 {
    4.0 / 3.0 * PI * radius * radius * radius * density
}

/// The named material with the typed values overriding its own.
fn material(check: Check) -> Result<Material> {
    let scene = check.scene;
    let named = scene.material.map(MaterialTyped::material);
    let either = |key: &str, typed: Option<f64>, named: Option<f64>| {
        check.need(key, typed.or(named), "it beside `young`, or a `material`")
    };
    let [young, density] = [scene.young.map(|m| m.value), scene.density.map(|m| m.value)];
    let material = Material {
        young: either("young", young, named.map(|m| m.young))?,
        poisson: either("poisson", scene.poisson, named.map(|m| m.poisson))?,
        density: either("density", density, named.map(|m| m.density))?,
    };
    if !(material.poisson > -1.0 && material.poisson <= 0.5) {
        let expected = "Poisson's ratio above -1, at most 0.5";
        return Err(check.fault("poisson", expected, material.poisson));
    }
    Ok(material)
}
