//! Drag of a body's surface on the particles near it: sticking and tangential friction, Bender et al. 2020, section
//! 4.4.
//!
//! The paper evaluates Eq. 16 (sticking) and Eq. 19 (tangential friction) at the four points x* +- d t1, x* +- d t2
//! around the closest point, d = r/2, each of a quarter of the boundary's volume. All four are s = sqrt(d^2 + Phi^2)
//! away, so that their sums are known, whatever the tangents t1 and t2 are:
//! ```text
//! a = -k [(nu_s + nu_f) 2 d^2 (1 - n n^T) + nu_s 4 Phi^2 n n^T] (v_i - v_B)
//! k = 2 (d + 2) V/4 |W'(s)| / s / (s^2 + 0.01 r^2)
//! ```
//! with nu_s the coefficient of sticking and nu_f that of friction. v_B is the body's velocity continued to x_i: the
//! four velocities of Eq. 17 amount to that exactly, and the four opposite forces, each along the line through x_i
//! and its point, to one at x_i, so that angular momentum is kept, too. In Eq. 19 a rotation about a tangent drops
//! out and v_B is that at x*; here it is that at x_i as well: fluid and body that turn together don't rub.

use crate::bodies::{Bodies, FluidContact};
use volmap_runtime::{DVec3, Kernel, Surface};

/// From the closest point to each of the four points, d, in support radii.
const POINT_DISTANCE: f64 = 0.5;
/// 2 (d + 2) in three dimensions, for each of the four points' share of the volume.
const FACTOR: f64 = 10.0 / 4.0;
/// What is added to the square of a distance, in those of the support radius.
const SMALL: f64 = 0.01;

/// A body's surface on a particle near it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drag {
    /// The particle.
    pub particle: u32,
    /// The body.
    pub body: u32,
    /// Where the particle is, and the opposite force acts, metres.
    pub point: DVec3,
    /// The surface's normal.
    pub normal: DVec3,
    /// Rate at which the particle's velocity along the surface becomes the body's, 1/s.
    pub tangential: f64,
    /// The same across the surface.
    pub across: f64,
}

impl Drag {
    /// What `boundary`, of the body with this `contact`, is to a particle at a point; none where it is nothing.
    pub fn new(
        particle: u32,
        body: u32,
        point: DVec3,
        boundary: &Surface,
        contact: FluidContact,
        kernel: &Kernel,
    ) -> Option<Drag> {
        let FluidContact { viscosity, friction } = contact;
        if viscosity == 0.0 && friction == 0.0 {
            return None;
        }
        let radius = kernel.support_radius();
        let (along, off) = ((POINT_DISTANCE * radius).powi(2), boundary.distance * boundary.distance);
        let distance = (along + off).sqrt();
        let weight =
            -kernel.derivative(distance) / distance / (distance * distance + SMALL * radius * radius);
        let scale = FACTOR * boundary.volume * weight;
        (scale > 0.0).then_some(Drag {
            particle,
            body,
            point,
            normal: boundary.normal,
            tangential: scale * (viscosity + friction) * 2.0 * along,
            across: scale * viscosity * 4.0 * off,
        })
    }

    /// How fast this difference of velocities, particle's less body's, is lost, m/s^2.
    pub fn rate(&self, difference: DVec3) -> DVec3 {
        let across = difference.dot(self.normal) * self.normal;
        self.tangential * (difference - across) + self.across * across
    }

    /// The larger of both rates, 1/s.
    pub fn strongest(&self) -> f64 {
        self.tangential.max(self.across)
    }

    /// [`Drag::rate`] as a matrix, 1/s: xx, yy, zz, xy, xz, yz.
    pub fn matrix(&self) -> [f64; 6] {
        let (n, more) = (self.normal, self.across - self.tangential);
        let at = |a: f64, b: f64| more * a * b;
        [
            self.tangential + at(n.x, n.x),
            self.tangential + at(n.y, n.y),
            self.tangential + at(n.z, n.z),
            at(n.x, n.y),
            at(n.x, n.z),
            at(n.y, n.z),
        ]
    }

