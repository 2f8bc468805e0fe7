//! Types of stored samples.

/// Type of one stored number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Sample {
    /// IEEE 754 binary64.
    F64,
    /// IEEE 754 binary32.
    F32,
    /// IEEE 754 binary16.
    F16,
    /// IBM System/360 single precision: sign, exponent of 16 in excess 64, fraction of 24 bits.
    IbmF32,
    /// Signed, 8 bits.
    I8,
    /// Signed, 16 bits.
    I16,
    /// Signed, 32 bits.
    I32,
    /// Signed, 64 bits.
    I64,
    /// Unsigned, 8 bits.
    U8,
    /// Unsigned, 16 bits.
    U16,
    /// Unsigned, 32 bits.
    U32,
    /// Unsigned, 64 bits.
    U64,
    /// One byte, 0 or not.
    Bool,
}

impl Sample {
    /// The type of NumPy's kind (`f`, `i`, `u`, `b`) with so many bytes.
    pub(crate) fn of_kind(kind: char, bytes: usize) -> Option<Sample> {
        use Sample::*;
        let all = [F64, F32, F16, I8, I16, I32, I64, U8, U16, U32, U64, Bool];
        let is_it = |one: &Sample| one.name().starts_with(kind) && one.bytes() == bytes;
        all.into_iter().find(is_it)
    }

    /// Bytes of one number.
    pub fn bytes(self) -> usize {
        use Sample::*;
        match self {
            I8 | U8 | Bool => 1,
            F16 | I16 | U16 => 2,
            F32 | IbmF32 | I32 | U32 => 4,
            F64 | I64 | U64 => 8,
        }
    }

    /// Relative rounding error of a stored number.
    pub fn relative_rounding(self) -> f64 {
        match self {
            Sample::F16 => 1.0 / 1024.0,
            Sample::F32 => f64::from(f32::EPSILON),
            // The leading hexadecimal digit may hold three zero bits.
            Sample::IbmF32 => 8.0 * f64::from(f32::EPSILON),
            _ => f64::EPSILON,
        }
    }

    /// The distance of neighbouring stored numbers as large as the largest of `values`.
    pub fn spacing(self, values: &[f64]) -> f64 {
        let sizes = values.iter().map(|value| value.abs());
        let largest = sizes.fold(0.0, f64::max);
        match largest > 0.0 && largest.is_finite() {
            true => self.relative_rounding() * largest.log2().floor().exp2(),
            false => 0.0,
        }
    }

    /// The number in `bytes`, which are [`Sample::bytes`] long. Integers beyond 2^53 are rounded.
    ///
    /// # Panics
    /// If `bytes` has another length.
    pub fn to_f64(self, order: ByteOrder, bytes: &[u8]) -> f64 {
        macro_rules! decode {
            ($type:ty) => {{
                let bytes = bytes.try_into().expect("as long as the type");
                match order {
                    ByteOrder::Little => <$type>::from_le_bytes(bytes),
                    ByteOrder::Big => <$type>::from_be_bytes(bytes),
                }
            }};
        }
        match self {
            Sample::F64 => decode!(f64),
            Sample::F32 => f64::from(decode!(f32)),
            Sample::F16 => half_to_f64(decode!(u16)),
            Sample::IbmF32 => ibm_to_f64(decode!(u32)),
            Sample::I8 => f64::from(decode!(i8)),
            Sample::I16 => f64::from(decode!(i16)),
            Sample::I32 => f64::from(decode!(i32)),
            Sample::I64 => decode!(i64) as f64,
            Sample::U8 => f64::from(decode!(u8)),
            Sample::U16 => f64::from(decode!(u16)),
            Sample::U32 => f64::from(decode!(u32)),
            Sample::U64 => decode!(u64) as f64,
            Sample::Bool => f64::from(decode!(u8) != 0),
        }
    }

