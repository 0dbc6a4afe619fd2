//! Short decimal numbers, such as nearly all of a mesh file's, at the speed of their digits.
//!
//! Clinger 1990, "How to read floating point numbers accurately": where the digits are a whole number
//! below 2^53 and the power of ten is one of those that f64 holds exactly, one multiplication or
//! division of the two rounds correctly. Anything else is left to the standard library.

/// The powers of ten that f64 holds exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];
/// Digits that surely fit a u64.
const MAX_DIGITS: usize = 19;

/// The number that `bytes` start with, correctly rounded, and its length. `None`: there is none, or
/// it isn't short. What follows the number is for the caller to judge.
pub fn short_decimal(bytes: &[u8]) -> Option<(f64, usize)> {
    let signed = usize::from(matches!(bytes.first(), Some(b'-' | b'+')));
    let (whole, mut at) = digits(bytes, signed, 0);
    let mut count = at - signed;
    let (mut mantissa, mut power) = (whole, 0);
    if bytes.get(at) == Some(&b'.') {
        let (all, end) = digits(bytes, at + 1, whole);
        (mantissa, power) = (all, -((end - at - 1) as i64));
        count += end - at - 1;
        at = end;
    }
    if count == 0 || count > MAX_DIGITS || mantissa > 1 << 53 {
        return None;
    }
    if let Some(b'e' | b'E') = bytes.get(at) {
        let sign = bytes.get(at + 1);
        let start = at + 1 + usize::from(matches!(sign, Some(b'-' | b'+')));
        let (exponent, end) = digits(bytes, start, 0);
        if end == start || end > start + 4 {
            return None;
        }
        power += if sign == Some(&b'-') { -(exponent as i64) } else { exponent as i64 };
        at = end;
    }
    let scale = POWERS.get(power.unsigned_abs() as usize)?;
    let value = if power < 0 { mantissa as f64 / scale } else { mantissa as f64 * scale };
    Some((if bytes[0] == b'-' { -value } else { value }, at))
}

/// Appends the digits from `at` on to a number, which may wrap, and returns it and where they end.
#[inline]
pub fn digits(bytes: &[u8], mut at: usize, mut number: u64) -> (u64, usize) {
    const SHIFT: [u64; 9] = [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000];
    while let Some(eight) = bytes.get(at..).and_then(|rest| rest.first_chunk()) {
        let (value, count) = digits_of_eight(*eight);
        number = number.wrapping_mul(SHIFT[count]).wrapping_add(value);
        at += count;
        if count < 8 {
            return (number, at);
        }
    }
    while let Some(digit) = bytes.get(at).map(|byte| byte.wrapping_sub(b'0'))
        && digit < 10
    {
        number = number.wrapping_mul(10).wrapping_add(u64::from(digit));
        at += 1;
    }
    (number, at)
}

/// The digits that eight bytes start with, as a number, and how many. All at once: Lemire 2021, "Number
/// parsing at a gigabyte per second".
#[inline]
fn digits_of_eight(bytes: [u8; 8]) -> (u64, usize) {
    let values = u64::from_le_bytes(bytes) ^ 0x3030_3030_3030_3030;
    // The high bit of bytes beyond 9. A carry can only reach bytes after the first of those.
    let others = (values.wrapping_add(0x7676_7676_7676_7676) | values) & 0x8080_8080_8080_8080;
    let count = others.trailing_zeros() as usize / 8;
    if count == 0 {
        return (0, 0);
    }
    // Zeros in front; then digits, pairs and fours are joined.
    let values = values << (64 - 8 * count);
    let pairs = values.wrapping_mul(10).wrapping_add(values >> 8);
    const EVERY_OTHER_PAIR: u64 = 0x0000_00FF_0000_00FF;
    let high = (pairs & EVERY_OTHER_PAIR).wrapping_mul(100 + (1_000_000 << 32));
    let low = (pairs >> 16 & EVERY_OTHER_PAIR).wrapping_mul(1 + (10_000 << 32));
    (high.wrapping_add(low) >> 32, count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What the standard library says, and whether `short_decimal` read the word at all.
    fn agrees(word: &str) -> bool {
        let Some((value, length)) = short_decimal(word.as_bytes()) else {
            return false;
        };
        assert_eq!(length, word.len(), "{word}");
        let expected: f64 = word.parse().unwrap();
        assert_eq!(value.to_bits(), expected.to_bits(), "{word}: {value} {expected}");
        true
    }

    #[test]
    fn numbers_of_all_kinds_are_read_and_rounded_correctly() {
        let short = "0 -0 +1 1. .5 -.25 007 0.1 -123.456 1e5 1E-5 2.5e+07 9007199254740992 9007199254740992e22 \
                     1.7e-21 000000.000001 0.000000000000000001 -8.88178e-16";
        for word in short.split_ascii_whitespace() {
            assert!(agrees(word), "{word}");
        }
        for word in ["", "-", ".", "e5", "1e", "1e+", "nan", "inf", "-.e1", "1e99999", "9007199254740993"] {
            assert_eq!(short_decimal(word.as_bytes()), None, "{word}");
        }
        for word in ["1e23", "1e-23", "0.30000000000000004", "18446744073709551616", "184467440737095516160"]
        {
            assert_eq!(short_decimal(word.as_bytes()), None, "{word}");
        }
        assert_eq!(short_decimal(b"1.5/2"), Some((1.5, 3)));
    }

    #[test]
    fn digits_end_at_any_other_byte() {
        for count in 0..20 {
            let number = &"12345678901234567890"[..count];
            let expected = number.parse().unwrap_or(0);
            for end in 0..=255u8 {
                let mut bytes = number.as_bytes().to_vec();
                assert_eq!(digits(&bytes, 0, 0), (expected, count));
                bytes.extend([end; 9]);
                if !end.is_ascii_digit() {
                    assert_eq!(digits(&bytes, 0, 0), (expected, count), "{count} {end}");
                }
            }
        }
    }

    proptest! {
        #[test]
        fn agrees_with_the_standard_library(word in "[-+]?[0-9]{0,9}\\.?[0-9]{1,12}([eE][-+]?[0-9]{1,3})?") {
            agrees(&word);
        }

        #[test]
        fn shortest_forms_come_back(value in proptest::num::f32::NORMAL) {
            agrees(&format!("{value:?}"));
            agrees(&format!("{value:.6}"));
        }
    }
}
