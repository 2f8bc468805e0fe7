//! From a typed scene to a simulation, every key checked.

use super::bodies::Bodies;
use super::check::Check;
use super::motion::Start;
use super::places::Places;
use super::{
    EndTimeTyped, EndsTyped, Recorded, Scene, Units, coefficients, drive, laws, masses, motion,
    resonators,
};
use crate::chain::{
    Accuracy, Chain, EndTime, Ends, Ground, Losses, OnSite, Record, Scheme, Simulation,
    SteppedSites,
};
use crate::error::{self, Error, Fault, Result, SceneFault};
use crate::system::memory::available_memory;

/// Samples of a scene that does not say.
const SAMPLES: usize = 1024;

/// A scene worked out.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    pub simulation: Simulation,
    pub units: Units,
    /// The drive in words.
    pub(super) drive: Option<String>,
    /// Distance of neighbouring bodies in m, if the scene determines it.
    pub pitch: Option<f64>,
    /// A text that describes this very scene.
    pub text: String,
}

/// Resolves the typed scene to a simulation.
pub(super) fn work_out(scene: &Scene, places: &Places, text: String) -> Result<Setup> {
    let check = Check::new(scene, places);
    let n = size(check)?;
    let bodies = bodies(check)?;
    let chain = chain(check, bodies.as_ref(), n)?;
    let (scheme, accuracy) = stepping(check, chain.has_pulls())?;
    let (drive, about) = drive::drive(check, n)?.unzip();
    let Start {
        velocity,
        displacement,
        resonators,
    } = motion::start(check, &chain, drive.as_ref())?;
    let simulation = Simulation {
        drive,
        scheme,
        estimate_error: estimate_error(check, accuracy)?,
        accuracy,
        end_time: end_time(check, chain.ends, &velocity, &displacement)?,
        chain,
        velocity,
        displacement,
        resonators,
        samples: scene.samples.unwrap_or(SAMPLES),
        record: record(scene),
        window: SteppedSites::default(),
        memory: scene.memory.map(|memory| memory.value as u64),
    };
    match simulation.check() {
        Ok(()) => {}
        Err(Error::Memory {
            needed, allowed, ..
        }) => return Err(too_large(check, n, needed, allowed)),
        Err(error) => return Err(check.named(error, "sites")),
    }
    Ok(Setup {
        simulation,
        units: check.units,
        drive: about,
        pitch: bodies.as_ref().map(Bodies::pitch),
        text,
    })
}

/// The chain of a typed scene, and the number of samples of its run.
pub(super) fn chain_of(scene: &Scene, places: &Places) -> Result<(Chain, usize)> {
    let check = Check::new(scene, places);
    let n = size(check)?;
    let chain = chain(check, bodies(check)?.as_ref(), n)?;
    Ok((chain, scene.samples.unwrap_or(SAMPLES)))
}

fn bodies(check: Check) -> Result<Option<Bodies>> {
    check.has_material().then(|| Bodies::new(check)).transpose()
}

fn chain(check: Check, bodies: Option<&Bodies>, n: usize) -> Result<Chain> {
    let scene = check.scene;
    let law = laws::laws(check)?;
    let (mut coefficient, ends) = coefficients::coefficients(check, bodies, &law, n)?;
    let mut mass = masses::masses(check, bodies, n)?;
    masses::defects(check, &mut mass, &mut coefficient)?;
    Ok(Chain {
        law: laws::with_defects(check, law, coefficient.len())?,
        mass,
        coefficient,
        ends,
        precompression: scene.precompression.map_or(0.0, |force| force.value),
        losses: Losses {
            dashpot: scene.dashpot.unwrap_or(0.0),
            tangent: scene.tangent.map_or(0.0, |time| time.value),
            drag: scene.drag.unwrap_or(0.0),
        },
        on_site: OnSite {
            gravity: scene.gravity.unwrap_or(0.0),
            ground: ground(check, n)?,
            resonators: resonators::resonators(check, n)?,
        },
    })
}

