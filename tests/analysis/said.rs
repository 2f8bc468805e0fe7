//! Fields and chains that are known by construction, and what is said of them: a row of `said.txt` each, which begins with its
//! grammar.

use std::collections::BTreeMap;

use ndarray::Array2;
use rayon::prelude::*;
use serde_json::{Value, json};
use wavecascade::analyze::{Analysis, Request, Results, ShowAxis, TimeRange, analyze};
use wavecascade::arrays::{LargeArray, Precision};
use wavecascade::budget::answer_of_run;
use wavecascade::chain::scene::{SceneSource, Setting, preset};
use wavecascade::field::{Field, OpenOptions};
use wavecascade::observer::Silent;
use wavecascade::sheet::Describe;

use test_support::changed;
use test_support::fields::{TEMPORAL, noise, segments};
use test_support::recipe::Recipes;

/// What a table begins with: functions of recipes, and words for facts.
#[derive(Default)]
struct Table {
    recipes: Recipes,
    words: BTreeMap<&'static str, &'static str>,
    rows: Vec<&'static str>,
}

/// Keys with a text each.
type Keys = Vec<(String, String)>;

/// One of the cases of a row: its parameters, and all that is said.
struct Case {
    keys: Keys,
    said: Value,
}

impl Table {
    fn read(text: &'static str) -> Table {
        let mut table = Table::default();
        let own = std::sync::Arc::new(dispersive);
        table.recipes.0.insert("dispersive".into(), own);
        let lines = text.lines();
        for line in lines.filter(|line| !line.is_empty() && !line.starts_with('#')) {
            match line.split_once(' ') {
                Some(("let", definition)) => table.recipes.add(definition),
                Some(("word", meaning)) => table.words.extend(meaning.split_once(": ")),
                _ => table.rows.push(line),
            }
        }
        table
    }

    /// What is said of a case of `source | recipe`, which has `keys`.
    fn said(&self, source: &str, recipe: &str, keys: &Keys) -> Value {
        let mut request = Request {
            results: Results {
                flux_surrogate: false,
                short_time: false,
                ..Results::ALL
            },
            maps: false,
            ..Request::default()
        };
        let (mut field, run) = match source.split_once(' ') {
            None => (self.field(recipe, keys), None),
            Some(("file", path)) => (Field::open(path, &OpenOptions::default()).unwrap(), None),
            Some(("scene", name)) => {
                let setup = scene(name, keys).setup().unwrap();
                let run = setup.simulation.run(&Silent).unwrap();
                match recipe {
                    "bare" => {
                        let field = Field::from_array(run.velocity.clone());
                        (changed(field, |it| it.time.step = run.time[1]), None)
                    }
                    _ => (run.to_field(), Some(run).filter(|_| recipe == "known")),
                }
            }
            Some(_) => panic!("{source}"),
        };
        for (option, text) in keys {
            if let Some(option) = option.strip_prefix("--") {
                set(&mut request, &mut field, option, text);
            }
        }
        match analyze(&field, &request) {
            Ok((mut analysis, _)) => {
                if let Some(run) = run {
                    answer_of_run(&run, &mut analysis).unwrap();
                }
                all_of(&analysis)
            }
            Err(error) => json!({"refused": error.to_string()}),
        }
    }

    /// Samples by a recipe; of the keys the first is the size.
    fn field(&self, recipe: &str, keys: &Keys) -> Field {
        let (times, sites) = keys[0].1.split_once('x').unwrap();
        let shape = (times.parse().unwrap(), sites.parse().unwrap());
        let (mut names, mut values) = (vec!["n", "j", "noise"], vec![0.0; 3]);
        for (key, text) in keys.iter().filter(|(key, _)| !key.starts_with("--")) {
            names.push(key.as_str());
            values.push(text.parse().unwrap());
        }
        let of = self.recipes.read(recipe, &names);
        let noise = noise(shape.0, shape.1);
        Field::from_array(Array2::from_shape_fn(shape, |(n, j)| {
            values[..3].copy_from_slice(&[n as f64, j as f64, noise[[n, j]]]);
            of(&values)
        }))
    }

