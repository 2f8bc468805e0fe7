//! Following pulses through a simulation in two passes: the first finds the peaks, the second
//! measures everything relative to them.

use std::ops::Range;

use super::pulse::{FRONT, Located, Pulse, Sense};
use crate::Result;
use crate::chain::{
    Interpolant, ObservedRun, Resolution, SAMPLES_PER_STEP, Signal, Simulation, StateView,
};
use crate::observer::Observer;

/// In the chain sense, following ends when the velocity of the last site exceeds this fraction of
/// the velocity scale, before a reflection enters the chain.
const UNREACHED: f64 = 1e-6;

/// A pulse has arrived at the wall when the velocity of the last site exceeds this fraction of the
/// velocity scale.
const ARRIVED: f64 = 1e-3;

/// A signal below this fraction of its maximum so far at both ends of a step does not exceed the
/// maximum within the step, since pulses last several steps.
const RISE: f64 = 0.5;

/// Peaks lower than the highest by more than this fraction are discarded without being located.
const DOUBT: f64 = 1e-2;

/// Longest duration of a pulse on the wall of a short chain, in contact times.
const WHOLE: f64 = 10.0;

/// Time limit in contact times per site; slower pulses are abandoned.
const PATIENCE: f64 = 20.0;

/// Spacing of the samples within a step, and the distance from its end that counts as zero, both as
/// fractions of the step.
const LOOK: f64 = 1.0 / SAMPLES_PER_STEP as f64;
const EDGE: f64 = 1e-6;

/// Follows the pulses of a simulation at one resolution.
pub(super) struct Following<'a> {
    pub(super) simulation: &'a Simulation,
    pub(super) sense: Sense,
    pub(super) resolution: Resolution,
    pub(super) observer: &'a dyn Observer,
}

/// The largest value so far, and its time.
#[derive(Debug, Clone, Copy, Default)]
struct Highest {
    value: f64,
    time: f64,
}

/// Largest force of each contact and largest velocity of the site before it.
struct Peaks {
    peaks: Vec<[Highest; 2]>,
    end: f64,
    arrived: bool,
}

/// The pulses at the contacts, until `end_time`; `None` where a pulse is incomplete.
pub(super) struct Followed {
    pub(super) pulses: Vec<Option<Pulse>>,
    pub(super) end_time: f64,
    pub(super) arrived: bool,
}

/// Intermediate results for the pulse at a contact.
#[derive(Debug, Clone, Copy, Default)]
struct PulsePassage {
    arrival: Option<f64>,
    rise: Option<f64>,
    fall: Option<f64>,
    /// Energy passed by the end of the pulse.
    energy: Option<f64>,
    at_peak: Option<EnergySplit>,
    /// Time at which the site before the contact reached half of its peak velocity.
    moving: Option<f64>,
}

/// Energy balance at a contact.
#[derive(Debug, Clone, Copy, Default)]
struct EnergySplit {
    passed: f64,
    behind: f64,
    lost: f64,
    closure: f64,
}

