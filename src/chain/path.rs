//! Quadratures along the motion of a chain, for rates with fractional-power singularities at
//! contact openings.
//!
//! Any rule over samples or steps converges slowly for a rate with terms like `delta^{1/4}`, such
//! as the transfer between wavenumbers. Here each step is computed twice: first to find the
//! contacts that open or close inside it, then from the same start to the nodes of Gauss's rule
//! between these times. Near an opening at `t_o` the variable is `s` with `t - t_o ~ s^4`, in which
//! all multiples of the power 1/4 are smooth.

use super::lattice::{Chain, Contact};
use super::simulation::Simulation;
use super::stepping::{self, FIRST_SITE, Mark, State, Stepping};
use crate::error::Result;
use crate::observer::Observer;

/// Nodes between two openings, and where nothing opens.
const NODES: usize = 12;
const SMOOTH_NODES: usize = 8;

/// Pieces within this many of their lengths from an opening use the substitution.
const FELT: f64 = 2.0;

/// Openings of contacts with less than this share of the energy are ignored; their contribution to
/// a rate is its square root.
const NOTICED: f64 = 1e-26;

/// Shown the chain at a sample, and the accelerations of its bodies.
pub(crate) type Visit<'a> = dyn FnMut(NodeState, &dyn Fn(usize) -> f64) + 'a;

/// A place on the way.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Node {
    /// A node of the quadrature, with its weight.
    Node(f64),
    /// The sample of this index.
    Sample(usize),
}

/// Displacements and velocities there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NodeState<'a> {
    pub(crate) t: f64,
    pub(crate) x: &'a [f64],
    pub(crate) v: &'a [f64],
    /// Those of resonators; empty without.
    pub(crate) resonators: [&'a [f64]; 2],
}

impl NodeState<'_> {
    pub(super) fn of<'s>(chain: &'s Chain, t: f64, state: &'s State) -> NodeState<'s> {
        let n = chain.n_sites();
        NodeState {
            t,
            x: &state.x[FIRST_SITE..][..n],
            v: &state.v[FIRST_SITE..][..n],
            resonators: state.resonators(chain),
        }
    }
}

/// Called at the nodes of the quadrature.
pub(crate) trait NodeVisitor {
    fn visit(&mut self, visit: Node, place: NodeState);

    /// Times between two states, a step apart, of singularities of a rate other than contact
    /// openings.
    fn cusps(&mut self, _from: NodeState, _to: NodeState) -> Vec<f64> {
        Vec::new()
    }
}

impl Simulation {
    /// Steps through `times`, rising from 0, with this error of a velocity a step relative to the
    /// velocity scale, no step longer than `longest`, and shows `path` every sample and the nodes between them, in order.
    ///
    /// # Errors
    /// As [`Simulation::run`].
    pub(crate) fn along(
        &self,
        times: &[f64],
        [local_error, longest]: [f64; 2],
        observer: &dyn Observer,
        path: &mut dyn NodeVisitor,
    ) -> Result<()> {
        let (stepping, scale) = self.stepping(times, local_error, false)?;
        let largest_energy = self.chain.stored_energy(&self.displacement)
            + 0.5 * scale * scale * self.chain.mass.iter().copied().fold(0.0, f64::max);
        let mut walk = Walk {
            simulation: self,
            stepping,
            observer,
            noticed: NOTICED * largest_energy,
            smooth: stepping::gauss(SMOOTH_NODES),
            beside: stepping::gauss(NODES),
            opened: None,
            longest,
            contacts: vec![None; stepping::first_contact(&self.chain)],
        };
        walk.contacts.extend(self.chain.all_contacts().map(Some));
        let mut time = 0.0;
        for (sample, &target) in times.iter().enumerate() {
            while time < target {
                time = walk.step(time, target, path)?;
            }
            path.visit(Node::Sample(sample), walk.place(time));
            observer.advance(1);
            observer.go_on()?;
        }
        Ok(())
    }

    /// Steps to each of `times`, rising from 0, with this error of a velocity a step relative to the velocity scale, and shows the
    /// chain and the accelerations of its bodies there. `halfway` other steps follow the same motion: they end between the times, too.
    ///
    /// # Errors
    /// As [`Simulation::run`].
    pub(crate) fn sampled(
        &self,
        times: &[f64],
        (local_error, halfway): (f64, bool),
        observer: &dyn Observer,
        visit: &mut Visit,
    ) -> Result<()> {
        let (mut stepping, _) = self.stepping(times, local_error, false)?;
        let mut last = 0.0;
        for &t in times {
            if halfway {
                stepping.advance_to(0.5 * (last + t), observer)?;
            }
            stepping.advance_to(t, observer)?;
            let state = stepping.state();
            visit(NodeState::of(&self.chain, t, state), &|body| {
                stepping.motion(FIRST_SITE + body, t, state)[2]
            });
            observer.advance(1);
            last = t;
        }
        Ok(())
    }
}

struct Walk<'a> {
    simulation: &'a Simulation,
    stepping: Box<dyn Stepping>,
    observer: &'a dyn Observer,
    /// Energy of a contact whose opening counts.
    noticed: f64,
    smooth: Vec<(f64, f64)>,
    beside: Vec<(f64, f64)>,
    /// The last time at which a contact opened or closed.
    opened: Option<f64>,
    longest: f64,
    /// The contacts, each at its place in rows.
    contacts: Vec<Option<Contact<'a>>>,
}

