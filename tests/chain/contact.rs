//! Hertz contacts against 90-digit arithmetic (`tests/data/contact_reference.py`), the published
//! stiffness ratio, and their own inverse.

use test_support::changed;
use test_support::scenes::{apart, largest, near};
use wavecascade::chain::contact::{
    Ellipse, HertzContact, Material, Surface, angle_of_stiffness_ratio, stiffness_ratio,
};

/// A material pair with `E* = 1`.
const UNIT: Material = Material {
    young: 2.0,
    poisson: 0.0,
    density: 1.0,
};

const BOTH: [Ellipse; 2] = [Ellipse::Approximate, Ellipse::Exact];

fn relative(found: f64, expected: f64) -> f64 {
    (found / expected - 1.0).abs()
}

#[test]
fn val_mpmath_coefficients_and_ellipses() {
    let table = include_str!("../data/contact_reference.csv").lines();
    let off = table.skip(1).map(|row| {
        let values: Vec<f64> = row.split(',').skip(1).map(|v| v.parse().unwrap()).collect();
        let [p1, q1, p2, q2, angle, exact, coefficient, aspect] = values[..] else {
            panic!("{row}")
        };
        let [first, second] = [[p1, q1], [p2, q2]].map(|curvature| Surface {
            material: UNIT,
            curvature,
        });
        let of = HertzContact::new(&first, &second, angle, BOTH[exact as usize]).unwrap();
        [
            relative(of.coefficient, coefficient),
            relative(of.aspect, aspect),
        ]
    });
    let off: Vec<[f64; 2]> = off.collect();
    let [coefficient, aspect] = [0, 1].map(|of| largest(off.iter().map(|off| off[of])));
    near(coefficient, 0.0, 5e-15, "coefficients");
    near(aspect, 0.0, 6e-15, "aspects");
}

#[test]
fn val_paper_stiffness_ratio_of_8_and_90_degrees() {
    let ratio = stiffness_ratio(8.0, Ellipse::Approximate).unwrap();
    assert!((ratio - 4.507).abs() < 5e-4, "{ratio}");
    let [a, b] = [8.0, 90.0].map(|angle| {
        let of =
            HertzContact::crossed_cylinders(9e-3, Material::QUARTZ, angle, Ellipse::Approximate);
        of.unwrap().coefficient
    });
    assert!(relative(a / b, ratio) < 1e-15);
}

#[test]
fn val_closed_form_spheres() {
    let (radius, material) = (9e-3, Material::QUARTZ);
    let sphere = Surface::sphere(radius, material);
    let modulus = material.young / (1.0 - material.poisson * material.poisson);
    for (other, radius) in [(Surface::flat(material), radius), (sphere, 0.5 * radius)] {
        for ellipse in BOTH {
            let contact = HertzContact::new(&sphere, &other, 33.0, ellipse).unwrap();
            let expected = 2.0 / 3.0 * modulus * radius.sqrt();
            assert!(relative(contact.coefficient, expected) < 1e-15);
            assert!((contact.aspect - 1.0).abs() < 1e-15);
        }
    }
}

#[test]
fn val_symmetry_angles_fold() {
    for ellipse in BOTH {
        let ratio = |angle| stiffness_ratio(angle, ellipse);
        for (angle, same) in [(98.0, 82.0), (172.0, 8.0), (-8.0, 8.0), (188.0, 8.0)] {
            assert_eq!(ratio(angle).unwrap(), ratio(same).unwrap());
        }
        assert_eq!(ratio(90.0).unwrap(), 1.0);
        let refused = [0.0, 180.0, f64::NAN].map(|angle| ratio(angle).is_err());
        assert_eq!(refused, [true; 3]);
    }
}

#[test]
fn val_inverse_angle_of_ratio() {
    for ellipse in BOTH {
        let ratio = |angle| stiffness_ratio(angle, ellipse).unwrap();
        let angle = |ratio| angle_of_stiffness_ratio(ratio, ellipse).unwrap();
        let angles = [1e-6, 0.01, 0.5, 2.0, 8.0, 18.0, 30.0, 45.0, 60.0, 70.0];
        let ratios = [1.0, 1.0 + 1e-12, 1.0 + 1e-6, 1.1, 2.398, 4.927, 1631.0, 1e6];
        let back = angles.map(|of| angle(ratio(of)) / of);
        assert!(apart(back, [1.0; 10]) < 1e-14, "{back:?}");
        let back = ratios.map(|of| ratio(angle(of)) / of);
        assert!(apart(back, [1.0; 8]) < 4e-15, "{back:?}");
        assert_eq!(angle(1.0), 90.0);
        // ratio - 1 = gamma^2 / 3 + ... with gamma = 90 degrees - angle
        let above = 2f64.powi(-40);
        let gamma = (90.0 - angle(1.0 + above)).to_radians();
        assert!(relative(3.0 * above / (gamma * gamma), 1.0) < 1e-9);
        let refused = |ratio| angle_of_stiffness_ratio(ratio, ellipse).is_err();
        assert!(refused(0.999) && refused(f64::INFINITY));
    }
}

#[test]
fn val_hertz_unphysical_surfaces_are_refused() {
    let cylinder = Surface::cylinder(9e-3, Material::QUARTZ);
    let hole = Surface {
        material: Material::QUARTZ,
        curvature: [-200.0, -200.0],
    };
    let ball = Surface::sphere(9e-3, Material::QUARTZ);
    for (first, second) in [(cylinder, cylinder), (ball, hole)] {
        assert!(HertzContact::new(&first, &second, 0.0, Ellipse::Exact).is_err());
    }
    let soft = changed(Material::QUARTZ, |it| it.poisson = 0.6);
    for (radius, material) in [(9e-3, soft), (0.0, Material::QUARTZ)] {
        let of = HertzContact::crossed_cylinders(radius, material, 45.0, Ellipse::Exact);
        assert!(of.is_err());
    }
}
