//! Estimates asked for in words, and what they give by name.
//!
//! Options of most: `segment=64 overlap=32 detrend=none gaps=mask window=hann`, `tapers=4:7` (seven Slepian sequences of the product 4);
//! further ones below. What an estimate does not take is a panic.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::str::FromStr;

use ndarray::{Array2, Axis};
use serde_json::Value;
use wavecascade::estimates::{
    self, Averaging, Bicoherence, BicoherenceRequest, Coherence, CoherenceRequest, FieldAxis,
    Increments, IncrementsRequest, Modes, ModesRequest, Slope, SlopeRequest, SpaceTimeEstimate,
    SpaceTimeRequest, SpectrumEstimate, SpectrumRequest, Tapers, Transfer, TransferRequest,
};
use wavecascade::observer::{Observer, Silent};
use wavecascade::prepare::Gaps;
use wavecascade::ridges::{self, RidgeLaw, Ridges, RidgesRequest};
use wavecascade::sheet::Describe;
use wavecascade::{Error, Field};

/// Options that are asked for; those that nothing took are an error.
struct Words<'w> {
    of: &'w str,
    left: RefCell<BTreeSet<&'w str>>,
}

impl<'w> Words<'w> {
    fn has(&self, word: &str) -> bool {
        self.left.borrow_mut().remove(word)
    }

    fn value(&self, key: &str) -> Option<&'w str> {
        let mut left = self.left.borrow_mut();
        let value = |word: &&'w str| Some((*word, word.strip_prefix(key)?.strip_prefix('=')?));
        let (word, value) = left.iter().find_map(value)?;
        left.remove(word);
        Some(value)
    }

    fn number<T: FromStr>(&self, key: &str) -> Option<T> {
        self.value(key).map(number)
    }

    fn set<T: FromStr>(&self, key: &str, to: &mut T) {
        if let Some(number) = self.number(key) {
            *to = number;
        }
    }

    /// Numbers with commas between them, or a range, as `0..4`.
    fn list<T: FromStr>(&self, key: &str) -> Option<Vec<T>> {
        let value = self.value(key)?;
        let Some((from, to)) = value.split_once("..") else {
            return Some(value.split(',').map(number).collect());
        };
        let range = number::<usize>(from)..number(to);
        Some(range.map(|n| number(&n.to_string())).collect())
    }

    fn band(&self) -> Option<(f64, f64)> {
        self.list("band").map(|ends| (ends[0], ends[1]))
    }

    fn tapers(&self, window: &str, tapers: &str, to: &mut Tapers) {
        if let Some(words) = self.value(tapers) {
            let (nw, count) = words.split_once(':').unwrap();
            let (nw, count) = (number(nw), number(count));
            *to = Tapers::Slepian { nw, count };
        }
        if let Some(window) = self.number(window) {
            *to = Tapers::Window(window);
        }
    }

    /// What most estimates take.
    fn averages(&self, averaging: &mut Averaging, gaps: &mut Gaps) {
        averaging.segment = self.number("segment");
        averaging.overlap = self.number("overlap");
        self.tapers("window", "tapers", &mut averaging.tapers);
        if let Some(name) = self.value("detrend") {
            averaging.detrend = serde_json::from_value(name.into()).unwrap();
        }
        if let Some(name) = self.value("gaps") {
            *gaps = serde_json::from_value(name.into()).unwrap();
        }
    }
}

fn number<T: FromStr>(text: &str) -> T {
    let parsed = text.parse();
    parsed.unwrap_or_else(|_| panic!("`{text}` cannot be read"))
}

/// Records of the same sites: `[&field]`, `&fields`.
pub trait Shots<'f>: IntoIterator<Item = &'f Field> {}

impl<'f, I: IntoIterator<Item = &'f Field>> Shots<'f> for I {}

type Found<T> = Result<T, Error>;

