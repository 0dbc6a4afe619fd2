//! Text for people: numbers as one reads them, and text from files that is safe to print.
//!
//! ```
//! use volmap_formats::text::{bytes, number, printable, thousands};
//!
//! assert_eq!(number(0.012_345), "0.0123");
//! assert_eq!(number(2.5e9), "2.50e9");
//! assert_eq!(volmap_formats::text::typeset(&number(-2.5e9)), "−2.50·10⁹");
//! assert_eq!(thousands(1_234_567), "1,234,567");
//! assert_eq!(bytes(45_600), "45.6 kB");
//! assert_eq!(printable("red: \u{1b}[31m"), "red: \u{fffd}[31m");
//! ```
//! No function of the system's mathematics library is used, so the text is the same on every machine.

/// A number with three digits, as `-0.0123`, `12,345`, `1.20e-5`, in characters that another program reads.
pub fn number(value: f64) -> String {
    significant(value, 3)
}

/// A number with so many digits, at least 1: plain from 0.001 to 999,999, else with a power of ten. Zeros at the end of
/// decimals are left out.
pub fn significant(value: f64, digits: usize) -> String {
    let more = digits.clamp(1, 17) - 1;
    if value == 0.0 || !value.is_finite() {
        return value.abs().to_string().replace("inf", if value < 0.0 { "-inf" } else { "inf" });
    }
    let rounded: f64 = format!("{value:.more$e}").parse().unwrap_or(value);
    match exponent(rounded) {
        power @ -3..=5 => {
            let decimals = more.saturating_sub(usize::try_from(power).unwrap_or(0));
            let decimals = decimals + usize::try_from(-power).unwrap_or(0);
            // Whole numbers keep all their digits.
            let value = if decimals == 0 { value } else { rounded };
            grouped(without_zeros(&format!("{value:.decimals$}")))
        }
        power => format!("{:.more$}e{power}", rounded / ten_to(power)),
    }
}

/// A part of a whole in percent, with three digits: 0.0042 is `0.42 %`.
pub fn percent(part: f64) -> String {
    format!("{} %", number(100.0 * part))
}

/// A whole number with commas: 1234567 is `1,234,567`.
pub fn thousands(n: u64) -> String {
    grouped(&n.to_string())
}

/// A size in the unit that suits it (powers of 1000).
pub fn bytes(n: u64) -> String {
    match n {
        0..10_000 => format!("{n} B"),
        10_000..10_000_000 => format!("{:.1} kB", n as f64 / 1e3),
        10_000_000..10_000_000_000 => format!("{:.1} MB", n as f64 / 1e6),
        _ => format!("{:.1} GB", n as f64 / 1e9),
    }
}

/// A time that somebody waits for: `0.42 s`, `12.3 s`, `2 min 5 s`, `3 h 10 min`.
pub fn duration(seconds: f64) -> String {
    match seconds.round() as u64 {
        0..60 => format!("{} s", number(seconds)),
        s @ 60..3600 => format!("{} min {} s", s / 60, s % 60),
        s => format!("{} h {} min", s / 3600, s % 3600 / 60),
    }
}

/// A number or a percentage of this module as a page or a picture has it: `-1.20e-5` is `−1.20·10⁻⁵`.
pub fn typeset(number: &str) -> String {
    let (number, unit) = number.split_once(' ').map_or((number, None), |(number, unit)| (number, Some(unit)));
    let number = match number.split_once('e') {
        Some((digits, power)) => match power.parse() {
            Ok(power) => format!("{}·{}", minus(digits), power_of_ten(power)),
            Err(_) => minus(number),
        },
        None => minus(number),
    };
    unit.map_or(number.clone(), |unit| format!("{number} {unit}"))
}

/// `10⁻⁵`.
pub fn power_of_ten(exponent: i32) -> String {
    let raised = |c: char| match c.to_digit(10) {
        Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
        None => '⁻',
    };
    format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
}

/// A written number with the sign for minus (U+2212) instead of a hyphen. A zero has no sign.
pub fn minus(text: &str) -> String {
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_owned(),
        Some(rest) => format!("−{rest}"),
        None => text.to_owned(),
    }
}

/// The largest k with 10^k <= |x|; 0 for zero.
pub fn exponent(x: f64) -> i32 {
    let text = format!("{:e}", x.abs());
    text.split_once('e').and_then(|(_, power)| power.parse().ok()).unwrap_or(0)
}

/// The closest number to 10^k.
pub fn ten_to(k: i32) -> f64 {
    format!("1e{k}").parse().unwrap_or(f64::INFINITY)
}

