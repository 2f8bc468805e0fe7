//! Chains: scenes, contacts, stepping, and sweeps of them.

mod contact;
mod design;
mod drives;
mod energy;
mod flight;
mod high_precision;
mod known;
mod laws;
mod lyapunov;
mod many;
mod on_site;
mod peaks;
mod presets;
mod reference;
mod resonators;
mod scale;
mod scene;
mod scene_hostile;
mod solitary;
mod states;
mod sweep;
mod tangents;
mod window;
mod work;
