//! Rates of a chain's state, and of its derivatives with respect to up to eight parameters.

use std::ops::Range;
use std::sync::Arc;

use super::direction::{Direction, all_contacts};
use crate::chain::drive::{Drive, Waveform};
use crate::chain::lattice::{Chain, Ends};
use crate::chain::law::ContactLaw;
use crate::chain::simulation::Simulation;
use crate::numeric::lanes::{LaneBlock, Lanes, SimdKernel, widest};

/// Displacement and velocity of each place, and their derivatives, a parameter a lane. Resonators are behind the bodies.
#[derive(Debug, Clone, Default)]
pub(super) struct Motion {
    pub(super) base: Vec<[f64; 2]>,
    pub(super) each: Vec<[LaneBlock; 2]>,
}

impl Motion {
    pub(super) fn zeros(places: usize) -> Motion {
        Motion {
            base: vec![[0.0; 2]; places],
            each: vec![[LaneBlock::default(); 2]; places],
        }
    }

    pub(super) fn places(&self) -> usize {
        self.base.len()
    }

    /// `self = start + sum of weight times rates` at some places, without a start from 0.
    pub(super) fn sum(
        &mut self,
        rows: &[Range<usize>],
        start: Option<&Motion>,
        terms: &[(f64, &Motion)],
    ) {
        self.base.resize(terms[0].1.places(), [0.0; 2]);
        self.each
            .resize(terms[0].1.places(), [LaneBlock::default(); 2]);
        widest(Sum {
            to: self,
            rows,
            start,
            terms,
        });
    }

    #[inline(always)]
    fn push<L: Lanes>(&mut self, s: usize, force: f64, each: L) {
        self.base[s][1] += force;
        (L::load(&self.each[s][1]) + each).store(&mut self.each[s][1]);
    }
}

struct Sum<'a> {
    to: &'a mut Motion,
    rows: &'a [Range<usize>],
    start: Option<&'a Motion>,
    terms: &'a [(f64, &'a Motion)],
}

impl SimdKernel for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for place in self.rows.iter().cloned().flatten() {
            let mut base = self.start.map_or([0.0; 2], |start| start.base[place]);
            let mut each = match self.start {
                Some(start) => [0, 1].map(|i| L::load(&start.each[place][i])),
                None => [L::splat(0.0); 2],
            };
            for (weight, rates) in self.terms {
                for i in [0, 1] {
                    base[i] += weight * rates.base[place][i];
                    each[i] = each[i] + L::splat(*weight) * L::load(&rates.each[place][i]);
                }
            }
            self.to.base[place] = base;
            for (each, to) in each.into_iter().zip(&mut self.to.each[place]) {
                each.store(to);
            }
        }
    }
}

/// What moves in a step other than in free flight.
#[derive(Debug, Clone, Default)]
pub(super) struct Active {
    pub(super) links: Vec<usize>,
    pub(super) bodies: Vec<Range<usize>>,
}

impl Active {
    /// The places of bodies, and of resonators.
    pub(super) fn places(&self, sites: usize, places: usize) -> Vec<Range<usize>> {
        let own = (places > sites).then_some(sites..places);
        self.bodies.iter().cloned().chain(own).collect()
    }
}

/// A parameter, the laws at both ends of its difference, and the length of that.
type ChangedLaw = (usize, [Arc<dyn ContactLaw>; 2], f64);

/// A contact with the places that it joins; `None` for a wall.
pub(super) struct Link<'a> {
    law: Arc<dyn ContactLaw>,
    contact: crate::chain::lattice::Contact<'a>,
    pub(super) left: Option<usize>,
    pub(super) right: Option<usize>,
    coefficient: LaneBlock,
    static_overlap: LaneBlock,
    /// Laws at both ends of the difference, for the parameters that change them.
    laws: Vec<ChangedLaw>,
}

impl Link<'_> {
    pub(super) fn overlap(&self, r: f64) -> f64 {
        self.contact.static_overlap + r
    }

    pub(super) fn opens(&self) -> bool {
        self.contact.law.is_one_sided() && self.contact.coefficient > 0.0
    }
}

