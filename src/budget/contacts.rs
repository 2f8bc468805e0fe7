//! The state of all contacts of a chain at one instant, the input of every budget.

use std::ops::Range;

use super::motion::Motion;
use crate::chain::{Chain, Contact, Drive, Ends, Law, NodeState, hertz_energies, hertz_roots};
use crate::error::{Error, Result};

/// What rounding makes of energies, relative to the largest.
const ROUNDING: f64 = 1e-12;

/// The contacts of a chain in order of x; a contact with a wall before site 0 is the first.
#[derive(Debug)]
pub(super) struct Contacts<'a> {
    pub(super) chain: &'a Chain,
    pub(super) drive: Option<&'a Drive>,
    /// 1 with a wall before site 0, else 0.
    pub(super) offset: usize,
    pub(super) each: Vec<Contact<'a>>,
    coefficient: Vec<f64>,
}

/// State of the contacts at one instant; each row has one value per contact.
#[derive(Debug, Clone, Default)]
pub(super) struct ContactState {
    /// Overlap beyond the static one.
    pub(super) overlap: Vec<f64>,
    /// Rate of the overlap, including the motion of a driven wall.
    pub(super) closing: Vec<f64>,
    /// Elastic force beyond the static one.
    pub(super) elastic: Vec<f64>,
    pub(super) damping: Vec<f64>,
    /// Energy beyond the static state.
    pub(super) energy: Vec<f64>,
    /// `phi = sign(r) sqrt(V)`, so that the energy is a square.
    pub(super) phi: Vec<f64>,
    /// `d phi / d r = F / (2 phi)`, with its limit where phi is 0.
    pub(super) phi_slope: Vec<f64>,
    /// Velocity of the wall before site 0, and the external force on [`Contacts::pushed`].
    pub(super) wall_velocity: f64,
    pub(super) push: f64,
}

/// What a budget over wavenumbers needs.
const ABOVE_REST: &str = "`frequency` or `scale`, since energy by wavenumber needs contacts whose energy is never below \
                          that at rest";

