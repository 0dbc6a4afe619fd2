//! Functions of one number as cubic Hermite splines on equal intervals: continuous with their first derivatives, and
//! the derivative that is returned is that of the spline itself.

/// `N` functions, tabulated together.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Table<const N: usize> {
    low: f64,
    per_step: f64,
    /// Value and slope (times the step) of every function at every node.
    nodes: Vec<[[f64; 2]; N]>,
}

impl<const N: usize> Table<N> {
    /// Tabulates from `low` to `high`; `f` gives value and derivative of every function.
    pub fn new(low: f64, high: f64, intervals: usize, f: impl Fn(f64) -> [[f64; 2]; N]) -> Table<N> {
        let step = (high - low) / intervals as f64;
        let node = |n: usize| f(low + n as f64 * step).map(|[value, slope]| [value, slope * step]);
        Table { low, per_step: 1.0 / step, nodes: (0..=intervals).map(node).collect() }
    }

    /// Keeps function `n`, which falls everywhere, from undershooting where it comes to its end as a high power:
    /// Fritsch and Carlson 1980, *Monotone Piecewise Cubic Interpolation*.
    pub fn limit(mut self, n: usize) -> Table<N> {
        let values: Vec<f64> = self.nodes.iter().map(|node| node[n][0]).collect();
        for (interval, rise) in values.windows(2).map(|pair| pair[1] - pair[0]).enumerate() {
            for node in &mut self.nodes[interval..interval + 2] {
                node[n][1] = node[n][1].max(3.0 * rise);
            }
        }
        self
    }

    /// Values and derivatives at `x`; those of the nearer end beyond the ends (and of the lower one for NaN).
    #[inline]
    pub fn at(&self, x: f64) -> [[f64; 2]; N] {
        let last = self.nodes.len() - 2;
        let place = (x - self.low) * self.per_step;
        let interval = (place as usize).min(last);
        let t = (place - interval as f64).clamp(0.0, 1.0);
        let ([from, to], mut out) = ([self.nodes[interval], self.nodes[interval + 1]], [[0.0; 2]; N]);
        for (out, (from, to)) in out.iter_mut().zip(from.iter().zip(&to)) {
            *out = hermite(*from, *to, t);
            out[1] *= self.per_step;
        }
        out
    }
}

/// Value and derivative at t in 0..=1 of the cubic with these values and slopes at both ends.
#[inline]
fn hermite([a, da]: [f64; 2], [b, db]: [f64; 2], t: f64) -> [f64; 2] {
    let rise = b - a;
    let (square, cube) = (3.0 * rise - 2.0 * da - db, da + db - 2.0 * rise);
    [a + t * (da + t * (square + t * cube)), da + t * (2.0 * square + t * 3.0 * cube)]
}

/// Functions and their derivatives, from differences within low..=high.
pub(crate) fn with_slopes<const N: usize>(
    f: impl Fn(f64) -> [f64; N],
    d: f64,
    low: f64,
    high: f64,
) -> [[f64; 2]; N] {
    const STEP: f64 = 1e-5;
    let (from, to) = ((d - STEP).max(low), (d + STEP).min(high));
    let (value, below, above) = (f(d), f(from), f(to));
    std::array::from_fn(|n| [value[n], (above[n] - below[n]) / (to - from)])
}
