//! Fields of trace headers, and which of them is the coordinate of the traces.

use super::layout::{Layout, i16_at, u16_at};
use crate::Sample;

/// What a trace header says in one number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Field {
    /// An integer of four bytes: its path, its place, and that of its scalar, if it has one.
    Stated(&'static str, usize, Option<usize>),
    /// In ms.
    Delay,
    /// Along the line through a point in a direction of length 1.
    Distance { from: [f64; 2], along: [f64; 2] },
}

/// The place of the scalar of positions.
const OF_POSITIONS: usize = 70;

impl Field {
    const OFFSET: Field = Field::Stated("/offset", 36, None);
    const GROUP_X: Field = Field::Stated("/group_x", 80, Some(OF_POSITIONS));
    const GROUP_Y: Field = Field::Stated("/group_y", 84, Some(OF_POSITIONS));
    pub(super) const OF_HEADERS: [Field; 7] = [
        Field::OFFSET,
        Field::Stated("/source_x", 72, Some(OF_POSITIONS)),
        Field::Stated("/source_y", 76, Some(OF_POSITIONS)),
        Field::GROUP_X,
        Field::GROUP_Y,
        Field::Stated("/elevation", 40, Some(68)),
        Field::Delay,
    ];

    pub(super) fn path(self) -> &'static str {
        match self {
            Field::Stated(path, ..) => path,
            Field::Delay => "/delay",
            Field::Distance { .. } => "/distance",
        }
    }

    /// Whether the coordinate unit of the header applies.
    pub(super) fn is_position(self) -> bool {
        matches!(self, Field::Stated(.., Some(OF_POSITIONS)))
    }

    /// Its value for a trace, with the scalar of the header applied.
    pub(super) fn value(self, layout: &Layout, header: &[u8]) -> f64 {
        let short = |at| i16_at(layout.order, header, at);
        match self {
            Field::Stated(_, at, scalar) => {
                let value = Sample::I32.to_f64(layout.order, &header[at..at + 4]);
                scaled(value, scalar.map_or(0, short))
            }
            // Revision 0 and Seismic Unix have no scalar of times.
            Field::Delay => {
                let has_scalar = matches!(layout.revision, Some(1..));
                scaled(short(108).into(), if has_scalar { short(214) } else { 0 })
            }
            Field::Distance { from, along } => {
                let x = Field::GROUP_X.value(layout, header) - from[0];
                let y = Field::GROUP_Y.value(layout, header) - from[1];
                x * along[0] + y * along[1]
            }
        }
    }
}

/// A positive scalar multiplies, a negative one divides, 0 is unset.
fn scaled(value: f64, scalar: i16) -> f64 {
    match scalar {
        0 => value,
        1.. => value * f64::from(scalar),
        _ => value / -f64::from(scalar),
    }
}

/// The trace headers of a file.
pub(super) struct Headers<'a> {
    pub layout: &'a Layout,
    pub bytes: &'a [u8],
}

impl Headers<'_> {
    pub(super) fn values(&self, field: Field) -> impl Iterator<Item = f64> + '_ {
        let headers = (0..self.layout.traces).map(|trace| self.layout.header(self.bytes, trace));
        headers.map(move |header| field.value(self.layout, header))
    }

    /// Traces that their headers call dead, or something else than the record of a sensor, with the code.
    pub(super) fn no_records(&self) -> impl Iterator<Item = String> + '_ {
        let code = |trace| u16_at(self.layout.order, self.layout.header(self.bytes, trace), 28);
        let marked = (0..self.layout.traces).map(move |trace| (trace + 1, code(trace)));
        let marked = marked.filter(|(_, code)| (2..=10).contains(code));
        marked.map(|(trace, code)| match code {
            2 => format!("{trace} (dead)"),
            3 => format!("{trace} (dummy)"),
            code => format!("{trace} (identification code {code})"),
        })
    }

    /// The unit code of coordinates; none if traces differ.
    pub(super) fn coordinate_units(&self) -> Option<u16> {
        let code = |trace| u16_at(self.layout.order, self.layout.header(self.bytes, trace), 88);
        let is_same = (1..self.layout.traces).all(|trace| code(trace) == code(0));
        is_same.then(|| code(0))
    }

    pub(super) fn is_constant(&self, field: Field) -> bool {
        let mut values = self.values(field);
        let first = values.next();
        first.is_none_or(|first| values.all(|value| value == first))
    }

    fn is_sorted(&self, field: Field, is_next: fn(&f64, &f64) -> bool) -> bool {
        self.layout.traces > 1 && self.values(field).is_sorted_by(is_next)
    }

    /// The field that rises from trace to trace along the line of receivers, if one does.
    pub(super) fn coordinate(&self, positions_are_lengths: bool) -> Option<Field> {
        let rises = |field: &Field| self.is_sorted(*field, |a, b| a < b);
        let along_x = positions_are_lengths && self.is_constant(Field::GROUP_Y);
        // Readers expect rising coordinates; a distance or an offset would hide the order.
        if along_x && self.is_sorted(Field::GROUP_X, |a, b| a > b) {
            return None;
        }
        let line = || self.line().filter(|_| positions_are_lengths);
        let fields = [
            Some(Field::GROUP_X).filter(|_| along_x),
            line(),
            Some(Field::OFFSET),
        ];
        fields.into_iter().flatten().find(rises)
    }

    /// The distance along the straight line from the first receiver to the last, if all lie on it.
    fn line(&self) -> Option<Field> {
        let point = |trace| {
            let header = self.layout.header(self.bytes, trace);
            [Field::GROUP_X, Field::GROUP_Y].map(|field| field.value(self.layout, header))
        };
        let (from, to) = (point(0), point(self.layout.traces.checked_sub(1)?));
        let (x, y) = (to[0] - from[0], to[1] - from[1]);
        let length = x.hypot(y);
        if length == 0.0 {
            return None;
        }
        let along = [x / length, y / length];
        let is_near = |[x, y]: [f64; 2]| {
            let across = (y - from[1]) * along[0] - (x - from[0]) * along[1];
            across.abs() <= 1e-6 * length
        };
        let all_near = (0..self.layout.traces).all(|trace| is_near(point(trace)));
        all_near.then_some(Field::Distance { from, along })
    }
}
