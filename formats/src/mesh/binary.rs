//! Numbers of a binary format.

/// The number types that mesh formats use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

/// Byte order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Endian {
    Little,
    Big,
}

impl Scalar {
    /// Bytes of one.
    pub fn size(self) -> usize {
        match self {
            Scalar::I8 | Scalar::U8 => 1,
            Scalar::I16 | Scalar::U16 => 2,
            Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
            Scalar::I64 | Scalar::U64 | Scalar::F64 => 8,
        }
    }

    /// The number at the start of `bytes`, which holds at least `size` bytes. Integers beyond 2^53
    /// are rounded; as counts and indices they are out of range anyway.
    #[inline]
    pub fn read(self, bytes: &[u8], endian: Endian) -> f64 {
        match self {
            Scalar::I8 => f64::from(bytes[0] as i8),
            Scalar::U8 => f64::from(bytes[0]),
            Scalar::I16 => f64::from(i16::from_le_bytes(first(bytes, endian))),
            Scalar::U16 => f64::from(u16::from_le_bytes(first(bytes, endian))),
            Scalar::I32 => f64::from(i32::from_le_bytes(first(bytes, endian))),
            Scalar::U32 => f64::from(u32::from_le_bytes(first(bytes, endian))),
            Scalar::I64 => i64::from_le_bytes(first(bytes, endian)) as f64,
            Scalar::U64 => u64::from_le_bytes(first(bytes, endian)) as f64,
            Scalar::F32 => f64::from(f32::from_le_bytes(first(bytes, endian))),
            Scalar::F64 => f64::from_le_bytes(first(bytes, endian)),
        }
    }
}

/// The first bytes, the lowest first.
#[inline]
fn first<const N: usize>(bytes: &[u8], endian: Endian) -> [u8; N] {
    let mut array = [0; N];
    array.copy_from_slice(&bytes[..N]);
    if endian == Endian::Big {
        array.reverse();
    }
    array
}

/// A number as a vertex index, if it is one.
pub fn as_index(value: f64) -> Option<u32> {
    ((0.0..f64::from(u32::MAX)).contains(&value) && value.fract() == 0.0).then_some(value as u32)
}

/// A number as a count, if it is one.
pub fn as_count(value: f64) -> Option<usize> {
    ((0.0..9e15).contains(&value) && value.fract() == 0.0).then_some(value as usize)
}
