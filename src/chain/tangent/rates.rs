//! Rates of a chain's state, and of its derivatives with respect to up to eight parameters.

use std::sync::Arc;

use super::direction::{Direction, all_contacts};
use crate::chain::drive::Drive;
use crate::chain::lattice::{Chain, Ends};
use crate::chain::law::ContactLaw;
use crate::chain::simulation::Simulation;
use crate::numeric::lanes::WIDTH;

/// A value for each parameter.
pub(super) type Each = [f64; WIDTH];

pub(super) const NONE: Each = [0.0; WIDTH];

/// Numbers of a place in [`Motion`].
const ROW: usize = 2 + 2 * WIDTH;

/// Displacement and velocity of each place, and their derivatives. Resonators are behind the bodies.
#[derive(Debug, Clone, Default)]
pub(super) struct Motion(pub(super) Vec<f64>);

impl Motion {
    pub(super) fn zeros(places: usize) -> Motion {
        Motion(vec![0.0; ROW * places])
    }

    pub(super) fn places(&self) -> usize {
        self.0.len() / ROW
    }

    /// Displacement and velocity.
    #[inline(always)]
    pub(super) fn base(&self, s: usize) -> [f64; 2] {
        [self.0[ROW * s], self.0[ROW * s + 1]]
    }

    pub(super) fn set_base(&mut self, s: usize, base: [f64; 2]) {
        self.0[ROW * s..][..2].copy_from_slice(&base);
    }

    /// Their derivatives.
    #[inline(always)]
    pub(super) fn each(&self, s: usize) -> [Each; 2] {
        [0, 1].map(|i| {
            let mut each = NONE;
            each.copy_from_slice(&self.0[ROW * s + 2 + WIDTH * i..][..WIDTH]);
            each
        })
    }

    pub(super) fn set_each(&mut self, s: usize, [x, v]: [Each; 2]) {
        let row = &mut self.0[ROW * s..][..ROW];
        row[2..2 + WIDTH].copy_from_slice(&x);
        row[2 + WIDTH..].copy_from_slice(&v);
    }

    fn add(&mut self, s: usize, rate: f64, each: &Each) {
        let row = &mut self.0[ROW * s..][..ROW];
        row[1] += rate;
        for (sum, value) in row[2 + WIDTH..].iter_mut().zip(each) {
            *sum += value;
        }
    }
}

/// A contact with the places that it joins; `None` for a wall.
pub(super) struct Link<'a> {
    law: Arc<dyn ContactLaw>,
    contact: crate::chain::lattice::Contact<'a>,
    pub(super) left: Option<usize>,
    pub(super) right: Option<usize>,
    coefficient: Each,
    static_overlap: Each,
    /// Laws at both ends of the difference, for the parameters that change them.
    laws: Vec<(usize, [Arc<dyn ContactLaw>; 2], f64)>,
}

impl Link<'_> {
    pub(super) fn overlap(&self, r: f64) -> f64 {
        self.contact.static_overlap + r
    }

    pub(super) fn opens(&self) -> bool {
        self.contact.law.is_one_sided() && self.contact.coefficient > 0.0
    }

    /// Derivative of the static overlap.
    pub(super) fn shift(&self) -> &Each {
        &self.static_overlap
    }
}

/// The equations of motion and their linearization.
pub(super) struct Rates<'a> {
    chain: &'a Chain,
    drive: Option<&'a Drive>,
    directions: &'a [Direction],
    pub(super) links: Vec<Link<'a>>,
    mass: Vec<Each>,
    ground: Vec<Each>,
    resonators: [Vec<Each>; 3],
    losses: [Each; 3],
    drives: bool,
}

/// The same entry of each direction.
fn gather(directions: &[Direction], of: impl Fn(&Direction) -> f64) -> Each {
    let mut each = NONE;
    for (value, direction) in each.iter_mut().zip(directions) {
        *value = of(direction);
    }
    each
}