    /// Whether a fact holds of a case.
    fn holds(&self, fact: &str, case: &Case) -> bool {
        if let Some((one, other)) = fact.split_once(" or ") {
            return self.holds(one, case) || self.holds(other, case);
        }
        if let Some(fact) = fact.strip_prefix("not ") {
            return !self.holds(fact, case);
        }
        let (word, rest) = fact.split_once(' ').unwrap_or((fact, ""));
        if let Some(meaning) = self.words.get(word) {
            let meaning = meaning.replace('$', rest);
            return self.holds(&meaning, case);
        }
        let (relation, right) = rest.split_once(' ').expect(fact);
        let found = case.at(word);
        let number = |text: &str| self.number(text, case);
        let value = match word.contains('(') {
            true => number(word),
            false => found.as_f64().unwrap_or(f64::NAN),
        };
        match (relation, right.split_once(" +- ")) {
            ("<", _) => value < number(right),
            (">", _) => value > number(right),
            ("has", _) => found.to_string().contains(right),
            ("=", Some((middle, within))) => (value - number(middle)).abs() < number(within),
            ("=", None) => match serde_json::from_str::<Value>(right) {
                Ok(expected) if !expected.is_number() => *found == expected,
                _ => value == number(right),
            },
            _ => panic!("{fact}"),
        }
    }

    /// The value of a formula of parameters and of what is said.
    fn number(&self, text: &str, case: &Case) -> f64 {
        let is_of_name = |c: char| c.is_alphanumeric() || "._".contains(c);
        let words = text.split(|c| !is_of_name(c));
        let named = words.filter(|word| word.starts_with(|c: char| c.is_alphabetic()));
        // What is not said is NaN; names without a point may be functions.
        let known = named.filter_map(|name| {
            let key = case.keys.iter().find(|(key, _)| key == name);
            let value = key.map(|(_, text)| text.parse().unwrap());
            let said = case.at(name).as_f64();
            let other = name.contains('.').then_some(f64::NAN);
            Some((name, value.or(said).or(other)?))
        });
        let (names, values): (Vec<&str>, Vec<f64>) = known.unzip();
        self.recipes.read(text, &names)(&values)
    }

    /// What does not hold of a row.
    fn wrong(&self, row: &str) -> Vec<String> {
        let parts: Vec<&str> = row.split(" | ").collect();
        let meaning = |word| self.words.get(word).copied().unwrap_or(word);
        let mut words = parts[0]
            .split(' ')
            .flat_map(|word| meaning(word).split(' '));
        let mut source = words.next().unwrap().to_owned();
        let mut all: Vec<Keys> = vec![Vec::new()];
        for word in words {
            let key = word.split_once('=');
            match key.or((source == "field").then_some(("--size", word))) {
                None => source = format!("{source} {word}"),
                Some((key, texts)) => {
                    let texts = listed(texts);
                    let with = |keys: Keys| {
                        let one =
                            |text: &String| [&keys[..], &[(key.to_owned(), text.clone())]].concat();
                        texts.iter().map(one).collect::<Vec<_>>()
                    };
                    all = all.into_iter().flat_map(with).collect();
                }
            }
        }
        let said = |keys: Keys| Case {
            said: self.said(&source, parts[1], &keys),
            keys,
        };
        let cases: Vec<Case> = all.into_par_iter().map(said).collect();
        let check = |fact: String| {
            let found = self.missed(&fact, &cases)?;
            Some(format!("{row}\nnot {fact}: {found}"))
        };
        let facts = self.facts(parts[2]).into_iter();
        facts.filter_map(check).collect()
    }

    /// Facts, with the meanings of words that stand for several.
    fn facts(&self, text: &str) -> Vec<String> {
        let each = |fact: &str| {
            let (word, rest) = fact.split_once(' ').unwrap_or((fact, ""));
            match self.words.get(word).filter(|of| of.contains(" ; ")) {
                Some(meaning) => self.facts(&meaning.replace('$', rest)),
                None => vec![fact.to_owned()],
            }
        };
        text.split(" ; ").flat_map(each).collect()
    }

