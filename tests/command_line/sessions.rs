//! What a stranger types, and what comes of it: the sessions of `sessions.txt`, each in a folder of its own, in lines of a verb
//! and its words. `sessions.txt` begins with the list of verbs.

use std::fs;

use ndarray::{Array2, Ix2};
use rayon::prelude::*;
use serde_json::Value;
use test_support::fields::{noise, reading};
use test_support::hostile::unescaped;
use test_support::made::{in_one_line, open, pulse, values};
use test_support::place::{Place, names, set, text};
use wavecascade::Field;

/// A folder, and what the last command said there.
pub struct Session {
    pub place: Place,
    columns: String,
    said: String,
}

/// A blank inside of a word is typed as `~`.
fn words(line: &str) -> Vec<String> {
    let words = line.split_whitespace();
    words.map(|word| word.replace('~', " ")).collect()
}

/// Whether a value of a summary is what is expected: a bound, a number and how far off it may be, words, a length, or JSON.
fn is_it(found: &Value, expected: &str) -> bool {
    let number = found.as_f64().unwrap_or(f64::NAN);
    let parsed = |text: &str| text.trim().parse::<f64>().unwrap();
    let (sign, rest) = expected.split_once(' ').unwrap_or((expected, ""));
    match (sign, expected.split_once(" +- ")) {
        (_, Some((value, within))) => (number - parsed(value)).abs() <= parsed(within),
        ("<", _) => number < parsed(rest),
        (">", _) => number > parsed(rest),
        ("with", _) => found.to_string().contains(rest),
        ("length", _) => {
            let length = found
                .as_array()
                .map_or(found.as_str().map_or(0, str::len), Vec::len);
            length.to_string() == rest
        }
        _ => *found == serde_json::from_str::<Value>(expected).unwrap(),
    }
}

/// Sites with noise above a tenth of the axis; one misses samples, one always does, one is dead.
fn faulty(times: usize, sites: usize) -> Array2<f64> {
    let source = noise(times, sites);
    let mut values = Array2::from_shape_fn((times, sites), |(n, j)| {
        let phase = 0.2 * n as f64 - 0.5 * j as f64;
        phase.sin() * (1.0 + 0.3 * (0.011 * n as f64).sin()) + 0.05 * source[[n, j]]
    });
    values.slice_mut(ndarray::s![300..700, 1]).fill(f64::NAN);
    values.slice_mut(ndarray::s![..;50, 4]).fill(f64::NAN);
    values.column_mut(2).fill(0.25);
    values
}

impl Session {
    /// In a folder.
    pub fn of(place: Place) -> Session {
        Session {
            place,
            columns: "1000".into(),
            said: String::new(),
        }
    }

    /// Runs the program; its code, and what it left unsaid on standard error.
    fn run(&mut self, line: &str) -> (Option<i32>, String) {
        let mut command = self.place.command(words(line));
        let output = command.env("COLUMNS", &self.columns).output().unwrap();
        let [out, err] = [&output.stdout, &output.stderr].map(|bytes| text(bytes));
        self.said = out + &err;
        (output.status.code(), err)
    }

    /// Whether lines keep to the width of the terminal.
    fn fits(&self) -> bool {
        let columns: usize = self.columns.parse().unwrap();
        let mut lines = self.said.lines();
        lines.all(|line| line.chars().count() <= columns)
    }

    fn array(&self, kind: &str, times: &str, sites: &str) -> Array2<f64> {
        let [times, sites] = [times, sites].map(|length| length.parse().unwrap());
        match kind {
            "pulse" => pulse(times, sites),
            "noise" => noise(times, sites),
            "wave" => test_support::pulse::wave(times, sites),
            "zeros" => Array2::zeros((times, sites)),
            "faulty" => faulty(times, sites),
            "holes" => {
                let mut wave = test_support::pulse::wave(times, sites);
                wave[[10, 3]] = f64::NAN;
                wave
            }
            _ => panic!("{kind}"),
        }
    }

    fn shape(&self, archive: &str, name: &str) -> String {
        let shape = self.place.array::<f64>(archive, name);
        let shape: Vec<String> = shape.shape().iter().map(usize::to_string).collect();
        shape.join(" ")
    }

