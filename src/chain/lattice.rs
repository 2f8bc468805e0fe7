//! The chain itself: masses, contacts, ends, losses.
//!
//! `m_j x_j'' = F_{j-1} - F_j`, `F_j = F(delta_j)`, `delta_j = x_j - x_{j+1} + delta0_j`: contact j
//! joins sites j and j+1, and the last one joins the last site to the fixed wall.

use super::law::{Law, Laws, typed};
use super::resonators::Resonators;
use crate::{Error, Result};

/// What holds the ends.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Ends {
    /// The first site is free, the last one touches a fixed wall: N contacts.
    #[default]
    Wall,
    /// Both ends are free: N - 1 contacts.
    Free,
    /// Both ends touch fixed walls: N contacts, and one of this coefficient before site 0.
    Fixed { left_coefficient: f64 },
    /// The last contact joins the last site to the first one: N contacts.
    Periodic,
}

/// Dissipative terms; 0 switches one off.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Losses {
    /// Dashpot in every closed contact: `Fd = dashpot * delta'`.
    pub dashpot: f64,
    /// Hertz-compatible damping: `Fd = tangent * (dF/d delta) delta'`.
    pub tangent: f64,
    /// Viscous drag on every site: the force `-drag * v`.
    pub drag: f64,
}

impl Losses {
    /// Whether any term is present.
    pub fn any(&self) -> bool {
        *self != Losses::default()
    }
}

/// One contact of a chain.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Contact<'a> {
    pub(crate) law: &'a Law,
    pub(crate) coefficient: f64,
    pub(crate) static_overlap: f64,
    /// The bodies left and right of it; `None` for a wall.
    pub(crate) sites: [Option<usize>; 2],
}

impl Contact<'_> {
    /// The difference of values of the bodies, left less right, with that of a wall on the left: of displacements the overlap beyond
    /// the static one.
    pub(crate) fn across(&self, values: &[f64], wall: f64) -> f64 {
        let [left, right] = self.sites;
        left.map_or(wall, |j| values[j]) - right.map_or(0.0, |j| values[j])
    }

    /// The mass with which the bodies move against each other.
    pub(crate) fn reduced_mass(&self, mass: &[f64]) -> f64 {
        let inverse = self.sites.iter().flatten().map(|j| 1.0 / mass[*j]);
        1.0 / inverse.sum::<f64>()
    }

    /// Elastic force beyond the static one, at an overlap beyond the static one.
    pub(crate) fn force(&self, r: f64) -> f64 {
        self.law.force(self.coefficient, self.static_overlap, r)
    }

    /// Derivative of the force along r.
    pub(crate) fn stiffness(&self, r: f64) -> f64 {
        self.law.stiffness(self.coefficient, self.static_overlap, r)
    }

    /// Energy beyond the static state.
    pub(crate) fn energy(&self, r: f64) -> f64 {
        self.law.energy(self.coefficient, self.static_overlap, r)
    }

    /// As [`Law::root_energy`].
    pub(crate) fn root_energy(&self, r: f64) -> (f64, f64) {
        self.law
            .root_energy(self.coefficient, self.static_overlap, r)
    }

    /// Whether waves of small amplitude about the static state are linear.
    pub(crate) fn has_linear_limit(&self) -> bool {
        self.static_overlap > 0.0 || !self.law.is_one_sided()
    }
}

/// Forces on the sites themselves.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct OnSite {
    /// Acceleration towards +x, held by the wall after the last site. Displacements are from the static state.
    pub gravity: f64,
    /// Springs between each site and the ground, without force in the static state.
    pub ground: Option<Ground>,
    /// A mass tied to each body.
    pub resonators: Option<Resonators>,
}

impl OnSite {
    /// Whether springs hold sites, to the ground or to resonators.
    pub(crate) fn any(&self) -> bool {
        self.ground.is_some() || self.resonators.is_some()
    }
}

/// Springs between sites and the ground: the force `-c F(x)` on a site at the displacement x.
#[derive(Debug, Clone, PartialEq)]
pub struct Ground {
    /// The law of each site.
    pub law: Laws,
    /// The coefficient of each site, 0 or more.
    pub coefficient: Vec<f64>,
}

