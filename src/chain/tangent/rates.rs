//! Rates of a chain's state, and of its derivatives with respect to up to eight parameters.

use std::ops::{Add, Mul, Range, Sub};

use super::direction::{Direction, data};
use crate::chain::drive::{Drive, Waveform};
use crate::chain::lattice::Chain;
use crate::chain::law::Law;
use crate::chain::simulation::Simulation;
use crate::numeric::lanes::{LaneBlock, Lanes, SimdKernel, widest};

/// A value with its derivatives, a parameter a lane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dual<L> {
    pub(super) value: f64,
    pub(super) each: L,
}

impl<L: Lanes> Dual<L> {
    #[inline(always)]
    fn constant(value: f64) -> Dual<L> {
        let each = L::splat(0.0);
        Dual { value, each }
    }

    /// With derivatives by what else changes.
    #[inline(always)]
    fn changed(self, more: LaneBlock) -> Dual<L> {
        let (value, each) = (self.value, self.each + L::load(&more));
        Dual { value, each }
    }
}

impl<L: Lanes> Add for Dual<L> {
    type Output = Dual<L>;

    #[inline(always)]
    fn add(self, b: Dual<L>) -> Dual<L> {
        let (value, each) = (self.value + b.value, self.each + b.each);
        Dual { value, each }
    }
}

impl<L: Lanes> Sub for Dual<L> {
    type Output = Dual<L>;

    #[inline(always)]
    fn sub(self, b: Dual<L>) -> Dual<L> {
        let (value, each) = (self.value - b.value, self.each - b.each);
        Dual { value, each }
    }
}

impl<L: Lanes> Mul for Dual<L> {
    type Output = Dual<L>;

    #[inline(always)]
    fn mul(self, b: Dual<L>) -> Dual<L> {
        let value = self.value * b.value;
        let each = self.each * L::splat(b.value) + L::splat(self.value) * b.each;
        Dual { value, each }
    }
}

/// A datum of a chain with its derivatives.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Parameter {
    pub(super) value: f64,
    each: LaneBlock,
}

impl Parameter {
    #[inline(always)]
    fn here<L: Lanes>(&self) -> Dual<L> {
        let (value, each) = (self.value, L::load(&self.each));
        Dual { value, each }
    }
}

/// The derivatives of a number by up to eight directions, from what it is at both ends of each.
fn slopes(directions: &[Direction], of: impl Fn(&Simulation) -> f64) -> LaneBlock {
    let mut each = LaneBlock::default();
    for (slope, Direction { ends, length, .. }) in each.0.iter_mut().zip(directions) {
        let [below, above] = ends.each_ref().map(&of);
        *slope = (above - below) / length;
    }
    each
}

/// The [`data`] of a simulation with their derivatives.
fn parameters(simulation: &Simulation, directions: &[Direction]) -> [Vec<Parameter>; 12] {
    let each = LaneBlock::default();
    let constants = |row: Vec<f64>| row.into_iter().map(|value| Parameter { value, each });
    let mut rows = data(simulation).map(|row| constants(row).collect::<Vec<_>>());
    for (lane, Direction { ends, length, .. }) in directions.iter().enumerate() {
        let [below, above] = ends.each_ref().map(data);
        for ((row, below), above) in rows.iter_mut().zip(below).zip(above) {
            for ((datum, below), above) in row.iter_mut().zip(below).zip(above) {
                datum.each.0[lane] = (above - below) / length;
            }
        }
    }
    rows
}

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

    /// Displacement and velocity of a place.
    #[inline(always)]
    fn read<L: Lanes>(&self, s: usize) -> [Dual<L>; 2] {
        [0, 1].map(|i| Dual {
            value: self.base[s][i],
            each: L::load(&self.each[s][i]),
        })
    }

    #[inline(always)]
    fn write<L: Lanes>(&mut self, s: usize, values: [Dual<L>; 2]) {
        for (i, Dual { value, each }) in values.into_iter().enumerate() {
            self.base[s][i] = value;
            each.store(&mut self.each[s][i]);
        }
    }

    #[inline(always)]
    fn push<L: Lanes>(&mut self, s: usize, force: Dual<L>) {
        let [x, v] = self.read(s);
        self.write(s, [x, v + force]);
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
            let mut sum = match self.start {
                Some(start) => start.read::<L>(place),
                None => [Dual::constant(0.0); 2],
            };
            for (weight, rates) in self.terms {
                for (sum, rate) in sum.iter_mut().zip(rates.read::<L>(place)) {
                    sum.value += weight * rate.value;
                    sum.each = sum.each + L::splat(*weight) * rate.each;
                }
            }
            self.to.write(place, sum);
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

/// A contact with the places that it joins; `None` for a wall.
pub(super) struct Link<'a> {
    law: &'a Law,
    pub(super) opens: bool,
    /// The one on the left is also the number of the contact.
    pub(super) sites: [Option<usize>; 2],
    coefficient: Parameter,
    pub(super) static_overlap: Parameter,
}

