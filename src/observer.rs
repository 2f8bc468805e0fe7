//! How long work tells its caller where it stands, and is told to stop.

/// Watches a run. Called from worker threads; the library itself prints nothing.
pub trait Observer: Sync {
    /// A stage begins; `units` of work lie ahead in it.
    fn stage(&self, _name: &'static str, _units: u64) {}

    /// `units` of the stage's work are done.
    fn advance(&self, _units: u64) {}

    /// Asked between blocks; `true` ends the run with [`crate::Error::Cancelled`].
    fn cancelled(&self) -> bool {
        false
    }
}

/// An observer that does not look.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Observer for Silent {}

/// Forwards the question whether to stop, and no progress: for parts of a stage that the caller
/// counts as one unit.
pub(crate) struct CancelOnly<'a>(pub(crate) &'a dyn Observer);

impl Observer for CancelOnly<'_> {
    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}
