//! Integrals along a line by Gauss and Legendre's rule of 5 points: exact to degree 9, which is that of every piece
//! of every integrand here (the sixth degree of Poly6 times a cubic).

/// The integral of `f` from `low` to `high`, exact where it is one polynomial there; 0 for an empty range.
pub(crate) fn integrate(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    if high <= low {
        return 0.0;
    }
    let root = (10.0_f64 / 7.0).sqrt();
    let near = (5.0 - 2.0 * root).sqrt() / 3.0;
    let far = (5.0 + 2.0 * root).sqrt() / 3.0;
    let part = 13.0 * 70.0_f64.sqrt();
    let (near_weight, far_weight) = ((322.0 + part) / 900.0, (322.0 - part) / 900.0);
    let (half, middle) = (0.5 * (high - low), 0.5 * (high + low));
    let pair = |x: f64| f(middle - half * x) + f(middle + half * x);
    half * (128.0 / 225.0 * f(middle) + near_weight * pair(near) + far_weight * pair(far))
}

/// The same, of a function that is a polynomial between ascending `breaks`.
pub(crate) fn integrate_pieces(breaks: &[f64], low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let mut sum = 0.0;
    let mut from = low;
    for &end in breaks.iter().filter(|&&end| low < end && end < high) {
        sum += integrate(from, end, &f);
        from = end;
    }
    sum + integrate(from, high, &f)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degree_9_is_exact_and_degree_10_is_not() {
        let error = |n: i32| {
            integrate(0.5, 2.0, |x| x.powi(n)) * f64::from(n + 1)
                / (2.0_f64.powi(n + 1) - 0.5_f64.powi(n + 1))
                - 1.0
        };
        for n in 0..=9 {
            assert!(error(n).abs() < 1e-14, "{n}");
        }
        assert!(error(10).abs() > 1e-8);
    }

    #[test]
    fn pieces_are_joined() {
        let sum = integrate_pieces(&[-1.0, 0.0, 3.0], -0.5, 2.0, f64::abs);
        assert!((sum - 2.125).abs() < 1e-15);
    }
}