impl Following<'_> {
    /// The pulses at these contacts.
    pub(super) fn all(&self, contacts: Range<usize>) -> Result<Followed> {
        let Peaks {
            peaks,
            end,
            arrived,
        } = self.peaks(contacts.clone())?;
        let mut passages = vec![PulsePassage::default(); contacts.len()];
        let mut watch = self.simulation.watch(self.resolution, self.observer)?;
        let start = self.start(&watch);
        for (i, contact) in contacts.clone().enumerate() {
            // A contact may be compressed from the start.
            let (force, peak) = (watch.force(contact), peaks[i][0].value);
            let begun = |part: f64| (force > 0.0 && force >= part * peak).then_some(0.0);
            (passages[i].arrival, passages[i].rise) = (begun(FRONT), begun(0.5));
        }
        while watch.times()[1] < end {
            self.advance(&mut watch)?;
            for (i, contact) in contacts.clone().enumerate() {
                if peaks[i][0].value > 0.0 {
                    self.pass(&mut watch, contact, peaks[i], &start, &mut passages[i])?;
                }
            }
        }
        let instant = watch.at(end)?;
        let ends = Splits::of(self.simulation, &instant, &start);
        let whole = contacts.enumerate().map(|(i, contact)| {
            let [force, velocity] = peaks[i];
            let passage = passages[i];
            let split = match self.sense {
                Sense::Chain => ends.at(contact),
                Sense::Wall => passage.at_peak?,
            };
            Some(Pulse {
                contact,
                peak_force: located(force.value),
                peak_time: located(force.time),
                peak_velocity: located(velocity.value),
                velocity_time: located(velocity.time),
                velocity_rise_time: passage.moving.map(located),
                arrival_time: located(passage.arrival?),
                width: located(passage.fall? - passage.rise?),
                energy_pulse: match self.sense {
                    Sense::Chain => passage.energy.map(located),
                    Sense::Wall => None,
                },
                energy_passed: located(split.passed),
                energy_behind: split.behind,
                energy_lost: split.lost,
                closure: split.closure,
            })
        });
        Ok(Followed {
            pulses: whole.collect(),
            end_time: end,
            arrived,
        })
    }

    fn advance(&self, watch: &mut ObservedRun) -> Result<()> {
        self.observer.go_on()?;
        watch.step()
    }

    /// Largest force of each contact and largest velocity of the site before it, until the end.
    fn peaks(&self, contacts: Range<usize>) -> Result<Peaks> {
        let simulation = self.simulation;
        let mut watch = simulation.watch(self.resolution, self.observer)?;
        let scale = simulation.speed();
        let last = simulation.chain.n_sites() - 1;
        let latest = PATIENCE * (last + 10) as f64 * simulation.contact_time(scale);
        let at_start = |j: usize| {
            let value = simulation.velocity[j].max(0.0);
            [Highest::default(), Highest { value, time: 0.0 }]
        };
        let mut peaks: Vec<[Highest; 2]> = contacts.clone().map(at_start).collect();
        let mut end = latest;
        while watch.times()[1] < end {
            self.advance(&mut watch)?;
            for (j, [force, velocity]) in contacts.clone().zip(&mut peaks) {
                if watch.presses(j) {
                    raise(&mut watch, Signal::Force(j), force)?;
                    raise(&mut watch, Signal::Velocity(j), velocity)?;
                }
            }
            let level = match self.sense {
                Sense::Chain => UNREACHED * scale,
                Sense::Wall => ARRIVED * scale,
            };
            if end == latest && watch.now().v[last] > level {
                let signal = Signal::Velocity(last);
                let share = watch.interpolant(signal).passes(level, 0.0, 1.0);
                let time = watch.interpolant(signal).time(share);
                let reached = crossing(&mut watch, signal, time, level)?;
                end = match self.sense {
                    Sense::Chain => reached,
                    Sense::Wall => 2.0 * reached + WHOLE * simulation.contact_time(scale),
                };
            }
        }
        Ok(Peaks {
            peaks,
            end,
            arrived: end != latest,
        })
    }

    /// Updates a contact's results with the last step.
    fn pass(
        &self,
        watch: &mut ObservedRun,
        contact: usize,
        [peak, velocity]: [Highest; 2],
        start: &[f64],
        passage: &mut PulsePassage,
    ) -> Result<()> {
        let [from, to] = watch.times();
        if self.sense == Sense::Wall && from < peak.time && peak.time <= to {
            // The energy that reaches the wall has passed the contact before it.
            let before = contact.saturating_sub(1);
            let instant = watch.at(peak.time)?;
            passage.at_peak = Some(Splits::of(self.simulation, &instant, start).at(before));
        }
        if let Some(moving) = moves_at(watch, contact, velocity)? {
            passage.moving = Some(moving);
        }
        if passage.energy.is_some() || !(watch.presses(contact) || passage.fall.is_some()) {
            return Ok(());
        }
        let signal = Signal::Force(contact);
        let interpolant = watch.interpolant(signal);
        let looks = interpolant.samples();
        let (front, half) = (FRONT * peak.value, 0.5 * peak.value);
        let passes = |level, rises| passes(&interpolant, &looks, level, rises);
        let is_after = |time: &f64| *time > peak.time;
        if passage.arrival.is_none()
            && let Some(time) = passes(front, true).next()
        {
            passage.arrival = Some(crossing(watch, signal, time, front)?);
        }
        if let Some(time) = passes(half, true).filter(|time| *time < peak.time).last() {
            passage.rise = Some(crossing(watch, signal, time, half)?);
        }
        if passage.fall.is_none()
            && let Some(time) = passes(half, false).find(is_after)
        {
            passage.fall = Some(crossing(watch, signal, time, half)?);
        }
        if let Some(time) = passes(front, false).find(is_after) {
            let time = crossing(watch, signal, time, front)?;
            passage.energy = Some(watch.at(time)?.passed[contact]);
        }
        Ok(())
    }

    /// Energy of each site at the start.
    fn start(&self, watch: &ObservedRun) -> Vec<f64> {
        site_energies(self.simulation, &watch.now())
    }
}

fn located(value: f64) -> Located {
    Located { value, error: 0.0 }
}