    /// From the body's centre of mass to where the force acts, metres.
    pub fn arm(&self, bodies: &Bodies) -> DVec3 {
        self.point - bodies.center_of_mass(self.body as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use volmap_runtime::{DQuat, KernelKind};

    /// A particle and a body that move and turn somehow, and what the four points make of it: force on the particle
    /// for each mass, and the torque of its opposite about the body's centre.
    fn four_points(
        boundary: &Surface,
        x: DVec3,
        motion: &Motion,
        kernel: &Kernel,
        sticks: bool,
    ) -> [DVec3; 2] {
        let n = boundary.normal;
        let first = n.any_orthonormal_vector();
        // Any two tangents.
        let turn = DQuat::from_axis_angle(n, 0.4);
        let (t1, t2) = (turn * first, turn * n.cross(first));
        let mut sum = [DVec3::ZERO; 2];
        for tangent in [t1, -t1, t2, -t2] {
            let point = boundary.closest_point + 0.5 * kernel.support_radius() * tangent;
            // Eq. 17
            let velocity = motion.velocity + motion.turn.cross(point - motion.centre);
            let mut apart = motion.particle - velocity;
            if !sticks {
                // Eq. 18
                apart -= apart.dot(n) * n;
            }
            let to = x - point;
            let square = to.length_squared() + 0.01 * kernel.support_radius().powi(2);
            // Eq. 16 and 19
            let slope = kernel.derivative(to.length()) * to.normalize();
            let force = 10.0 * 0.25 * boundary.volume * apart.dot(to) / square * slope;
            sum = [sum[0] + force, sum[1] + (point - motion.centre).cross(-force)];
        }
        sum
    }

    struct Motion {
        particle: DVec3,
        velocity: DVec3,
        turn: DVec3,
        centre: DVec3,
    }

    const RADIUS: f64 = 0.1;

    fn boundary(distance: f64) -> (Surface, DVec3) {
        let (normal, x) = (DVec3::new(0.6, -0.64, 0.48), DVec3::new(0.3, 0.2, -0.7));
        (Surface { distance, normal, closest_point: x - distance * normal, volume: 2.1e-3 }, x)
    }

    #[test]
    fn four_points_are_their_closed_form() {
        let centre = DVec3::new(-0.2, 0.5, 0.1);
        let (particle, velocity) = (DVec3::new(0.4, -1.0, 0.3), DVec3::new(-0.3, 0.2, 0.8));
        for kernel in KernelKind::ALL.map(|kind| Kernel::new(kind, RADIUS)) {
            for distance in [0.08, 0.05, 0.02, 0.0, -0.03] {
                let (boundary, x) = boundary(distance);
                for (contact, turn) in [
                    (FluidContact { viscosity: 1.0, friction: 0.0 }, DVec3::new(2.0, -5.0, 3.0)),
                    // Without a rotation about a tangent, which Eq. 19 sees at x*.
                    (FluidContact { viscosity: 0.0, friction: 1.0 }, 3.0 * boundary.normal),
                ] {
                    let motion = Motion { particle, velocity, turn, centre };
                    let drag = Drag::new(0, 0, x, &boundary, contact, &kernel).unwrap();
                    let got = -drag.rate(particle - velocity - turn.cross(x - centre));
                    let [force, torque] =
                        four_points(&boundary, x, &motion, &kernel, contact.viscosity > 0.0);
                    let size = force.length() + 1e-9;
                    assert!(
                        (got - force).length() < 1e-12 * size,
                        "{:?} {distance}: {got} {force}",
                        kernel.kind()
                    );
                    let opposite = (x - centre).cross(-got);
                    assert!((opposite - torque).length() < 1e-12 * size, "{opposite} {torque}");
                }
            }
        }
    }

    #[test]
    fn matrices_are_the_rates() {
        let (boundary, x) = boundary(0.03);
        let kernel = Kernel::new(KernelKind::CubicSpline, RADIUS);
        let contact = FluidContact { viscosity: 0.5, friction: 2.0 };
        let drag = Drag::new(3, 1, x, &boundary, contact, &kernel).unwrap();
        let [xx, yy, zz, xy, xz, yz] = drag.matrix();
        for (axis, column) in [(DVec3::X, [xx, xy, xz]), (DVec3::Y, [xy, yy, yz]), (DVec3::Z, [xz, yz, zz])] {
            assert!((drag.rate(axis) - DVec3::from(column)).length() < 1e-12 * drag.tangential);
        }
        let (none, far) = (FluidContact::default(), Surface { distance: 0.9 * RADIUS, ..boundary });
        assert_eq!(Drag::new(3, 1, x, &boundary, none, &kernel), None);
        assert_eq!(Drag::new(3, 1, x, &far, contact, &kernel), None, "all four are farther than r");
    }
}
