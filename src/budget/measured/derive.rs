//! What follows from velocities: displacements, forces, fluxes, energies, momentum.

use ndarray::{Array1, Array2, ArrayView1, Axis};

use super::missing;
use crate::budget::contacts::{ContactState, Contacts};
use crate::budget::motion::Motion;
use crate::budget::quadrature::{CUBIC, Quadrature};
use crate::budget::real_space::SiteTerms;
use crate::chain::Chain;

/// Arrays over `(time, site)` or `(time, contact)`.
#[derive(Debug, Clone)]
pub(super) struct Derived {
    pub(super) velocity: Array2<f64>,
    pub(super) displacement: Array2<f64>,
    /// Overlap beyond the static one.
    pub(super) overlap: Array2<f64>,
    /// Force beyond the static one, damping included.
    pub(super) force: Array2<f64>,
    pub(super) flux: Array2<f64>,
    /// Integral of the flux by the trapezoid rule, as budgets of samples have it.
    pub(super) passed: Array2<f64>,
    /// Total energy `(time, 1)`.
    pub(super) energy: Array2<f64>,
    /// Total energy and what losses have taken, at each time.
    pub(super) given: Vec<f64>,
    /// `m (v - v(t0))` less the integral of all forces, `(time, site)`.
    pub(super) unbalanced: Array2<f64>,
    /// Integral of the elastic force, `(time, contact)`, that of a wall before site 0 first.
    pub(super) impulse: Array2<f64>,
}

/// The motion of velocities and displacements.
pub(super) fn motion<'a>(
    chain: &'a Chain,
    time: ArrayView1<'a, f64>,
    displacement: &'a Array2<f64>,
    velocity: &'a Array2<f64>,
) -> Motion<'a> {
    Motion {
        chain,
        drive: None,
        time,
        displacement: displacement.view(),
        velocity: velocity.view(),
        resonators: None,
        energy_passed: None,
        energy_lost: None,
        energy_input: None,
    }
}

impl Derived {
    /// From velocities `dt` apart; columns of `missing` sites are filled in.
    pub(super) fn of(chain: &Chain, dt: f64, velocity: Array2<f64>, missing: &[bool]) -> Derived {
        let (samples, n) = velocity.dim();
        let m = chain.n_contacts();
        let quadrature = Quadrature::new(samples, CUBIC);
        let (displacement, velocity) = Derived::moved(chain, dt, velocity, missing);
        let time = Array1::from_shape_fn(samples, |i| dt * i as f64);
        let motion = motion(chain, time.view(), &displacement, &velocity);
        let contacts = Contacts::of(&motion);
        let offset = contacts.offset;
        let mut out = Derived {
            overlap: Array2::zeros((samples, m)),
            force: Array2::zeros((samples, m)),
            flux: Array2::zeros((samples, m)),
            passed: Array2::zeros((samples, m)),
            energy: Array2::zeros((samples, 1)),
            given: Vec::new(),
            unbalanced: Array2::zeros((samples, n)),
            impulse: Array2::zeros((samples, contacts.len())),
            velocity: Array2::default((0, 0)),
            displacement: Array2::default((0, 0)),
        };
        let mut state = ContactState::default();
        let mut sites = SiteTerms::default();
        let mut lost = Array2::zeros((samples, 1));
        for i in 0..samples {
            let at = motion.at(i);
            contacts.evaluate(at, &mut state);
            sites.evaluate(&contacts, at, &state);
            out.energy[[i, 0]] = sites.kinetic + sites.contact;
            lost[[i, 0]] = crate::numeric::sum(&sites.loss);
            out.flux.row_mut(i).assign(&ArrayView1::from(&sites.flux));
            let forces = state.elastic.iter().zip(&state.damping);
            let force: Vec<f64> = forces.map(|(e, d)| e + d).collect();
            for j in 0..m {
                out.overlap[[i, j]] = state.overlap[j + offset];
                out.force[[i, j]] = force[j + offset];
            }
            for j in 0..n {
                out.unbalanced[[i, j]] = contacts.push_on(j, &force) - contacts.pull(j, at);
            }
            let elastic = ArrayView1::from(&state.elastic);
            out.impulse.row_mut(i).assign(&elastic);
        }
        out.passed = Quadrature::new(samples, 2).running(out.flux.view(), dt);
        let lost = quadrature.running(lost.view(), dt);
        out.given = (&out.energy + &lost).into_raw_vec_and_offset().0;
        out.impulse = quadrature.running(out.impulse.view(), dt);
        let pushed = quadrature.running(out.unbalanced.view(), dt);
        let mass = ArrayView1::from(&chain.mass);
        let gained = (&velocity - &velocity.row(0)) * mass;
        out.unbalanced = gained - pushed;
        out.velocity = velocity;
        out.displacement = displacement;
        out
    }

    /// Displacements and velocities alone.
    pub(super) fn moved(
        chain: &Chain,
        dt: f64,
        mut velocity: Array2<f64>,
        missing: &[bool],
    ) -> (Array2<f64>, Array2<f64>) {
        let quadrature = Quadrature::new(velocity.nrows(), CUBIC);
        let mut displacement = quadrature.running(velocity.view(), dt);
        missing::fill(chain, dt, missing, &mut displacement, &mut velocity);
        (displacement, velocity)
    }
}

/// Largest magnitude so far along time, of each column of what two samplings differ by.
pub(super) fn envelope(full: &Array2<f64>, half: &Array2<f64>, share: f64) -> Array2<f64> {
    let mut out = Array2::zeros(full.dim());
    let last = half.nrows() - 1;
    for (column, mut out) in out.axis_iter_mut(Axis(1)).enumerate() {
        let mut most: f64 = 0.0;
        for (i, out) in out.iter_mut().enumerate() {
            // An odd sample is as far off as the next even one.
            let k = i.div_ceil(2).min(last);
            most = most.max(share * (full[[2 * k, column]] - half[[k, column]]).abs());
            *out = most;
        }
    }
    out
}