fn site_energies(simulation: &Simulation, instant: &StateView) -> Vec<f64> {
    let chain = &simulation.chain;
    let mut energies = vec![0.0; chain.n_sites()];
    let wall = Some(instant.wall).filter(|_| chain.has_left_wall());
    let wall = wall.unwrap_or(0.0);
    chain.site_energies(instant.x, instant.v, wall, &mut energies);
    chain.add_resonator_energies(instant.x, instant.resonators, &mut energies);
    energies
}

/// Updates `highest` with the maximum of the last step, which is located only if it may be larger.
fn raise(watch: &mut ObservedRun, signal: Signal, highest: &mut Highest) -> Result<()> {
    let interpolant = watch.interpolant(signal);
    if interpolant.value(0.0).max(interpolant.value(1.0)) < RISE * highest.value {
        return Ok(());
    }
    let looks = interpolant.samples();
    let best =
        (0..=SAMPLES_PER_STEP).fold(0, |best, i| if looks[i] > looks[best] { i } else { best });
    let around = |at: f64| [(at - LOOK).max(0.0), (at + LOOK).min(1.0)];
    let [from, to] = around(LOOK * best as f64);
    let (share, value) = interpolant.largest(from, to);
    if share > 1.0 - EDGE || value < (1.0 - DOUBT) * highest.value {
        return Ok(());
    }
    let close = watch.near(signal, interpolant.time(share))?;
    let (share, value) = close.largest(0.0, 1.0);
    if value > highest.value {
        let time = close.time(share);
        *highest = Highest { value, time };
    }
    Ok(())
}

/// The last time, in the last step and before the peak velocity of a site, at which its velocity
/// rises through half of the peak.
fn moves_at(watch: &mut ObservedRun, site: usize, highest: Highest) -> Result<Option<f64>> {
    let half = 0.5 * highest.value;
    let [from, _] = watch.times();
    if from >= highest.time || watch.now().v[site] < RISE * half {
        return Ok(None);
    }
    let signal = Signal::Velocity(site);
    let interpolant = watch.interpolant(signal);
    let looks = interpolant.samples();
    let before = passes(&interpolant, &looks, half, true).filter(|time| *time < highest.time);
    let last = before.last();
    last.map(|time| crossing(watch, signal, time, half))
        .transpose()
}

/// About when a signal rises through a level in the last step, or falls.
fn passes(
    interpolant: &Interpolant,
    looks: &[f64; SAMPLES_PER_STEP + 1],
    level: f64,
    rises: bool,
) -> impl Iterator<Item = f64> {
    let does = move |look: &usize| match (looks[*look], looks[look + 1]) {
        (a, b) if rises => a < level && b >= level,
        (a, b) => a > level && b <= level,
    };
    (0..SAMPLES_PER_STEP).filter(does).map(move |look| {
        let share = interpolant.passes(level, LOOK * look as f64, LOOK * (look + 1) as f64);
        interpolant.time(share)
    })
}

/// The time near `time` at which the signal crosses a level.
fn crossing(watch: &mut ObservedRun, signal: Signal, time: f64, level: f64) -> Result<f64> {
    let close = watch.near(signal, time)?;
    Ok(close.time(close.passes(level, 0.0, 1.0)))
}

/// Energies on the striker's side of every contact: cumulative sums over the sites.
struct Splits {
    behind: Vec<f64>,
    lost: Vec<f64>,
    /// Initial energy plus energy input.
    given: Vec<f64>,
    passed: Vec<f64>,
    total: f64,
}

impl Splits {
    fn of(simulation: &Simulation, instant: &StateView, start: &[f64]) -> Splits {
        let now = site_energies(simulation, instant);
        let sums = |values: &[f64], first: f64| {
            let summed = values.iter().scan(first, |sum, value| {
                *sum += value;
                Some(*sum)
            });
            summed.collect::<Vec<f64>>()
        };
        let lost = match simulation.chain.is_lossy() {
            true => sums(instant.lost, 0.0),
            false => vec![0.0; now.len()],
        };
        let given = sums(start, instant.input);
        Splits {
            total: given.last().copied().unwrap_or(0.0),
            behind: sums(&now, 0.0),
            passed: instant.passed.to_vec(),
            lost,
            given,
        }
    }

    fn at(&self, contact: usize) -> EnergySplit {
        let (passed, behind) = (self.passed[contact], self.behind[contact]);
        let lost = self.lost[contact];
        EnergySplit {
            passed,
            behind,
            lost,
            closure: (passed + behind + lost - self.given[contact]) / self.total,
        }
    }
}
