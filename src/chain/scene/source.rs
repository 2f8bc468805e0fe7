//! From a text and settings over it to a typed scene, with the place of every key.

use std::path::{Path, PathBuf};

use toml::de::DeTable;
use toml::{Table, Value};

use super::places::{Places, line_at};
use super::properties::{Kind, properties, property};
use super::{Scene, Setup, check, files, setup};
use crate::chain::Chain;
use crate::error::{Error, KeyPlace, Result, SceneFault, nearest_key};
use crate::field::regular_file;

/// Bytes of a scene file that are read at most; long lists of values fit, and so does the text in
/// the file of its run.
const LENGTH_LIMIT: u64 = 8 << 20;

/// One key set from outside of a scene's text.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// Name of the field, such as `stiffness_ratio`.
    pub key: String,
    /// As typed: `4.9`, `9 mm`, `stiff`, lists with commas (`1,4.9`), a table as
    /// `site=20,factor=2`; [`UNSET`] takes the key out of the scene, where it is no value of it.
    pub text: String,
    /// What set it, for messages: `--stiffness-ratio`.
    pub source: String,
}

impl Setting {
    /// A key set to `text` by `source`.
    pub fn new(key: &str, text: impl Into<String>, source: impl Into<String>) -> Setting {
        Setting {
            key: key.to_owned(),
            text: text.into(),
            source: source.into(),
        }
    }
}

/// What a setting says of a key that is to be left out.
pub const UNSET: &str = "none";

/// Keys of other programs, in small letters, and what serves instead.
const ELSEWHERE: [(&[&str], &str); 7] = [
    (
        &["friction", "viscosity"],
        "`drag`, `dashpot` or `tangent` for losses; friction is not modelled",
    ),
    (
        &["thermostat", "temperature"],
        "`velocities`, or `modes` with `mode_energy`, for a chain of this energy; a thermostat is not modelled",
    ),
    (
        &["dt", "timestep", "time_step"],
        "`step` for the length of steps, or `samples` and `end_time` for that of samples",
    ),
    (&["duration", "t_end", "t_max"], "`end_time`"),
    (&["n", "n_sites", "particles"], "`sites`"),
    (&["boundary", "boundaries", "periodic"], "`ends`"),
    (&["integrator", "method"], "`scheme`"),
];

/// The text of a scene and the settings over it.
///
/// # Examples
/// ```
/// use wavecascade::chain::scene::{SceneSource, Setting};
///
/// let scene = SceneSource::new(None, "sites = 20\nstiffness_ratio = 2.0\nend_time = 30.0");
/// let member = scene.with([Setting {
///     key: "stiffness_ratio".into(),
///     text: "4.9272".into(),
///     source: "stiffness_ratio of member 7".into(),
/// }]);
/// let setup = member.setup()?;
/// assert_eq!(setup.simulation.chain.coefficient[1], 4.9272);
/// # Ok::<(), wavecascade::Error>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SceneSource {
    path: Option<PathBuf>,
    text: String,
    settings: Vec<Setting>,
    is_carried: bool,
}

impl SceneSource {
    /// A scene of this text; `path` is what messages call it, unless it is empty.
    pub fn new(path: Option<&Path>, text: impl Into<String>) -> SceneSource {
        let path = path.filter(|path| !path.as_os_str().is_empty());
        SceneSource {
            path: path.map(Path::to_owned),
            text: text.into(),
            settings: Vec::new(),
            is_carried: false,
        }
    }

    /// The scene that a run carries, whose text names no files: they are in it as values.
    pub(crate) fn carried(path: Option<&Path>, text: impl Into<String>) -> SceneSource {
        SceneSource {
            is_carried: true,
            ..SceneSource::new(path, text)
        }
    }

    /// The text of a file.
    ///
    /// # Errors
    /// [`Error::Read`]; [`Error::Input`] if it is not a regular file; [`Error::Scene`] if it is too
    /// long or not text.
    pub fn read(path: &Path) -> Result<SceneSource> {
        let fault = |expected: String, found: String| {
            let place = KeyPlace::File {
                path: path.to_owned(),
                line: None,
            };
            Error::scene(SceneFault::new(place, "", expected, found))
        };
        let length = regular_file(path)?.len();
        if length > LENGTH_LIMIT {
            let expected = format!("a scene, a text of at most {LENGTH_LIMIT} bytes");
            return Err(fault(expected, format!("{length} bytes")));
        }
        let bytes = std::fs::read(path).map_err(Error::read("read", path))?;
        let text = String::from_utf8(bytes).map_err(|error| {
            let at = error.utf8_error().valid_up_to();
            let found = format!("something else at byte {at}");
            fault("a scene, a text in UTF-8".into(), found)
        })?;
        Ok(SceneSource::new(Some(path), text))
    }

