//! What is told of many errors: extremes, means, percentiles, a histogram, and how they vary with the distance.

use glam::DVec3;
use schemars::JsonSchema;
use serde::Serialize;

/// One measured value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Where, metres.
    pub point: DVec3,
    /// Signed distance from the surface there, metres.
    pub distance: f64,
    /// What the asset says.
    pub value: f64,
    /// What is right.
    pub reference: f64,
}

impl Measurement {
    /// Signed error.
    pub fn error(&self) -> f64 {
        self.value - self.reference
    }
}

/// Errors of many points. All but `mean` are of sizes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Statistics {
    /// Number of points.
    pub count: usize,
    /// Largest.
    pub max: f64,
    /// Mean of the signed errors: what doesn't average out.
    pub bias: f64,
    /// Half the width of the 95 % confidence interval of `bias`.
    pub bias_confidence: f64,
    /// Mean of the sizes.
    pub mean: f64,
    /// Root of the mean square.
    pub rms: f64,
    /// Percentiles of the sizes: 50, 90, 99, 99.9.
    pub percentiles: [f64; 4],
    /// With 95 % confidence, no larger part of the sampled space has an error above `max`.
    pub beyond_max: f64,
    /// The worst point.
    pub worst: Option<Worst>,
}

/// The worst point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Worst {
    /// Where, metres.
    pub point: [f64; 3],
    /// Its signed distance from the surface, metres.
    pub distance: f64,
    /// What the asset says.
    pub value: f64,
    /// What is right.
    pub reference: f64,
}

/// The parts of the points whose errors are at most each of the percentiles.
pub const PERCENTILES: [f64; 4] = [0.5, 0.9, 0.99, 0.999];

impl Statistics {
    /// Of measurements, whose errors are divided by `unit`.
    pub fn of<'a>(all: impl Iterator<Item = &'a Measurement>, unit: f64) -> Statistics {
        let all: Vec<&Measurement> = all.collect();
        let n = all.len() as f64;
        if all.is_empty() {
            return Statistics::default();
        }
        let errors = || all.iter().map(|m| m.error() / unit);
        let bias = errors().sum::<f64>() / n;
        let variance = errors().map(|e| (e - bias) * (e - bias)).sum::<f64>() / (n - 1.0).max(1.0);
        let mut sizes: Vec<f64> = errors().map(f64::abs).collect();
        sizes.sort_by(f64::total_cmp);
        // The first of several that are as bad.
        let worst = all.iter().rev().max_by(|a, b| a.error().abs().total_cmp(&b.error().abs()));
        Statistics {
            count: all.len(),
            max: sizes[sizes.len() - 1],
            bias,
            bias_confidence: 1.96 * (variance / n).sqrt(),
            mean: sizes.iter().sum::<f64>() / n,
            rms: (sizes.iter().map(|e| e * e).sum::<f64>() / n).sqrt(),
            percentiles: PERCENTILES.map(|part| percentile(&sizes, part)),
            beyond_max: 1.0 - 0.05f64.powf(1.0 / n),
            worst: worst.map(|m| Worst {
                point: m.point.to_array(),
                distance: m.distance,
                value: m.value,
                reference: m.reference,
            }),
        }
    }
}

/// The smallest number that is no smaller than this part of the sorted ones, which there are.
fn percentile(sorted: &[f64], part: f64) -> f64 {
    let rank = (part * sorted.len() as f64).ceil() as usize;
    sorted[rank.clamp(1, sorted.len()) - 1]
}

/// Points whose error size lies in `low .. high`, as a part of all.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct HistogramBar {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Part of all points.
    pub part: f64,
}

