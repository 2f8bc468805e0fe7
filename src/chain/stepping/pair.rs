//! One step of an embedded pair on one island.

use super::super::law::Kernel;
use super::correction::{Correction, Quintic};
use super::islands::Island;
use super::system::{State, System};
use super::tableau::{Tableau, Weights};

/// Scratch of a step.
#[derive(Debug)]
pub(super) struct Scratch {
    stride: usize,
    /// Accelerations, forces and damping forces, one row a stage.
    k: Vec<f64>,
    force: Vec<f64>,
    damping: Vec<f64>,
    x: Vec<f64>,
    v: Vec<f64>,
    error: Vec<f64>,
}

impl Scratch {
    pub(super) fn new(places: usize, stages: usize) -> Scratch {
        let stride = places + 1;
        Scratch {
            stride,
            k: vec![0.0; stride * stages],
            force: vec![0.0; stride * stages],
            damping: vec![0.0; stride * stages],
            x: vec![0.0; stride],
            v: vec![0.0; stride],
            error: vec![0.0; stride],
        }
    }

    /// Room for the forces and the damping forces of one evaluation.
    pub(super) fn forces(&mut self) -> (&mut [f64], &mut [f64]) {
        (&mut self.force, &mut self.damping)
    }
}

/// What came of a step.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Outcome {
    /// Largest estimated error of a velocity.
    pub(super) error: f64,
    /// A guard contact pressed.
    pub(super) leaked: bool,
    /// Contacts that were corrected.
    pub(super) corrected: u64,
}

impl Outcome {
    pub(super) fn and(self, other: Outcome) -> Outcome {
        Outcome {
            // NaN is kept: it is larger than any tolerance.
            error: if self.error.is_nan() || self.error > other.error {
                self.error
            } else {
                other.error
            },
            leaked: self.leaked || other.leaked,
            corrected: self.corrected + other.corrected,
        }
    }
}

/// `out = base(s) + sum_m scale w_m k_m`, the sum started with `first(s)`.
#[inline(always)]
fn weighted_by<const M: usize>(
    out: &mut [f64],
    terms: &Weights,
    scale: f64,
    k: &[f64],
    stride: usize,
    base: impl Fn(usize) -> f64,
    first: impl Fn(usize) -> f64,
) {
    let n = out.len();
    let rows: [&[f64]; M] = std::array::from_fn(|m| &k[terms[m].0 * stride..][..n]);
    let w: [f64; M] = std::array::from_fn(|m| scale * terms[m].1);
    for s in 0..n {
        let mut sum = first(s);
        for m in 0..M {
            sum += w[m] * rows[m][s];
        }
        out[s] = base(s) + sum;
    }
}

/// [`weighted_by`] for the number of terms at hand.
#[inline(always)]
fn weighted(
    out: &mut [f64],
    terms: &Weights,
    scale: f64,
    k: &[f64],
    stride: usize,
    base: impl Fn(usize) -> f64,
    first: impl Fn(usize) -> f64,
) {
    macro_rules! by_count {
        ($($count:literal)*) => {
            match terms.len() {
                $($count => weighted_by::<$count>(out, terms, scale, k, stride, base, first),)*
                _ => weighted_by::<13>(out, terms, scale, k, stride, base, first),
            }
        };
    }
    by_count!(0 1 2 3 4 5 6 7 8 9 10 11 12)
}

