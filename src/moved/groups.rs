//! What groups of sites say, in each kind of window.

use super::along_x::{AlongX, Options};
use super::share::{Grid, Group, Moved, Share};
use super::windows::Windows;
use super::{Evidence, KEEPS, Movement, Part, Reason, Verdict, seen};

/// Sites of a group.
pub(super) const NEIGHBOURS: usize = 4;
/// Groups without which nothing is compared.
pub(super) const FEWEST: usize = 2;
/// Ratio of the parts of the energy that windows hold, at the last and the first group, below which a wave spreads out of them.
const SPREADS_OUT: f64 = 0.85;
/// The same of all energy, that below the resolution of the windows too.
const HOLDS_ALL: f64 = 0.95;
/// Part of the energy of a window of twice the length that a window may miss and hold all of the wave.
const HOLDS: f64 = 0.03;
/// Part of a window by which a share that falls comes later at the last group than at the first, if the rest of it follows behind; and
/// by which it does more than the others, since a pulse that absorption lengthens is seen earlier.
const LATER: f64 = 0.28;
const THAN_OTHERS: f64 = 0.1;
/// Part of its first energy that a front holds as long as it is followed.
const FOLLOWED: f64 = 0.3;
/// Bodies of the longest launch.
const LAUNCH: usize = 13;
/// Bodies over which a front that has formed and keeps its energy is followed, at least; one that loses energy; and bodies
/// after which one that has not formed is said not to.
const TRAVEL: usize = 8;
const LOSING: usize = 20;
const NEVER: usize = 2 * LAUNCH;
/// Bodies over which nothing is said of waves that go on.
const FEW: usize = LAUNCH + NEVER;
/// The kind of window that fades, of those of a struck chain.
const FADING: usize = 3;

/// Sites in groups of `size`, at most `most` of them, spread evenly.
pub(super) fn grouped(sites: &[usize], size: usize, most: usize) -> Vec<Vec<usize>> {
    let groups: Vec<&[usize]> = sites.chunks_exact(size).collect();
    let count = groups.len().min(most);
    (0..count)
        .map(|i| match count {
            1 => groups[0].to_vec(),
            _ => groups[i * (groups.len() - 1) / (count - 1)].to_vec(),
        })
        .collect()
}

/// Sites of a group, of `sites` that can be compared: a tenth of few.
pub(super) fn group_size(sites: usize, pairs: bool) -> usize {
    match sites / 10 {
        0 | 1 if pairs => 2,
        0 | 1 => 1,
        2 | 3 => 2,
        _ => NEIGHBOURS,
    }
}

/// Groups by kind of window: flat ones of the length, its half and its double; of a struck chain the same fading; the tail.
pub(super) struct Found<'a> {
    pub options: &'a Options,
    pub kinds: &'a [Windows],
    pub groups: Vec<Vec<Group>>,
    pub sense: f64,
}

