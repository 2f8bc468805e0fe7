//! What the user types: every field optional, nothing checked beyond its type.
//!
//! The doc comments here are all there is: they become the schema's descriptions, the comments of
//! the template and the help of the options. `x-group` opens a group of fields.
//!
//! What a key needs is declared beside it, and checked in one place: the bounds of its numbers, one by one for lists (`minimum`,
//! `exclusiveMinimum`, `exclusiveMaximum`); keys that decide the same (`x-excludes`); keys of which one has to be there
//! (`x-beside`), or has to have one of these words (`x-where`); the length of a list (`x-length`).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::choices::{
    Defect, DriveTyped, EndTimeTyped, EndsTyped, FirstContact, MaterialTyped, Recorded, Shape,
    Units, WaveformTyped,
};
use crate::chain::Scheme;
use crate::chain::contact::Ellipse;
use crate::measure::{
    Angle, Density, Force, Frequency, Length, Mass, Measure, Memory, Pressure, Speed, Time,
};

/// A scene: a chain, how it starts, and what is asked of it.
///
/// A scene with a material is in SI; one without has no units. A quantity of an SI scene is a number
/// in the unit stated or a text with its unit, such as "9 mm".
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(title = "cascade scene")]
pub struct Scene {
    /// Number of sites, the striker (site 0) included.
    #[schemars(extend("x-group" = "The chain"), extend("examples" = [300]))]
    pub sites: Option<usize>,
    /// What holds the ends.
    #[schemars(extend("default" = "wall"))]
    pub ends: Option<EndsTyped>,
    /// Force of a contact against its overlap d, times its coefficient: `hertz` (d^1.5), `power` (d^exponent), `spring`
    /// (d - alpha d^2 + beta d^3), `toda` ((e^(b d) - 1) / b), `morse` ((e^(2 b d) - e^(b d)) / b), `polynomial 1 -0.3 0.05`
    /// (d - 0.3 d^2 + 0.05 d^3), `table -1 -2, 0 0, 1 3` (overlap and force, in rows), or a formula such as
    /// `k*d + a*d^3; k=1, a=0.3`. Hertz and power only press, the others pull, too; `one-sided` or `two-sided` before a law
    /// says otherwise.
    #[schemars(extend("default" = "hertz"))]
    pub law: Option<String>,
    /// Table of a measured law, beside the scene's file: a column of overlaps and one of forces, with units where the
    /// header has them (`overlap [um], force [N]`). A run file holds it as `law`.
    #[schemars(extend("examples" = ["force.csv"]), extend("x-excludes" = ["law", "laws"]))]
    pub law_file: Option<String>,
    /// Laws repeated along the chain from contact 0 on, each as the text of `law`.
    #[schemars(extend("examples" = [["d - 0.2*d^3", "d + 0.2*d^3"]]))]
    #[schemars(extend("x-excludes" = ["law"]), extend("x-length" = "cell of contacts"))]
    pub laws: Option<Vec<String>>,
    /// Exponent p, 1 or more, of the law `power`.
    #[schemars(extend("examples" = [1.5]), extend("minimum" = 1.0))]
    pub exponent: Option<f64>,
    /// Quadratic term of the law `spring`. Formulas may use it, as `exponent`, `beta` and `steepness`, by name.
    #[schemars(extend("default" = 0.0))]
    pub alpha: Option<f64>,
    /// Cubic term of the law `spring`.
    #[schemars(extend("default" = 0.0))]
    pub beta: Option<f64>,
    /// b of the laws `toda` and `morse`, over the unit of length.
    #[schemars(extend("examples" = [1.0]), extend("exclusiveMinimum" = 0.0))]
    pub steepness: Option<f64>,
    /// Static force in every contact, in N in an SI scene; at free ends a constant force holds it.
    #[schemars(extend("default" = 0.0), extend("minimum" = 0.0))]
    pub precompression: Option<Measure<Force>>,
    /// Acceleration towards the last site, in m/s^2 in an SI scene: the weight of the bodies presses the contacts, and a wall after
    /// the last site carries it.
    #[schemars(extend("default" = 0.0), extend("minimum" = 0.0))]
    pub gravity: Option<f64>,
    /// Springs between the sites and the ground: their coefficients, repeated along the chain; 0 is none.
    #[schemars(extend("examples" = [[0.2]]), extend("minimum" = 0.0), extend("x-length" = "cell of sites"))]
    pub ground_cell: Option<Vec<f64>>,
    /// Force of these springs against the displacement, as the text of `law` [default: spring].
    #[schemars(extend("examples" = ["d + 0.2*d^3"]), extend("x-beside" = ["ground_cell"]))]
    pub ground_law: Option<String>,
    /// Resonators on the bodies (mass in mass): the mass tied to each body alone by a linear spring, in kg in an SI scene; a number,
    /// or values repeated along the chain, of which 0 is none.
    #[schemars(extend("examples" = [[0.3]]), extend("minimum" = 0.0), extend("x-length" = "cell of sites"))]
    pub resonator_mass: Option<Vec<f64>>,
    /// Frequency of each resonator while its body is held, `sqrt(stiffness / mass) / (2 pi)`, in cycles per unit of time (Hz in an SI
    /// scene), repeated likewise.
    #[schemars(extend("examples" = [[0.1]]), extend("minimum" = 0.0))]
    #[schemars(extend("x-beside" = ["resonator_mass"]), extend("x-length" = "cell of sites"))]
    pub resonator_frequency: Option<Vec<f64>>,
    /// Stiffness of the spring of each resonator, in place of its frequency (N/m in an SI scene), repeated likewise.
    #[schemars(extend("examples" = [[0.1]]), extend("minimum" = 0.0))]
    #[schemars(extend("x-beside" = ["resonator_mass"]), extend("x-excludes" = ["resonator_frequency"]))]
    #[schemars(extend("x-length" = "cell of sites"))]
    pub resonator_stiffness: Option<Vec<f64>>,
    /// Dashpot beside the spring of each resonator, force over relative speed (N s/m in an SI scene), repeated likewise
    /// [default: none].
    #[schemars(extend("examples" = [[0.01]]), extend("minimum" = 0.0))]
    #[schemars(extend("x-beside" = ["resonator_mass"]), extend("x-length" = "cell of sites"))]
    pub resonator_damping: Option<Vec<f64>>,