/// What an estimate finds by the usual request with these options.
fn asked<'f, R: Default, F>(
    words: &str,
    shots: impl Shots<'f>,
    estimate: impl Fn(&[&Field], &R, &dyn Observer) -> Found<F>,
    take: impl Fn(&Words, &mut R),
) -> Found<F> {
    let words = Words {
        of: words,
        left: RefCell::new(words.split_whitespace().collect()),
    };
    let mut request = R::default();
    take(&words, &mut request);
    let left = words.left.borrow();
    assert!(left.is_empty(), "{left:?} of {}", words.of);
    estimate(&shots.into_iter().collect::<Vec<_>>(), &request, &Silent)
}

/// `along=space whole equal`.
pub fn spectrum<'f>(words: &str, shots: impl Shots<'f>) -> Found<SpectrumEstimate> {
    let take = |words: &Words, it: &mut SpectrumRequest| {
        words.averages(&mut it.averaging, &mut it.gaps);
        if words.has("along=space") {
            it.along = FieldAxis::Space;
        }
        it.is_whole = words.has("whole");
        it.is_adaptive = !words.has("equal");
        it.subtract_noise = words.has("subtract-noise");
    };
    asked(words, shots, estimates::spectrum, take)
}

/// `reference=4`.
pub fn coherence<'f>(words: &str, shots: impl Shots<'f>) -> Found<Coherence> {
    let take = |words: &Words, it: &mut CoherenceRequest| {
        words.averages(&mut it.averaging, &mut it.gaps);
        words.set("reference", &mut it.reference);
    };
    asked(words, shots, estimates::coherence, take)
}

/// `site=0 output=1 sites=0,5`, the last of the rows of `along`.
pub fn bicoherence<'f>(words: &str, shots: impl Shots<'f>) -> Found<Bicoherence> {
    let take = |words: &Words, it: &mut BicoherenceRequest| {
        words.averages(&mut it.averaging, &mut it.gaps);
        words.set("site", &mut it.site);
        it.output = words.number("output");
        it.along = words.list("sites").unwrap_or_default();
    };
    asked(words, shots, estimates::bicoherence, take)
}

/// `frequencies=0.1,0.2`.
pub fn modes<'f>(words: &str, shots: impl Shots<'f>) -> Found<Modes> {
    let take = |words: &Words, it: &mut ModesRequest| {
        words.averages(&mut it.averaging, &mut it.gaps);
        it.frequencies = words.list("frequencies").unwrap_or_default();
    };
    asked(words, shots, estimates::modes, take)
}

/// `space-window=none` or `space-tapers=2:3` along x, `equal`.
pub fn spacetime<'f>(words: &str, shots: impl Shots<'f>) -> Found<SpaceTimeEstimate> {
    let take = |words: &Words, it: &mut SpaceTimeRequest| {
        words.averages(&mut it.averaging, &mut it.gaps);
        words.tapers("space-window", "space-tapers", &mut it.space);
        it.is_adaptive = !words.has("equal");
    };
    asked(words, shots, estimates::spacetime, take)
}

/// `separations=1,2 lags=4 band=0.4,2.1 histograms=2`.
pub fn increments<'f>(words: &str, shots: impl Shots<'f>) -> Found<Increments> {
    let take = |words: &Words, it: &mut IncrementsRequest| {
        it.separations = words.list("separations");
        it.lags = words.list("lags");
        it.band = words.band();
        words.set("histograms", &mut it.histograms);
    };
    asked(words, shots, estimates::increments, take)
}

/// `axis=time band=0.02,0.48 frames=1`.
pub fn slope<'f>(words: &str, shots: impl Shots<'f>) -> Found<Slope> {
    let take = |words: &Words, it: &mut SlopeRequest| {
        words.averages(&mut it.averaging, &mut it.gaps);
        if words.has("axis=time") {
            it.axis = FieldAxis::Time;
        }
        it.band = words.band().unwrap_or(it.band);
        words.set("frames", &mut it.frames);
    };
    asked(words, shots, estimates::slope, take)
}