impl Found<'_> {
    fn between(&self, kind: usize, a: usize, b: usize) -> Movement {
        let groups = &self.groups[kind];
        let upper = &self.kinds[kind].grid.upper;
        let place = |group: &Group| self.options.place(group);
        let [a, b] = [&groups[a], &groups[b]];
        let movement = Movement::between(a, b, upper, self.options.tolerance, &place);
        match self.options.is_simulated() {
            // A pulse that becomes longer loses none of its energy below the resolution of the windows.
            true => Movement {
                energy_ratio: b.with_drift() / a.with_drift(),
                ..movement
            },
            false => movement,
        }
    }

    fn moved(&self, kind: usize, a: usize, b: usize) -> Moved {
        Moved::between(&self.groups[kind][a], &self.groups[kind][b])
    }

    /// Withdraws what other windows (by kind) do not say.
    fn checked_by_windows(
        &self,
        kind: usize,
        (a, b): (usize, usize),
        others: &[usize],
        movement: Movement,
    ) -> Movement {
        let tolerance = self.options.tolerance;
        let (verdict, groups) = (movement.verdict, &self.groups[kind]);
        if verdict == Verdict::Unchanged && movement.bound > 6.0 * tolerance {
            let bound = movement.bound;
            return movement.but_untold(Reason::Errors { bound });
        }
        let holds = |row: [usize; 2]| {
            let twice = self.groups[2].iter().find(|group| group.rows == row);
            let main = groups.iter().find(|group| group.rows == row);
            let held = twice
                .zip(main)
                .map(|(twice, main)| main.energy / twice.energy);
            held.is_some_and(|held| (held - 1.0).abs() < HOLDS)
        };
        // Half a window cuts off what a whole one holds.
        let is_whole = kind == 0 && [a, b].iter().all(|&group| holds(groups[group].rows));
        for &other in others.iter().filter(|other| **other != 1 || !is_whole) {
            let at = |rows: [usize; 2]| self.groups[other].iter().position(|g| g.rows == rows);
            let same = at(groups[a].rows).zip(at(groups[b].rows));
            let moved = same.map(|(a, b)| self.moved(other, a, b));
            let is_resolved =
                |row: [usize; 2]| at(row).is_none_or(|i| self.groups[other][i].is_resolved());
            let moved = moved.filter(|_| [a, b].iter().all(|&i| is_resolved(groups[i].rows)));
            if let Some(moved) = moved.filter(|moved| !moved.agrees(verdict, tolerance)) {
                let (up, down) = (moved.up.share, moved.down.share);
                return movement.but_untold(Reason::Windows { up, down });
            }
        }
        movement
    }

    /// Withdraws what neither other windows (by kind) nor the groups beside say.
    fn checked(
        &self,
        kind: usize,
        (a, b): (usize, usize),
        others: &[usize],
        movement: Movement,
    ) -> Movement {
        let movement = self.checked_by_windows(kind, (a, b), others, movement);
        let groups = &self.groups[kind];
        if groups.len() < 4 {
            return movement;
        }
        let beside = [
            (a + 1, b),
            (a, b - 1),
            (a.saturating_sub(1), b),
            (a, (b + 1).min(groups.len() - 1)),
        ];
        for (a, b) in beside.into_iter().filter(|(a, b)| a < b) {
            let moved = self.moved(kind, a, b);
            if !moved.agrees(movement.verdict, self.options.tolerance) {
                let (up, down) = (moved.up.share, moved.down.share);
                return movement.but_untold(Reason::Neighbours { up, down });
            }
        }
        movement
    }

    fn evidence(&self, kind: usize, compared: [usize; 2]) -> Evidence {
        let place = |group: &Group| self.options.place(group);
        Evidence::new(
            &self.kinds[kind].grid.upper,
            &self.groups[kind],
            compared,
            &place,
        )
    }

    /// From the first group to the last.
    pub fn of_field(&self, tail: Option<usize>) -> AlongX {
        let last = self.groups[0].len() - 1;
        let mut movement = self.checked(0, (0, last), &[1, 2], self.between(0, 0, last));
        if self.sense == 0.0 {
            (movement.transfer, movement.energy_ratio) = (None, f64::NAN);
        }
        let moves = !matches!(movement.verdict, Verdict::Unchanged | Verdict::Untold);
        // What arrives later than a window lasts is missing: the rest may then seem to have grown a little.
        let gained = self.gained_below(last, movement.down_at);
        if movement.transfer == Some(true)
            && movement.verdict == Verdict::Down
            && gained < 0.5 * movement.down
        {
            movement.transfer = Some(false);
        }
        if moves && (self.spreads_out() || self.falls_behind(last, &movement)) {
            (movement.transfer, movement.lags) = (None, true);
        }
        let groups = &self.groups[0];
        if self.options.is_simulated() && groups[last].bodies_from(&groups[0]) < FEW {
            movement = self.in_short_chain(movement);
        }
        let mut along = AlongX {
            movement,
            evidence: Some(self.evidence(0, [0, last])),
            ..AlongX::untold(Reason::NoEnergy)
        };
        // Of an array into which waves of several origins run, no part is a tail.
        if let Some(tail) = tail.filter(|_| self.sense != 0.0) {
            self.add_tail(&mut along, (0, 0..last + 1), tail);
        }
        along
    }

    /// Energy that the last group has more than the first below a frequency, over that of the fainter one.
    fn gained_below(&self, last: usize, edge: f64) -> f64 {
        let upper = &self.kinds[0].grid.upper;
        let at = upper.partition_point(|upper| *upper < edge);
        let [a, b] = [0, last].map(|group| &self.groups[0][group]);
        match at < upper.len() {
            true => (b.below(at)[0] - a.below(at)[0]) / a.energy.min(b.energy),
            false => 0.0,
        }
    }

    /// Whether windows hold less and less of the energy of those of twice the length (or those of half of theirs, where the
    /// former do not fit): a wave that disperses leaves its window, slow frequencies first, which are not lost.
    fn spreads_out(&self) -> bool {
        let [window, half, twice] = [0, 1, 2].map(|kind| &self.groups[kind]);
        let [short, long] = match twice.len() >= FEWEST {
            true => [window, twice],
            false => [half, window],
        };
        let held = |group: Option<&Group>, of: &dyn Fn(&Group) -> f64| {
            let group = group?;
            let same = short.iter().find(|one| one.rows == group.rows)?;
            Some(of(same) / of(group))
        };
        let falls = |most: f64, of: &dyn Fn(&Group) -> f64| {
            let ends = held(long.first(), of).zip(held(long.last(), of));
            ends.is_some_and(|(first, last)| last < most * first)
        };
        // A pulse that absorption lengthens falls below the resolution of a window, not out of it.
        falls(SPREADS_OUT, &|group| group.energy) && falls(HOLDS_ALL, &Group::with_drift)
    }

    /// Whether the frequencies whose share falls come later and later in their windows, more than others: what is missing of them follows behind, or
    /// comes after the record. Absorption takes them where they are.
    fn falls_behind(&self, last: usize, movement: &Movement) -> bool {
        let upper = &self.kinds[0].grid.upper;
        let after = |edge: f64| upper.partition_point(|upper| *upper <= edge);
        let falls = match (movement.verdict, movement.transfer) {
            // Which end is later is not known.
            _ if self.sense == 0.0 => return false,
            (Verdict::Down, _) => after(movement.down_at)..upper.len(),
            (Verdict::Up, Some(false)) => 0..after(movement.up_at),
            (Verdict::Spreads, Some(false)) => after(movement.down_at)..after(movement.up_at),
            _ => return false,
        };
        let later = |of: std::ops::Range<usize>| {
            let [first, last] = [0, last].map(|group| self.groups[0][group].delay(of.clone()));
            (last - first) / self.kinds[0].samples as f64
        };
        let all = later(0..upper.len());
        let falls = later(falls);
        falls > LATER && falls - all > THAN_OTHERS
    }

    pub fn of_struck_chain(&self, tail: Option<usize>) -> AlongX {
        let tolerance = self.options.tolerance;
        let groups = &self.groups[FADING];
        let last = groups.len() - 1;
        let later = |a: usize| (a + 1..=last).map(move |b| self.moved(FADING, a, b));
        let is_formed = |&a: &usize| later(a).all(|moved| moved.most() < tolerance);
        match (0..last.div_ceil(2))
            .find(is_formed)
            .filter(|&formed| !self.sheds(formed, last))
        {
            Some(formed) => {
                let mut movement = self.between(FADING, formed, last);
                let bound = later(formed).map(|moved| moved.bound()).fold(0.0, f64::max);
                (movement.verdict, movement.transfer) = (Verdict::Unchanged, None);
                movement.bound = bound;
                movement.settled_at = movement.from.map(|place| place.rows[0]);
                // Groups beside have been compared, and those before are the launch.
                let mut movement =
                    self.checked_by_windows(FADING, (formed, last), &[4, 5], movement);
                let least = match movement.energy_ratio > KEEPS {
                    true => TRAVEL,
                    false => LOSING,
                };
                if groups[last].bodies_from(&groups[formed]) < least {
                    movement.settled_at = None;
                    movement = self.in_short_chain(movement);
                }
                let launch = self.between(FADING, 0, formed.max(1));
                let mut along = AlongX {
                    movement,
                    launch: Some(launch),
                    evidence: Some(self.evidence(FADING, [0, formed.max(1)])),
                    ..AlongX::untold(Reason::NoEnergy)
                };
                if let Some(tail) = tail {
                    self.add_tail(&mut along, (0, formed..last + 1), tail);
                }
                along
            }
            None => self.of_unsettled(tail),
        }
    }

    /// Whether a front whose content has settled loses most of its energy to what follows it: half of its own is gone, and a
    /// fifth of that of the window lies behind it.
    fn sheds(&self, formed: usize, last: usize) -> bool {
        let [flat, fading] = [&self.groups[0], &self.groups[FADING]];
        let end = &fading[last];
        let window = flat.iter().find(|group| group.rows == end.rows);
        let behind = window.is_some_and(|window| end.energy < 0.8 * window.energy);
        behind && end.energy < 0.5 * fading[formed].energy
    }

    /// The launch and what follows it are not told apart.
    fn in_short_chain(&self, movement: Movement) -> Movement {
        let groups = &self.groups[0];
        let bodies = groups[groups.len() - 1].bodies_from(&groups[0]);
        movement.but_untold(Reason::ShortChain { bodies })
    }

    /// The front never forms: it is followed while it holds three tenths of its energy.
    fn of_unsettled(&self, tail: Option<usize>) -> AlongX {
        let groups = &self.groups[0];
        let held = |group: &Group| group.with_drift() >= FOLLOWED * groups[0].with_drift();
        let end = (1..groups.len())
            .take_while(|&b| held(&groups[b]))
            .last()
            .unwrap_or(1);
        let mut movement = self.between(0, 0, end);
        // What the front loses is in its tail: it keeps its low frequencies, and none are gained.
        let follows = || tail.is_some_and(|tail| self.follows((0, end), tail, movement.down));
        movement.lags =
            movement.verdict == Verdict::Down && (movement.transfer != Some(true) || follows());
        if movement.energy_ratio < 0.9 || movement.lags {
            movement.transfer = None;
        }
        let mut movement = self.checked(0, (0, end), &[1, 2], movement);
        if groups[groups.len() - 1].bodies_from(&groups[0]) < NEVER {
            movement = self.in_short_chain(movement);
        }
        let mut along = AlongX {
            movement,
            evidence: Some(self.evidence(0, [0, end])),
            ..AlongX::untold(Reason::NoEnergy)
        };
        if let Some(tail) = tail {
            self.add_tail(&mut along, (0, end..end + 1), tail);
        }
        along
    }

    /// Whether most of the share that moved `down` in the front is in what follows it: front and tail together have kept their
    /// spectrum, as linear waves do.
    fn follows(&self, (a, b): (usize, usize), tail: usize, down: f64) -> bool {
        let [fine, coarse] = [&self.kinds[tail].grid, &self.kinds[0].grid];
        let together = |front: &Group| {
            let rows = front.rows;
            let behind = self.groups[tail].iter().find(|tail| tail.rows == rows)?;
            Some(front.on(coarse, fine).and(behind))
        };
        let whole = |mut groups: std::ops::RangeInclusive<usize>, is_first: bool| match is_first {
            true => groups.find_map(|g| together(&self.groups[0][g])),
            false => groups.rev().find_map(|g| together(&self.groups[0][g])),
        };
        let ends = whole(a..=b, true).zip(whole(a..=b, false));
        ends.is_some_and(|(first, last)| Moved::between(&first, &last).down.share < 0.5 * down)
    }

    /// The front and what it leaves behind, at the groups of `kind` in a range that both have.
    fn add_tail(
        &self,
        along: &mut AlongX,
        (kind, range): (usize, std::ops::Range<usize>),
        tail: usize,
    ) {
        let both = self.groups[kind][range].iter().filter_map(|front| {
            let tail = self.groups[tail]
                .iter()
                .find(|tail| tail.rows == front.rows)?;
            Some((front, tail))
        });
        let both: Vec<(&Group, &Group)> = both.collect();
        // A front in the middle of the range, where it has formed and its tail is long.
        let Some(&(front, behind)) = both.get(both.len() / 2) else {
            return;
        };
        let [fine, coarse] = [&self.kinds[tail].grid, &self.kinds[kind].grid];
        let on_tail = front.on(coarse, fine);
        let against = Moved::between(&on_tail, behind);
        let first = Moved::between(&self.groups[kind][0], front);
        let all = front.energy + behind.energy;
        let part = |group: &Group, grid: &Grid, moved: &Moved, upper: &[f64]| {
            let at = |share: &Share| (share.share > 0.0).then(|| upper[share.at]);
            Part {
                energy_share: group.energy / all,
                up: moved.up.share,
                up_at: at(&moved.up),
                down: moved.down.share,
                down_at: at(&moved.down),
                peak_frequency: group.peak(grid),
                band: [group.quantile(grid, 0.1), group.quantile(grid, 0.9)],
            }
        };
        along.front = Some(part(front, coarse, &first, &coarse.upper));
        along.tail = Some(part(behind, fine, &against, &fine.upper));
        if let Some(evidence) = &mut along.evidence {
            let place = |group: &Group| self.options.place(group);
            evidence.tail = Some(seen(&behind.on(fine, coarse), &evidence.upper, &place));
        }
    }
}