/// Advances an island from `state` at time t by h, into `next`.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
pub(super) fn advance<K: Kernel, const LOSSY: bool, const ENERGY: bool>(
    system: &System<K>,
    tableau: &Tableau,
    correction: Option<&Correction>,
    negligible: f64,
    island: &Island,
    (t, h): (f64, f64),
    state: &State,
    next: &mut State,
    scratch: &mut Scratch,
) -> Outcome {
    let places = island.places();
    let (first, n) = (places.start, places.len());
    let stride = scratch.stride;
    let x = &state.x[places.clone()];
    let v = &state.v[places.clone()];
    let Scratch {
        k,
        force,
        damping,
        x: xs,
        v: vs,
        error,
        ..
    } = scratch;
    let (xs, vs) = (&mut xs[..n], &mut vs[..n]);
    let mut leaked = false;

    k[..n].copy_from_slice(&state.a[places.clone()]);
    if ENERGY {
        let start = &mut k[stride..stride + n];
        system.accelerate::<LOSSY>(t, first, x, v, force, damping, start);
    }
    let last = tableau.stages() - 1;
    for stage in 1..=last {
        let ch = tableau.c[stage] * h;
        let terms = &tableau.a[stage];
        weighted(xs, terms, h * h, k, stride, |s| x[s], |s| ch * v[s]);
        if LOSSY {
            let terms = &tableau.velocity[stage];
            weighted(vs, terms, h, k, stride, |s| v[s], |_| 0.0);
        }
        system.place_ghosts(t + ch, first, xs, vs);
        let row = if ENERGY { stage * stride } else { 0 };
        let force = &mut force[row..];
        let a = &mut k[stage * stride..][..n];
        system.accelerate::<LOSSY>(t + ch, first, xs, vs, force, &mut damping[row..], a);
        leaked |=
            (island.guards[0] && force[1] != 0.0) || (island.guards[1] && force[n - 1] != 0.0);
    }

    let (x1, v1) = (&mut next.x[places.clone()], &mut next.v[places.clone()]);
    weighted(x1, &tableau.b, h * h, k, stride, |s| x[s], |s| h * v[s]);
    weighted(v1, &tableau.bp, h, k, stride, |s| v[s], |_| 0.0);
    let error = &mut error[..n];
    weighted(error, &tableau.error, h, k, stride, |_| 0.0, |_| 0.0);
    system.place_ghosts(t + h, first, x1, v1);

    let mut events: Vec<Event> = Vec::new();
    let end = &k[last * stride..][..n];
    if let Some(correction) = correction {
        // The interpolants are those of the uncorrected step, whatever neighbours need.
        xs.copy_from_slice(x1);
        vs.copy_from_slice(v1);
        for i in 0..n - 1 {
            let d0 = system.static_overlap[first + i];
            let (start, finish) = (d0 + (x[i] - x[i + 1]), d0 + (xs[i] - xs[i + 1]));
            let (closing, closing_end) = (h * (v[i] - v[i + 1]), h * (vs[i] - vs[i + 1]));
            let crosses = (start > 0.0) != (finish > 0.0);
            let grazes = closing * closing_end < 0.0
                && (start > 0.0) == (closing < 0.0)
                && start.abs().min(finish.abs()) < closing.abs() + closing_end.abs();
            let scale = h * system.coefficient[first + i];
            let mobility = system.mobility[first + i].max(system.mobility[first + i + 1]);
            let force = system.kernel.power(start.max(finish).max(0.0));
            if !(grazes || crosses && scale * force * mobility > negligible) {
                continue;
            }
            let bend = h * h * (k[i] - k[i + 1]);
            let bend_end = h * h * (end[i] - end[i + 1]);
            let overlap = Quintic::hermite([start, closing, bend], [finish, closing_end, bend_end]);
            let [left, right] = system.flux_share[first + i];
            let speed = |s: f64| {
                if !ENERGY {
                    return 0.0;
                }
                let of_place = |i: usize| {
                    let path = [x[i], h * v[i], h * h * k[i]];
                    let path_end = [xs[i], h * vs[i], h * h * end[i]];
                    Quintic::hermite(path, path_end).slope_at(s) / h
                };
                left * of_place(i) + right * of_place(i + 1)
            };
            let Some(missed) = correction.along(system.kernel, tableau, &overlap, speed) else {
                continue;
            };
            for (s, sign) in [(i, -1.0), (i + 1, 1.0)] {
                let push = sign * scale * system.mobility[first + s];
                v1[s] += push * missed.impulse;
                x1[s] += push * h * missed.moment;
                error[s] -= push * missed.estimate;
            }
            events.push(Event {
                contact: i,
                work: if ENERGY { scale * missed.work } else { 0.0 },
                impulses: if ENERGY {
                    correction.up_to_stages(system.kernel, tableau, &overlap)
                } else {
                    Vec::new()
                },
            });
        }
        if system.periodic && !events.is_empty() {
            // The two images of the closing contact were corrected alike, each on its own side.
            (x1[0], v1[0], error[0]) = (x1[n - 2], v1[n - 2], error[n - 2]);
            (x1[n - 1], v1[n - 1], error[n - 1]) = (x1[1], v1[1], error[1]);
        }
    }
    if ENERGY {
        let step = Step {
            tableau,
            first,
            n,
            t,
            h,
            stride,
        };
        pass_energy::<K, LOSSY>(system, &step, &events, state, next, k, force, damping, vs);
    }
    if !events.is_empty() {
        let (x1, v1) = (&next.x[places.clone()], &next.v[places.clone()]);
        let a = &mut next.a[places];
        system.accelerate::<LOSSY>(t + h, first, x1, v1, force, damping, a);
        leaked |=
            (island.guards[0] && force[1] != 0.0) || (island.guards[1] && force[n - 1] != 0.0);
    } else {
        next.a[places].copy_from_slice(end);
    }
    let error = error.iter().fold(0.0, |worst: f64, e| {
        let e = e.abs();
        if e > worst || e.is_nan() { e } else { worst }
    });
    Outcome {
        error,
        leaked,
        corrected: events.len() as u64,
    }
}