/// `from=0 to=1 lag=9 highest=0.2 resamplings=40 threads=2`.
pub fn transfer<'f>(words: &str, shots: impl Shots<'f>) -> Found<Transfer> {
    let take = |words: &Words, it: &mut TransferRequest| {
        words.averages(&mut it.averaging, &mut it.gaps);
        words.set("from", &mut it.from);
        words.set("to", &mut it.to);
        words.set("lag", &mut it.lag);
        words.set("resamplings", &mut it.resamplings);
        it.highest = words.number("highest");
        it.threads = words.number("threads");
    };
    asked(words, shots, estimates::transfer, take)
}

/// `laws=monatomic|diatomic`, each without blanks; `points=4 significance=0 memory=100`.
pub fn ridges<'f>(words: &str, shots: impl Shots<'f>) -> Found<Ridges> {
    let take = |words: &Words, it: &mut RidgesRequest| {
        it.segment = words.number("segment");
        words.set("window", &mut it.window_time);
        words.set("space-window", &mut it.window_space);
        words.set("significance", &mut it.alpha);
        words.set("points", &mut it.fewest);
        it.memory = words.number("memory");
        let laws = words.value("laws").map(|laws| laws.split('|'));
        let laws = laws.into_iter().flatten();
        it.laws = laws.map(|law| RidgeLaw::parse(law).unwrap()).collect();
    };
    asked(words, shots, ridges::ridges, take)
}

/// What an estimate says: its first line, the numbers of its summary, its arrays by name, further dimensions than the first side by side.
pub struct Seen {
    pub answer: String,
    pub numbers: Value,
    pub arrays: BTreeMap<String, Array2<f64>>,
}

impl Seen {
    fn of(result: &dyn Describe) -> Seen {
        let sheet = result.describe();
        let arrays = sheet.variables.iter().map(|variable| {
            let rows = variable.dimensions.first().map_or(1, |(_, length)| *length);
            let shape = (rows, variable.values.len() / rows.max(1));
            let values = Array2::from_shape_vec(shape, variable.values.to_vec());
            (variable.name.clone(), values.unwrap())
        });
        let mut arrays: BTreeMap<_, _> = arrays.collect();
        if let Some(high) = arrays.get("jackknife_high") {
            let half = (high / &arrays["spectrum"]).ln();
            arrays.insert("jackknife".into(), half);
        }
        Seen {
            arrays,
            answer: sheet.answer,
            numbers: sheet.numbers.into(),
        }
    }

    /// An array, one column of it (`structure:1`), or the numbers at a place of the summary (`/level`), `null` as NaN.
    #[track_caller]
    pub fn array(&self, name: &str) -> Array2<f64> {
        if name.starts_with('/') {
            let found = flat(self.numbers.pointer(name).unwrap_or(&Value::Null));
            return Array2::from_shape_vec((found.len(), 1), found).unwrap();
        }
        if let Some((name, column)) = name.split_once(':') {
            let column = column.parse().unwrap();
            return self.array(name).select(Axis(1), &[column]);
        }
        let found = self.arrays.get(name);
        let names = self.arrays.keys();
        found
            .unwrap_or_else(|| panic!("no {name} of {names:?}"))
            .clone()
    }
}

/// All numbers of a value, in their order; `null` is NaN.
pub fn flat(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(list) => list.iter().flat_map(flat).collect(),
        one => vec![one.as_f64().unwrap_or(f64::NAN)],
    }
}

/// Any estimate: its name and options.
pub fn seen<'f>(words: &str, shots: impl Shots<'f>) -> Found<Seen> {
    let (name, words) = words.split_once(' ').unwrap_or((words, ""));
    let result: Box<dyn Describe> = match name {
        "spectrum" => Box::new(spectrum(words, shots)?),
        "coherence" => Box::new(coherence(words, shots)?),
        "bicoherence" => Box::new(bicoherence(words, shots)?),
        "modes" => Box::new(modes(words, shots)?),
        "spacetime" => Box::new(spacetime(words, shots)?),
        "increments" => Box::new(increments(words, shots)?),
        "slope" => Box::new(slope(words, shots)?),
        "transfer" => Box::new(transfer(words, shots)?),
        "ridges" => Box::new(ridges(words, shots)?),
        _ => panic!("{name}"),
    };
    Ok(Seen::of(&result))
}
