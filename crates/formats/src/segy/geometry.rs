//! Fields of trace headers, and which of them is the coordinate of the traces.

use super::layout::{Layout, i16_at, number_at, u16_at};
use crate::Sample;

/// What a trace header says in one number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Field {
    Offset,
    Elevation,
    SourceX,
    SourceY,
    GroupX,
    GroupY,
    /// In ms.
    Delay,
    /// Along the line through a point in a direction of length 1.
    Distance {
        from: [f64; 2],
        along: [f64; 2],
    },
}

impl Field {
    pub(super) const OF_HEADERS: [Field; 7] = [
        Field::Offset,
        Field::SourceX,
        Field::SourceY,
        Field::GroupX,
        Field::GroupY,
        Field::Elevation,
        Field::Delay,
    ];

    pub(super) fn path(self) -> &'static str {
        match self {
            Field::Offset => "/offset",
            Field::Elevation => "/elevation",
            Field::SourceX => "/source_x",
            Field::SourceY => "/source_y",
            Field::GroupX => "/group_x",
            Field::GroupY => "/group_y",
            Field::Delay => "/delay",
            Field::Distance { .. } => "/distance",
        }
    }

    /// Whether the coordinate unit of the header applies.
    pub(super) fn is_position(self) -> bool {
        matches!(
            self,
            Field::SourceX | Field::SourceY | Field::GroupX | Field::GroupY
        )
    }

    /// Its value for a trace, with the scalar of the header applied.
    pub(super) fn value(self, layout: &Layout, header: &[u8]) -> f64 {
        let integer = |at| number_at(Sample::I32, layout.order, header, at);
        let coordinate = |at| scaled(integer(at), i16_at(layout.order, header, 70));
        match self {
            Field::Offset => integer(36),
            Field::Elevation => scaled(integer(40), i16_at(layout.order, header, 68)),
            Field::SourceX => coordinate(72),
            Field::SourceY => coordinate(76),
            Field::GroupX => coordinate(80),
            Field::GroupY => coordinate(84),
            Field::Delay => {
                let delay = f64::from(i16_at(layout.order, header, 108));
                // Revision 0 and Seismic Unix have no scalar of times.
                match layout.revision {
                    Some(1..) => scaled(delay, i16_at(layout.order, header, 214)),
                    _ => delay,
                }
            }
            Field::Distance { from, along } => {
                let x = Field::GroupX.value(layout, header) - from[0];
                let y = Field::GroupY.value(layout, header) - from[1];
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
        let first = code(0);
        (1..self.layout.traces)
            .all(|trace| code(trace) == first)
            .then_some(first)
    }

    pub(super) fn is_constant(&self, field: Field) -> bool {
        let mut values = self.values(field);
        values
            .next()
            .is_none_or(|first| values.all(|value| value == first))
    }

    fn rises(&self, field: Field) -> bool {
        self.layout.traces > 1 && self.values(field).is_sorted_by(|a, b| a < b)
    }

    fn falls(&self, field: Field) -> bool {
        self.layout.traces > 1 && self.values(field).is_sorted_by(|a, b| a > b)
    }

    /// The field that rises from trace to trace along the line of receivers, if one does.
    pub(super) fn coordinate(&self, positions_are_lengths: bool) -> Option<Field> {
        if positions_are_lengths {
            if self.is_constant(Field::GroupY) {
                if self.rises(Field::GroupX) {
                    return Some(Field::GroupX);
                }
                // Readers expect rising coordinates; a distance or an offset would hide the order.
                if self.falls(Field::GroupX) {
                    return None;
                }
            }
            if let Some(distance) = self.line().filter(|&distance| self.rises(distance)) {
                return Some(distance);
            }
        }
        self.rises(Field::Offset).then_some(Field::Offset)
    }

    /// The distance along the straight line from the first receiver to the last, if all lie on it.
    fn line(&self) -> Option<Field> {
        let point = |trace| {
            let header = self.layout.header(self.bytes, trace);
            [Field::GroupX, Field::GroupY].map(|field| field.value(self.layout, header))
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
