//! temp: moves to the runtime
pub fn plane_volume(distance: f64, radius: f64, ball: f64) -> f64 {
    let q = (distance / radius).max(-1.0);
    let at = |b: f64| (b - q).max(0.0);
    let cubes = |t: f64, sign: f64| t.powi(5) * (0.1 - sign / 60.0 * t);
    let squares = |t: f64| t.powi(4) * (1.0 / 6.0 - t / 30.0);
    let sum = 2.0 * (cubes(at(2.0), 1.0) + cubes(at(0.0), -1.0)) - 8.0 * (cubes(at(1.5), 1.0) + cubes(at(-0.5), -1.0))
        + 6.0 * (cubes(at(1.0), 1.0) + squares(at(1.0)));
    0.75 * ball * sum
}
