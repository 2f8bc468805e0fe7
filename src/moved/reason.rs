//! Why a verdict cannot be given, and what would give one.

/// Why it cannot be told what moved.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Reason {
    NoEnergy,
    /// Too few sites that the wave passes; 0 where some between them are left out.
    FewSites {
        sites: usize,
    },
    /// The record begins in the middle of the motion, ends before the wave has passed, or holds few periods of it: sites that
    /// hold all of it, of those there are.
    ShortRecord {
        whole: usize,
        sites: usize,
    },
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
    /// Of all sites.
    pub(crate) const SHORT: Reason = Reason::ShortRecord { whole: 0, sites: 0 };

    /// Stable name, for programs.
    pub fn code(&self) -> &'static str {
        match self {
            Reason::NoEnergy => "no-energy",
            Reason::FewSites { .. } => "few-sites",
            Reason::ShortRecord { .. } => "short-record",
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
        let percent = |share: f64| format!("{:.0} %", 100.0 * share);
        match *self {
            Reason::NoEnergy => "nothing moves".into(),
            Reason::FewSites { sites: 0 } => "sites are left out".into(),
            Reason::FewSites { sites: 1 } => "there is one site".into(),
            Reason::FewSites { sites } => format!("{sites} sites in a row are too few"),
            Reason::ShortRecord { whole: 0, .. } => {
                "the record begins in the middle of the motion, ends before it has passed, or holds few periods of it".into()
            }
            Reason::ShortRecord { whole, sites } => {
                format!("the record is too short: {whole} of {sites} sites hold all of the wave")
            }
            Reason::Noise { bound } if bound < 1.0 => {
                format!("errors hide moves of up to {}", percent(bound))
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
            Reason::FewSites { .. } => "record more sites",
            Reason::ShortRecord { .. } => "begin before the wave enters, and record longer",
            Reason::Noise { .. } => "average several records, or record longer",
            Reason::Mixed => {
                "record one source at a time, and end with `--times` before it is back"
            }
            Reason::Aperture { folds: true } => "place sites at smaller distances",
            Reason::Aperture { folds: false } => "record a longer stretch of the structure",
        }
    }
}