impl<'a> Contacts<'a> {
    pub(super) fn of(motion: &Motion<'a>) -> Contacts<'a> {
        let chain = motion.chain;
        let each: Vec<Contact> = chain.all_contacts().collect();
        Contacts {
            chain,
            drive: motion.drive,
            offset: usize::from(chain.has_left_wall()),
            coefficient: each.iter().map(|contact| contact.coefficient).collect(),
            each,
        }
    }

    /// Whether all contacts are Hertz's and just touch, so that whole rows are computed at once.
    fn just_touch(&self) -> bool {
        !self.chain.is_pressed() && self.chain.law.only() == Some(&Law::Hertz)
    }

    /// The site on which the external force acts, if there is one.
    pub(super) fn pushed(&self) -> usize {
        self.drive.map_or(0, Drive::site)
    }

    /// That site where it is any body of the chain, not its free end.
    pub(super) fn pushed_inside(&self) -> Option<usize> {
        match self.drive {
            Some(Drive::Body(site, _) | Drive::Motion(site, _)) => Some(*site),
            _ => None,
        }
    }

    /// Force on site j from these contact forces.
    #[inline]
    pub(super) fn push_on(&self, j: usize, force: &[f64]) -> f64 {
        let right = force.get(j + self.offset).copied().unwrap_or(0.0);
        let left = match (j + self.offset).checked_sub(1) {
            Some(left) => force[left],
            None if self.chain.ends == Ends::Periodic => force[force.len() - 1],
            None => 0.0,
        };
        left - right
    }

    /// Force on each site from these contact forces.
    pub(super) fn push_all(&self, force: &[f64], out: &mut [f64]) {
        for (j, push) in out.iter_mut().enumerate() {
            *push = self.push_on(j, force);
        }
    }

    /// Accelerations of the sites by the contacts of `state`, drag, the ground, resonators and the external force.
    pub(super) fn accelerations(&self, at: NodeState, state: &ContactState) -> Vec<f64> {
        let forces = state.elastic.iter().zip(&state.damping);
        let force: Vec<f64> = forces.map(|(elastic, damping)| elastic + damping).collect();
        let pushed = self.pushed();
        let push = |j: usize| if j == pushed { state.push } else { 0.0 };
        let all = |j: usize| self.push_on(j, &force) + push(j) - self.pull(j, at);
        let masses = self.chain.mass.iter().enumerate();
        masses.map(|(j, mass)| all(j) / mass).collect()
    }

    /// Force on site j towards -x by drag, the ground and a resonator.
    pub(super) fn pull(&self, j: usize, at: NodeState) -> f64 {
        let [y, w] = at.resonators;
        let own = y.get(j).zip(w.get(j)).map(|(y, w)| [*y, *w]);
        self.chain.pull(j, [at.x[j], at.v[j]], own)
    }

    /// Overlap beyond the static one at which contact i opens; `None` if it cannot open.
    pub(super) fn opens_at(&self, i: usize) -> Option<f64> {
        let contact = self.each[i];
        let one_sided = contact.law.is_one_sided();
        one_sided.then_some(-contact.static_overlap)
    }

    /// Fills `state` from the motion at one time.
    pub(super) fn evaluate(&self, at: NodeState, state: &mut ContactState) {
        self.evaluate_some(0..self.each.len(), at, state);
        state.push = self.drive.map_or(0.0, |drive| {
            let site = drive.site();
            let inner = || {
                let on = |force: &[f64]| self.push_on(site, force);
                on(&state.elastic) + on(&state.damping) - self.pull(site, at)
            };
            drive.push_at(at.t, self.chain.mass[site], inner)
        });
    }

    /// The same for a range of contacts, from the first of which rows then begin, without the external force.
    fn evaluate_some(&self, some: Range<usize>, at: NodeState, state: &mut ContactState) {
        let NodeState { t, x, v, .. } = at;
        for row in [
            &mut state.overlap,
            &mut state.closing,
            &mut state.elastic,
            &mut state.damping,
            &mut state.energy,
            &mut state.phi,
            &mut state.phi_slope,
        ] {
            row.resize(some.len(), 0.0);
        }
        let [wall, wall_velocity] = self.wall(t);
        state.wall_velocity = wall_velocity;
        for (row, values, wall) in [
            (&mut state.overlap, x, wall),
            (&mut state.closing, v, wall_velocity),
        ] {
            let contacts = row.iter_mut().zip(&self.each[some.clone()]);
            contacts.for_each(|(apart, contact)| *apart = contact.across(values, wall));
        }
        let out = [&mut state.elastic[..], &mut state.energy];
        self.forces_and_energies(some.clone(), &state.overlap, out);
        if self.chain.losses.any() {
            let motion = state.overlap.iter().zip(&state.closing);
            for (i, (damping, (r, closing))) in some.zip(state.damping.iter_mut().zip(motion)) {
                *damping = self.chain.damping(self.each[i], *r, *closing);
            }
        }
    }

    /// Refuses contact energies below those at rest, as bistable laws have them: they are no squares.
    ///
    /// # Errors
    /// [`Error::Request`] that names the first.
    pub(super) fn check_roots(&self, motion: &Motion) -> Result<()> {
        let never_below = |of: &Contact| matches!(of.law, Law::Hertz | Law::Power { .. });
        if self.chain.on_site.ground.is_none() && self.each.iter().all(never_below) {
            return Ok(());
        }
        let springs: Vec<Contact> = self.chain.springs().collect();
        let mut largest = 0.0f64;
        for at in (0..motion.samples()).map(|i| motion.at(i)) {
            let [wall, _] = self.wall(at.t);
            let energy = |of: &Contact| of.energy(of.across(at.x, wall));
            let energies: Vec<f64> = springs.iter().map(energy).collect();
            largest = energies.iter().fold(largest, |a, b| a.max(b.abs()));
            let mut all = springs.iter().zip(energies);
            if let Some((spring, energy)) = all.find(|(_, energy)| *energy < -ROUNDING * largest) {
                let j = spring.sites[0].or(spring.sites[1]).unwrap_or(0);
                let found = format!("{energy:.3e} in a spring of body {j} at time {}", at.t);
                return Err(Error::request("only", ABOVE_REST, found));
            }
        }
        Ok(())
    }

    /// Displacement and velocity of a wall before site 0.
    fn wall(&self, t: f64) -> [f64; 2] {
        match self.drive {
            Some(Drive::Wall(wave)) => [wave.at(t), wave.rate_at(t)],
            _ => [0.0; 2],
        }
    }

    /// `phi` and its slope from the overlaps of `state`.
    pub(super) fn evaluate_roots(&self, state: &mut ContactState) {
        let (overlap, phi, slope) = (&state.overlap, &mut state.phi, &mut state.phi_slope);
        if self.just_touch() {
            return hertz_roots([&self.coefficient, overlap], [phi, slope]);
        }
        let roots = phi.iter_mut().zip(slope);
        for (i, ((phi, slope), r)) in roots.zip(overlap).enumerate() {
            (*phi, *slope) = self.each[i].root_energy(*r);
        }
    }

    /// Forces and energies of a range of contacts at these overlaps.
    pub(super) fn forces_and_energies(
        &self,
        contacts: Range<usize>,
        overlap: &[f64],
        [force, energy]: [&mut [f64]; 2],
    ) {
        if self.just_touch() {
            return hertz_energies([&self.coefficient[contacts], overlap], [force, energy]);
        }
        let out = force.iter_mut().zip(energy);
        for ((i, r), (force, energy)) in contacts.zip(overlap).zip(out) {
            let contact = self.each[i];
            *force = contact.force(*r);
            *energy = contact.energy(*r);
        }
    }

    /// Forces, including damping, and mean speeds of a range of the chain's contacts; 0 at a wall, which
    /// transmits no energy.
    pub(super) fn forces_and_speeds(
        &self,
        some: Range<usize>,
        at: NodeState,
        state: &mut ContactState,
    ) -> impl Iterator<Item = [f64; 2]> {
        let some = some.start + self.offset..some.end + self.offset;
        self.evaluate_some(some.clone(), at, state);
        let state = &*state;
        some.enumerate()
            .map(move |(place, i)| self.force_and_speed([i, place], at.v, state))
    }

    /// The same of contact i, which has this place in `state`.
    pub(super) fn force_and_speed(
        &self,
        [i, place]: [usize; 2],
        v: &[f64],
        state: &ContactState,
    ) -> [f64; 2] {
        let force = state.elastic[place] + state.damping[place];
        match self.each[i].sites {
            [Some(left), Some(right)] => [force, 0.5 * (v[left] + v[right])],
            _ => [0.0; 2],
        }
    }
}