    /// Whether a line holds, once it is done.
    pub fn holds(&mut self, line: &str) -> bool {
        let (verb, rest) = line.split_once(' ').unwrap();
        let typed = words(rest);
        let of: Vec<&str> = typed.iter().map(String::as_str).collect();
        let after = |count: usize| rest.splitn(count + 1, ' ').nth(count).unwrap_or("");
        let all = |within: &str, words: &str| {
            let words = words.replace("\\n", "\n");
            words.split(" ; ").all(|word| within.contains(word))
        };
        let before = self.place.names();
        match verb {
            "file" => self.place.write(of[0], unescaped(after(1))),
            "array" => self.place.save(of[0], &self.array(of[1], of[2], of[3])),
            "copy" => {
                let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
                fs::copy(root.join(of[0]), self.place.path(of[1])).unwrap();
            }
            "noisy" => {
                let [times, sites] = [2, 3].map(|i| of[i].parse().unwrap());
                let noise = noise(times, sites) * of[4].parse::<f64>().unwrap();
                let velocity = self.place.array::<f64>(of[1], "velocity") + noise;
                let velocity = velocity.into_dimensionality::<Ix2>();
                self.place.save(of[0], &velocity.unwrap());
            }
            "estimates" => super::estimates::fields(&self.place),
            "sidecar" => self.place.write(of[0], test_support::pulse::SIDECAR),
            "folder" => fs::create_dir(self.place.path(of[0])).unwrap(),
            #[cfg(unix)]
            "link" => std::os::unix::fs::symlink(of[0], self.place.path(of[1])).unwrap(),
            "half" => {
                let bytes = fs::read(self.place.path(of[0])).unwrap();
                self.place.write(of[1], &bytes[..bytes.len() / 2]);
            }
            "damage" => {
                let mut bytes = fs::read(self.place.path(of[0])).unwrap();
                let middle = bytes.len() / 2;
                bytes[middle] ^= 1;
                self.place.write(of[0], bytes);
            }
            "keep" => self.place.write(of[0], &self.said),
            "columns" => self.columns = rest.into(),
            "$" => {
                let (code, err) = self.run(rest);
                return code == Some(0) && err.is_empty();
            }
            "!" => {
                let (code, err) = self.run(after(1));
                let is_error = err.starts_with("error: ") && self.said == err;
                return code == of[0].parse().ok() && is_error && self.place.names() == before;
            }
            "?" => return self.run(after(1)).0 == of[0].parse().ok(),
            "says" => return all(&self.said, rest) || all(&in_one_line(&self.said), rest),
            "not" => return rest.split(" ; ").all(|word| !self.said.contains(word)),
            "begins" => return self.said.starts_with(rest),
            "lines" => return self.said.lines().count() <= of[0].parse::<usize>().unwrap(),
            "fits" => return self.fits(),
            "answers" => {
                let is_said = self.said.starts_with(&format!("{rest}: "));
                let is_undefined = ["NaN", "undefined"].iter().any(|no| self.said.contains(no));
                return is_said && !is_undefined && self.fits() && self.said.lines().count() <= 12;
            }
            "alike" => {
                let of_file = |name: &str| self.place.json(name).pointer(of[2]).cloned();
                return of_file(of[0]).is_some() && of_file(of[0]) == of_file(of[1]);
            }
            "json" => {
                let of_last = || serde_json::from_str(&self.said).unwrap();
                let found = match of[0] {
                    "-" => of_last(),
                    name => self.place.json(name),
                };
                let found: &Value = found.pointer(of[1]).unwrap_or(&Value::Null);
                return is_it(found, after(2)) || {
                    self.said = found.to_string();
                    false
                };
            }
            "text" => return all(&self.place.read(of[0]), after(1)),
            "has" => {
                return of[1..]
                    .iter()
                    .all(|name| self.place.path(of[0]).join(name).exists());
            }
            "names" => return names(&self.place.path(of[0])) == set(&of[1..]),
            "arrays" => return set(&of[1..]).is_subset(&self.place.arrays(of[0])),
            "lacks" => return set(&of[1..]).is_disjoint(&self.place.arrays(of[0])),
            "shape" => return self.shape(of[0], of[1]) == after(2),
            "value" => {
                let array = self.place.array::<f64>(of[0], of[1]);
                let index: Vec<usize> = of[2].split(',').map(|i| i.parse().unwrap()).collect();
                self.said = array[&index[..]].to_string();
                return is_it(&array[&index[..]].into(), after(3));
            }
            "equal" => {
                let [a, b] = [of[0], of[1]].map(|name| self.place.array::<f64>(name, of[2]));
                return a == b;
            }
            "struck" => return open(&self.place, of[0]).struck.is_some(),
            "alike-fields" => {
                let of_variable = of.len() > 2;
                let [a, b] = [of[0], of[1]].map(|name| {
                    let variable = of.get(2).map(|name| (*name).to_owned());
                    let options = reading(|it| it.variable = variable);
                    Field::open(self.place.path(name), &options).unwrap()
                });
                let axes = |it: &Field| (it.time.clone(), it.space.clone(), it.unit.clone());
                let of = |it: &Field| (values(it), axes(it), it.quantity, it.struck);
                let is_whole = b.notes.is_empty() || of_variable;
                return of(&a) == of(&b) && is_whole;
            }
            "same" => {
                let [a, b] = [of[0], of[1]].map(|name| fs::read(self.place.path(name)).unwrap());
                return a == b;
            }
            _ => panic!("{line}"),
        }
        true
    }
}

#[test]
fn regress_sessions() {
    let sessions = include_str!("sessions.txt").split("\n== ").skip(1);
    // Alone: those of which a line has these words.
    let chosen = std::env::var("SESSION").unwrap_or_default();
    let sessions = sessions.filter(|session| session.contains(&chosen));
    let wrong = sessions
        .collect::<Vec<_>>()
        .into_par_iter()
        .filter_map(|text| {
            let mut session = Session::of(Place::new());
            let mut lines = text
                .lines()
                .filter(|line| !line.is_empty() && !line.starts_with('#'));
            let name = lines.next().unwrap();
            // What comes after a line that does not hold may follow from it.
            let line = lines.find(|line| !session.holds(line))?;
            Some(format!("{name}: {line}\n{}", session.said))
        });
    let wrong: Vec<String> = wrong.collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}