/// Commas between groups of three digits before the point.
fn grouped(number: &str) -> String {
    let (sign, rest) = number.strip_prefix('-').map_or(("", number), |rest| ("-", rest));
    let (whole, decimals) = rest.find('.').map_or((rest, ""), |point| rest.split_at(point));
    let mut out = sign.to_owned();
    for (at, digit) in whole.chars().enumerate() {
        if at > 0 && (whole.len() - at).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out + decimals
}

fn without_zeros(number: &str) -> &str {
    if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number }
}

/// Text from files as it may be printed or shown: control characters, and those that turn the direction of the text
/// after them (Unicode Standard Annex 9), become U+FFFD. Line breaks and tabs stay.
pub fn printable(text: &str) -> String {
    text.chars().map(|c| if is_unsafe(c) && !matches!(c, '\n' | '\t') { '\u{fffd}' } else { c }).collect()
}

/// As [`printable`], in one line: line breaks and tabs become spaces.
pub fn printable_line(text: &str) -> String {
    let line = |c: char| if matches!(c, '\n' | '\t') { ' ' } else { c };
    printable(text).chars().map(line).collect()
}

/// As [`printable_line`], of at most so many characters: for messages that quote a file.
pub fn quoted(text: &str, longest: usize) -> String {
    // Not the whole of a long text is looked at.
    let end = text.char_indices().nth(longest).map_or(text.len(), |(end, _)| end);
    printable_line(&text[..end])
}

fn is_unsafe(c: char) -> bool {
    c.is_control() || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let cases = [
            (0.0, "0"),
            (1.2e-5, "1.20e-5"),
            (-0.012345, "-0.0123"),
            (0.5, "0.5"),
            (99.96, "100"),
            (0.09996, "0.1"),
            (123.4, "123"),
            (-12345.6, "-12,346"),
            (9.996e-5, "1.00e-4"),
            (2.5e9, "2.50e9"),
            (998_400.0, "998,400"),
            (999_999.4, "1.00e6"),
            (-1e-300, "-1.00e-300"),
            (f64::INFINITY, "inf"),
            (f64::NEG_INFINITY, "-inf"),
        ];
        for (value, text) in cases {
            assert_eq!(number(value), text);
        }
        assert_eq!(number(f64::NAN), "NaN");
        for (plain, set) in [
            ("-1.20e-5 %", "−1.20·10⁻⁵ %"),
            ("2.50e9", "2.50·10⁹"),
            ("-12,346", "−12,346"),
            ("-0", "0"),
            ("-inf", "−inf"),
            ("NaN", "NaN"),
        ] {
            assert_eq!(typeset(plain), set);
        }
    }

    #[test]
    fn digits_are_as_many_as_asked_for() {
        let cases = [
            (2.432, 4, "2.432"),
            (12.3456, 4, "12.35"),
            (1234.5, 4, "1,234"),
            (1234.5, 6, "1,234.5"),
            (0.001, 4, "0.001"),
            (4.944e-4, 4, "4.944e-4"),
            (49_943_122.733_5, 4, "4.994e7"),
            (5.0, 1, "5"),
        ];
        for (value, digits, text) in cases {
            assert_eq!(significant(value, digits), text);
        }
        // No number is long.
        for power in -300..300 {
            assert!(significant(1.234_567 * ten_to(power), 4).chars().count() < 14, "10^{power}");
        }
    }

    #[test]
    fn amounts_have_units() {
        assert_eq!(
            [0, 999, 1000, 1_234_567].map(thousands),
            ["0", "999", "1,000", "1,234,567"].map(String::from)
        );
        assert_eq!(
            [9_999, 45_600, 20_100_000].map(bytes),
            ["9999 B", "45.6 kB", "20.1 MB"].map(String::from)
        );
        assert_eq!(
            [0.42, 12.34, 125.0, 11_400.0].map(duration),
            ["0.42 s", "12.3 s", "2 min 5 s", "3 h 10 min"].map(String::from)
        );
        assert_eq!(percent(0.0042), "0.42 %");
    }

    #[test]
    fn what_a_terminal_would_obey_is_replaced() {
        assert_eq!(printable("a\0\u{1b}[1m\u{202e}b\n\tc"), "a\u{fffd}\u{fffd}[1m\u{fffd}b\n\tc");
        assert_eq!(printable_line("a\r\nb\tc"), "a\u{fffd} b c");
        assert_eq!(printable("Größe Φ 漢"), "Größe Φ 漢");
        assert_eq!(quoted("漢字です\n", 2), "漢字");
        assert_eq!(quoted("a\u{7}", 200), "a\u{fffd}");
    }
}