    /// The integer in `bytes`; `None` for floats and for what exceeds an `i64`.
    ///
    /// # Panics
    /// If `bytes` has another length than [`Sample::bytes`].
    pub fn to_i64(self, order: ByteOrder, bytes: &[u8]) -> Option<i64> {
        use Sample::*;
        if self.is_float() {
            return None;
        }
        let wide = order.unsigned(&bytes[..self.bytes()]);
        let unused = 64 - 8 * self.bytes() as u32;
        match self {
            I8 | I16 | I32 | I64 => Some(((wide << unused) as i64) >> unused),
            _ => i64::try_from(wide).ok(),
        }
    }

    /// Whether it is a floating-point number.
    pub fn is_float(self) -> bool {
        matches!(
            self,
            Sample::F64 | Sample::F32 | Sample::F16 | Sample::IbmF32
        )
    }

    /// Writes the number in `one`, of type `from`, to `out` as one of this type, in native byte order.
    ///
    /// # Errors
    /// The number, if this type has no such integer.
    pub(crate) fn convert(
        self,
        from: Sample,
        order: ByteOrder,
        one: &[u8],
        out: &mut [u8],
    ) -> std::result::Result<(), f64> {
        let number = || from.to_f64(order, one);
        match self {
            _ if self == from => {
                out.copy_from_slice(one);
                if order != ByteOrder::NATIVE {
                    out.reverse();
                }
            }
            Sample::F64 => out.copy_from_slice(&number().to_ne_bytes()),
            Sample::F32 => out.copy_from_slice(&(number() as f32).to_ne_bytes()),
            Sample::Bool => out.fill(u8::from(number() != 0.0)),
            _ => {
                let integer = from.to_i64(order, one).ok_or_else(number)?;
                out.copy_from_slice(&integer.to_le_bytes()[..self.bytes()]);
                if self.to_i64(ByteOrder::Little, out) != Some(integer) {
                    return Err(number());
                }
                if ByteOrder::NATIVE == ByteOrder::Big {
                    out.reverse();
                }
            }
        }
        Ok(())
    }

    /// Its name in messages: `f32`, `i16`.
    pub fn name(self) -> &'static str {
        match self {
            Sample::F64 => "f64",
            Sample::F32 => "f32",
            Sample::F16 => "f16",
            Sample::IbmF32 => "IBM f32",
            Sample::I8 => "i8",
            Sample::I16 => "i16",
            Sample::I32 => "i32",
            Sample::I64 => "i64",
            Sample::U8 => "u8",
            Sample::U16 => "u16",
            Sample::U32 => "u32",
            Sample::U64 => "u64",
            Sample::Bool => "bool",
        }
    }
}

/// What a variable holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SampleType {
    /// Numbers.
    Number(Sample),
    /// What cannot be a field, named: `text`, `complex numbers`, `a compound type`.
    Other(String),
}

impl SampleType {
    /// The type of its numbers, if it holds any.
    pub fn number(&self) -> Option<Sample> {
        match self {
            SampleType::Number(sample) => Some(*sample),
            SampleType::Other(_) => None,
        }
    }

    /// What it holds: `f32`, `text`.
    pub fn name(&self) -> &str {
        match self {
            SampleType::Number(sample) => sample.name(),
            SampleType::Other(other) => other,
        }
    }

    /// How what is not read becomes something that is, where there is a way.
    pub fn way_out(&self) -> Option<&'static str> {
        let SampleType::Other(what) = self else {
            return None;
        };
        let way = WAYS_OUT.iter().find(|(begins, _)| what.starts_with(begins));
        way.map(|(_, way)| *way)
    }
}

/// A plain copy of what the reader of HDF5 does not follow.
const COPY: &str = "make a plain copy with h5py: `h5py.File(\"copy.h5\", \"w\")[\"v\"] = \
                    h5py.File(\"in.h5\")[\"v\"][...]`, with the name of the data set for `v`";

