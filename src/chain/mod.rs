//! The chain: from a scene to velocities, forces and the energy passed.

pub mod contact;
mod elliptic;
mod root;