    /// A case of which a fact does not hold: of all, of a number of them at least or at most, or of the first and the others.
    fn missed(&self, fact: &str, cases: &[Case]) -> Option<String> {
        let (how, rest) = fact.split_once(' ').unwrap_or((fact, ""));
        if let "least" | "most" = how {
            let (count, fact) = rest.split_once(' ').unwrap();
            let count: usize = count.parse().unwrap();
            let held = cases.iter().filter(|case| self.holds(fact, case)).count();
            let is_wrong = match how {
                "least" => held < count,
                _ => held > count,
            };
            return is_wrong.then(|| format!("{held} of {}", cases.len()));
        }
        let is_missed = |case: &&Case| match how {
            "same" => {
                let (place, within) = rest.split_once(" within ").unwrap_or((rest, "0"));
                let [first, other] = [&cases[0], *case].map(|case| case.at(place));
                let both = other.as_f64().zip(first.as_f64());
                let apart = both.map(|(a, b)| (a / b - 1.0).abs());
                first != other && !apart.is_some_and(|apart| apart < within.parse().unwrap())
            }
            _ => !self.holds(fact, case),
        };
        let missed = cases.iter().find(is_missed)?;
        let meaning = self.words.get(how).unwrap_or(&fact);
        let places = meaning.split(' ').chain(fact.split(' '));
        let mut found = places.map(|place| missed.at(place));
        let found = found.find(|found| !found.is_null());
        let [answer, codes] = ["answer", "codes"].map(|place| missed.at(place));
        Some(format!("{found:?}, {answer}, {codes} of {:?}", missed.keys))
    }
}

impl Case {
    /// A value by its place.
    fn at(&self, place: &str) -> &Value {
        let pointer = format!("/{}", place.replace('.', "/"));
        self.said.pointer(&pointer).unwrap_or(&Value::Null)
    }
}

/// `1,2.5` or `1..8`.
fn listed(texts: &str) -> Vec<String> {
    if let Some((from, to)) = texts.split_once("..") {
        let [from, to]: [i64; 2] = [from, to].map(|end| end.parse().unwrap());
        return (from..=to).map(|i| i.to_string()).collect();
    }
    texts.split(',').map(str::to_owned).collect()
}

/// A preset, a file, or a scene of nothing but keys.
fn scene(name: &str, keys: &Keys) -> SceneSource {
    let text = match (name, preset(name)) {
        ("of", _) => String::new(),
        (_, Some(preset)) => preset.text.into(),
        (path, None) => std::fs::read_to_string(path).unwrap(),
    };
    let keys = keys.iter().filter(|(key, _)| !key.starts_with("--"));
    SceneSource::new(None, text).with(keys.map(|(key, text)| Setting {
        key: key.clone(),
        text: text.clone(),
        source: key.clone(),
    }))
}

/// An option as on the command line, or a part of an axis.
fn set(request: &mut Request, field: &mut Field, option: &str, text: &str) {
    let number = || text.parse::<f64>().unwrap();
    let word = || json!(text);
    let ends: Vec<f64> = text.split(':').filter_map(|end| end.parse().ok()).collect();
    match option {
        "size" => {}
        _ if text == "none" => {}
        "dt" => field.time.step = number(),
        "dx" => field.space.step = number(),
        "t0" => field.time.origin = number(),
        "x0" => field.space.origin = number(),
        "results" => {
            request.results = match text {
                "temporal" => TEMPORAL,
                "spatial" => changed(Results::NONE, |it| it.spatial = true),
                _ => Results::ALL,
            }
        }
        "maps" => request.maps = true,
        "show-frequency" => request.show.frequency = shown(text),
        "show-wavenumber" => request.show.wavenumber = shown(text),
        "show-time" => request.show.time = shown(text),
        "show-space" => request.show.space = shown(text),
        "sites" => request.sites = Some(ends[0] as usize..ends[1] as usize),
        "times" => {
            let (from, to) = (ends[0], ends[1]);
            request.times = TimeRange::Interval { from, to };
        }
        "gaps" => request.gaps = serde_json::from_value(word()).unwrap(),
        "detrend-time" => request.detrend_time = serde_json::from_value(word()).unwrap(),
        "detrend-space" => request.detrend_space = serde_json::from_value(word()).unwrap(),
        "detrend-field" => request.detrend_field_mean = true,
        "window" => {
            request.window_time = text.parse().unwrap();
            request.window_space = request.window_time;
        }
        "pad-time" => request.pad_time = Some(number() as usize),
        "welch" => request.welch = Some(segments(ends[0] as usize, ends[1] as usize)),
        "edge" => request.band_edge_frequency = Some(number()),
        "reference-site" => request.reference_site = Some(number() as usize),
        "front-window" => request.front_window = Some(number()),
        "noise" => request.noise = Some(number()),
        "precision" => request.precision = Precision::F32,
        _ => panic!("{option}"),
    }
}