/// A contact that opened or closed inside the step.
struct Event {
    contact: usize,
    /// Work that the quadrature missed.
    work: f64,
    /// Impulse up to each stage that the stage's velocity missed, in units of the step.
    impulses: Vec<f64>,
}

/// Where and when a step is taken.
struct Step<'a> {
    tableau: &'a Tableau,
    first: usize,
    n: usize,
    t: f64,
    h: f64,
    stride: usize,
}

/// Adds what the contacts passed on and what was lost, by the quadrature of the velocities.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn pass_energy<K: Kernel, const LOSSY: bool>(
    system: &System<K>,
    step: &Step,
    events: &[Event],
    state: &State,
    next: &mut State,
    k: &[f64],
    force: &[f64],
    damping: &[f64],
    vs: &mut [f64],
) {
    let Step {
        tableau,
        first,
        n,
        t,
        h,
        stride,
    } = *step;
    let v = &state.v[first..first + n];
    let passed = &mut next.passed[first..first + n - 1];
    passed.copy_from_slice(&state.passed[first..first + n - 1]);
    let share = &system.flux_share[first..first + n - 1];
    for event in events {
        passed[event.contact] += event.work;
    }
    if LOSSY {
        next.lost[first..first + n].copy_from_slice(&state.lost[first..first + n]);
    }
    for &(stage, weight) in &tableau.bp {
        let ch = tableau.c[stage] * h;
        let terms = &tableau.velocity[stage];
        weighted(vs, terms, h, k, stride, |s| v[s], |_| 0.0);
        system.place_ghosts(t + ch, first, &mut [0.0], vs);
        for event in events {
            let missed = h * system.coefficient[first + event.contact] * event.impulses[stage];
            let left = event.contact;
            vs[left] -= missed * system.mobility[first + left];
            vs[left + 1] += missed * system.mobility[first + left + 1];
        }
        let weight = weight * h;
        let row = &force[stage * stride + 1..][..n - 1];
        for i in 0..n - 1 {
            passed[i] += weight * row[i] * (share[i][0] * vs[i] + share[i][1] * vs[i + 1]);
        }
        if LOSSY {
            let lost = &mut next.lost[first..first + n];
            let row = &damping[stage * stride + 1..][..n - 1];
            for i in 0..n - 1 {
                let heat = weight * row[i] * (vs[i] - vs[i + 1]);
                let [left, right] = system.loss_share(first + i);
                lost[i] += left * heat;
                lost[i + 1] += right * heat;
            }
            for s in 0..n {
                if system.mobility[first + s] > 0.0 {
                    lost[s] += weight * system.losses.drag * vs[s] * vs[s];
                }
            }
        }
    }
}
