//! How a scene's run changes with its keys.

use super::key::{FreeKey, settings};
use crate::chain::scene::SceneSource;
use crate::chain::{Direction, Gradient};
use crate::error::{Error, Result};
use crate::observer::Observer;

/// Half of the difference of a key, over its value: its square, and rounding over it, are below 1e-10.
const STEP: f64 = 2e-6;

/// Derivatives of a scene's run at these times, rising from 0, with respect to keys that it states, as [`FreeKey::of`] reads them, per
/// unit of the key.
///
/// # Errors
/// [`Error::Request`] for keys that are no numbers of the scene; as [`crate::chain::Simulation::gradient`].
pub fn gradient(
    scene: &SceneSource,
    keys: &[String],
    times: &[f64],
    observer: &dyn Observer,
) -> Result<Gradient> {
    let named = |error: Error| error.of_option("free", "gradient");
    let keys = FreeKey::each(keys, scene).map_err(named)?;
    let directions: Result<Vec<Direction>> = keys.iter().map(|key| direction(scene, key)).collect();
    let names = keys.iter().map(|key| (key.name.clone(), key.unit.clone()));
    let simulation = scene.setup()?.simulation;
    simulation.gradient(
        names.collect(),
        &directions.map_err(named)?,
        times,
        observer,
    )
}

/// How the scene changes with a key.
fn direction(scene: &SceneSource, key: &FreeKey) -> Result<Direction> {
    let step = STEP * key.start.abs();
    if step == 0.0 {
        return Err(super::key::refuse("a key that is not 0", &key.name));
    }
    let at = |value: f64| {
        let set = settings(std::slice::from_ref(key), std::iter::once(value));
        Ok::<_, Error>(scene.with(set).setup()?.simulation)
    };
    let ends = [key.start - step, key.start + step];
    let [low, high] = ends.map(|value| value.clamp(key.bounds[0], key.bounds[1]));
    Direction::between(&at(low)?, &at(high)?, high - low)
}