/// How the texts of [`SampleType::Other`] begin, and what can be done about it.
const WAYS_OUT: [(&str, &str); 6] = [
    ("a virtual data set", COPY),
    ("samples in another file", COPY),
    (
        "data compressed by",
        "compress it by gzip, where its filter is installed: `h5repack -f GZIP=4 in.h5 copy.h5`, or with h5py \
         after `import hdf5plugin`: `h5py.File(\"copy.h5\", \"w\")[\"v\"] = h5py.File(\"in.h5\")[\"v\"][...]`",
    ),
    (
        "data whose _FillValue has another type",
        "give the attribute `_FillValue` the type of the data",
    ),
    (
        "complex numbers",
        "store the real part as an array of its own",
    ),
    (
        "functions of type",
        "export responses over time (function type 1, abscissa type 17)",
    ),
];

/// Byte order of stored numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ByteOrder {
    /// The lowest byte first.
    Little,
    /// The highest byte first.
    Big,
}

impl ByteOrder {
    /// That of this machine.
    pub const NATIVE: ByteOrder = match cfg!(target_endian = "big") {
        true => ByteOrder::Big,
        false => ByteOrder::Little,
    };

    /// The unsigned number of at most 8 bytes.
    pub(crate) fn unsigned(self, bytes: &[u8]) -> u64 {
        let add = |number: u64, byte: &u8| number << 8 | u64::from(*byte);
        match self {
            ByteOrder::Little => bytes.iter().rev().fold(0, add),
            ByteOrder::Big => bytes.iter().fold(0, add),
        }
    }
}

/// IEEE 754 binary16: 1 sign bit, 5 of exponent, 10 of fraction.
pub fn half_to_f64(bits: u16) -> f64 {
    let fraction = f64::from(bits & 0x3ff);
    let magnitude = match (bits >> 10) & 0x1f {
        0 => fraction * 2f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        exponent => (1024.0 + fraction) * 2f64.powi(i32::from(exponent) - 25),
    };
    if bits >> 15 == 0 {
        magnitude
    } else {
        -magnitude
    }
}

/// IBM System/360 single precision: `(-1)^s 0.f 16^(e - 64)`, which every `f64` holds exactly.
pub fn ibm_to_f64(bits: u32) -> f64 {
    let fraction = f64::from(bits & 0x00ff_ffff);
    let exponent = ((bits >> 24) & 0x7f) as i32;
    let magnitude = fraction * 2f64.powi(4 * (exponent - 64) - 24);
    if bits >> 31 == 0 {
        magnitude
    } else {
        -magnitude
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_definition_ibm_floats() {
        // Examples of the System/360 Principles of Operation.
        assert_eq!(ibm_to_f64(0xc276_a000), -118.625);
        assert_eq!(ibm_to_f64(0x4110_0000), 1.0);
        let largest = (1.0 - 16f64.powi(-6)) * 16f64.powi(63);
        assert_eq!(ibm_to_f64(0x7fff_ffff), largest);
        assert_eq!(ibm_to_f64(0x0010_0000), 16f64.powi(-65));
        assert_eq!(ibm_to_f64(0), 0.0);
    }

    #[test]
    fn integers_keep_their_sign_and_order() {
        let to_i64 = |sample: Sample, order, bytes: &[u8]| sample.to_i64(order, bytes);
        assert_eq!(to_i64(Sample::I16, ByteOrder::Big, &[0xff, 0xfe]), Some(-2));
        let unsigned = to_i64(Sample::U16, ByteOrder::Big, &[0xff, 0xfe]);
        assert_eq!(unsigned, Some(65534));
        let large = (-(1i64 << 62) - 1).to_le_bytes();
        let found = to_i64(Sample::I64, ByteOrder::Little, &large);
        assert_eq!(found, Some(-(1i64 << 62) - 1));
        assert_eq!(to_i64(Sample::U64, ByteOrder::Little, &[0xff; 8]), None);
        assert_eq!(to_i64(Sample::F32, ByteOrder::Little, &[0; 4]), None);
    }
}
