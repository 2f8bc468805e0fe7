//! Ways in which a file can fail to be what its format promises.

/// One such way, with what was expected and what was found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InputFault {
    #[error("expected samples, found an empty file")]
    Empty,
}

impl InputFault {
    /// What the user can do about it.
    pub fn advice(&self) -> Option<String> {
        match self {
            InputFault::Empty => None,
        }
    }
}