/// Sizes of errors over `unit`, by decades in three steps; smaller ones are in the first bar.
pub fn histogram(all: &[Measurement], unit: f64) -> Vec<HistogramBar> {
    const SMALLEST: i32 = -24;
    let edge = |step: i32| 10f64.powf(f64::from(step) / 3.0);
    let mut counts = [0usize; 1 + SMALLEST.unsigned_abs() as usize];
    for m in all {
        let size = (m.error() / unit).abs();
        let step = (SMALLEST..=0).find(|&step| size < edge(step)).unwrap_or(0);
        counts[(step - SMALLEST) as usize] += 1;
    }
    let bar = |(at, count): (usize, usize)| {
        let step = at as i32 + SMALLEST;
        HistogramBar { low: edge(step - 1), high: edge(step), part: count as f64 / all.len().max(1) as f64 }
    };
    counts.into_iter().enumerate().map(bar).collect()
}

/// Errors of the points in a range of distances from the surface.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct DistanceBin {
    /// Lower end, in support radii.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Number of points.
    pub count: usize,
    /// Mean, 50 and 90 % percentile and maximum of the sizes.
    pub mean: f64,
    /// 50 %.
    pub median: f64,
    /// 90 %.
    pub percentile_90: f64,
    /// Largest.
    pub max: f64,
}

/// Sizes of errors over `unit` from 2 radii deep to 2 radii outside, in `bins` ranges; those without points are left
/// out.
pub fn by_distance(all: &[Measurement], unit: f64, radius: f64, bins: usize) -> Vec<DistanceBin> {
    let edge = |bin: usize| -2.0 + 4.0 * bin as f64 / bins as f64;
    let own = |bin: usize| {
        let (low, high) = (edge(bin), edge(bin + 1));
        let inside = all.iter().filter(|m| (low * radius..high * radius).contains(&m.distance));
        let mut sizes: Vec<f64> = inside.map(|m| (m.error() / unit).abs()).collect();
        sizes.sort_by(f64::total_cmp);
        (!sizes.is_empty()).then(|| DistanceBin {
            low,
            high,
            count: sizes.len(),
            mean: sizes.iter().sum::<f64>() / sizes.len() as f64,
            median: percentile(&sizes, 0.5),
            percentile_90: percentile(&sizes, 0.9),
            max: percentile(&sizes, 1.0),
        })
    };
    (0..bins).filter_map(own).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measurements(n: usize) -> Vec<Measurement> {
        let measurement = |i: usize| Measurement {
            point: DVec3::splat(i as f64),
            distance: -2.0 + 4.0 * i as f64 / n as f64,
            value: if i.is_multiple_of(2) { i as f64 } else { -(i as f64) },
            reference: 0.0,
        };
        (0..n).map(measurement).collect()
    }

    #[test]
    fn figures_are_those_of_a_known_series() {
        let all = measurements(1000);
        let found = Statistics::of(all.iter(), 2.0);
        assert_eq!((found.count, found.max), (1000, 999.0 / 2.0));
        assert_eq!(found.percentiles, [499.0, 899.0, 989.0, 998.0].map(|x| x / 2.0));
        assert!((found.mean - 999.0 / 4.0).abs() < 1e-9 && (found.bias + 0.25).abs() < 1e-9, "{found:?}");
        assert!((found.rms - (999.0f64 * 1999.0 / 6.0).sqrt() / 2.0).abs() < 1e-9);
        assert_eq!(found.worst.map(|w| w.point), Some([999.0; 3]));
        // The rule of three.
        assert!((found.beyond_max - 3.0 / 1000.0).abs() < 1e-5);
        assert_eq!(Statistics::of([].iter(), 1.0), Statistics::default());
    }

    #[test]
    fn every_point_is_in_one_bar_and_one_bin() {
        let all = measurements(1000);
        let parts: f64 = histogram(&all, 1000.0).iter().map(|bar| bar.part).sum();
        assert!((parts - 1.0).abs() < 1e-12);
        let bars = histogram(&all, 1000.0);
        assert_eq!(bars.last().map(|bar| bar.high), Some(1.0));
        let bins = by_distance(&all, 1.0, 1.0, 16);
        assert_eq!(bins.iter().map(|bin| bin.count).sum::<usize>(), 1000);
        assert!(bins.windows(2).all(|pair| pair[0].high == pair[1].low && pair[0].max < pair[1].max));
    }
}