/// The number of sites, of a run that fits the memory, before anything as long as the chain is made.
fn size(check: Check) -> Result<usize> {
    let scene = check.scene;
    let n = check.need("sites", scene.sites, "the number of sites")?;
    let least = match scene.ends.unwrap_or_default() {
        EndsTyped::Periodic => 3,
        EndsTyped::Free => 2,
        EndsTyped::Wall | EndsTyped::Fixed => 1,
    };
    if n < least {
        return Err(check.fault("sites", format!("{least} or more with these ends"), n));
    }
    check.values(n)?;
    let samples = scene.samples.unwrap_or(SAMPLES) as u64;
    let needed = (n as u64).saturating_mul(samples.saturating_mul(8).saturating_add(64));
    let allowed = scene.memory.map(|memory| memory.value as u64);
    let allowed = allowed.unwrap_or_else(available_memory);
    match needed > allowed {
        true => Err(too_large(check, n, needed, allowed)),
        false => Ok(n),
    }
}

fn too_large(check: Check, sites: usize, needed: u64, allowed: u64) -> Error {
    let samples = check.scene.samples.unwrap_or(SAMPLES);
    let key = match samples > sites && check.places.has("samples") {
        true => "samples",
        false => "sites",
    };
    let expected = format!("a run that fits {} of memory", error::size(allowed));
    let needed = error::size(needed);
    let found = format!("{sites} sites at {samples} samples, which need {needed}");
    let advice = "choose fewer `samples` or `sites`, keep less with `record`, or raise `memory`";
    Error::scene(SceneFault {
        place: check.places.of(key),
        key: key.to_owned(),
        fault: Fault::expected(expected, found, advice),
    })
}

/// Springs to the ground.
fn ground(check: Check, n: usize) -> Result<Option<Ground>> {
    let Some(cell) = &check.scene.ground_cell else {
        return Ok(None);
    };
    let text = check.scene.ground_law.as_deref().unwrap_or("spring");
    let law = laws::parsed(check, "ground_law", text)?;
    let any = cell.iter().any(|coefficient| *coefficient > 0.0);
    Ok(any.then(|| Ground {
        law: law.into(),
        coefficient: cell.iter().copied().cycle().take(n).collect(),
    }))
}

fn stepping(check: Check, has_pulls: bool) -> Result<(Scheme, Accuracy)> {
    let scene = check.scene;
    let scheme = match scene.scheme {
        None if has_pulls => Scheme::RungeKutta,
        None => Scheme::default(),
        Some(scheme) if has_pulls && !scheme.takes_losses() => {
            let keys = [
                "dashpot",
                "tangent",
                "drag",
                "ground_cell",
                "resonator_mass",
            ];
            let loss = keys.iter().find(|key| check.places.has(key));
            let expected = "runge-kutta, which takes losses, springs to the ground and resonators";
            let beside = check.places.mention(loss.unwrap_or(&keys[0]));
            return Err(check.fault("scheme", expected, format!("another beside {beside}")));
        }
        Some(scheme) => scheme,
    };
    if !scheme.is_adaptive() {
        let expected = "`step`, since the scheme takes steps of one length";
        if scene.tolerance.is_some() {
            return Err(check.fault("tolerance", expected, "a tolerance"));
        }
        check.need("step", scene.step, "a step, which this scheme takes")?;
    }
    Ok(match scene.step {
        Some(step) => (scheme, Accuracy::Step(step.value)),
        None => (scheme, Accuracy::Tolerance(scene.tolerance.unwrap_or(1e-9))),
    })
}

fn estimate_error(check: Check, accuracy: Accuracy) -> Result<bool> {
    let typed = check.scene.estimate_error;
    if typed == Some(true) && matches!(accuracy, Accuracy::Step(_)) {
        let expected = "none beside `step`: an error is estimated for a `tolerance`";
        return Err(check.fault("estimate_error", expected, "true"));
    }
    Ok(typed.unwrap_or(true))
}

fn end_time(check: Check, ends: Ends, velocity: &[f64], displacement: &[f64]) -> Result<EndTime> {
    if let Some(EndTimeTyped::At(time)) = check.scene.end_time {
        return Ok(EndTime::At(time.value));
    }
    let moves = |values: &[f64]| values.last().is_some_and(|v| *v != 0.0);
    if ends == Ends::Periodic || moves(velocity) || moves(displacement) {
        let expected = "a time, since no front reaches the last site";
        let found = match check.scene.end_time {
            Some(_) => "auto",
            None => "nothing",
        };
        return Err(check.fault("end_time", expected, found));
    }
    Ok(EndTime::Arrival)
}

fn record(scene: &Scene) -> Record {
    let Some(typed) = &scene.record else {
        return Record::ALL;
    };
    Record {
        displacement: typed.contains(&Recorded::Displacement),
        force: typed.contains(&Recorded::Force),
        energy: typed.contains(&Recorded::EnergyPassed),
    }
}
