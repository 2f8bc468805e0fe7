//! Why a verdict cannot be given, and what would give one.

/// Why it cannot be told what moved.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Reason {
    NoEnergy,
    /// Too few sites in a row that the wave passes.
    FewSites,
    /// The record begins in the middle of the motion, ends before the wave has passed, or holds few periods of it.
    ShortRecord,
    /// Moves up to this share are not told from errors.
    Noise {
        bound: f64,
    },
    /// Waves of several origins, or what comes back, are in the windows.
    Mixed,
    /// Waves are shorter than two distances of the sites (`folds`), or as long as the array.
    Aperture {
        folds: bool,
    },
}

impl Reason {
    /// Stable name, for programs.
    pub fn code(&self) -> &'static str {
        match self {
            Reason::NoEnergy => "no-energy",
            Reason::FewSites => "few-sites",
            Reason::ShortRecord => "short-record",
            Reason::Noise { .. } => "noise",
            Reason::Mixed => "mixed",
            Reason::Aperture { .. } => "aperture",
        }
    }

    /// Stable name, message and advice.
    pub(crate) fn parts(&self) -> (&'static str, String, &'static str) {
        (self.code(), self.message(), self.advice())
    }

    /// The reason, without a full stop.
    pub fn message(&self) -> String {
        match *self {
            Reason::NoEnergy => "nothing moves".into(),
            Reason::FewSites => "there are too few sites in a row".into(),
            Reason::ShortRecord => {
                "the record begins in the middle of the motion, ends before it has passed, or holds few periods of it".into()
            }
            Reason::Noise { bound } if bound < 1.0 => {
                format!("errors hide moves of up to {:.0} %", 100.0 * bound)
            }
            Reason::Noise { .. } => "the wave does not rise far enough above the noise".into(),
            Reason::Mixed => {
                "waves of several origins mix, or what comes back with what arrives".into()
            }
            Reason::Aperture { folds: true } => {
                "wavenumbers fold: waves are shorter than two distances of the sites".into()
            }
            Reason::Aperture { folds: false } => "the wave is as long as the array".into(),
        }
    }

    /// What to record or to ask for instead.
    pub fn advice(&self) -> &'static str {
        match self {
            Reason::NoEnergy => "check the file with `cascade inspect`",
            Reason::FewSites => "record more sites",
            Reason::ShortRecord => "begin before the wave enters, and record longer",
            Reason::Noise { .. } => "average several records, or record longer",
            Reason::Mixed => {
                "record one source at a time, and end with `--times` before it is back"
            }
            Reason::Aperture { folds: true } => "place sites at smaller distances",
            Reason::Aperture { folds: false } => "record a longer stretch of the structure",
        }
    }
}