    /// The scene with more settings. Later settings take precedence over earlier ones. Tables in
    /// settings ([`defect`](Scene::defect)) replace all those of the text.
    pub fn with(&self, settings: impl IntoIterator<Item = Setting>) -> SceneSource {
        let mut more = self.clone();
        more.settings.extend(settings);
        more
    }

    /// The scene as typed.
    ///
    /// # Errors
    /// [`Error::Scene`] for a text that is no TOML, an unknown key, a value of another type.
    pub fn scene(&self) -> Result<Scene> {
        let (table, places) = self.table()?;
        Self::typed(table, &places)
    }

    /// The scene checked and worked out.
    ///
    /// # Errors
    /// [`Error::Scene`] naming the first key at fault with its place.
    pub fn setup(&self) -> Result<Setup> {
        let (table, places, reads) = self.whole()?;
        let scene = Self::typed(table.clone(), &places)?;
        check::texts(&table, &places)?;
        setup::work_out(&scene, &places, self.text_of(reads, &table, &places)?)
    }

    /// The chain alone, and the number of samples of its run.
    ///
    /// # Errors
    /// As [`SceneSource::setup`].
    pub(crate) fn chain(&self) -> Result<(Chain, usize)> {
        let (table, places, _) = self.whole()?;
        setup::chain_of(&Self::typed(table, &places)?, &places)
    }

    /// A fault that a run found in a value, with the place of its key.
    pub fn locate(&self, error: Error) -> Error {
        match (error, self.table()) {
            (
                Error::Request {
                    option,
                    expected,
                    found,
                },
                Ok((_, places)),
            ) if places.has(&option.replace('-', "_")) => {
                let key = option.replace('-', "_");
                let fault = SceneFault::new(places.of(&key), &key, expected, found);
                Error::scene(fault)
            }
            (error, _) => error,
        }
    }

    /// What the text, or a setting, holds of a key; `None` for nothing.
    ///
    /// # Errors
    /// As [`SceneSource::scene`], for what cannot be read.
    pub(crate) fn typed_value(&self, key: &str) -> Result<Option<Value>> {
        Ok(self.table()?.0.remove(key))
    }

    /// The keys that the text or a setting holds.
    ///
    /// # Errors
    /// As [`SceneSource::scene`], for what cannot be read.
    pub(crate) fn typed_keys(&self) -> Result<Vec<String>> {
        Ok(self.table()?.0.keys().cloned().collect())
    }

    /// The complete scene as one text: that of the file, or, with settings or other files, all keys written anew.
    pub(crate) fn whole_text(&self) -> Result<String> {
        let (table, places, reads) = self.whole()?;
        self.text_of(reads, &table, &places)
    }

    /// All keys, which go together, with the values that files hold; whether there are such files.
    fn whole(&self) -> Result<(Table, Places, bool)> {
        let (mut table, mut places) = self.table()?;
        check::keys(&table, &places)?;
        let reads = match self.is_carried {
            true => files::refuse(&table, &places)?,
            false => files::read_in(&mut table, &mut places)?,
        };
        Ok((table, places, reads))
    }

    fn text_of(&self, reads: bool, table: &Table, places: &Places) -> Result<String> {
        if !reads && self.settings.is_empty() {
            return Ok(self.text.clone());
        }
        let text = toml::to_string(table);
        text.map_err(|error| places.fault("", "values that TOML can hold", error))
    }

    fn typed(mut table: Table, places: &Places) -> Result<Scene> {
        // A number stands for a cell of one.
        for property in properties() {
            let is_cell = property.length.is_some_and(|length| length.repeats);
            if let Some(value) = table.get_mut(&property.name)
                && is_cell
                && (value.is_float() || value.is_integer())
            {
                *value = Value::Array(vec![value.clone()]);
            }
        }
        serde_path_to_error::deserialize(Value::Table(table)).map_err(|error| {
            let key = error.path().to_string();
            let message = error.inner().message();
            Error::scene(SceneFault::of_serde(places.of(&key), &key, message))
        })
    }

