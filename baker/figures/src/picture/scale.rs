//! Scales with round ticks. No function of the system's mathematics library is used, as their last bits differ from
//! machine to machine.

use volmap_formats::text::{exponent, minus, number, power_of_ten, ten_to, typeset};

/// From numbers to places on an axis, with labelled ticks.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    /// Lowest and highest number; the second is larger.
    pub limits: [f64; 2],
    /// Logarithmic.
    pub log: bool,
    /// Numbers and what is written at them.
    pub ticks: Vec<(f64, String)>,
    /// The labels are numbers over ten to this power.
    pub exponent: i32,
}

impl Scale {
    /// In proportion, with at most `most` ticks (at least 2).
    pub fn linear(limits: [f64; 2], most: usize) -> Scale {
        let limits = widened(limits);
        let ticks_of = |most: usize| linear_ticks(limits, most);
        let enough = |found: &(Vec<(f64, String)>, i32)| found.0.len() > 1;
        // Two ticks are needed to read a scale, even where there is little room.
        let (ticks, exponent) =
            (most.max(2)..=most.max(2) + 9).map(ticks_of).find(enough).unwrap_or_else(|| ticks_of(20));
        Scale { limits, log: false, ticks, exponent }
    }

    /// Logarithmic, with at most about `most` ticks. Limits that aren't positive become so.
    pub fn log(limits: [f64; 2], most: usize) -> Scale {
        let high = if limits[1] > 0.0 && limits[1].is_finite() { limits[1] } else { 1.0 };
        let low = if limits[0] > 0.0 && limits[0] < high { limits[0] } else { 1e-6 * high };
        Scale { limits: [low, high], log: true, ticks: log_ticks([low, high], most.max(2)), exponent: 0 }
    }

    /// Place of a number: 0 at the lower limit, 1 at the upper.
    pub fn place(&self, value: f64) -> f64 {
        let [low, high] = self.limits;
        match self.log {
            false => (value - low) / (high - low),
            true if value > 0.0 => log10(value / low) / log10(high / low),
            true => f64::NEG_INFINITY,
        }
    }

    /// Name and unit of the axis, with the power of ten of its labels.
    pub fn title(&self, name: &str, unit: &str) -> String {
        let power = power_of_ten(self.exponent);
        let unit = match (self.exponent, unit) {
            (0, unit) => unit.to_owned(),
            (_, "") => power,
            (_, unit) => format!("{power} {unit}"),
        };
        if unit.is_empty() { name.to_owned() } else { format!("{name} ({unit})") }
    }
}

/// Finite limits that differ.
fn widened([low, high]: [f64; 2]) -> [f64; 2] {
    if !(low.is_finite() && high.is_finite()) || low > high {
        return [0.0, 1.0];
    }
    let size = low.abs().max(high.abs());
    match (high - low > 1e-12 * size, size > 0.0) {
        (true, _) => [low, high],
        (false, true) => [low - 0.5 * size, high + 0.5 * size],
        (false, false) => [0.0, 1.0],
    }
}

fn linear_ticks([low, high]: [f64; 2], most: usize) -> (Vec<(f64, String)>, i32) {
    let least = (high - low) / most as f64;
    let power = exponent(least);
    let mantissas = [1.0, 2.0, 5.0, 10.0];
    let unit = mantissas.into_iter().find(|m| m * ten_to(power) >= least).unwrap_or(10.0);
    let (unit, power) = if unit == 10.0 { (1.0, power + 1) } else { (unit, power) };
    let step = unit * ten_to(power);
    let labels = match exponent(low.abs().max(high.abs())) {
        -2..=3 => 0,
        other => other,
    };
    let decimals = usize::try_from(labels - power).unwrap_or(0);
    let slack = 1e-9;
    let (first, last) = ((low / step - slack).ceil() as i64, (high / step + slack).floor() as i64);
    let tick = |n: i64| {
        let written = n as f64 * unit * ten_to(power - labels);
        (n as f64 * step, minus(&format!("{written:.decimals$}")))
    };
    ((first..=last).map(tick).collect(), labels)
}

