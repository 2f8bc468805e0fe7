//! Hertz contacts against 90-digit arithmetic (`tests/data/contact_reference.py`), the published
//! stiffness ratio, and their own inverse.

use test_support::changed;
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
    let table = include_str!("../data/contact_reference.csv");
    let (mut worst_coefficient, mut worst_aspect) = (0f64, 0f64);
    for row in table.lines().skip(1) {
        let values: Vec<f64> = row.split(',').skip(1).map(|v| v.parse().unwrap()).collect();
        let [p1, q1, p2, q2, angle, exact, coefficient, aspect] = values[..] else {
            panic!("{row}")
        };
        let surface = |curvature| Surface {
            material: UNIT,
            curvature,
        };
        let ellipse = BOTH[exact as usize];
        let contact =
            HertzContact::new(&surface([p1, q1]), &surface([p2, q2]), angle, ellipse).unwrap();
        worst_coefficient = worst_coefficient.max(relative(contact.coefficient, coefficient));
        worst_aspect = worst_aspect.max(relative(contact.aspect, aspect));
    }
    println!("coefficient {worst_coefficient:.2e}, aspect {worst_aspect:.2e}");
    assert!(worst_coefficient < 5e-15, "{worst_coefficient:e}");
    assert!(worst_aspect < 6e-15, "{worst_aspect:e}");
}

#[test]
fn val_paper_stiffness_ratio_of_8_and_90_degrees() {
    let ratio = stiffness_ratio(8.0, Ellipse::Approximate).unwrap();
    assert!((ratio - 4.507).abs() < 5e-4, "{ratio}");
    let of_contacts = |angle| {
        HertzContact::crossed_cylinders(9e-3, Material::QUARTZ, angle, Ellipse::Approximate)
            .unwrap()
            .coefficient
    };
    assert!(relative(of_contacts(8.0) / of_contacts(90.0), ratio) < 1e-15);
}

#[test]
fn val_closed_form_spheres() {
    let (radius, material) = (9e-3, Material::QUARTZ);
    let sphere = Surface::sphere(radius, material);
    let modulus = material.young / (1.0 - material.poisson * material.poisson);
    for (other, expected) in [
        (Surface::flat(material), 2.0 / 3.0 * modulus * radius.sqrt()),
        (sphere, 2.0 / 3.0 * modulus * (0.5 * radius).sqrt()),
    ] {
        for ellipse in BOTH {
            let contact = HertzContact::new(&sphere, &other, 33.0, ellipse).unwrap();
            assert!(relative(contact.coefficient, expected) < 1e-15);
            assert!((contact.aspect - 1.0).abs() < 1e-15);
        }
    }
}

#[test]
fn val_symmetry_angles_fold() {
    for ellipse in BOTH {
        for (angle, same) in [(98.0, 82.0), (172.0, 8.0), (-8.0, 8.0), (188.0, 8.0)] {
            assert_eq!(
                stiffness_ratio(angle, ellipse).unwrap(),
                stiffness_ratio(same, ellipse).unwrap()
            );
        }
        assert_eq!(stiffness_ratio(90.0, ellipse).unwrap(), 1.0);
        assert!(stiffness_ratio(0.0, ellipse).is_err());
        assert!(stiffness_ratio(180.0, ellipse).is_err());
        assert!(stiffness_ratio(f64::NAN, ellipse).is_err());
    }
}

#[test]
fn val_inverse_angle_of_ratio() {
    let mut worst = 0f64;
    for ellipse in BOTH {
        for angle in [1e-6, 0.01, 0.5, 2.0, 8.0, 18.0, 30.0, 45.0, 60.0, 70.0] {
            let back = angle_of_stiffness_ratio(stiffness_ratio(angle, ellipse).unwrap(), ellipse);
            worst = worst.max(relative(back.unwrap(), angle));
        }
        for ratio in [1.0, 1.0 + 1e-12, 1.0 + 1e-6, 1.1, 2.398, 4.927, 1631.0, 1e6] {
            let angle = angle_of_stiffness_ratio(ratio, ellipse).unwrap();
            let off = relative(stiffness_ratio(angle, ellipse).unwrap(), ratio);
            assert!(off < 4e-15, "{ratio}: {off:e}");
        }
        assert_eq!(angle_of_stiffness_ratio(1.0, ellipse).unwrap(), 90.0);
        // ratio - 1 = gamma^2 / 3 + ... with gamma = 90 degrees - angle
        let above = 2f64.powi(-40);
        let gamma = (90.0 - angle_of_stiffness_ratio(1.0 + above, ellipse).unwrap()).to_radians();
        assert!(relative(3.0 * above / (gamma * gamma), 1.0) < 1e-9);
        assert!(angle_of_stiffness_ratio(0.999, ellipse).is_err());
        assert!(angle_of_stiffness_ratio(f64::INFINITY, ellipse).is_err());
    }
    println!("worst {worst:.2e}");
    assert!(worst < 1e-14, "{worst:e}");
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
    assert!(HertzContact::crossed_cylinders(9e-3, soft, 45.0, Ellipse::Exact).is_err());
    assert!(HertzContact::crossed_cylinders(0.0, Material::QUARTZ, 45.0, Ellipse::Exact).is_err());
}