/// The equations of motion and their linearization.
pub(super) struct Rates<'a> {
    chain: &'a Chain,
    drive: Option<&'a Drive>,
    directions: &'a [Direction],
    pub(super) links: Vec<Link<'a>>,
    mass: Vec<LaneBlock>,
    ground: Vec<LaneBlock>,
    resonators: [Vec<LaneBlock>; 3],
    losses: [LaneBlock; 3],
    drives: bool,
}

/// The same entry of each direction.
fn gather(directions: &[Direction], of: impl Fn(&Direction) -> f64) -> LaneBlock {
    let mut each = LaneBlock::default();
    for (value, direction) in each.0.iter_mut().zip(directions) {
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
        let row = |of: fn(&Direction) -> &Vec<f64>, count: usize| -> Vec<LaneBlock> {
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

    /// Value, rate and acceleration at time t of what the drive does, and their derivatives.
    fn driven(&self, t: f64) -> ([f64; 3], [LaneBlock; 3]) {
        let mut each = [LaneBlock::default(); 3];
        let Some(drive) = self.drive else {
            return ([0.0; 3], each);
        };
        let of = |wave: &Waveform| [wave.at(t), wave.rate_at(t), wave.acceleration_at(t)];
        if self.drives {
            for (p, d) in self.directions.iter().enumerate() {
                if let Some(waves) = &d.drive {
                    let [a, b] = waves.each_ref().map(of);
                    (0..3).for_each(|i| each[i].0[p] = (b[i] - a[i]) / d.length);
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

    /// Whether the wall before the first body is moved.
    fn moves_wall(&self) -> bool {
        matches!(self.drive, Some(Drive::Wall(_)))
    }

    /// The excess overlap of a link and its rate.
    #[inline(always)]
    pub(super) fn across(&self, link: &Link, t: f64, at: &Motion) -> [f64; 2] {
        let left = match link.left {
            Some(s) => at.base[s],
            None if self.moves_wall() => {
                let ([x, v, _], _) = self.driven(t);
                [x, v]
            }
            None => [0.0; 2],
        };
        let right = link.right.map_or([0.0; 2], |s| at.base[s]);
        [left[0] - right[0], left[1] - right[1]]
    }

    /// Their derivatives.
    #[inline(always)]
    pub(super) fn across_each<L: Lanes>(&self, link: &Link, t: f64, at: &Motion) -> [L; 2] {
        let [left, right] = self.beside_each(link, t, at);
        [
            L::load(&left[0]) - L::load(&right[0]),
            L::load(&left[1]) - L::load(&right[1]),
        ]
    }

    /// Derivatives of the overlap of a link.
    pub(super) fn overlap_each(&self, link: &Link, t: f64, at: &Motion) -> LaneBlock {
        let [[left, _], [right, _]] = self.beside_each(link, t, at);
        let mut each = link.static_overlap;
        for ((each, left), right) in each.0.iter_mut().zip(left.0).zip(right.0) {
            *each += left - right;
        }
        each
    }

    /// Derivatives of displacement and velocity on both sides of a link.
    #[inline(always)]
    fn beside_each(&self, link: &Link, t: f64, at: &Motion) -> [[LaneBlock; 2]; 2] {
        let still = [LaneBlock::default(); 2];
        let left = match link.left {
            Some(s) => at.each[s],
            None if self.moves_wall() => {
                let (_, [x, v, _]) = self.driven(t);
                [x, v]
            }
            None => still,
        };
        [left, link.right.map_or(still, |s| at.each[s])]
    }

    /// Second derivative of the overlap of a link in time.
    pub(super) fn bend(&self, link: &Link, t: f64, rates: &Motion) -> f64 {
        let left = match link.left {
            Some(s) => rates.base[s][1],
            None if self.moves_wall() => self.driven(t).0[2],
            None => 0.0,
        };
        left - link.right.map_or(0.0, |s| rates.base[s][1])
    }

    /// Sets a body whose motion is prescribed.
    pub(super) fn place(&self, t: f64, at: &mut Motion) {
        if let Some((site, _)) = self.drive.and_then(Drive::motion) {
            let ([x, v, _], [dx, dv, _]) = self.driven(t);
            (at.base[site], at.each[site]) = ([x, v], [dx, dv]);
        }
    }

    /// What moves other than in free flight, of the first `moved` bodies, in a step of this length between two states.
    pub(super) fn active(&self, [from, to]: [f64; 2], ends: [&Motion; 2], moved: usize) -> Active {
        let everywhere = self.chain.has_pulls() || self.drive.is_some();
        let (mut links, mut bodies) = (Vec::new(), Vec::<Range<usize>>::new());
        for (i, link) in self.links.iter().enumerate() {
            let nearest = link.left.unwrap_or(0).min(link.right.unwrap_or(usize::MAX));
            let acts = everywhere || !link.opens() || link.contact.static_overlap > 0.0;
            if nearest >= moved || !(acts || self.presses(link, [from, to], ends)) {
                continue;
            }
            links.push(i);
            for s in [link.left, link.right].into_iter().flatten() {
                match bodies.last_mut() {
                    Some(last) if (last.start..=last.end).contains(&s) => {
                        last.end = last.end.max(s + 1);
                    }
                    _ => bodies.push(s..s + 1),
                }
            }
        }
        if everywhere {
            bodies = std::iter::once(0..moved).collect();
        }
        // The last link of a ring leads to the first body.
        bodies.sort_by_key(|bodies| bodies.start);
        bodies.dedup_by(|next, last| {
            let joined = next.start <= last.end;
            if joined {
                last.end = last.end.max(next.end);
            }
            joined
        });
        Active { links, bodies }
    }

    /// Whether a link may press within a step.
    fn presses(&self, link: &Link, times: [f64; 2], ends: [&Motion; 2]) -> bool {
        let node = |i: usize| {
            let [r, closing] = self.across(link, times[i], ends[i]);
            [link.overlap(r), closing]
        };
        let ([a, closing], [b, parting]) = (node(0), node(1));
        let half = 0.5 * (times[1] - times[0]);
        let meets = closing > 0.0 && parting < 0.0;
        a > 0.0 || b > 0.0 || meets && (a + half * closing).max(b - half * parting) > 0.0
    }

    /// Rates of change at time t of what is active.
    pub(super) fn evaluate(&self, t: f64, at: &Motion, active: &Active, out: &mut Motion) {
        widest(Evaluate {
            rates: self,
            t,
            at,
            active,
            out,
        });
    }

    #[inline(always)]
    fn evaluate_here<L: Lanes>(&self, t: f64, at: &Motion, active: &Active, out: &mut Motion) {
        let (chain, n) = (self.chain, self.chain.n_sites());
        for places in active.places(n, at.places()) {
            out.base[places.clone()].fill([0.0; 2]);
            out.each[places].fill([LaneBlock::default(); 2]);
        }
        for i in &active.links {
            self.press::<L>(&self.links[*i], t, at, out);
        }
        let (push, pushes) = self.driven(t);
        let drag = chain.losses.drag;
        for j in active.bodies.iter().cloned().flatten() {
            let [x, v] = at.base[j];
            let [dx, dv]: [L; 2] = [L::load(&at.each[j][0]), L::load(&at.each[j][1])];
            let mut force = out.base[j][1] - drag * v;
            let mut forces = L::load(&out.each[j][1])
                - L::splat(drag) * dv
                - L::splat(v) * L::load(&self.losses[2]);
            if let Some(ground) = &chain.on_site.ground {
                let (law, c) = (ground.law.of(j), ground.coefficient[j]);
                force -= law.force(c, 0.0, x);
                let (stiffness, one) = (law.stiffness(c, 0.0, x), law.force(1.0, 0.0, x));
                let mut changed = LaneBlock::default();
                for (value, d) in changed.0.iter_mut().zip(self.directions) {
                    if let Some(laws) = &d.ground_laws {
                        let [a, b] = laws.each_ref().map(|laws| laws.of(j).force(c, 0.0, x));
                        *value = (b - a) / d.length;
                    }
                }
                forces = forces
                    - L::splat(stiffness) * dx
                    - L::splat(one) * L::load(&self.ground[j])
                    - L::load(&changed);
            }
            if let Some(drive @ (Drive::Force(_) | Drive::Body(..))) = self.drive
                && drive.site() == j
            {
                force += push[0];
                forces = forces + L::load(&pushes[0]);
            }
            if let Some(all) = chain.resonators().filter(|all| all.mass[j] > 0.0) {
                let ([y, w], own) = (at.base[n + j], &at.each[n + j]);
                let (ahead, faster, m) = (y - x, w - v, all.mass[j]);
                let pull = all.force(j, ahead, faster);
                let of = |i: usize| L::load(&self.resonators[i][j]);
                let pulls = L::splat(all.stiffness[j]) * (L::load(&own[0]) - dx)
                    + L::splat(all.damping[j]) * (L::load(&own[1]) - dv)
                    + L::splat(ahead) * of(1)
                    + L::splat(faster) * of(2);
                force += pull;
                forces = forces + pulls;
                out.base[n + j] = [w, -pull / m];
                out.each[n + j][0] = own[1];
                let slowed = (L::splat(pull / m) * of(0) - pulls) / L::splat(m);
                slowed.store(&mut out.each[n + j][1]);
            }
            let m = chain.mass[j];
            out.base[j] = [v, force / m];
            out.each[j][0] = at.each[j][1];
            let faster = (forces - L::splat(force / m) * L::load(&self.mass[j])) / L::splat(m);
            faster.store(&mut out.each[j][1]);
        }
        if let Some((site, _)) = self.drive.and_then(Drive::motion) {
            out.base[site] = [push[1], push[2]];
            out.each[site] = [pushes[1], pushes[2]];
        }
    }

    /// Adds the force of a link to the places beside it.
    #[inline(always)]
    fn press<L: Lanes>(&self, link: &Link, t: f64, at: &Motion, out: &mut Motion) {
        let losses = &self.chain.losses;
        let [r, closing] = self.across(link, t, at);
        let contact = &link.contact;
        let overlap = link.overlap(r);
        let is_open = link.opens() && overlap <= 0.0;
        if is_open && contact.static_overlap == 0.0 {
            return;
        }
        let [dr, dclosing]: [L; 2] = self.across_each(link, t, at);
        let (c, d0) = (contact.coefficient, contact.static_overlap);
        let (one, stiffness) = (link.law.excess_force(d0, r), link.law.stiffness(overlap));
        let bend = match losses.tangent > 0.0 {
            true => losses.tangent * c * link.law.bend(overlap) * closing,
            false => 0.0,
        };
        let (dashpot, felt) = match is_open {
            true => (0.0, 0.0),
            false => (losses.dashpot, closing),
        };
        let damper = dashpot + losses.tangent * c * stiffness;
        let force = c * one + damper * closing;
        let rest = match d0 > 0.0 {
            true => link.law.stiffness(d0),
            false => 0.0,
        };
        let mut forces = L::splat(c * stiffness + bend) * dr
            + L::splat(damper) * dclosing
            + L::splat(one + losses.tangent * stiffness * closing) * L::load(&link.coefficient);
        if d0 > 0.0 {
            let of_overlap = c * (stiffness - rest) + bend;
            forces = forces + L::splat(of_overlap) * L::load(&link.static_overlap);
        }
        if losses.any() {
            forces = forces
                + L::splat(felt) * L::load(&self.losses[0])
                + L::splat(c * stiffness * closing) * L::load(&self.losses[1]);
        }
        if !link.laws.is_empty() {
            let mut changed = LaneBlock::default();
            for (p, [a, b], length) in &link.laws {
                let of = |law: &Arc<dyn ContactLaw>| {
                    let damping = losses.tangent * law.stiffness(overlap) * closing;
                    c * (law.excess_force(d0, r) + damping)
                };
                changed.0[*p] = (of(b) - of(a)) / length;
            }
            forces = forces + L::load(&changed);
        }
        if let Some(s) = link.left {
            out.push(s, -force, L::splat(0.0) - forces);
        }
        if let Some(s) = link.right {
            out.push(s, force, forces);
        }
    }
}

struct Evaluate<'a> {
    rates: &'a Rates<'a>,
    t: f64,
    at: &'a Motion,
    active: &'a Active,
    out: &'a mut Motion,
}

impl SimdKernel for Evaluate<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Evaluate {
            rates,
            t,
            at,
            active,
            out,
        } = self;
        rates.evaluate_here::<L>(t, at, active, out);
    }
}
