//! What windows at groups of sites say.

use super::along_x::Options;
use super::profile::{Profile, Row, add};
use super::windows::Spectrum;
use super::{Answer, Movement};

/// Part of a move that is left in the whole record, below which what is missing in the windows comes late.
pub(super) const LATE: f64 = 0.5;

/// Part of the energy of a wave that is in the last quarter of a window before the record's end where it has not all come.
const COMES: f64 = 0.1;

/// What a site says; no spectrum where the window does not fit.
pub(super) struct Seen {
    /// When something comes behind the first pulse.
    pub second: Option<usize>,
    pub spectrum: Option<Spectrum>,
    /// What follows the window, to the record's end; what is in the last quarter of a window before it.
    pub rest: Vec<f64>,
    pub last: Vec<f64>,
    /// Energy of the window, that below its resolution too.
    pub energy: f64,
    /// Where its middle lies, in samples of the record.
    pub centre: f64,
    /// By what its squares count.
    pub weight: f64,
}

/// Sites in groups, in the order in which the wave passes them.
pub(super) struct Found<'a> {
    pub options: &'a Options,
    pub groups: Vec<Vec<usize>>,
    pub seen: Vec<Option<Seen>>,
    pub upper: &'a [f64],
}

impl Found<'_> {
    /// Of whole windows; with what follows them, if `is_long`.
    pub fn profile(&self, is_long: bool) -> Profile {
        let row = |&site: &usize| {
            let seen = self.seen[site].as_ref()?;
            let spectrum = seen.spectrum.as_ref()?;
            let mut energy = spectrum.energy.clone();
            if is_long {
                add(&mut energy, &seen.rest);
            }
            energy.iter_mut().for_each(|e| *e *= seen.weight);
            Some(Row::new([site; 2], vec![energy], spectrum.noise.clone()))
        };
        let groups = self.groups.iter();
        let groups = groups.filter_map(|group| group.iter().map(row).collect::<Option<Vec<Row>>>());
        Profile::new(groups.collect(), self.upper, self.options.is_simulated())
    }

    /// What the sites of a group say.
    pub fn of_group(&self, rows: [usize; 2]) -> impl Iterator<Item = &Seen> {
        let mut groups = self.groups.iter();
        let group = groups.find(|group| [group[0], group[group.len() - 1]] == rows);
        let sites = group.into_iter().flatten();
        sites.filter_map(|&site| self.seen[site].as_ref())
    }

    /// Energies of a group, summed over its sites.
    pub fn sum(&self, rows: [usize; 2], of: impl Fn(&Seen) -> &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.upper.len()];
        self.of_group(rows).for_each(|seen| add(&mut sum, of(seen)));
        sum
    }

    /// What moved along x in a field.
    pub fn along_x(&self, profile: &Profile, sense: f64) -> Answer {
        let place = |rows| self.options.place(rows);
        let (mut movement, group) = profile.judge(self.options.tolerance, &place);
        if sense == 0.0 {
            (movement.transfer, movement.energy_ratio) = (None, f64::NAN);
        }
        if movement.moves() && self.is_late(&movement, profile.rows(group)) {
            (movement.transfer, movement.lags) = (None, true);
        }
        Answer {
            frequency: movement,
            along_x: Some(profile.evidence([0, group], &place)),
            ..Answer::default()
        }
    }

    /// Whether what is missing in the windows comes late: less than half of the move is left in the whole record, or what is
    /// missing still comes when the record ends.
    fn is_late(&self, movement: &Movement, rows: [usize; 2]) -> bool {
        let (most, way) = (movement.most(), movement.way());
        let left = self.profile(true).same(rows, way);
        let falls = match way {
            0 => 0..most.interval + 1,
            _ => most.interval + 1..self.upper.len(),
        };
        let energy = |of: Vec<f64>| of[falls.clone()].iter().sum::<f64>();
        let window = self.sum(rows, |seen| {
            seen.spectrum.as_ref().map_or(&[], |of| &of.energy)
        });
        let missing = most.share * window.iter().sum::<f64>();
        let all = energy(window) + energy(self.sum(rows, |seen| &seen.rest));
        let comes = energy(self.sum(rows, |seen| &seen.last)) > COMES * all.max(missing);
        comes || left.is_some_and(|left| left < LATE * most.share)
    }
}
