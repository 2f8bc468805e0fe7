//! The repository itself: which room uses which, what an estimate takes, where links lead, and one version.

mod estimates;
mod links;
mod map;
mod rooms;
mod versions;
