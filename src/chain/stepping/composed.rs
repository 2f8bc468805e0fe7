//! One step of a symmetric composition of kicks and drifts on one island.

use super::super::law::Kernel;
use super::islands::Island;
use super::pair::{Outcome, Scratch};
use super::system::{State, System};
use super::tableau::Composition;

/// The kicks and drifts of a step, in shares of it.
#[derive(Debug)]
pub(super) struct Splitting {
    kicks: Vec<f64>,
    pub(super) drifts: Vec<f64>,
}

impl Splitting {
    pub(super) fn new(composition: &Composition) -> Splitting {
        let (kicks, drifts) = composition.stages();
        Splitting { kicks, drifts }
    }

    /// Free flight over a step, with the roundings that the drifts make.
    #[inline(always)]
    pub(super) fn fly(&self, h: f64, v: &[f64], x: &mut [f64]) {
        for drift in &self.drifts {
            let time = drift * h;
            for (x, v) in x.iter_mut().zip(v) {
                *x += time * v;
            }
        }
    }
}

/// Advances an island from `state` at time t by h, into `next`.
#[inline(always)]
pub(super) fn advance<K: Kernel, const ENERGY: bool>(
    system: &System<K>,
    splitting: &Splitting,
    island: &Island,
    (mut t, h): (f64, f64),
    state: &State,
    next: &mut State,
    scratch: &mut Scratch,
) -> Outcome {
    let places = island.places();
    let (first, n) = (places.start, places.len());
    let State {
        x, v, a, passed, ..
    } = next;
    let (x, v, a) = (
        &mut x[places.clone()],
        &mut v[places.clone()],
        &mut a[places.clone()],
    );
    x.copy_from_slice(&state.x[places.clone()]);
    v.copy_from_slice(&state.v[places.clone()]);
    a.copy_from_slice(&state.a[places.clone()]);
    let (force, damping) = scratch.forces();
    if ENERGY {
        passed[first..first + n - 1].copy_from_slice(&state.passed[first..first + n - 1]);
        system.accelerate::<false>(t, first, x, v, force, damping, a);
    }
    let share = &system.flux_share[first..first + n - 1];
    let mut leaked = false;
    for (i, kick) in splitting.kicks.iter().enumerate() {
        if let Some(drift) = i.checked_sub(1).and_then(|i| splitting.drifts.get(i)) {
            let time = drift * h;
            for s in 0..n {
                x[s] += time * v[s];
            }
            t += time;
            system.place_ghosts(t, first, x, v);
            system.accelerate::<false>(t, first, x, v, force, damping, a);
            leaked |=
                (island.guards[0] && force[1] != 0.0) || (island.guards[1] && force[n - 1] != 0.0);
        }
        let time = kick * h;
        if ENERGY {
            // During a kick the force is constant and the velocity linear in time.
            let passed = &mut passed[first..first + n - 1];
            let mean = |s: usize| v[s] + 0.5 * time * a[s];
            for i in 0..n - 1 {
                passed[i] +=
                    time * force[i + 1] * (share[i][0] * mean(i) + share[i][1] * mean(i + 1));
            }
        }
        for s in 0..n {
            v[s] += time * a[s];
        }
    }
    // A speed that is not finite is an error that no tolerance accepts.
    let error = if v.iter().all(|v| v.is_finite()) {
        0.0
    } else {
        f64::NAN
    };
    Outcome {
        error,
        leaked,
        corrected: 0,
    }
}