impl Walk<'_> {
    fn place(&self, t: f64) -> NodeState<'_> {
        NodeState::of(&self.simulation.chain, t, self.stepping.state())
    }

    /// One step towards `target`; returns where it ends.
    fn step(&mut self, from: f64, target: f64, path: &mut dyn NodeVisitor) -> Result<f64> {
        let mark = self.stepping.mark();
        let step = self.stepping.step().min(self.longest);
        let steps = ((target - from) / step).ceil().max(1.0);
        let to = if steps == 1.0 {
            target
        } else {
            from + (target - from) / steps
        };
        let to = self.go_towards(to)?;
        let allowed = self.stepping.step();
        // What opens soon after the step is felt in it.
        let middle = self.stepping.mark();
        let beyond = self.go_towards(to + (to - from))?;
        let soon = self.openings(&middle, beyond)?;
        self.stepping.reset(&middle);
        let ends = [(from, &mark), (to, &middle)];
        let ends = ends.map(|(t, mark)| NodeState::of(&self.simulation.chain, t, &mark.state));
        let cusps = path.cusps(ends[0], ends[1]);
        let mut inside = self.openings(&mark, to)?;
        self.stepping.reset(&mark);
        inside.extend(cusps);
        if let Some(drive) = &self.simulation.drive {
            // The push, or the speed of the wall, breaks off there.
            inside.extend(drive.waveform().kinks().filter(|t| from < *t && *t < to));
        }
        inside.sort_by(f64::total_cmp);
        let opening = |t: f64, times: &[f64]| times.iter().copied().find(|other| *other > t);
        let mut start = from;
        for end in inside.iter().copied().chain([to]) {
            let left = self.opened.filter(|t| *t <= start);
            if end > start {
                let right = opening(start, &inside).or(opening(start, &soon));
                self.piece([start, end], [left, right], path)?;
                start = end;
            }
            if end < to || inside.last() == Some(&to) {
                self.opened = Some(end);
            }
        }
        self.stepping.advance_to(to, self.observer)?;
        self.stepping.set_step(allowed);
        Ok(to)
    }

    /// A step, or several where there are dampers: around a jump of theirs steps are too short to integrate over one by one.
    fn go_towards(&mut self, to: f64) -> Result<f64> {
        if self.simulation.chain.losses.any() {
            self.stepping.advance_to(to, self.observer)?;
            return Ok(to);
        }
        self.stepping.step_towards(to, self.observer)
    }

    /// Visits the nodes of a piece, with the openings before and after it.
    fn piece(
        &mut self,
        [from, to]: [f64; 2],
        openings: [Option<f64>; 2],
        path: &mut dyn NodeVisitor,
    ) -> Result<()> {
        let length = to - from;
        let [left, right] = openings;
        let left = left.filter(|t| from - t < FELT * length);
        let right = right.filter(|t| t - to < FELT * length);
        let nodes: Vec<(f64, f64)> = match (left, right) {
            (Some(_), Some(_)) => {
                let middle = from + 0.5 * length;
                self.piece([from, middle], [left, None], path)?;
                return self.piece([middle, to], [None, right], path);
            }
            (None, None) => {
                let on = |&(s, w): &(f64, f64)| (from + length * s, length * w);
                self.smooth.iter().map(on).collect()
            }
            (Some(opening), None) => self.graded(opening, from, to),
            (None, Some(opening)) => {
                let mut nodes = self.graded(opening, to, from);
                nodes.reverse();
                nodes
            }
        };
        for (t, weight) in nodes {
            self.stepping.advance_to(t, self.observer)?;
            path.visit(Node::Node(weight), self.place(t));
        }
        Ok(())
    }

    /// Nodes between `near` and `far` of an opening, even in `s` with `t = opening +- s^4`.
    fn graded(&self, opening: f64, near: f64, far: f64) -> Vec<(f64, f64)> {
        let sign = (far - near).signum();
        let root = |t: f64| (sign * (t - opening)).max(0.0).sqrt().sqrt();
        let (first, last) = (root(near), root(far));
        let on = |&(node, w): &(f64, f64)| {
            let s = first + (last - first) * node;
            let cube = s * s * s;
            (opening + sign * cube * s, 4.0 * cube * (last - first) * w)
        };
        self.beside.iter().map(on).collect()
    }

    /// The times inside a step at which contacts open or close, to the last digits.
    fn openings(&mut self, mark: &Mark, to: f64) -> Result<Vec<f64>> {
        let noticed = |s: usize, overlap| {
            let energy = |of: Contact| of.law.energy(of.coefficient, 0.0, overlap);
            self.contacts[s].map_or(0.0, energy) >= self.noticed
        };
        let ends = [(mark.time, &mark.state), (to, self.stepping.state())];
        let found = self.stepping.openings(ends, &noticed);
        self.refine(mark, to, found)
    }

    /// One step of Newton's method from each time, on the motion itself.
    fn refine(&mut self, mark: &Mark, to: f64, found: Vec<(f64, usize)>) -> Result<Vec<f64>> {
        if found.is_empty() {
            return Ok(Vec::new());
        }
        self.stepping.reset(mark);
        let mut times = Vec::with_capacity(found.len());
        for (t, s) in found {
            self.stepping.advance_to(t, self.observer)?;
            let d0 = self.contacts[s].map_or(0.0, |contact| contact.static_overlap);
            let state = self.stepping.state();
            let closing = state.v[s - 1] - state.v[s];
            let off = (d0 + state.x[s - 1] - state.x[s]) / closing;
            // Where the contact only grazes, the interpolant knows better.
            let small = off.abs() < 1e-3 * (to - mark.time);
            let refined = if small { t - off } else { t };
            times.push(refined.clamp(mark.time, to));
        }
        times.sort_by(f64::total_cmp);
        Ok(times)
    }
}
