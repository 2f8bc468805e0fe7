//! The repository itself: which room uses which, what an estimate takes, how long rooms are, where links lead, and one version.

mod estimates;
mod lines;
mod links;
mod map;
mod rooms;
mod versions;