impl<'a> Rates<'a> {
    /// For up to eight directions.
    pub(super) fn new(simulation: &'a Simulation, directions: &'a [Direction]) -> Rates<'a> {
        let chain = &simulation.chain;
        let n = chain.n_sites();
        let offset = usize::from(chain.left_contact().is_some());
        let row = |of: fn(&Direction) -> &Vec<f64>, count: usize| -> Vec<Each> {
            let at = |j: usize| gather(directions, |d| of(d).get(j).copied().unwrap_or(0.0));
            (0..count).map(at).collect()
        };
        let links = all_contacts(chain).enumerate().map(|(i, contact)| {
            let right = i + 1 - offset;
            let index = i.checked_sub(offset);
            let changed = directions.iter().enumerate().filter_map(|(p, d)| {
                let laws = d.laws.as_ref()?.each_ref().map(|laws| match index {
                    Some(j) => laws.of(j).shared(),
                    None => laws.before_first().shared(),
                });
                Some((p, laws, d.length))
            });
            Link {
                law: contact.law.shared(),
                contact,
                left: index,
                right: match chain.ends {
                    _ if right < n => Some(right),
                    Ends::Periodic => Some(0),
                    _ => None,
                },
                coefficient: gather(directions, |d| d.coefficient[i]),
                static_overlap: gather(directions, |d| d.static_overlap[i]),
                laws: changed.collect(),
            }
        });
        Rates {
            chain,
            drive: simulation.drive.as_ref(),
            directions,
            links: links.collect(),
            mass: row(|d| &d.mass, n),
            ground: row(|d| &d.ground, n),
            resonators: [
                row(|d| &d.resonators[0], n),
                row(|d| &d.resonators[1], n),
                row(|d| &d.resonators[2], n),
            ],
            losses: [
                gather(directions, |d| d.dashpot),
                gather(directions, |d| d.tangent),
                gather(directions, |d| d.drag),
            ],
            drives: directions.iter().any(|d| d.drive.is_some()),
        }
    }

    /// Value and rate at time t of what the drive does, and their derivatives.
    fn driven(&self, t: f64) -> ([f64; 3], [Each; 3]) {
        let Some(drive) = self.drive else {
            return ([0.0; 3], [NONE; 3]);
        };
        let of =
            |wave: &crate::chain::Waveform| [wave.at(t), wave.rate_at(t), wave.acceleration_at(t)];
        let mut each = [NONE; 3];
        if self.drives {
            for (p, d) in self.directions.iter().enumerate() {
                if let Some(waves) = &d.drive {
                    let [a, b] = waves.each_ref().map(of);
                    (0..3).for_each(|i| each[i][p] = (b[i] - a[i]) / d.length);
                }
            }
        }
        (of(drive.waveform()), each)
    }

    /// Whether stiffnesses go with multiples of 1/2 of the overlap where contacts open.
    pub(super) fn opens_with_roots(&self) -> bool {
        let mut powers = self.links.iter().filter_map(|link| link.law.opens());
        powers.all(|power| (2.0 * power).fract() == 0.0)
    }

    /// The excess overlap of a link and its rate, and their derivatives.
    pub(super) fn across(&self, link: &Link, t: f64, at: &Motion) -> ([f64; 2], [Each; 2]) {
        let side = |place: Option<usize>, is_left: bool| match (place, self.drive) {
            (Some(s), _) => (at.base(s), at.each(s)),
            (None, Some(Drive::Wall(_))) if is_left => {
                let ([x, v, _], [dx, dv, _]) = self.driven(t);
                ([x, v], [dx, dv])
            }
            _ => ([0.0; 2], [NONE; 2]),
        };
        let (left, right) = (side(link.left, true), side(link.right, false));
        let apart = |i: usize| left.0[i] - right.0[i];
        let each = |i: usize| std::array::from_fn(|p| left.1[i][p] - right.1[i][p]);
        ([apart(0), apart(1)], [each(0), each(1)])
    }

    /// Sets a body whose motion is prescribed.
    pub(super) fn place(&self, t: f64, at: &mut Motion) {
        if let Some((site, _)) = self.drive.and_then(Drive::motion) {
            let ([x, v, _], [dx, dv, _]) = self.driven(t);
            at.set_base(site, [x, v]);
            at.set_each(site, [dx, dv]);
        }
    }

    /// Rates of change at time t of all that moves within the first `moved` bodies.
    pub(super) fn evaluate(&self, t: f64, at: &Motion, moved: usize, out: &mut Motion) {
        let (chain, n) = (self.chain, self.chain.n_sites());
        let losses = &chain.losses;
        out.0.fill(0.0);
        for link in &self.links {
            let nearest = link.left.unwrap_or(0).min(link.right.unwrap_or(usize::MAX));
            if nearest < moved {
                self.press(link, t, at, out);
            }
        }
        let (push, pushes) = self.driven(t);
        for j in 0..moved {
            let ([x, v], [dx, dv]) = (at.base(j), at.each(j));
            let mut force = -losses.drag * v;
            let mut each: Each =
                std::array::from_fn(|p| -losses.drag * dv[p] - self.losses[2][p] * v);
            if let Some(ground) = &chain.on_site.ground {
                let (law, c) = (ground.law.of(j), ground.coefficient[j]);
                force -= law.force(c, 0.0, x);
                let stiffness = law.stiffness(c, 0.0, x);
                let one = law.force(1.0, 0.0, x);
                for (p, sum) in each.iter_mut().enumerate() {
                    *sum -= stiffness * dx[p] + one * self.ground[j][p];
                    if let Some(Some(laws)) = self.directions.get(p).map(|d| &d.ground_laws) {
                        let [a, b] = laws.each_ref().map(|laws| laws.of(j).force(c, 0.0, x));
                        *sum -= (b - a) / self.directions[p].length;
                    }
                }
            }
            if let Some(drive @ (Drive::Force(_) | Drive::Body(..))) = self.drive
                && drive.site() == j
            {
                force += push[0];
                (0..WIDTH).for_each(|p| each[p] += pushes[0][p]);
            }
            if let Some(all) = chain.resonators().filter(|all| all.mass[j] > 0.0) {
                let ([y, w], [dy, dw]) = (at.base(n + j), at.each(n + j));
                let (ahead, faster) = (y - x, w - v);
                let pull = all.force(j, ahead, faster);
                let pulls: Each = std::array::from_fn(|p| {
                    all.force(j, dy[p] - dx[p], dw[p] - dv[p])
                        + self.resonators[1][j][p] * ahead
                        + self.resonators[2][j][p] * faster
                });
                force += pull;
                (0..WIDTH).for_each(|p| each[p] += pulls[p]);
                let m = all.mass[j];
                let own: Each =
                    std::array::from_fn(|p| -(pulls[p] - pull / m * self.resonators[0][j][p]) / m);
                out.add(n + j, -pull / m, &own);
            }
            out.add(j, force, &each);
            self.accelerate(j, out);
            for s in [j, n + j] {
                if s < at.places() {
                    let ([_, v], [_, dv]) = (at.base(s), at.each(s));
                    let ([_, a], [_, da]) = (out.base(s), out.each(s));
                    out.set_base(s, [v, a]);
                    out.set_each(s, [dv, da]);
                }
            }
        }
        if let Some((site, _)) = self.drive.and_then(Drive::motion) {
            out.set_base(site, [push[1], push[2]]);
            out.set_each(site, [pushes[1], pushes[2]]);
        }
    }

    /// From forces to accelerations.
    fn accelerate(&self, j: usize, out: &mut Motion) {
        let m = self.chain.mass[j];
        let ([_, force], [_, forces]) = (out.base(j), out.each(j));
        let a = force / m;
        out.set_base(j, [0.0, a]);
        let each = std::array::from_fn(|p| (forces[p] - a * self.mass[j][p]) / m);
        out.set_each(j, [NONE, each]);
    }

    /// Adds the force of a link to the places beside it.
    fn press(&self, link: &Link, t: f64, at: &Motion, out: &mut Motion) {
        let losses = &self.chain.losses;
        let ([r, closing], [dr, dclosing]) = self.across(link, t, at);
        let contact = &link.contact;
        let overlap = link.overlap(r);
        let is_open = link.opens() && overlap <= 0.0;
        if is_open && contact.static_overlap == 0.0 {
            return;
        }
        let (c, d0) = (contact.coefficient, contact.static_overlap);
        if c == 0.0 && link.coefficient == NONE {
            return;
        }
        let (one, stiffness) = (link.law.excess_force(d0, r), link.law.stiffness(overlap));
        let rest = link.law.stiffness(d0);
        let bend = match losses.tangent > 0.0 {
            true => c * link.law.bend(overlap),
            false => 0.0,
        };
        let dashpot = if is_open { 0.0 } else { losses.dashpot };
        let damper = dashpot + losses.tangent * c * stiffness;
        let force = c * one + damper * closing;
        let along = c * stiffness + losses.tangent * bend * closing;
        let of_coefficient = one + losses.tangent * stiffness * closing;
        let of_overlap = c * (stiffness - rest) + losses.tangent * bend * closing;
        let of_dashpot = if is_open { 0.0 } else { closing };
        let of_tangent = c * stiffness * closing;
        let mut each: Each = std::array::from_fn(|p| {
            along * dr[p]
                + damper * dclosing[p]
                + of_coefficient * link.coefficient[p]
                + of_overlap * link.static_overlap[p]
                + of_dashpot * self.losses[0][p]
                + of_tangent * self.losses[1][p]
        });
        for (p, [a, b], length) in &link.laws {
            let of = |law: &Arc<dyn ContactLaw>| {
                c * (law.excess_force(d0, r) + losses.tangent * law.stiffness(overlap) * closing)
            };
            each[*p] += (of(b) - of(a)) / length;
        }
        if let Some(s) = link.left {
            out.add(s, -force, &each.map(|f| -f));
        }
        if let Some(s) = link.right {
            out.add(s, force, &each);
        }
    }
}
