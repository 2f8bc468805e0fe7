//! From a typed scene to a simulation, every key checked.

use super::bodies::Bodies;
use super::check::Check;
use super::motion::Start;
use super::pattern::check_cell;
use super::places::Places;
use super::{
    EndTimeTyped, EndsTyped, Recorded, Scene, Units, coefficients, drive, laws, masses, motion,
    resonators,
};
use crate::chain::{
    Accuracy, Chain, EndTime, Ends, Ground, Losses, OnSite, Record, Scheme, Simulation,
    SteppedSites,
};
use crate::error::{Error, Problem, Result, SceneFault};
use crate::system::memory::available_memory;

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
    let check = Check::new(scene, places)?;
    let n = sites(check)?;
    let samples = scene.samples.unwrap_or(1024);
    if samples < 2 {
        return Err(check.fault("samples", "2 or more", samples));
    }
    let memory = memory(check)?;
    // Before anything as long as the chain is made.
    let allowed = memory.unwrap_or_else(available_memory);
    let least = (n as u64).saturating_mul((samples as u64).saturating_mul(8).saturating_add(64));
    if least > allowed {
        return Err(too_large(check, n, samples, least, allowed));
    }
    let law = laws::laws(check)?;
    let bodies = match check.has_material() {
        true => Some(Bodies::new(check)?),
        false => None,
    };
    let bodies = bodies.as_ref();
    let (mut coefficient, ends) = coefficients::coefficients(check, bodies, &law, n)?;
    let mut mass = masses::masses(check, bodies, n)?;
    masses::defects(check, &mut mass, &mut coefficient)?;
    let law = laws::with_defects(check, law, coefficient.len())?;
    let precompression = scene.precompression.map_or(0.0, |force| force.value);
    check.not_negative("precompression", precompression)?;
    let losses = losses(check)?;
    let on_site = OnSite {
        gravity: check.not_negative("gravity", scene.gravity.unwrap_or(0.0))?,
        ground: ground(check, n)?,
        resonators: resonators::resonators(check, n)?,
    };
    let chain = Chain {
        mass,
        coefficient,
        law,
        ends,
        precompression,
        losses,
        on_site,
    };
    let (scheme, accuracy) = stepping(check, chain.has_pulls())?;
    let (drive, about) = drive::drive(check, n)?.unzip();
    let Start {
        velocity,
        displacement,
        resonators,
    } = motion::start(check, &chain, drive.as_ref())?;
    let simulation = Simulation {
        chain,
        drive,
        scheme,
        estimate_error: estimate_error(check, accuracy)?,
        accuracy,
        end_time: end_time(check, ends, &velocity, &displacement)?,
        velocity,
        displacement,
        resonators,
        samples,
        record: record(scene),
        window: SteppedSites::default(),
        memory,
    };
    match simulation.check() {
        Ok(()) => {}
        Err(Error::Memory {
            needed, allowed, ..
        }) => return Err(too_large(check, n, samples, needed, allowed)),
        Err(error) => return Err(check.named(error, "sites")),
    }
    Ok(Setup {
        simulation,
        units: check.units,
        drive: about,
        pitch: bodies.map(Bodies::pitch),
        text,
    })
}

fn sites(check: Check) -> Result<usize> {
    let n = check.need("sites", check.scene.sites, "the number of sites")?;
    let least = match check.scene.ends.unwrap_or_default() {
        EndsTyped::Periodic => 3,
        EndsTyped::Free => 2,
        EndsTyped::Wall | EndsTyped::Fixed => 1,
    };
    if n < least {
        return Err(check.fault("sites", format!("{least} or more with these ends"), n));
    }
    Ok(n)
}

fn memory(check: Check) -> Result<Option<u64>> {
    let Some(memory) = check.scene.memory else {
        return Ok(None);
    };
    check.positive("memory", memory.value)?;
    Ok(Some(memory.value as u64))
}

fn too_large(check: Check, sites: usize, samples: usize, needed: u64, allowed: u64) -> Error {
    let key = if samples > sites && check.places.has("samples") {
        "samples"
    } else {
        "sites"
    };
    Error::scene(SceneFault {
        place: check.places.of(key),
        key: key.to_owned(),
        problem: Problem::TooLarge {
            sites,
            samples,
            needed,
            allowed,
        },
    })
}

fn losses(check: Check) -> Result<Losses> {
    let scene = check.scene;
    let tangent = scene.tangent.map_or(0.0, |time| time.value);
    Ok(Losses {
        dashpot: check.not_negative("dashpot", scene.dashpot.unwrap_or(0.0))?,
        tangent: check.not_negative("tangent", tangent)?,
        drag: check.not_negative("drag", scene.drag.unwrap_or(0.0))?,
    })
}

/// Springs to the ground.
fn ground(check: Check, n: usize) -> Result<Option<Ground>> {
    let scene = check.scene;
    check.only_with(
        &["ground_law"],
        scene.ground_cell.is_some(),
        "`ground_cell`",
    )?;
    let Some(cell) = &scene.ground_cell else {
        return Ok(None);
    };
    for (i, coefficient) in cell.iter().enumerate() {
        check.not_negative(&format!("ground_cell[{i}]"), *coefficient)?;
    }
    check_cell(check, "ground_cell", cell)?;
    if cell.iter().all(|coefficient| *coefficient == 0.0) {
        return Err(check.fault("ground_cell", "a coefficient above 0", "none"));
    }
    let text = scene.ground_law.as_deref().unwrap_or("spring");
    let law = laws::parsed(check, "ground_law", text)?;
    Ok(Some(Ground {
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
    check.one_of(&["tolerance", "step"], "the length of steps")?;
    if let Some(step) = scene.step {
        return Ok((scheme, Accuracy::Step(check.positive("step", step.value)?)));
    }
    let tolerance = scene.tolerance.unwrap_or(1e-9);
    if !(tolerance > 0.0 && tolerance < 1.0) {
        let expected = "a number above 0 and below 1";
        return Err(check.fault("tolerance", expected, tolerance));
    }
    Ok((scheme, Accuracy::Tolerance(tolerance)))
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
        return Ok(EndTime::At(check.positive("end_time", time.value)?));
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