/// `HIGH`, or `LOW:HIGH`, of which either may be left out.
fn shown(text: &str) -> ShowAxis {
    let number = |text: &str, other: f64| text.parse().unwrap_or(other);
    match text.split_once(':') {
        None => ShowAxis::UpTo(number(text, f64::NAN)),
        Some((low, high)) => ShowAxis::Interval {
            low: number(low, f64::NEG_INFINITY),
            high: number(high, f64::INFINITY),
        },
    }
}

/// The numbers of a summary, arrays of one dimension by their names, warnings by their codes, and what of the axes is shown.
fn all_of(analysis: &Analysis) -> Value {
    let sheet = analysis.describe();
    let mut all = sheet.numbers;
    let mut add = |name: &str, value: Value| drop(all.insert(name.into(), value));
    add("answer", json!(sheet.answer));
    let warnings = sheet.warnings.iter();
    let codes: Vec<&str> = warnings.clone().map(|of| of.code).collect();
    add("codes", json!(codes));
    let with_sites = warnings.clone().filter(|of| of.numbers["sites"].is_array());
    let faults: Vec<&str> = with_sites.map(|of| of.code).collect();
    add("faults", json!(faults));
    for of in warnings {
        let says = |it: &mut Value| it["says"] = json!(of.message);
        add(of.code, changed(of.numbers.clone(), says));
    }
    for of in sheet.variables.iter().filter(|of| of.dimensions.len() == 1) {
        add(&of.name, json!(of.values));
    }
    let told = analysis.undirected.map(|reason| reason.code());
    add("told", json!(told));
    let field = analysis.maps.get(&LargeArray::SAMPLES);
    let shown = field.map(|map| map.shown().values.dim());
    add("shown_field", json!(shown));
    for (name, of) in analysis.display.parts() {
        let bins = [of.bins.start, of.bins.end];
        let of = json!({"bins": bins, "low": of.low, "high": of.high, "below": of.below, "above": of.above, "whole": of.is_whole()});
        add(&format!("shown_{}", name.replace("position", "space")), of);
    }
    Value::Object(all)
}

/// Waves `w = c k (1 - beta k^2)` about the site 35: of n, j, c, beta, the carrier and the width.
fn dispersive(of: &[f64]) -> f64 {
    let [n, j, c, beta, carrier, width] = of.try_into().unwrap();
    let waves = (1..280).map(|i| {
        let k = 0.01 * f64::from(i);
        let a = (-0.5 * ((k - carrier) / width).powi(2)).exp();
        [
            a,
            a * (k * (j - 35.0) - c * k * (1.0 - beta * k * k) * n).cos(),
        ]
    });
    let [all, sum] = waves.fold([0.0; 2], |[all, sum], [a, wave]| [all + a, sum + wave]);
    sum / all
}

#[test]
fn val_construction_kinds_of_fields_and_what_is_said_of_them() {
    let table = Table::read(include_str!("said.txt"));
    // Alone: rows that have these words.
    let chosen = std::env::var("ROW").unwrap_or_default();
    let rows = table.rows.par_iter().filter(|row| row.contains(&chosen));
    let wrong: Vec<String> = rows.flat_map(|row| table.wrong(row)).collect();
    let (count, wrong) = (wrong.len(), wrong.join("\n"));
    assert!(count == 0, "{count} wrong:\n{wrong}");
}
