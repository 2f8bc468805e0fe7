//! Samples as the bytes of a file.

use crate::arrays::Precision;
use crate::error::Result;

/// Samples that are converted at once: what is converted stays in cache.
const AT_ONCE: usize = 8192;

/// Order of the bytes of a sample in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    Little,
    Big,
}

/// Bytes of one sample.
pub(super) fn bytes_of(precision: Precision) -> u64 {
    match precision {
        Precision::F64 => 8,
        Precision::F32 => 4,
    }
}

/// Hands `values` over as bytes, piece by piece, each with the place of its first byte.
///
/// # Errors
/// Those of `write`.
pub(super) fn in_bytes(
    values: &[f64],
    precision: Precision,
    order: Order,
    mut write: impl FnMut(u64, &[u8]) -> Result<()>,
) -> Result<()> {
    let is_native = cfg!(target_endian = "little") == (order == Order::Little);
    if is_native && precision == Precision::F64 {
        return write(0, bytemuck::cast_slice(values));
    }
    let (mut doubles, mut singles) = (Vec::<u64>::new(), Vec::<u32>::new());
    for (n, piece) in values.chunks(AT_ONCE).enumerate() {
        let at = (n * AT_ONCE) as u64 * bytes_of(precision);
        let bytes: &[u8] = match precision {
            Precision::F64 => {
                doubles.clear();
                doubles.extend(piece.iter().map(|v| v.to_bits().swap_bytes()));
                bytemuck::cast_slice(&doubles)
            }
            Precision::F32 => {
                singles.clear();
                let bits = piece.iter().map(|&v| (v as f32).to_bits());
                singles.extend(bits.map(|bits| match is_native {
                    true => bits,
                    false => bits.swap_bytes(),
                }));
                bytemuck::cast_slice(&singles)
            }
        };
        write(at, bytes)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_bytes_are_those_of_the_standard_library() {
        let values: Vec<f64> = (0..20_001).map(|i| 0.1 * f64::from(i) - 3.0).collect();
        type Bytes = fn(f64) -> Vec<u8>;
        let cases: [(Precision, Order, Bytes); 4] = [
            (Precision::F64, Order::Little, |v| v.to_le_bytes().into()),
            (Precision::F64, Order::Big, |v| v.to_be_bytes().into()),
            (Precision::F32, Order::Little, |v| {
                (v as f32).to_le_bytes().into()
            }),
            (Precision::F32, Order::Big, |v| {
                (v as f32).to_be_bytes().into()
            }),
        ];
        for (precision, order, expected) in cases {
            let mut bytes = Vec::<u8>::new();
            in_bytes(&values, precision, order, |at, piece| {
                assert_eq!(at, bytes.len() as u64);
                bytes.extend(piece);
                Ok(())
            })
            .unwrap();
            let expected: Vec<u8> = values.iter().flat_map(|v| expected(*v)).collect();
            assert!(bytes == expected);
        }
    }
}
