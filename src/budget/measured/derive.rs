//! What follows from velocities: displacements, forces, fluxes, energies, momentum.

use ndarray::{Array1, Array2, ArrayView1, Axis, s};

use super::missing;
use crate::budget::contacts::{ContactState, Contacts};
use crate::budget::motion::Motion;
use crate::budget::quadrature::{CUBIC, running};
use crate::budget::real_space::SiteTerms;
use crate::chain::Chain;

/// What follows from velocities, or the standard errors of that: `(time, site)` or `(time, contact)`.
#[derive(Debug, Clone, Default)]
pub struct MotionArrays {
    /// Drift taken off, zero while at rest, missing sites filled in.
    pub velocity: Array2<f64>,
    /// Beyond the static one.
    pub overlap: Array2<f64>,
    /// Beyond the static one, damping included.
    pub force: Array2<f64>,
    pub flux: Array2<f64>,
    /// Integral of the flux by the trapezoid rule, as budgets of samples have it.
    pub passed: Array2<f64>,
    /// Total energy, `(time, 1)`.
    pub energy: Array2<f64>,
    /// `m (v - v(t0))` less the integral of all forces, `(time, site)`.
    pub(super) unbalanced: Array2<f64>,
}

impl MotionArrays {
    /// Puts `of` this array, that of `a` and that of `b` in place of each array.
    pub(super) fn combine(
        &mut self,
        a: &MotionArrays,
        b: &MotionArrays,
        of: impl Fn(&mut Array2<f64>, &Array2<f64>, &Array2<f64>),
    ) {
        of(&mut self.velocity, &a.velocity, &b.velocity);
        of(&mut self.overlap, &a.overlap, &b.overlap);
        of(&mut self.force, &a.force, &b.force);
        of(&mut self.flux, &a.flux, &b.flux);
        of(&mut self.passed, &a.passed, &b.passed);
        of(&mut self.energy, &a.energy, &b.energy);
        of(&mut self.unbalanced, &a.unbalanced, &b.unbalanced);
    }
}

/// What follows from velocities.
#[derive(Debug, Clone)]
pub(super) struct Derived {
    pub(super) values: MotionArrays,
    pub(super) displacement: Array2<f64>,
    /// Total energy and what losses have taken, at each time.
    pub(super) given: Vec<f64>,
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
        let (displacement, velocity) = Derived::moved(chain, dt, velocity, missing);
        let time = Array1::from_shape_fn(samples, |i| dt * i as f64);
        let motion = motion(chain, time.view(), &displacement, &velocity);
        let contacts = Contacts::of(&motion);
        let offset = contacts.offset;
        let [mut overlap, mut force, mut flux] = [(); 3].map(|()| Array2::zeros((samples, m)));
        let [mut energy, mut lost] = [(); 2].map(|()| Array2::zeros((samples, 1)));
        let mut pushed = Array2::zeros((samples, n));
        let mut elastic = Array2::zeros((samples, contacts.each.len()));
        let mut state = ContactState::default();
        let mut sites = SiteTerms::default();
        for i in 0..samples {
            let at = motion.at(i);
            contacts.evaluate(at, &mut state);
            sites.evaluate(&contacts, at, &state);
            energy[[i, 0]] = sites.kinetic + sites.contact;
            lost[[i, 0]] = crate::numeric::sum(&sites.loss);
            flux.row_mut(i).assign(&ArrayView1::from(&sites.flux));
            elastic.row_mut(i).assign(&ArrayView1::from(&state.elastic));
            let all = &elastic.row(i) + &ArrayView1::from(&state.damping);
            let inside = ArrayView1::from(&state.overlap[offset..]);
            overlap.row_mut(i).assign(&inside.slice(s![..m]));
            force.row_mut(i).assign(&all.slice(s![offset..offset + m]));
            let all = all.to_vec();
            for j in 0..n {
                pushed[[i, j]] = contacts.push_on(j, &all) - contacts.pull(j, at);
            }
        }
        let lost = running(lost.view(), dt, CUBIC);
        let mass = ArrayView1::from(&chain.mass);
        let gained = (&velocity - &velocity.row(0)) * mass;
        Derived {
            given: (&energy + &lost).into_raw_vec_and_offset().0,
            impulse: running(elastic.view(), dt, CUBIC),
            values: MotionArrays {
                passed: running(flux.view(), dt, 2),
                unbalanced: gained - running(pushed.view(), dt, CUBIC),
                velocity,
                overlap,
                force,
                flux,
                energy,
            },
            displacement,
        }
    }

    /// Displacements and velocities alone.
    pub(super) fn moved(
        chain: &Chain,
        dt: f64,
        mut velocity: Array2<f64>,
        missing: &[bool],
    ) -> (Array2<f64>, Array2<f64>) {
        let mut displacement = running(velocity.view(), dt, CUBIC);
        missing::fill(chain, dt, missing, &mut displacement, &mut velocity);
        (displacement, velocity)
    }
}

/// Share of the difference of two samplings that is the error of the finer one, at an error of
/// second order.
pub(super) const HALVED: f64 = 1.0 / 3.0;

/// The largest error by the sampling so far along time, of each column, by what every other sample finds.
pub(super) fn envelope(full: &Array2<f64>, half: &Array2<f64>) -> Array2<f64> {
    let mut out = Array2::zeros(full.dim());
    let last = half.nrows() - 1;
    for (column, mut out) in out.axis_iter_mut(Axis(1)).enumerate() {
        let mut most: f64 = 0.0;
        for (i, out) in out.iter_mut().enumerate() {
            // An odd sample is as far off as the next even one.
            let k = i.div_ceil(2).min(last);
            most = most.max(HALVED * (full[[2 * k, column]] - half[[k, column]]).abs());
            *out = most;
        }
    }
    out
}