/// The law of a contact, that before site 0 without index.
fn law_at(chain: &Chain, index: Option<usize>) -> &Law {
    index.map_or(chain.law.before_first(), |j| chain.law.of(j))
}

/// The equations of motion and their linearization.
pub(super) struct Rates<'a> {
    chain: &'a Chain,
    drive: Option<&'a Drive>,
    directions: &'a [Direction],
    pub(super) links: Vec<Link<'a>>,
    /// Inverse masses.
    mobility: Vec<Parameter>,
    ground: Vec<Parameter>,
    /// Inverse mass, stiffness and damping.
    resonators: [Vec<Parameter>; 3],
    /// Dashpot, tangent damping and drag.
    losses: [Parameter; 3],
    /// Whether laws of contacts, those to the ground, and the drive change with a parameter.
    changes: [bool; 3],
}

impl<'a> Rates<'a> {
    /// For up to eight directions, with the start.
    pub(super) fn new(simulation: &'a Simulation, directions: &'a [Direction]) -> (Self, Motion) {
        let chain = &simulation.chain;
        let [
            mobility,
            coefficient,
            static_overlap,
            dashpot,
            tangent,
            drag,
            v,
            x,
            ground,
            resonator_mobility,
            stiffness,
            damping,
        ] = parameters(simulation, directions);
        let links = chain.all_contacts().zip(coefficient).zip(static_overlap);
        let links = links.map(|((contact, coefficient), static_overlap)| Link {
            law: contact.law,
            opens: contact.law.is_one_sided() && contact.coefficient > 0.0,
            sites: contact.sites,
            coefficient,
            static_overlap,
        });
        let ground_law = |of: &Simulation| Some(of.chain.on_site.ground.as_ref()?.law.clone());
        let ends = || directions.iter().map(|direction| &direction.ends);
        let rates = Rates {
            chain,
            drive: simulation.drive.as_ref(),
            directions,
            links: links.collect(),
            mobility,
            ground,
            resonators: [resonator_mobility, stiffness, damping],
            losses: [dashpot[0], tangent[0], drag[0]],
            changes: [
                ends().any(|[a, b]| a.chain.law != b.chain.law),
                ends().any(|[a, b]| ground_law(a) != ground_law(b)),
                ends().any(|[a, b]| a.drive != b.drive),
            ],
        };
        let mut start = Motion {
            base: x.iter().zip(&v).map(|(x, v)| [x.value, v.value]).collect(),
            each: x.iter().zip(&v).map(|(x, v)| [x.each, v.each]).collect(),
        };
        rates.place(0.0, &mut start);
        (rates, start)
    }

    /// Value, rate and acceleration at time t of what the drive does.
    fn driven(&self, t: f64) -> [Parameter; 3] {
        let Some(drive) = self.drive else {
            return Default::default();
        };
        let of = |wave: &Waveform| [wave.at(t), wave.rate_at(t), wave.acceleration_at(t)];
        let mut driven = of(drive.waveform()).map(|value| Parameter {
            value,
            ..Parameter::default()
        });
        if self.changes[2] {
            let end = |end: &Simulation| end.drive.as_ref().map(|drive| of(drive.waveform()));
            for (i, datum) in driven.iter_mut().enumerate() {
                datum.each = slopes(self.directions, |at| end(at).map_or(0.0, |of| of[i]));
            }
        }
        driven
    }

    /// Whether stiffnesses go with multiples of 1/2 of the overlap where contacts open.
    pub(super) fn opens_with_roots(&self) -> bool {
        let mut powers = self.links.iter().filter_map(|link| link.law.opens());
        powers.all(|power| (2.0 * power).fract() == 0.0)
    }

    /// The overlap of a link beyond the static one, and its rate.
    #[inline(always)]
    fn across<L: Lanes>(&self, link: &Link, t: f64, at: &Motion) -> [Dual<L>; 2] {
        let [left, right] = link.sites.map(|place| place.map(|s| at.read(s)));
        let [x, v] = left.unwrap_or_else(|| {
            let drive = self.drive.filter(|drive| matches!(drive, Drive::Wall(_)));
            let [x, v, _] = drive.map_or_else(Default::default, |_| self.driven(t));
            [x.here(), v.here()]
        });
        let [x1, v1] = right.unwrap_or([Dual::constant(0.0); 2]);
        [x - x1, v - v1]
    }

    /// The overlap of a link and its rate.
    pub(super) fn overlap(&self, link: &Link, t: f64, at: &Motion) -> [Dual<LaneBlock>; 2] {
        let [r, closing] = self.across(link, t, at);
        [link.static_overlap.here() + r, closing]
    }