impl Ground {
    /// The spring of site j, towards -x where the site is ahead.
    pub(crate) fn spring(&self, j: usize) -> Contact<'_> {
        Contact {
            law: self.law.of(j),
            coefficient: self.coefficient[j],
            static_overlap: 0.0,
            sites: [Some(j), None],
        }
    }
}

/// A chain of N sites.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    /// Mass of each site.
    pub mass: Vec<f64>,
    /// Coefficient of each contact; [`Ends`] determines their number.
    pub coefficient: Vec<f64>,
    /// The law of each contact.
    pub law: Laws,
    pub ends: Ends,
    /// Static force in every contact, held at free ends by a constant force from outside.
    pub precompression: f64,
    pub losses: Losses,
    pub on_site: OnSite,
}

impl Chain {
    /// The non-dimensional dimer: unit masses, Hertz contacts of coefficients 1, kappa, 1, ...,
    /// free at the striker, with a wall after the last site.
    pub fn dimer(n_sites: usize, stiffness_ratio: f64) -> Chain {
        Chain {
            mass: vec![1.0; n_sites],
            coefficient: (0..n_sites)
                .map(|j| if j % 2 == 0 { 1.0 } else { stiffness_ratio })
                .collect(),
            law: Law::Hertz.into(),
            ends: Ends::Wall,
            precompression: 0.0,
            losses: Losses::default(),
            on_site: OnSite::default(),
        }
    }

    pub fn n_sites(&self) -> usize {
        self.mass.len()
    }

    pub fn n_contacts(&self) -> usize {
        self.coefficient.len()
    }

    /// Whether there is a wall before site 0.
    pub fn has_left_wall(&self) -> bool {
        matches!(self.ends, Ends::Fixed { .. })
    }

    /// Static overlap of contact j.
    pub fn static_overlap(&self, contact: usize) -> f64 {
        self.contact(contact).static_overlap
    }

    /// Static force in contact j: the precompression and the weight of the sites before it.
    pub fn static_force(&self, contact: usize) -> f64 {
        match self.on_site.gravity {
            0.0 => self.precompression,
            g => self.precompression + g * (0..=contact).map(|j| self.whole_mass(j)).sum::<f64>(),
        }
    }

    /// Whether contacts are pressed in the static state.
    pub(crate) fn is_pressed(&self) -> bool {
        self.precompression > 0.0 || self.on_site.gravity > 0.0
    }

    /// Whether motions add up: no contact opens, and no force bends.
    pub(crate) fn is_linear(&self) -> bool {
        let ground = self
            .on_site
            .ground
            .iter()
            .flat_map(|ground| ground.law.each());
        self.law.each().iter().chain(ground).all(Law::is_linear)
    }

    /// Whether forces act on sites that are none of contacts: drag, springs to the ground, or resonators.
    pub(crate) fn has_pulls(&self) -> bool {
        self.losses.any() || self.on_site.any()
    }