fn log_ticks([low, high]: [f64; 2], most: usize) -> Vec<(f64, String)> {
    let (first, last) = (exponent(low), exponent(high));
    let decades = (last - first + 1) as usize;
    let inside = |value: &f64| *value >= low * (1.0 - 1e-9) && *value <= high * (1.0 + 1e-9);
    let mantissas: &[f64] = if 3 * decades <= most { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let every = decades.div_ceil(most).max(1);
    let values =
        (first..=last).step_by(every).flat_map(|power| mantissas.iter().map(move |m| m * ten_to(power)));
    let ticks: Vec<(f64, String)> = values.filter(inside).map(|value| (value, decade_label(value))).collect();
    if ticks.len() > 1 {
        ticks
    } else {
        linear_ticks([low, high], most).0.into_iter().map(|(v, _)| (v, typeset(&number(v)))).collect()
    }
}

fn decade_label(value: f64) -> String {
    let power = exponent(value * (1.0 + 1e-9));
    if (-3..=3).contains(&power) {
        return typeset(&number(value));
    }
    match (value / ten_to(power)).round() {
        1.0 => power_of_ten(power),
        mantissa => format!("{mantissa}·{}", power_of_ten(power)),
    }
}

/// The decimal logarithm of a positive number to about 1e-15, with the same bits everywhere.
pub fn log10(x: f64) -> f64 {
    if !(x > 0.0 && x.is_finite()) {
        return if x > 0.0 { f64::INFINITY } else { f64::NEG_INFINITY };
    }
    let power = exponent(x);
    // ln m = 2 artanh((m - 1) / (m + 1)); the square roots bring m in [1, 10) near 1.
    let root = (x / ten_to(power)).sqrt().sqrt().sqrt();
    let t = (root - 1.0) / (root + 1.0);
    let series = (0..8).rev().fold(0.0, |sum, n| sum * t * t + 1.0 / f64::from(2 * n + 1));
    f64::from(power) + 16.0 * t * series / std::f64::consts::LN_10
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: &Scale) -> Vec<&str> {
        scale.ticks.iter().map(|(_, label)| label.as_str()).collect()
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(
            labels(&Scale::linear([-0.65, 0.65], 8)),
            ["−0.6", "−0.4", "−0.2", "0.0", "0.2", "0.4", "0.6"]
        );
        let small = Scale::linear([0.0, 1.2e-5], 6);
        assert_eq!(labels(&small), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0", "1.2"]);
        assert_eq!(small.title("error", "m³"), "error (10⁻⁵ m³)");
        assert_eq!(labels(&Scale::linear([0.0, 250.0], 6)), ["0", "50", "100", "150", "200", "250"]);
        for limits in
            [[3.0, 3.0], [0.0, 0.0], [f64::NAN, 1.0], [2.0, 1.0], [0.0, f64::INFINITY], [1e300, 2e300]]
        {
            let scale = Scale::linear(limits, 5);
            assert!(scale.ticks.len() >= 2 && scale.ticks.len() <= 7, "{scale:?}");
            assert!(scale.ticks.iter().all(|(value, _)| (-1e-9..=1.0 + 1e-9).contains(&scale.place(*value))));
        }
    }

    #[test]
    fn ticks_of_logarithms() {
        assert_eq!(labels(&Scale::log([1e-8, 1e-5], 5)), ["10⁻⁸", "10⁻⁷", "10⁻⁶", "10⁻⁵"]);
        assert_eq!(labels(&Scale::log([0.01, 1.0], 12)), ["0.01", "0.02", "0.05", "0.1", "0.2", "0.5", "1"]);
        assert!(Scale::log([1e-300, 1e300], 6).ticks.len() <= 7);
        assert!(Scale::log([2.1e-3, 2.9e-3], 5).ticks.len() >= 2);
        assert!(Scale::log([0.0, -1.0], 5).ticks.len() >= 2);
        let scale = Scale::log([1e-4, 1.0], 5);
        assert!((scale.place(1e-2) - 0.5).abs() < 1e-14);
        assert_eq!(scale.place(0.0), f64::NEG_INFINITY);
    }

    #[test]
    fn logarithm_is_right() {
        for x in [1e-300, 3.7e-8, 0.1, 0.999, 1.0, 1.001, 2.0, 9.999, 10.0, 12345.0, 1e300] {
            assert!((log10(x) - x.log10()).abs() <= 1e-14 * x.log10().abs().max(1.0), "{x}");
        }
    }
}
