//! Chains: scenes, contacts, stepping, and sweeps of them.

mod bits;
mod contact;
mod design;
mod drives;
mod energy;
mod flight;
mod known;
mod laws;
mod lyapunov;
mod on_site;
mod peaks;
mod presets;
mod reference;
mod scene;
mod scene_hostile;
mod solitary;
mod states;
mod sweep;
mod tangents;
mod work;
