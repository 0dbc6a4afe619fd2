//! What is measured of a simulation, whatever the experiment: speeds, energies, momenta, centre of mass.

use crate::error::Error;
use crate::simulation::{Simulation, StepReport};
use volmap_runtime::DVec3;

/// Simulates until a time (seconds), and shows every step to `look`.
///
/// # Errors
/// As [`Simulation::step`].
pub fn until(
    simulation: &mut Simulation,
    time: f64,
    look: &mut dyn FnMut(&Simulation, &StepReport),
) -> Result<(), Error> {
    while simulation.time() < time - 1e-9 {
        let report = simulation.step()?;
        look(simulation, &report);
    }
    Ok(())
}

/// The particles' velocities, m/s.
pub fn velocities(simulation: &Simulation) -> impl Iterator<Item = DVec3> {
    simulation.particles().velocities.iter().map(|&velocity| DVec3::from(velocity.map(f64::from)))
}

/// Root of the mean square of the particles' speeds, m/s.
pub fn rms_speed(simulation: &Simulation) -> f64 {
    let sum: f64 = velocities(simulation).map(DVec3::length_squared).sum();
    (sum / simulation.particles().len().max(1) as f64).sqrt()
}

/// Kinetic energy of the fluid, joule.
pub fn kinetic_energy(simulation: &Simulation) -> f64 {
    let sum: f64 = velocities(simulation).map(DVec3::length_squared).sum();
    0.5 * simulation.particle_mass() * sum
}

/// Momentum of the fluid, kg m/s, and angular momentum about the origin, kg m^2/s.
pub fn momenta(simulation: &Simulation) -> [DVec3; 2] {
    let all = simulation.particles().positions.iter().zip(velocities(simulation));
    let add = |[p, l]: [DVec3; 2], (x, v): (&DVec3, DVec3)| [p + v, l + x.cross(v)];
    all.fold([DVec3::ZERO; 2], add).map(|sum| simulation.particle_mass() * sum)
}

/// The fluid's centre of mass, metres.
pub fn centre(simulation: &Simulation) -> DVec3 {
    let positions = &simulation.particles().positions;
    positions.iter().sum::<DVec3>() / positions.len().max(1) as f64
}

/// The value below which a part (0 to 1) of all lies, linearly between the nearest two; NaN of none.
pub fn percentile(values: &[f64], part: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let place = part.clamp(0.0, 1.0) * last as f64;
    let below = place as usize;
    let above = (below + 1).min(last);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

/// Offset and slope of the line of least squares through points (x, y).
pub fn line(points: &[[f64; 2]]) -> [f64; 2] {
    let count = points.len() as f64;
    let mean = |axis: usize| points.iter().map(|point| point[axis]).sum::<f64>() / count;
    let [x, y] = [mean(0), mean(1)];
    let [mut square, mut product] = [0.0; 2];
    for point in points {
        square += (point[0] - x).powi(2);
        product += (point[0] - x) * (point[1] - y);
    }
    let slope = product / square;
    [y - slope * x, slope]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_and_lines_are_those_of_the_textbook() {
        assert_eq!(percentile(&[3.0, 1.0, 2.0, 5.0, 4.0], 0.5), 3.0);
        assert_eq!(percentile(&[1.0, 2.0], 0.99), 1.99);
        assert!(percentile(&[], 0.5).is_nan());
        let [offset, slope] = line(&[[0.0, 1.0], [1.0, 3.5], [2.0, 5.0]]);
        assert!((slope - 2.0).abs() < 1e-12 && (offset - 7.0 / 6.0).abs() < 1e-12);
    }
}
