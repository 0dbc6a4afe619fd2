//! Bytes, as 500MB or 4GiB.

use serde::Serialize;
use std::str::FromStr;

/// A number of bytes, at least 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(transparent)]
pub struct ByteSize(pub u64);

/// Names of units, those that end in others first, and their bytes.
const UNITS: [(&str, f64); 10] = [
    ("KiB", 1024.0),
    ("MiB", 1_048_576.0),
    ("GiB", 1_073_741_824.0),
    ("TiB", 1_099_511_627_776.0),
    ("kB", 1e3),
    ("KB", 1e3),
    ("MB", 1e6),
    ("GB", 1e9),
    ("TB", 1e12),
    ("B", 1.0),
];

impl FromStr for ByteSize {
    type Err = String;

    fn from_str(text: &str) -> Result<ByteSize, String> {
        let unit = UNITS.iter().find_map(|(name, size)| Some((text.strip_suffix(name)?, *size)));
        let (number, size) = unit.unwrap_or((text, 1.0));
        let bytes = number.trim().parse::<f64>().ok().map(|n| (n * size) as u64).filter(|bytes| *bytes > 0);
        bytes.map(ByteSize).ok_or_else(|| "give a size as 4GiB or 500MB".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_units() {
        assert_eq!("4GiB".parse(), Ok(ByteSize(4 << 30)));
        assert_eq!("500MB".parse(), Ok(ByteSize(500_000_000)));
        assert_eq!("1.5 kB".parse(), Ok(ByteSize(1500)));
        assert_eq!("7".parse(), Ok(ByteSize(7)));
        assert!(
            ["-1GB", "much", "", "0B", "0.5B", "nan"].iter().all(|text| text.parse::<ByteSize>().is_err())
        );
    }
}
