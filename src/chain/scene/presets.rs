//! Scenes that come with the program, most of which reproduce a published result.

/// A scene that comes with the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Preset {
    pub name: &'static str,
    /// What it shows, in a line.
    pub shows: &'static str,
    /// The text of its scene.
    pub text: &'static str,
}

macro_rules! presets {
    ($($name:literal: $shows:literal,)*) => {
        &[$(Preset {
            name: $name,
            shows: $shows,
            text: include_str!(concat!(
                env!("CARGO_MANIFEST_DIR"), "/examples/scenes/", $name, ".toml"
            )),
        },)*]
    };
}

/// All of them, in the order of their subjects.
pub const PRESETS: &[Preset] = presets! {
    "dimer": "a Hertz dimer at the ratio 4.9272, whose pulse stays whole",
    "sonic_vacuum": "Nesterenko's solitary wave, whose speed is the sixth root of its force",
    "quartz_cylinders": "the measured chain of quartz cylinders",
    "quartz_experiment": "the same with its sphere and its wall",
    "lossy_spheres": "steel spheres with losses and a defect",
    "driven_end": "a compressed dimer driven at one end",
    "disordered": "random masses, behind which a pulse decays",
    "linear_chain": "springs, started in one mode, in which they stay",
    "diatomic": "springs and two masses: the gap between their branches",
    "mass_in_mass": "a resonator in each body: the gap at their frequency",
    "fput": "the alpha chain: the first mode spreads, and comes back",
    "fput_beta": "the beta chain: odd modes alone take part",
    "toda_soliton": "a soliton in closed form",
    "alternating": "contacts that alternately soften and harden: a gap that opens with the amplitude",
    "bistable": "an impact that bistable contacts keep in their second wells",
};

/// The preset of a name.
pub fn preset(name: &str) -> Option<&'static Preset> {
    PRESETS.iter().find(|preset| preset.name == name)
}
