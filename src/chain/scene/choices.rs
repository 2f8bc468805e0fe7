//! The choices and compound values of a scene's fields, under the words that are typed.

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use crate::chain::contact::Material;
use crate::measure::{Measure, Time};

/// The units of a scene and of its results.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Units {
    /// Numbers alone.
    #[default]
    None,
    /// m, kg, s, N, J.
    Si,
}

/// What holds the ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EndsTyped {
    /// The striker is free, the last site touches a fixed wall.
    #[default]
    Wall,
    /// Both ends are free.
    Free,
    /// Both ends touch fixed walls.
    Fixed,
    /// The last site touches the first.
    Periodic,
}

/// Which contact of a dimer comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FirstContact {
    #[default]
    Soft,
    Stiff,
}

/// A material of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MaterialTyped {
    /// Fused quartz.
    Quartz,
    /// Stainless steel 316.
    Steel,
    /// Polytetrafluoroethylene.
    Ptfe,
}

impl MaterialTyped {
    pub(super) fn material(self) -> Material {
        match self {
            MaterialTyped::Quartz => Material::QUARTZ,
            MaterialTyped::Steel => Material::STEEL,
            MaterialTyped::Ptfe => Material::PTFE,
        }
    }
}

/// The shape of the bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// Crossed cylinders, which touch by their sides.
    #[default]
    Cylinder,
    Sphere,
}

/// What is driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DriveTyped {
    /// A force on a body, positive towards +x.
    Force,
    /// The displacement of the wall before site 0; both ends are fixed.
    Wall,
    /// The velocity of this wall.
    WallVelocity,
    /// The displacement of a body, whatever pushes it.
    Displacement,
    /// The velocity of a body.
    Velocity,
}

/// The waveform of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WaveformTyped {
    /// amplitude sin(2 pi frequency t).
    #[default]
    Sine,
    /// amplitude sin(pi t / duration) up to the duration, then nothing.
    HalfSine,
    /// cycles of a sine under Hann's window, then nothing.
    ToneBurst,
    /// a sine whose frequency goes evenly from the first to the last within the duration.
    Chirp,
    /// 128 sines of random phases in a band.
    Noise,
    /// The spline through values at times.
    Values,
}

/// An array of the run file that can be left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Recorded {
    /// Displacement of every site.
    Displacement,
    /// Force in every contact.
    Force,
    /// Energy passed through every contact, and lost at every site.
    EnergyPassed,
}

/// A site or a contact that differs from its pattern.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Defect {
    /// The site whose mass differs.
    pub site: Option<usize>,
    /// The contact whose coefficient differs.
    pub contact: Option<usize>,
    /// By what it is multiplied.
    pub factor: Option<f64>,
    /// By what it is replaced.
    pub value: Option<f64>,
    /// The law of the contact, as the text of `law`.
    pub law: Option<String>,
}

/// The end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum EndTimeTyped {
    /// When the front reaches the last site.
    #[default]
    Auto,
    At(Measure<Time>),
}

impl Serialize for EndTimeTyped {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            EndTimeTyped::Auto => serializer.serialize_str("auto"),
            EndTimeTyped::At(time) => time.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for EndTimeTyped {
    fn deserialize<T: Deserializer<'de>>(deserializer: T) -> Result<Self, T::Error> {
        let typed = toml::Value::deserialize(deserializer)?;
        if typed.as_str() == Some("auto") {
            return Ok(EndTimeTyped::Auto);
        }
        let time = Measure::deserialize(typed).map_err(|error| {
            let message = error.message().trim();
            de::Error::custom(format!("{message}, or `auto`"))
        })?;
        Ok(EndTimeTyped::At(time))
    }
}

impl JsonSchema for EndTimeTyped {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "end_time".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut schema = Measure::<Time>::json_schema(generator);
        schema.insert("x-words".into(), serde_json::json!(["auto"]));
        schema
    }
}