    /// All keys with their values.
    fn table(&self) -> Result<(Table, Places)> {
        let syntax = |error: &toml::de::Error| {
            let line = error.span().map(|span| line_at(&self.text, span.start));
            let place = match self.path.clone() {
                Some(path) => KeyPlace::File { path, line },
                None => KeyPlace::Nowhere,
            };
            let reason = error.message().trim().replace('\n', ", ");
            Error::scene(SceneFault::syntax(place, "", reason))
        };
        let spanned = DeTable::parse(&self.text).map_err(|error| syntax(&error))?;
        let mut places = Places::of_text(self.path.as_deref(), &self.text, spanned.get_ref());
        let mut table: Table = toml::from_str(&self.text).map_err(|error| syntax(&error))?;
        for Setting { key, text, source } in &self.settings {
            if unsets(key, text) {
                table.remove(key);
                continue;
            }
            let value = value_of(key, text).map_err(|expected| {
                let place = KeyPlace::Setting {
                    source: source.clone(),
                };
                Error::scene(SceneFault::new(place, key, expected, format!("{text:?}")))
            })?;
            let was_set = places.set(key, source);
            match (table.get_mut(key), value) {
                (Some(Value::Array(tables)), Value::Array(more))
                    if was_set && kind_of(key) == Some(&Kind::Tables) =>
                {
                    tables.extend(more);
                }
                (_, value) => {
                    table.insert(key.clone(), value);
                }
            }
        }
        match table.keys().find(|key| property(key).is_none()) {
            Some(key) => Err(places.fault(key, in_place_of(key), format!("`{key}`"))),
            None => Ok((table, places)),
        }
    }
}

/// What is expected in place of an unknown key.
fn in_place_of(key: &str) -> String {
    let small = key.to_lowercase();
    let elsewhere = ELSEWHERE.iter().find(|(names, _)| names.contains(&&*small));
    let known = properties().iter().map(|property| &*property.name);
    match (elsewhere, nearest_key(key, known)) {
        (Some((_, instead)), _) => (*instead).into(),
        (None, Some(name)) => format!("a key of scenes (`{name}`?)"),
        (None, None) => "a key of scenes".into(),
    }
}

/// Whether a setting takes a key out of the scene, by `none` where that is no value of it.
fn unsets(key: &str, text: &str) -> bool {
    let is_value =
        matches!(kind_of(key), Some(Kind::Choice(all)) if all.iter().any(|one| one.name == UNSET));
    text.trim() == UNSET && !is_value && property(key).is_some()
}

fn kind_of(key: &str) -> Option<&'static Kind> {
    property(key).map(|property| &property.kind)
}

/// The value of a setting, parsed by the kind of its field. The error is the expected form.
fn value_of(key: &str, text: &str) -> std::result::Result<Value, String> {
    let text = text.trim();
    let toml = |text: &str, expected: &str| match toml::from_str::<Table>(&format!("v = {text}")) {
        Ok(mut table) if table.len() == 1 => table.remove("v").ok_or(expected.to_owned()),
        _ => Err(expected.to_owned()),
    };
    match kind_of(key) {
        Some(Kind::Numbers | Kind::Choices(_)) if text.starts_with('[') => toml(text, "a list"),
        Some(Kind::Numbers | Kind::Choices(_)) if text.is_empty() => Ok(Value::Array(Vec::new())),
        Some(Kind::Numbers | Kind::Choices(_)) => {
            Ok(Value::Array(text.split(',').map(scalar).collect()))
        }
        Some(Kind::Tables) if text.starts_with('[') => toml(text, "a list of tables"),
        Some(Kind::Tables) => {
            let braced = match text.starts_with('{') {
                true => text.to_owned(),
                false => format!("{{{text}}}"),
            };
            let table = toml(&braced, "a table such as `site=20,factor=2`")?;
            Ok(Value::Array(vec![table]))
        }
        Some(Kind::Text | Kind::Choice(_)) => Ok(Value::String(text.to_owned())),
        _ => Ok(scalar(text)),
    }
}

fn scalar(text: &str) -> Value {
    let text = text.trim();
    if let Ok(whole) = text.parse() {
        Value::Integer(whole)
    } else if let Ok(number) = text.parse() {
        Value::Float(number)
    } else if let Ok(flag) = text.parse() {
        Value::Boolean(flag)
    } else {
        Value::String(text.to_owned())
    }
}
