//! Sites that can experience a force soon; the others fly freely or are still at rest.
//!
//! A contact that is open now and cannot close within the horizon carries no force, so the sites on
//! its two sides need not be stepped together. The rest are islands: ranges of contacts that press
//! or may press, rounded up to whole blocks, with an open guard contact at each end. If a guard
//! presses during a step, the horizon was too long. The step is then repeated on new islands, so
//! that the result has the same bits as that of the whole chain.

use std::ops::Range;

use super::super::law::Kernel;
use super::system::{State, System};
use crate::numeric::lanes::{AlignedRow, LaneBlock, Lanes, SimdKernel, WIDTH, widest};

/// Blocks of places stepped together, with the contacts between them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Island {
    pub(super) blocks: Range<usize>,
    /// Whether the first, and the last, contact is a guard.
    guards: [bool; 2],
}

impl Island {
    /// Its blocks of a row.
    #[inline(always)]
    pub(super) fn of<'a>(&self, row: &'a AlignedRow) -> &'a [LaneBlock] {
        &row.0[self.blocks.clone()][..self.blocks.len()]
    }

    #[inline(always)]
    pub(super) fn of_mut<'a>(&self, row: &'a mut AlignedRow) -> &'a mut [LaneBlock] {
        &mut row.0[self.blocks.clone()][..self.blocks.len()]
    }

    pub(super) fn places(&self) -> Range<usize> {
        WIDTH * self.blocks.start..WIDTH * self.blocks.end
    }

    pub(super) fn is_guard(&self, contact: usize) -> bool {
        let Range { start, end } = self.places();
        (self.guards[0] && contact == start + 1) || (self.guards[1] && contact == end - 1)
    }

    /// Whether a guard pressed.
    #[inline(always)]
    pub(super) fn leaks(&self, force: &[f64]) -> bool {
        let Range { start, end } = self.places();
        (self.guards[0] && force[start + 1] != 0.0) || (self.guards[1] && force[end - 1] != 0.0)
    }
}

/// What of the chain is stepped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SteppedSites {
    /// Only where a force acts or may act soon.
    #[default]
    Active,
    /// The whole chain, for comparison: the same bits, more work.
    Whole,
}

#[derive(Debug, Clone)]
pub(super) struct Islands {
    window: SteppedSites,
    pub(super) active: Vec<Island>,
    /// The places that move and belong to no island, in order.
    pub(super) gaps: Vec<Range<usize>>,
    masks: Vec<u8>,
    /// Contacts ahead of the front that are stepped along.
    ahead: usize,
    /// The places from here on have never moved, and their contacts carry no force.
    pub(super) at_rest: usize,
}

impl Islands {
    pub(super) fn new(window: SteppedSites, ahead: usize) -> Islands {
        Islands {
            window,
            active: Vec::new(),
            gaps: Vec::new(),
            masks: Vec::new(),
            ahead,
            at_rest: usize::MAX,
        }
    }

    /// Forgets which places have moved.
    pub(super) fn forget(&mut self) {
        self.at_rest = usize::MAX;
    }

    /// Finds the islands that hold for the time `horizon`, wider ones with more caution.
    pub(super) fn survey<K: Kernel>(
        &mut self,
        system: &System<K>,
        state: &State,
        horizon: f64,
        caution: f64,
    ) {
        let places = system.places();
        let front = (0..places.min(self.at_rest))
            .rev()
            .find(|&s| state.x[s] != 0.0 || state.v[s] != 0.0)
            .map_or(0, |last| last + 1);
        let front = front.max(system.driven().map_or(0, |place| place + 1));
        let ahead = (caution * self.ahead as f64) as usize;
        let reached = front.saturating_add(ahead).min(places);
        // Islands may end two places farther, and end with a whole block.
        self.at_rest = (reached + 2).next_multiple_of(WIDTH).min(places) + WIDTH;
        self.active.clear();
        self.gaps.clear();
        let opens = system.all_open && system.losses.drag == 0.0 && system.ground.is_none();
        // The resonators of a front are far from it in rows.
        if self.window == SteppedSites::Whole || system.periodic || system.resonators.is_some() {
            self.push(0..places, places);
        } else if !opens || system.static_overlap[system.contacts.start] > 0.0 {
            self.push(0..reached, places);
        } else {
            self.survey_open(system, state, caution * horizon, reached);
        }
        let mut flying = 0;
        for island in &self.active {
            let places = island.places();
            if flying < places.start {
                self.gaps.push(flying..places.start);
            }
            flying = places.end;
        }
        if flying < reached {
            self.gaps.push(flying..reached);
        }
    }

