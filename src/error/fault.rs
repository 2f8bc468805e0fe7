//! What is wrong with a file, and what mends it.

use std::borrow::Cow;

pub use wavecascade_formats::Error as FormatError;

/// What is wrong, and what mends it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{said}")]
pub struct Fault {
    /// A sentence: what was expected, and what was found.
    pub said: String,
    /// What the user of the program can do; empty where that is not known.
    pub advice: Cow<'static, str>,
}

/// Advice of several faults.
pub(crate) const DAMAGED: &str =
    "the file was damaged or cut short while written or copied; copy or write it again";
pub(crate) const UNFINISHED: &str = "check that the program which wrote the file had finished";
pub(crate) const SIMULATE: &str = "make it anew with `cascade simulate`";
pub(crate) const OTHER_VARIABLE: &str =
    "name one of them with `--variable`; `cascade inspect FILE` lists what is in a file";

impl Fault {
    /// With an advice, which may be empty.
    pub fn new(said: impl Into<String>, advice: impl Into<Cow<'static, str>>) -> Fault {
        Fault {
            said: said.into(),
            advice: advice.into(),
        }
    }

    pub(crate) fn expected(
        expected: impl std::fmt::Display,
        found: impl std::fmt::Display,
        advice: impl Into<Cow<'static, str>>,
    ) -> Fault {
        Fault::new(format!("expected {expected}, found {found}"), advice)
    }

    /// Of a run file without a report that is one.
    pub(crate) fn report(found: impl std::fmt::Display) -> Fault {
        Fault::expected("the report of a run", found, SIMULATE)
    }

    /// Of an array of which a file of that length cannot hold all samples.
    pub(crate) fn overclaimed(claimed: u64, most: u64) -> Fault {
        let expected = format!("at most {most} bytes of samples in a file of this length");
        Fault::expected(expected, format!("an array of {claimed}"), DAMAGED)
    }
}

/// A way in which a file fails to be what its format promises. Those that callers tell apart have their data.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InputFault {
    #[error(
        "expected uniform {axis} steps of {expected}, found {found} before {axis} index {index}"
    )]
    UnevenAxis {
        axis: &'static str,
        index: usize,
        expected: f64,
        found: f64,
    },
    #[error("expected the variable {name:?}, found {}", some_of(variables))]
    NoSuchVariable {
        name: String,
        variables: Vec<String>,
    },
    #[error(transparent)]
    Other(#[from] Fault),
}

impl InputFault {
    /// What the user of the program can do; empty where that is not known.
    pub fn advice(&self) -> &str {
        match self {
            InputFault::UnevenAxis { found, .. } => uneven_advice(*found),
            InputFault::NoSuchVariable { .. } => OTHER_VARIABLE,
            InputFault::Other(fault) => &fault.advice,
        }
    }

    /// The fault of a member of an archive.
    pub(crate) fn within(self, member: &str) -> InputFault {
        let advice = self.advice().to_owned();
        Fault::new(format!("member {member:?}: {self}"), advice).into()
    }
}

/// What can be done about a step of coordinates that is not that of the others.
pub(crate) fn uneven_advice(found: f64) -> &'static str {
    match found > 0.0 && found < f64::INFINITY {
        true => {
            "interpolate to even steps with `--resample cubic`, allow more deviation (`--jitter 5%`), or \
             state `--dt` or `--dx` if the coordinates are approximate"
        }
        false => "coordinates must increase: sort the samples by them, and leave one of equal ones",
    }
}

/// Some of many names.
pub(crate) fn some_of(names: &[String]) -> String {
    const MOST: usize = 12;
    match names.len() {
        0 => "none".into(),
        1..=MOST => names.join(", "),
        all => format!("{} and {} more", names[..MOST].join(", "), all - MOST),
    }
}

pub(crate) fn shape_of(lengths: &[u64]) -> String {
    let lengths: Vec<String> = lengths.iter().map(u64::to_string).collect();
    format!("({})", lengths.join(", "))
}