    /// Coefficients alternate between 1 and this, which is 1 or more. With a material, between that
    /// of cylinders crossed at 90 degrees and this times as much.
    #[schemars(extend("x-group" = "Contact coefficients (N/m^1.5 in an SI scene with Hertz's law)"),
               extend("examples" = [4.9272]), extend("minimum" = 1.0), extend("x-where" = {"shape": ["cylinder"]}))]
    pub stiffness_ratio: Option<f64>,
    /// Which contact of the dimer the striker touches.
    #[schemars(extend("default" = "soft"), extend("x-beside" = ["stiffness_ratio"]))]
    pub first_contact: Option<FirstContact>,
    /// Coefficients repeated along the chain from contact 0 on: one is uniform, two a dimer, three
    /// a trimer.
    #[schemars(extend("examples" = [[1.0, 4.9272]]), extend("exclusiveMinimum" = 0.0))]
    #[schemars(extend("x-excludes" = ["stiffness_ratio"]), extend("x-length" = "cell of contacts"))]
    pub coefficient_cell: Option<Vec<f64>>,
    /// The coefficient of every contact, the wall's included.
    #[schemars(extend("examples" = [[1.0, 2.0, 4.0]]), extend("exclusiveMinimum" = 0.0))]
    #[schemars(extend("x-excludes" = ["stiffness_ratio", "coefficient_cell"]), extend("x-length" = "contacts"))]
    pub coefficients: Option<Vec<f64>>,
    /// By what coefficients grow geometrically from the first contact to the last.
    #[schemars(extend("default" = 1.0), extend("exclusiveMinimum" = 0.0))]
    pub coefficient_taper: Option<f64>,
    /// Each coefficient is multiplied by a random number in 1 -+ this, below 1.
    #[schemars(extend("default" = 0.0), extend("minimum" = 0.0), extend("exclusiveMaximum" = 1.0))]
    pub coefficient_spread: Option<f64>,
    /// Coefficient of the striker's contact, contact 0 [default: that of the pattern].
    #[schemars(extend("examples" = [1.0]), extend("exclusiveMinimum" = 0.0))]
    #[schemars(extend("x-where" = {"ends": ["wall", "free", "fixed"]}))]
    pub striker_coefficient: Option<f64>,
    /// Coefficient of the last contact where it is a wall's [default: that of the pattern].
    #[schemars(extend("examples" = [1.0]), extend("exclusiveMinimum" = 0.0))]
    #[schemars(extend("x-where" = {"ends": ["wall", "fixed"]}))]
    pub wall_coefficient: Option<f64>,
    /// Coefficient of the contact with the wall before site 0, with fixed ends [default: the last
    /// one of the cell, as if the pattern went on].
    #[schemars(extend("examples" = [1.0]), extend("exclusiveMinimum" = 0.0))]
    #[schemars(extend("x-where" = {"ends": ["fixed"]}))]
    pub left_wall_coefficient: Option<f64>,

    /// Masses alternate between 1 and this, the striker's first.
    #[schemars(extend("x-group" = "Masses (kg in an SI scene)"), extend("examples" = [2.0]), extend("exclusiveMinimum" = 0.0))]
    pub mass_ratio: Option<f64>,
    /// Masses repeated along the chain from the striker on [default: 1, or those of the bodies].
    #[schemars(extend("examples" = [[1.0, 2.0]]), extend("exclusiveMinimum" = 0.0))]
    #[schemars(extend("x-excludes" = ["mass_ratio"]), extend("x-length" = "cell of sites"))]
    pub mass_cell: Option<Vec<f64>>,
    /// The mass of every site.
    #[schemars(extend("examples" = [[1.0, 1.0, 2.0]]), extend("exclusiveMinimum" = 0.0))]
    #[schemars(extend("x-excludes" = ["mass_ratio", "mass_cell"]), extend("x-length" = "sites"))]
    pub masses: Option<Vec<f64>>,
    /// By what masses grow geometrically from the first site to the last.
    #[schemars(extend("default" = 1.0), extend("exclusiveMinimum" = 0.0))]
    pub mass_taper: Option<f64>,
    /// Each mass is multiplied by a random number in 1 -+ this, below 1.
    #[schemars(extend("default" = 0.0), extend("minimum" = 0.0), extend("exclusiveMaximum" = 1.0))]
    pub mass_spread: Option<f64>,
    /// Mass of the striker [default: that of the pattern, or of its sphere].
    #[schemars(extend("examples" = [1.0]), extend("exclusiveMinimum" = 0.0))]
    pub striker_mass: Option<Measure<Mass>>,
    /// Seed of all that is random.
    #[schemars(extend("default" = 0))]
    #[schemars(extend("x-beside" = ["mass_spread", "coefficient_spread", "striker_velocity_spread", "modes", "drive_band"]))]
    pub seed: Option<u64>,
    /// Single sites or contacts that differ, after all patterns, as tables `[[defect]]` of `site` or
    /// `contact` and either `factor` or `value`.
    #[schemars(extend("examples" = [[{"site": 20, "factor": 2.0}]]), extend("exclusiveMinimum" = 0.0))]
    pub defect: Option<Vec<Defect>>,

    /// Units of the scene [default: si with a material, else none]. In SI without a material, masses
    /// and coefficients are given.
    #[schemars(extend("x-group" = "Bodies of an SI scene"), extend("examples" = ["si"]))]
    pub units: Option<Units>,
    /// Material of the bodies, in place of which `young`, `poisson` and `density` serve.
    #[schemars(extend("examples" = ["quartz"]))]
    pub material: Option<MaterialTyped>,
    /// Young's modulus, in Pa [default: the material's].
    #[schemars(extend("examples" = ["72 GPa"]), extend("exclusiveMinimum" = 0.0))]
    pub young: Option<Measure<Pressure>>,
    /// Poisson's ratio [default: the material's].
    #[schemars(extend("examples" = [0.17]), extend("x-beside" = ["material", "young"]))]
    pub poisson: Option<f64>,
    /// Density, in kg/m^3 [default: the material's].
    #[schemars(extend("examples" = [2200.0]), extend("exclusiveMinimum" = 0.0))]
    #[schemars(extend("x-beside" = ["material", "young"]))]
    pub density: Option<Measure<Density>>,
    /// Shape of the bodies.
    #[schemars(extend("default" = "cylinder"), extend("x-beside" = ["material", "young"]))]
    pub shape: Option<Shape>,
    /// Radius of the bodies, in m.
    #[schemars(extend("examples" = ["9 mm"]), extend("exclusiveMinimum" = 0.0))]
    #[schemars(extend("x-beside" = ["material", "young"]))]
    pub radius: Option<Measure<Length>>,
    /// Length of the cylinders, in m; it decides their mass.
    #[schemars(extend("examples" = ["18 mm"]), extend("exclusiveMinimum" = 0.0))]
    #[schemars(extend("x-beside" = ["material", "young"]), extend("x-where" = {"shape": ["cylinder"]}))]
    #[schemars(extend("x-excludes" = ["mass_cell", "masses"]))]
    pub length: Option<Measure<Length>>,
    /// Angle between the axes of neighbouring cylinders, in degrees.
    #[schemars(extend("examples" = [8.0]), extend("exclusiveMinimum" = 0.0))]
    #[schemars(extend("x-beside" = ["material", "young"]), extend("x-where" = {"shape": ["cylinder"]}))]
    #[schemars(extend("x-excludes" = ["stiffness_ratio", "coefficient_cell", "coefficients"]))]
    pub angle: Option<Measure<Angle>>,
    /// Angle at every second contact, from contact 1 on, in degrees [default: the same].
    #[schemars(extend("examples" = [90.0]), extend("exclusiveMinimum" = 0.0))]
    #[schemars(extend("x-beside" = ["angle"]), extend("x-where" = {"shape": ["cylinder"]}))]
    pub second_angle: Option<Measure<Angle>>,
    /// Angles repeated along the chain from contact 0 on, in degrees.
    #[schemars(extend("examples" = [[8.0, 90.0, 90.0]]), extend("exclusiveMinimum" = 0.0))]
    #[schemars(extend("x-beside" = ["material", "young"]), extend("x-where" = {"shape": ["cylinder"]}))]
    #[schemars(extend("x-excludes" = ["stiffness_ratio", "coefficient_cell", "coefficients", "angle"]))]
    #[schemars(extend("x-length" = "cell of contacts"))]
    pub angle_cell: Option<Vec<f64>>,
    /// How the ellipse of a contact is found.
    #[schemars(extend("default" = "approximate"), extend("x-beside" = ["material", "young"]))]
    pub ellipse: Option<Ellipse>,
    /// The striker is a sphere of this radius, in m [default: it is like the other bodies].
    #[schemars(extend("examples" = ["9 mm"]), extend("exclusiveMinimum" = 0.0))]
    #[schemars(extend("x-beside" = ["material", "young"]), extend("x-where" = {"ends": ["wall", "free", "fixed"]}))]
    pub striker_radius: Option<Measure<Length>>,
    /// Material of the spherical striker [default: that of the bodies].
    #[schemars(extend("examples" = ["steel"]), extend("x-beside" = ["striker_radius"]))]
    pub striker_material: Option<MaterialTyped>,
    /// Radius of the sphere by which the wall touches the last body, in m [default: flat where
    /// there is a `wall_material`; else see there].
    #[schemars(extend("examples" = ["9 mm"]), extend("exclusiveMinimum" = 0.0))]
    #[schemars(extend("x-beside" = ["material", "young"]), extend("x-where" = {"ends": ["wall", "fixed"]}))]
    #[schemars(extend("x-excludes" = ["wall_coefficient"]))]
    pub wall_radius: Option<Measure<Length>>,
    /// Material of the wall [default: that of the bodies beside `wall_radius`; without either key the wall's
    /// contact is like those between bodies, as if one more body were held].
    #[schemars(extend("examples" = ["steel"]))]
    #[schemars(extend("x-beside" = ["material", "young"]), extend("x-where" = {"ends": ["wall", "fixed"]}))]
    #[schemars(extend("x-excludes" = ["wall_coefficient"]))]
    pub wall_material: Option<MaterialTyped>,

    /// Velocity of the striker at time 0, in m/s in an SI scene [default: 1 in a scene without
    /// units in which nothing else moves].
    #[schemars(extend("x-group" = "How it starts"), extend("examples" = [1.0]))]
    pub striker_velocity: Option<Measure<Speed>>,
    /// The striker's velocity is multiplied by a random number in 1 -+ this, below 1.
    #[schemars(extend("default" = 0.0), extend("minimum" = 0.0), extend("exclusiveMaximum" = 1.0))]
    pub striker_velocity_spread: Option<f64>,
    /// The initial velocity of every site.
    #[schemars(extend("examples" = [[1.0, 0.0, 0.0]]))]
    #[schemars(extend("x-excludes" = ["striker_velocity"]), extend("x-length" = "sites"))]
    pub velocities: Option<Vec<f64>>,
    /// The initial displacement of every site from the static state.
    #[schemars(extend("examples" = [[0.1, 0.0, -0.1]]), extend("x-length" = "sites"))]
    pub displacements: Option<Vec<f64>>,
    /// The initial displacement of the resonator of every site [default: those of the bodies].
    #[schemars(extend("examples" = [[0.1, 0.0, -0.1]]))]
    #[schemars(extend("x-beside" = ["resonator_mass"]), extend("x-length" = "sites"))]
    pub resonator_displacements: Option<Vec<f64>>,
    /// The initial velocity of the resonator of every site [default: those of the bodies].
    #[schemars(extend("examples" = [[1.0, 0.0, 0.0]]))]
    #[schemars(extend("x-beside" = ["resonator_mass"]), extend("x-length" = "sites"))]
    pub resonator_velocities: Option<Vec<f64>>,
    /// File with the initial state, beside the scene's file: a run (`run.npz` or `run.nc`), which goes on from its
    /// last sample, or a table (or `.npy`) of displacements and velocities, a row a site. A run file holds them as
    /// `displacements` and `velocities`.
    #[schemars(extend("examples" = ["run.npz"]))]
    #[schemars(extend("x-excludes" = ["displacements", "velocities", "resonator_displacements", "resonator_velocities", "striker_velocity", "mode", "modes"]))]
    pub state: Option<String>,
    /// Initial displacements in the shape of this mode, from 1 on: with `mode_amplitude` of the uniform linear
    /// chain, with `mode_energy` of this chain linearized about its static state, counted from the lowest frequency
    /// above 0.
    #[schemars(extend("examples" = [1]), extend("x-excludes" = ["displacements"]))]
    pub mode: Option<usize>,
    /// First and last of the modes of this chain, linearized, that start with random phases (`seed`), each with
    /// `mode_energy`.
    #[schemars(extend("examples" = [[1, 8]]))]
    #[schemars(extend("x-excludes" = ["striker_velocity", "velocities", "displacements", "mode"]))]
    pub modes: Option<Vec<usize>>,
    /// Energy of each mode, in J in an SI scene.
    #[schemars(extend("examples" = [0.1]), extend("exclusiveMinimum" = 0.0))]
    #[schemars(extend("x-beside" = ["mode", "modes"]))]
    #[schemars(extend("x-excludes" = ["resonator_displacements", "resonator_velocities"]))]
    pub mode_energy: Option<f64>,
    /// Amplitude of the sine or cosine that the mode samples, in m in an SI scene.
    #[schemars(extend("examples" = [1.0]))]
    #[schemars(extend("x-beside" = ["mode"]), extend("x-excludes" = ["mode_energy"]))]
    pub mode_amplitude: Option<Measure<Length>>,

    /// What is driven from time 0 on.
    #[schemars(extend("x-group" = "Drive"), extend("examples" = ["force"]))]
    pub drive: Option<DriveTyped>,
    /// The body that is driven, from 0 on.
    #[schemars(extend("default" = 0))]
    #[schemars(extend("x-beside" = ["drive"]), extend("x-where" = {"drive": ["force", "displacement", "velocity"]}))]
    pub drive_site: Option<usize>,
    /// The drive in time [default: sine, or values where they are given].
    #[schemars(extend("examples" = ["tone-burst"]), extend("x-beside" = ["drive"]))]
    pub drive_waveform: Option<WaveformTyped>,
    /// Amplitude of the drive: a force, in N in an SI scene, a displacement, in m, or a velocity, in m/s; of noise the root mean square; a factor of values, by default 1.
    #[schemars(extend("examples" = [0.1]), extend("x-beside" = ["drive"]))]
    pub drive_amplitude: Option<f64>,
    /// Frequency of a sine or a tone burst, and the first one of a chirp, in cycles per unit of time (Hz in an SI
    /// scene).
    #[schemars(extend("examples" = [0.05]), extend("exclusiveMinimum" = 0.0))]
    #[schemars(extend("x-beside" = ["drive"]), extend("x-where" = {"drive_waveform": ["sine", "tone-burst", "chirp"]}))]
    pub drive_frequency: Option<Measure<Frequency>>,
    /// Last frequency of a chirp.
    #[schemars(extend("examples" = [0.5]), extend("exclusiveMinimum" = 0.0))]
    #[schemars(extend("x-beside" = ["drive"]), extend("x-where" = {"drive_waveform": ["chirp"]}))]
    pub drive_end_frequency: Option<Measure<Frequency>>,
    /// Cycles of a tone burst.
    #[schemars(extend("examples" = [5.0]), extend("minimum" = 1.0))]
    #[schemars(extend("x-beside" = ["drive"]), extend("x-where" = {"drive_waveform": ["tone-burst"]}))]
    pub drive_cycles: Option<f64>,
    /// Lowest and highest frequency of noise, in cycles per unit of time (Hz in an SI scene).
    #[schemars(extend("examples" = [[0.05, 0.2]]), extend("minimum" = 0.0))]
    #[schemars(extend("x-beside" = ["drive"]), extend("x-where" = {"drive_waveform": ["noise"]}))]
    pub drive_band: Option<Vec<f64>>,
    /// Seed of noise [default: `seed`].
    #[schemars(extend("examples" = [1]))]
    #[schemars(extend("x-beside" = ["drive"]), extend("x-where" = {"drive_waveform": ["noise"]}))]
    pub drive_seed: Option<u64>,
    /// Duration of a half-sine, a chirp or noise, in s in an SI scene [default for noise: no end].
    #[schemars(extend("examples" = [10.0]), extend("exclusiveMinimum" = 0.0))]
    #[schemars(extend("x-beside" = ["drive"]), extend("x-where" = {"drive_waveform": ["half-sine", "chirp", "noise"]}))]
    pub drive_duration: Option<Measure<Time>>,
    /// Table of the drive, beside the scene's file: a column of times and one of values, separated by commas,
    /// semicolons, tabs or blanks, with units where the header has them (`time [ms], force [kN]`). A run file
    /// holds them as `drive_times` and `drive_values`.
    #[schemars(extend("examples" = ["force.csv"]))]
    #[schemars(extend("x-beside" = ["drive"]), extend("x-where" = {"drive_waveform": ["values"]}))]
    #[schemars(extend("x-excludes" = ["drive_times", "drive_values"]))]
    pub drive_file: Option<String>,
    /// Times of the drive's values, rising, six or more. Between them runs a spline of degree five. Before and
    /// after them a force and a velocity are 0, and a displacement stays as it is at the ends.
    #[schemars(extend("examples" = [[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]]))]
    #[schemars(extend("x-beside" = ["drive"]), extend("x-where" = {"drive_waveform": ["values"]}))]
    pub drive_times: Option<Vec<f64>>,
    /// The drive at these times.
    #[schemars(extend("examples" = [[0.0, 0.1, 0.3, 0.3, 0.1, 0.0]]))]
    #[schemars(extend("x-beside" = ["drive"]), extend("x-where" = {"drive_waveform": ["values"]}))]
    pub drive_values: Option<Vec<f64>>,

    /// Dashpot in every closed contact, force over closing speed (N s/m in an SI scene).
    #[schemars(extend("x-group" = "Losses"), extend("default" = 0.0), extend("minimum" = 0.0))]
    pub dashpot: Option<f64>,
    /// Hertz-compatible damping: the damping force is this times the tangent stiffness times the
    /// closing speed (s in an SI scene).
    #[schemars(extend("default" = 0.0), extend("minimum" = 0.0))]
    pub tangent: Option<Measure<Time>>,
    /// Viscous drag on every site, force over velocity (N s/m in an SI scene).
    #[schemars(extend("default" = 0.0), extend("minimum" = 0.0))]
    pub drag: Option<f64>,

    /// Largest error of any site's velocity at any sample, relative to the impact velocity.
    #[schemars(extend("x-group" = "Stepping"), extend("default" = 1e-9), extend("exclusiveMinimum" = 0.0), extend("exclusiveMaximum" = 1.0))]
    pub tolerance: Option<f64>,
    /// Method of stepping [default: nystrom, or runge-kutta for a chain with losses].
    #[schemars(extend("examples" = ["nystrom"]))]
    pub scheme: Option<Scheme>,
    /// Longest step, in s in an SI scene, in place of a tolerance.
    #[schemars(extend("examples" = [0.01]), extend("exclusiveMinimum" = 0.0))]
    #[schemars(extend("x-excludes" = ["tolerance"]))]
    pub step: Option<Measure<Time>>,
    /// Whether the run is checked by a second one of smaller steps, which `tolerance` rests on.
    #[schemars(extend("default" = true))]
    pub estimate_error: Option<bool>,

    /// End of the run, in s in an SI scene, or `auto`: when the front reaches the last site, which is
    /// before the force at a wall behind it peaks.
    #[schemars(extend("x-group" = "What is kept"), extend("default" = "auto"), extend("exclusiveMinimum" = 0.0))]
    pub end_time: Option<EndTimeTyped>,
    /// Number of samples, uniform from 0 to the end, both included.
    #[schemars(extend("default" = 1024), extend("minimum" = 2.0))]
    pub samples: Option<usize>,
    /// What is computed and kept beside the velocities; may be empty.
    #[schemars(extend("default" = ["displacement", "force", "energy_passed"]))]
    pub record: Option<Vec<Recorded>>,
    /// Memory that the results may take, such as 2GiB [default: what is free].
    #[schemars(extend("examples" = ["2GiB"]), extend("exclusiveMinimum" = 0.0))]
    pub memory: Option<Measure<Memory>>,
}
