//! Working spaces that are handed on.

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, PoisonError};

/// Working spaces of threads that are done, for those to come: new memory costs a fault a page.
#[derive(Debug)]
pub struct ScratchPool<T>(Mutex<Vec<T>>);

impl<T> Default for ScratchPool<T> {
    fn default() -> Self {
        ScratchPool(Mutex::default())
    }
}

impl<T> ScratchPool<T> {
    /// A pooled one that `fits`, else a new one; dropping the guard returns it to the pool.
    pub fn take(&self, fits: impl Fn(&T) -> bool, new: impl FnOnce() -> T) -> ScratchGuard<'_, T> {
        let mut spare = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let at = spare.iter().position(fits);
        let found = at.map(|at| spare.swap_remove(at));
        drop(spare);
        ScratchGuard {
            space: Some(found.unwrap_or_else(new)),
            spare: self,
        }
    }
}

/// A scratch that returns to its pool when dropped.
#[derive(Debug)]
pub struct ScratchGuard<'a, T> {
    space: Option<T>,
    spare: &'a ScratchPool<T>,
}

impl<T> Deref for ScratchGuard<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.space.as_ref().expect("there until the drop")
    }
}

impl<T> DerefMut for ScratchGuard<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        self.space.as_mut().expect("there until the drop")
    }
}

impl<T> Drop for ScratchGuard<'_, T> {
    fn drop(&mut self) {
        let mut spare = self.spare.0.lock().unwrap_or_else(PoisonError::into_inner);
        spare.extend(self.space.take());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_dropped_is_taken_again_if_it_fits() {
        let spare = ScratchPool::default();
        let take = |least: usize, new: usize| spare.take(move |&old| old >= least, || new);
        let (mut first, second) = (take(0, 3), take(0, 5));
        *first += 1;
        drop((first, second));
        assert_eq!(*take(5, 9), 5);
        assert_eq!(*take(6, 7), 7);
        let (a, b, c) = (take(0, 0), take(0, 0), take(0, 0));
        let mut found = [*a, *b, *c];
        found.sort_unstable();
        assert_eq!(found, [4, 5, 7]);
    }
}
