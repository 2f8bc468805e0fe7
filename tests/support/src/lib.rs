//! What several tests of the workspace share.

pub mod fields;
pub mod figures;
pub mod hostile;
pub mod made;
pub mod measured;
pub mod netcdf;
pub mod place;
pub mod power;
pub mod preload;
pub mod pulse;
pub mod running;
pub mod shared;

/// The same with a change.
pub fn changed<T>(mut it: T, change: impl FnOnce(&mut T)) -> T {
    change(&mut it);
    it
}