    /// All contacts in order, that with a wall before site 0 left out.
    pub(crate) fn contacts(&self) -> impl Iterator<Item = Contact<'_>> {
        let mut weight = 0.0;
        (0..self.n_contacts()).map(move |j| {
            weight += self.on_site.gravity * self.whole_mass(j);
            self.pressed(j, self.precompression + weight)
        })
    }

    /// All contacts in order, that with a wall before site 0 first.
    pub(crate) fn all_contacts(&self) -> impl Iterator<Item = Contact<'_>> {
        self.left_contact().into_iter().chain(self.contacts())
    }

    /// All springs: the contacts, that with a wall before site 0 behind them, and those to the ground.
    pub(crate) fn springs(&self) -> impl Iterator<Item = Contact<'_>> {
        let ground = self.on_site.ground.iter();
        let ground = ground.flat_map(|all| (0..self.n_sites()).map(|j| all.spring(j)));
        self.contacts().chain(self.left_contact()).chain(ground)
    }

    /// Contact j.
    pub(crate) fn contact(&self, j: usize) -> Contact<'_> {
        self.pressed(j, self.static_force(j))
    }

    /// Contact j under a static force.
    fn pressed(&self, j: usize, force: f64) -> Contact<'_> {
        let (law, coefficient) = (self.law.of(j), self.coefficient[j]);
        Contact {
            law,
            coefficient,
            static_overlap: law.static_overlap(coefficient, force),
            sites: [Some(j), self.right_site(j)],
        }
    }

    /// The contact with a wall before site 0, if there is one.
    pub(crate) fn left_contact(&self) -> Option<Contact<'_>> {
        let Ends::Fixed { left_coefficient } = self.ends else {
            return None;
        };
        let law = self.law.before_first();
        Some(Contact {
            law,
            coefficient: left_coefficient,
            static_overlap: law.static_overlap(left_coefficient, self.precompression),
            sites: [None, Some(0)],
        })
    }

    /// Overlap of contact j beyond the static one, `x_j - x_{j+1}`; of velocities its rate.
    pub fn overlap(&self, contact: usize, displacement: &[f64]) -> f64 {
        let right = self.right_site(contact);
        displacement[contact] - right.map_or(0.0, |right| displacement[right])
    }

    /// The site after a contact; `None` for a wall.
    fn right_site(&self, contact: usize) -> Option<usize> {
        match (contact + 1 < self.n_sites(), self.ends) {
            (true, _) => Some(contact + 1),
            (false, Ends::Periodic) => Some(0),
            (false, _) => None,
        }
    }

    /// Force in contact j beyond the static one, damping included.
    pub fn force(&self, contact: usize, displacement: &[f64], velocity: &[f64]) -> f64 {
        let [r, closing] = [displacement, velocity].map(|values| self.overlap(contact, values));
        self.total_force(self.contact(contact), r, closing)
    }

    /// Force of a contact beyond the static one, damping included, at an overlap beyond the static one and its rate.
    pub(crate) fn total_force(&self, contact: Contact, r: f64, closing: f64) -> f64 {
        contact.force(r) + self.damping(contact, r, closing)
    }

    /// The damping alone.
    pub(crate) fn damping(&self, contact: Contact, r: f64, closing: f64) -> f64 {
        let losses = &self.losses;
        if losses.dashpot == 0.0 && losses.tangent == 0.0 {
            return 0.0;
        }
        let closed = contact.static_overlap + r > 0.0 || !contact.law.is_one_sided();
        let dashpot = if closed { losses.dashpot } else { 0.0 };
        (dashpot + losses.tangent * contact.stiffness(r)) * closing
    }

    /// Force on body j towards -x by drag, the ground and its resonator, at displacement and velocity of both.
    pub(crate) fn pull(&self, j: usize, [x, v]: [f64; 2], resonator: Option<[f64; 2]>) -> f64 {
        let ground = self.on_site.ground.as_ref();
        let held = ground.map_or(0.0, |ground| ground.spring(j).force(x));
        let resonator = match (self.resonators(), resonator) {
            (Some(all), Some([y, w])) => all.force(j, y - x, w - v),
            _ => 0.0,
        };
        self.losses.drag * v + held - resonator
    }

    /// Energy of each site beyond the static state: `m v^2 / 2`, half of the energy of each contact
    /// with another site, all of the energy of a contact with a wall. `wall` is the displacement of
    /// the wall before site 0, 0 where it is at rest or absent. Those of resonators are added by
    /// [`Chain::add_resonator_energies`].
    pub fn site_energies(
        &self,
        displacement: &[f64],
        velocity: &[f64],
        wall: f64,
        out: &mut [f64],
    ) {
        for (j, energy) in out.iter_mut().enumerate() {
            *energy = 0.5 * self.mass[j] * velocity[j] * velocity[j];
        }
        for spring in self.springs() {
            let energy = spring.energy(spring.across(displacement, wall));
            match spring.sites {
                [Some(left), Some(right)] => {
                    out[left] += 0.5 * energy;
                    out[right] += 0.5 * energy;
                }
                [left, right] => left.or(right).into_iter().for_each(|j| out[j] += energy),
            }
        }
    }

    /// Whether energy reaches the sites beyond a contact through that contact alone, and none is put in or
    /// lost: what has passed it is by how much their energy has grown.
    pub(crate) fn is_closed(&self, driven: bool) -> bool {
        !driven && !self.is_lossy() && self.ends != Ends::Periodic
    }

    /// Magnitudes of the energies of all springs, added up; a wall before site 0 is at rest.
    pub(super) fn stored_energy(&self, displacement: &[f64]) -> f64 {
        let energy = |of: Contact| of.energy(of.across(displacement, 0.0)).abs();
        self.springs().map(energy).sum()
    }

    /// Total energy beyond the static state without that of resonators; `wall` as for [`Chain::site_energies`].
    pub fn energy(&self, displacement: &[f64], velocity: &[f64], wall: f64) -> f64 {
        let mut energies = vec![0.0; self.n_sites()];
        self.site_energies(displacement, velocity, wall, &mut energies);
        energies.iter().sum()
    }

    /// # Errors
    /// [`Error::Request`] naming the first value that is not physical or does not fit the others.
    pub fn check(&self) -> Result<()> {
        let n = self.n_sites();
        let contacts = match self.ends {
            Ends::Free => n.saturating_sub(1),
            _ => n,
        };
        let enough = n >= 3 || n > 0 && self.ends != Ends::Periodic;
        Error::require(enough, "sites", "1 or more, 3 or more if periodic", n)?;
        let expected = format!("{contacts} contacts for {n} sites with these ends");
        let found = self.n_contacts();
        Error::require(found == contacts, "coefficient", expected, found)?;
        let left = match self.ends {
            Ends::Fixed { left_coefficient } => Some(left_coefficient),
            _ => None,
        };
        let (above, is_above) = ("finite values above 0", |v: f64| v > 0.0 && v.is_finite());
        all_are(("mass", above), &self.mass, is_above)?;
        let coefficients = self.coefficient.iter().chain(&left);
        all_are(("coefficient", above), coefficients, is_above)?;
        for law in self.law.each() {
            match *law {
                Law::Power { exponent } => {
                    typed::power(exponent)?;
                }
                Law::Spring { alpha, beta } => {
                    let finite = ("law", "finite alpha and beta");
                    all_are(finite, [&alpha, &beta], f64::is_finite)?;
                }
                _ => {}
            }
        }
        for (name, value) in [
            ("precompression", self.precompression),
            ("gravity", self.on_site.gravity),
            ("dashpot", self.losses.dashpot),
            ("tangent", self.losses.tangent),
            ("drag", self.losses.drag),
        ] {
            not_negative(name, [&value])?;
        }
        let held =
            self.on_site.gravity == 0.0 || matches!(self.ends, Ends::Wall | Ends::Fixed { .. });
        let expected = "ends with a wall after the last site, which carries the weight";
        Error::require(held, "gravity", expected, "others")?;
        if let Some(all) = self.resonators() {
            all.check(n)?;
        }
        if let Some(ground) = &self.on_site.ground {
            let (found, expected) = (ground.coefficient.len(), "coefficients, one a site");
            Error::require(found == n, "ground", format!("{n} {expected}"), found)?;
            not_negative("ground", &ground.coefficient)?;
        }
        let mut contacts = self.contacts().chain(self.left_contact()).enumerate();
        let is_none = |(_, contact): &(usize, Contact)| contact.static_overlap.is_nan();
        if let Some((j, contact)) = contacts.find(is_none) {
            let option = match self.on_site.gravity > 0.0 {
                true => "gravity",
                false => "precompression",
            };
            let law = contact.law.text();
            let expected = format!("static forces that the law `{law}` can carry");
            let force = self.static_force(j.min(self.n_contacts() - 1));
            return Err(Error::request(
                option,
                &expected,
                format!("{force} in contact {j}"),
            ));
        }
        Ok(())
    }
}

/// That all values are so.
pub(super) fn all_are<'v>(
    (option, expected): (&'static str, &str),
    values: impl IntoIterator<Item = &'v f64>,
    are_so: impl Fn(f64) -> bool,
) -> Result<()> {
    let other = values.into_iter().find(|value| !are_so(**value));
    other.map_or(Ok(()), |value| Err(Error::request(option, expected, value)))
}

pub(super) fn not_negative<'v>(
    option: &'static str,
    values: impl IntoIterator<Item = &'v f64>,
) -> Result<()> {
    let option = (option, "finite values of 0 or more");
    all_are(option, values, |v| v >= 0.0 && v.is_finite())
}
