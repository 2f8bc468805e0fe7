//! Which sites can feel a force soon: the others fly freely or have not been reached.
//!
//! A contact that is open now and cannot close within the horizon carries no force, and the sites
//! it parts need not be stepped together. What is left are islands: runs of contacts that press or
//! may, with an open guard contact at each end. A guard that pressed during a step tells that the
//! horizon was misjudged: the step is then repeated on new islands, so that the result has the
//! same bits as that of the whole chain.

use std::ops::Range;

use super::super::law::Kernel;
use super::system::{State, System};

/// A run of contacts stepped together.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Island {
    pub(super) contacts: Range<usize>,
    /// Whether the first, and the last, contact is a guard.
    pub(super) guards: [bool; 2],
}

impl Island {
    /// Places from the left of the first contact to the right of the last one.
    pub(super) fn places(&self) -> Range<usize> {
        self.contacts.start..self.contacts.end + 1
    }
}

/// What of the chain is stepped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Window {
    /// Only where a force acts or may act soon.
    #[default]
    Active,
    /// The whole chain, for comparison: the same bits, more work.
    Whole,
}

#[derive(Debug, Clone)]
pub(super) struct Islands {
    pub(super) window: Window,
    pub(super) active: Vec<Island>,
    /// One past the last place that may move before the next survey.
    pub(super) reached: usize,
    /// Contacts ahead of the front that are stepped along.
    ahead: usize,
}

impl Islands {
    pub(super) fn new(window: Window, ahead: usize) -> Islands {
        Islands {
            window,
            active: Vec::new(),
            reached: 0,
            ahead,
        }
    }

    /// Finds the islands that hold for the time `horizon`, wider ones with more caution.
    pub(super) fn survey<K: Kernel>(
        &mut self,
        system: &System<K>,
        state: &State,
        horizon: f64,
        caution: f64,
    ) {
        let horizon = caution * horizon;
        let ahead = (caution * self.ahead as f64) as usize;
        let all = system.contacts.clone();
        self.active.clear();
        if self.window == Window::Whole || system.periodic {
            self.reached = system.places();
            if !all.is_empty() {
                self.active.push(Island {
                    contacts: all,
                    guards: [false; 2],
                });
            }
            return;
        }
        let State { x, v, a, .. } = state;
        let moved = (0..system.places())
            .rev()
            .find(|&s| x[s] != 0.0 || v[s] != 0.0);
        let front = moved.map_or(0, |place| place + 1);
        self.reached = (front + ahead).min(system.places());
        let end = (front + ahead).min(all.end);
        let opens = system.kernel.opening_power().is_some() && system.losses.drag == 0.0;
        if !opens || system.static_overlap[all.start] > 0.0 {
            self.push(all.start..end, &all);
            return;
        }
        let mut run: Option<Range<usize>> = None;
        for i in all.start..end {
            let (left, right) = (i, i + 1);
            let reach = horizon * (v[left] - v[right]).max(0.0) * 1.01
                + horizon * horizon * (a[left].abs() + a[right].abs());
            let slack = x[left].abs() + x[right].abs() + horizon * (v[left].abs() + v[right].abs());
            let driven = i == 0 && system.drive.is_some();
            if system.overlap(i, x) + reach < -4.0 * f64::EPSILON * slack && !driven {
                continue;
            }
            match &mut run {
                Some(run) if i <= run.end + 2 => run.end = i + 1,
                Some(done) => {
                    let done = done.clone();
                    self.push(done, &all);
                    run = Some(i..i + 1);
                }
                None => run = Some(i..i + 1),
            }
        }
        if let Some(run) = run {
            self.push(run, &all);
        }
    }

    fn push(&mut self, run: Range<usize>, all: &Range<usize>) {
        let guards = [run.start > all.start, run.end < all.end];
        self.active.push(Island {
            contacts: run.start - usize::from(guards[0])..run.end + usize::from(guards[1]),
            guards,
        });
    }

    /// The places up to the front that belong to no island, in order.
    pub(super) fn gaps(&self) -> impl Iterator<Item = Range<usize>> {
        let starts = std::iter::once(0).chain(self.active.iter().map(|i| i.places().end));
        let ends = self
            .active
            .iter()
            .map(|i| i.places().start)
            .chain(std::iter::once(self.reached));
        starts.zip(ends).filter(|(s, e)| s < e).map(|(s, e)| s..e)
    }

    /// The contacts that belong to no island, in order.
    pub(super) fn shut(&self, contacts: usize) -> impl Iterator<Item = Range<usize>> {
        let starts = std::iter::once(0).chain(self.active.iter().map(|i| i.contacts.end));
        let ends = self
            .active
            .iter()
            .map(|i| i.contacts.start)
            .chain(std::iter::once(contacts));
        starts.zip(ends).map(|(s, e)| s..e)
    }
}
