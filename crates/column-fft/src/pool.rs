//! Scratch that is used again.

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, PoisonError};

/// Scratch of threads that are done, for threads to come: new memory costs a fault a page.
#[derive(Debug)]
pub(crate) struct Pool<T>(Mutex<Vec<Vec<T>>>);

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Pool(Mutex::default())
    }
}

impl<T: Copy + Default> Pool<T> {
    /// Scratch of at least `length` elements, which goes back to the pool when it is dropped.
    pub fn take(&self, length: usize) -> Guard<'_, T> {
        let mut pool = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let at = pool.iter().position(|scratch| scratch.len() >= length);
        let found = at.map(|at| pool.swap_remove(at));
        drop(pool);
        Guard {
            scratch: found.unwrap_or_else(|| vec![T::default(); length]),
            pool: self,
        }
    }
}

/// Scratch that belongs to a pool.
#[derive(Debug)]
pub(crate) struct Guard<'a, T> {
    scratch: Vec<T>,
    pool: &'a Pool<T>,
}

impl<T> Deref for Guard<'_, T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.scratch
    }
}

impl<T> DerefMut for Guard<'_, T> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.scratch
    }
}

impl<T> Drop for Guard<'_, T> {
    fn drop(&mut self) {
        let mut pool = self.pool.0.lock().unwrap_or_else(PoisonError::into_inner);
        pool.push(std::mem::take(&mut self.scratch));
    }
}