    /// Sets a body whose motion is prescribed.
    pub(super) fn place(&self, t: f64, at: &mut Motion) {
        if let Some((site, _)) = self.drive.and_then(Drive::motion) {
            let [x, v, _] = self.driven(t);
            (at.base[site], at.each[site]) = ([x.value, v.value], [x.each, v.each]);
        }
    }

    /// What moves other than in free flight, of the first `moved` bodies, in a step in which these links press.
    pub(super) fn active(&self, moved: usize, presses: impl Fn(usize) -> bool) -> Active {
        let everywhere = self.chain.has_pulls() || self.drive.is_some();
        let (mut links, mut bodies) = (Vec::new(), Vec::<Range<usize>>::new());
        for (i, link) in self.links.iter().enumerate() {
            let [left, right] = link.sites;
            let nearest = left.unwrap_or(0).min(right.unwrap_or(usize::MAX));
            let acts = everywhere || !link.opens || link.static_overlap.value > 0.0;
            if nearest < moved && (acts || presses(i)) {
                links.push(i);
                bodies.extend(link.sites.into_iter().flatten().map(|s| s..s + 1));
            }
        }
        if everywhere {
            bodies = std::iter::once(0..moved).collect();
        }
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
        let push = self.driven(t).map(|datum| datum.here::<L>());
        let (drag, zero) = (self.losses[2].here(), Dual::constant(0.0));
        for j in active.bodies.iter().cloned().flatten() {
            let ([x, v], [_, contacts]) = (at.read::<L>(j), out.read::<L>(j));
            let mut force = contacts - drag * v;
            if let Some(ground) = &chain.on_site.ground {
                let law = ground.law.of(j);
                let spring = Dual {
                    value: law.force(1.0, 0.0, x.value),
                    each: L::splat(law.jet(x.value).slope) * x.each,
                };
                let mut changed = LaneBlock::default();
                if self.changes[1] {
                    changed = slopes(self.directions, |end| {
                        let ground = end.chain.on_site.ground.as_ref();
                        ground.map_or(0.0, |of| of.law.of(j).force(1.0, 0.0, x.value))
                    });
                }
                force = force - self.ground[j].here() * spring.changed(changed);
            }
            if let Some(drive @ (Drive::Force(_) | Drive::Body(..))) = self.drive
                && drive.site() == j
            {
                force = force + push[0];
            }
            if chain.resonators().is_some_and(|all| all.mass[j] > 0.0) {
                let [y, w] = at.read(n + j);
                let [mobility, stiffness, damping] =
                    self.resonators.each_ref().map(|of| of[j].here());
                let pull = stiffness * (y - x) + damping * (w - v);
                force = force + pull;
                out.write(n + j, [w, mobility * (zero - pull)]);
            }
            out.write(j, [v, self.mobility[j].here() * force]);
        }
        if let Some((site, _)) = self.drive.and_then(Drive::motion) {
            out.write(site, [push[1], push[2]]);
        }
    }

    /// Adds the force of a link to the places beside it.
    #[inline(always)]
    fn press<L: Lanes>(&self, link: &Link, t: f64, at: &Motion, out: &mut Motion) {
        let [r, closing] = self.across::<L>(link, t, at);
        let (c, d0) = (link.coefficient.here(), link.static_overlap.here());
        let overlap = d0 + r;
        let is_open = link.opens && overlap.value <= 0.0;
        if is_open && d0.value == 0.0 {
            return;
        }
        let here = link.law.jet(overlap.value);
        let rest = match d0.value > 0.0 {
            true => link.law.jet(d0.value).slope,
            false => here.slope,
        };
        let mut elastic = Dual {
            value: link.law.force(1.0, d0.value, r.value),
            each: L::splat(here.slope) * r.each + L::splat(here.slope - rest) * d0.each,
        };
        let [dashpot, tangent, _] = &self.losses;
        // An infinite bend times no damping is none.
        let bend = if tangent.value > 0.0 { here.bend } else { 0.0 };
        let mut stiffness = Dual {
            value: here.slope,
            each: L::splat(bend) * overlap.each,
        };
        if self.changes[0] {
            let (d0, r, index) = (d0.value, r.value, link.sites[0]);
            let slopes = |of: fn(&Law, f64, f64) -> f64| {
                slopes(self.directions, |end| of(law_at(&end.chain, index), d0, r))
            };
            let forces = slopes(|law, d0, r| law.force(1.0, d0, r));
            let stiffnesses = slopes(|law, d0, r| law.stiffness(1.0, d0, r));
            (elastic, stiffness) = (elastic.changed(forces), stiffness.changed(stiffnesses));
        }
        let mut damper = tangent.here() * c * stiffness;
        if !is_open {
            damper = damper + dashpot.here();
        }
        let force = c * elastic + damper * closing;
        for (place, force) in link
            .sites
            .into_iter()
            .zip([Dual::constant(0.0) - force, force])
        {
            place.into_iter().for_each(|s| out.push(s, force));
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