    fn survey_open<K: Kernel>(
        &mut self,
        system: &System<K>,
        state: &State,
        horizon: f64,
        reached: usize,
    ) {
        let mut masks = std::mem::take(&mut self.masks);
        widest(Reaches {
            system,
            x: &state.x,
            v: &state.v,
            force: &state.force,
            horizon,
            blocks: reached.div_ceil(WIDTH),
            masks: &mut masks,
        });
        if system.drives_end() {
            masks[0] |= 2;
        }
        if let Some(place) = system.driven() {
            // A drive changes how soon its contacts close.
            for contact in [place, place + 1] {
                masks[contact / WIDTH] |= 1 << (contact % WIDTH);
            }
        }
        let places = system.places();
        let mut run: Option<Range<usize>> = None;
        for (b, mask) in masks.iter().enumerate().filter(|(_, mask)| **mask != 0) {
            let first = WIDTH * b + mask.trailing_zeros() as usize;
            let last = WIDTH * b + mask.ilog2() as usize;
            // The contacts beside these are the guards.
            let around = first.saturating_sub(2)..(last + 2).min(places);
            match &mut run {
                Some(run) if around.start <= run.end + WIDTH => run.end = around.end,
                _ => {
                    if let Some(done) = run.replace(around) {
                        self.push(done, places);
                    }
                }
            }
        }
        self.masks = masks;
        if let Some(run) = run {
            self.push(run, places);
        }
    }

    /// Adds the blocks that hold these places.
    fn push(&mut self, run: Range<usize>, places: usize) {
        let blocks = run.start / WIDTH..run.end.div_ceil(WIDTH);
        if let Some(last) = self.active.last_mut()
            && blocks.start <= last.blocks.end
        {
            last.blocks.end = last.blocks.end.max(blocks.end);
            last.guards[1] = WIDTH * last.blocks.end < places;
            return;
        }
        let guards = [blocks.start > 0, WIDTH * blocks.end < places];
        self.active.push(Island { blocks, guards });
    }

    /// Contacts in islands, those that pad them included.
    pub(super) fn contacts(&self) -> u64 {
        let contacts = |island: &Island| (WIDTH * island.blocks.len()) as u64;
        self.active.iter().map(contacts).sum()
    }

    /// The contacts before this one that belong to no island, in order.
    pub(super) fn shut(&self, contacts: usize) -> impl Iterator<Item = Range<usize>> {
        // The contact on the left of an island's first place is outside it.
        let starts = std::iter::once(0).chain(self.active.iter().map(|i| i.places().end));
        let starts_of_islands = self.active.iter().map(|i| i.places().start);
        let ends = starts_of_islands.chain(std::iter::once(contacts));
        starts.zip(ends).map(|(s, e)| s..e.max(s))
    }
}

/// Names the contacts that press, or may within the time `horizon`, a mask for each block.
struct Reaches<'a, K> {
    system: &'a System<K>,
    x: &'a AlignedRow,
    v: &'a AlignedRow,
    force: &'a AlignedRow,
    horizon: f64,
    blocks: usize,
    masks: &'a mut Vec<u8>,
}

impl<K: Kernel> SimdKernel for Reaches<'_, K> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let zero = L::splat(0.0);
        let (horizon, squared) = (
            L::splat(self.horizon * 1.01),
            L::splat(self.horizon * self.horizon),
        );
        let rounding = L::splat(4.0 * f64::EPSILON);
        let mut before = [zero; 3];
        self.masks.clear();
        let mut here = L::load(&self.force.0[0]);
        for b in 0..self.blocks {
            let after = self.force.0.get(b + 1).map_or(zero, L::load);
            let mobility = L::load(&self.system.mobility.0[b]);
            let acceleration = (mobility * (here - here.take_right(after))).abs();
            here = after;
            let (x, v) = (L::load(&self.x.0[b]), L::load(&self.v.0[b]));
            let (xl, vl) = (x.take_left(before[0]), v.take_left(before[1]));
            let bend = acceleration.take_left(before[2]) + acceleration;
            before = [x, v, acceleration];
            let overlap = L::load(&self.system.static_overlap.0[b]) + (xl - x);
            let closing = (vl - v).positive();
            let slack = xl.abs() + x.abs() + horizon * (vl.abs() + v.abs());
            let latest = overlap + horizon * closing + squared * bend + rounding * slack;
            // Touching contacts may press: only contacts that are certainly open are left out.
            let open = (zero - latest).positive_mask();
            let exists = L::load(&self.system.coefficient.0[b]).positive_mask();
            self.masks.push(exists & !open);
        }
    }
}
