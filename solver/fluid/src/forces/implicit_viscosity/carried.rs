//! Bodies in the viscous solve. Free ones give way to the drag that is being looked for, so that fluid and body agree
//! at the end of the step: their velocities are eliminated from the system, which stays symmetric (a Schur
//! complement).
//!
//! ```text
//! (M + G) u = M u0 + dt m sum J^T B v,   G = dt m sum J^T B J,   J: u, linear and angular, -> velocity at x_i
//! u = u0 + K dt m sum J^T B (v - J u0),   K = (M + G)^-1 = (1 + R G)^-1 R,   R = M^-1, which is 0 along locked axes
//! ```
//! m is a particle's mass, u0 the body's velocity by all forces so far. The idea is that of Gissler et al. 2019,
//! *Interlinked SPH Pressure Solvers for Strong Fluid-Rigid Coupling*.

use crate::bodies::Bodies;
use crate::boundary::Boundary;
use crate::boundary::drag::Drag;
use crate::coupling::Motions;
use crate::pairs::Quad;
use nalgebra::{Matrix6, Vector6};
use volmap_runtime::DVec3;

/// A vector of each particle.
pub type Field<'a> = &'a dyn Fn(usize) -> DVec3;

/// What the particles would get of a solve: the sums over them of v0 . w and |w|^2, where v0 are the velocities before
/// and v0 - w those after it, m^2/s^2.
#[derive(Clone, Copy, Debug, Default)]
pub struct Exchanged {
    pub along: f64,
    pub square: f64,
}

impl Exchanged {
    /// Adds a particle: its velocity before, and what it loses.
    pub fn add(&mut self, before: DVec3, lost: DVec3) {
        self.along += before.dot(lost);
        self.square += lost.length_squared();
    }

    /// Both together.
    pub fn and(self, other: Exchanged) -> Exchanged {
        Exchanged { along: self.along + other.along, square: self.square + other.square }
    }
}

/// The bodies and what they are to a viscous solve.
pub struct Carried<'a> {
    bodies: &'a Bodies,
    boundary: &'a Boundary,
    /// Mass of a particle, kg.
    mass: f64,
    /// Time step, seconds.
    dt: f64,
    /// Velocities without drag, m/s and rad/s, u0.
    known: Motions,
    /// K of each body, none if it isn't free or touches nothing.
    inverses: Vec<Option<Matrix6<f64>>>,
}

impl<'a> Carried<'a> {
    /// For particles of a mass (kg) and a step of `dt` seconds.
    pub fn new(bodies: &'a Bodies, boundary: &'a Boundary, mass: f64, dt: f64) -> Carried<'a> {
        let known = |body: usize| {
            let (state, [linear, angular]) = (bodies.state(body), bodies.acceleration(body));
            [state.velocity + dt * linear, state.angular_velocity + dt * angular]
        };
        let count = bodies.posed().len();
        let mut carried = Carried {
            bodies,
            boundary,
            mass,
            dt,
            known: (0..count).map(known).collect(),
            inverses: vec![None; count],
        };
        carried.inverses = carried.inverses();
        carried
    }

    /// Velocities of bodies among particles of these velocities.
    pub fn velocities(&self, field: Field) -> Motions {
        let mut motions = self.changes(field, &self.known);
        for (motion, known) in motions.iter_mut().zip(&self.known) {
            *motion = [motion[0] + known[0], motion[1] + known[1]];
        }
        motions
    }

    /// The same without the known velocities: what of it depends on the particles.
    pub fn response(&self, field: Field) -> Motions {
        self.changes(field, &vec![[DVec3::ZERO; 2]; self.known.len()])
    }

    /// Sum of the squares of the known velocities where they touch the fluid, m^2/s^2.
    pub fn square(&self) -> f64 {
        self.boundary.drags().map(|drag| self.at(drag, &self.known).length_squared()).sum()
    }

    /// A body's velocity at a particle, m/s.
    pub fn at(&self, drag: &Drag, motions: &[[DVec3; 2]]) -> DVec3 {
        let [linear, angular] = motions[drag.body as usize];
        linear + angular.cross(drag.arm(self.bodies))
    }

    /// Momentum and angular momentum about the centre of mass that particles and bodies of these velocities exchange
    /// in the step: what each body gets.
    pub fn impulses(&self, field: Field, motions: &[[DVec3; 2]]) -> Motions {
        self.exchange(field, motions, |_| true)
    }

    /// How much of what particles and bodies (`impulses`) exchange is done, from 0 to 1: what takes the most energy.
    /// Done in part, an exchange takes
    /// ```text
    /// E(part) = part (m sum v0 . w - sum J . u0) - part^2 / 2 (m sum |w|^2 + sum J . R J)
    /// ```
    /// from particles, free bodies and whoever drives the others; J is a body's impulse. If the system is solved, that
    /// grows up to a part of more than 1: gain - cost is then what viscosity and drag dissipate.
    pub fn part(&self, of_particles: Exchanged, impulses: &[[DVec3; 2]]) -> f64 {
        let mut gain = self.mass * of_particles.along;
        let mut cost = self.mass * of_particles.square;
        for (body, (&[push, turn], known)) in impulses.iter().zip(&self.known).enumerate() {
            gain -= push.dot(known[0]) + turn.dot(known[1]);
            if self.bodies.is_free(body) {
                let [linear, angular] = self.bodies.response(body, push, turn);
                cost += push.dot(linear) + turn.dot(angular);
            }
        }
        if gain >= cost { 1.0 } else { (gain / cost).max(0.0) }
    }

    fn changes(&self, field: Field, motions: &[[DVec3; 2]]) -> Motions {
        let impulses = self.exchange(field, motions, |body| self.inverses[body].is_some());
        let change = |(impulse, inverse): (&[DVec3; 2], &Option<Matrix6<f64>>)| {
            inverse.map_or([DVec3::ZERO; 2], |inverse| motion(&(inverse * vector(*impulse))))
        };
        impulses.iter().zip(&self.inverses).map(change).collect()
    }

    fn exchange(&self, field: Field, motions: &[[DVec3; 2]], of: impl Fn(usize) -> bool) -> Motions {
        let mut sums = vec![[DVec3::ZERO; 2]; motions.len()];
        if !(0..motions.len()).any(&of) {
            return sums;
        }
        for drag in self.boundary.drags().filter(|drag| of(drag.body as usize)) {
            let own = field(drag.particle as usize);
            let impulse = self.mass * self.dt * drag.rate(own - self.at(drag, motions));
            let [linear, angular] = &mut sums[drag.body as usize];
            *linear += impulse;
            *angular += drag.arm(self.bodies).cross(impulse);
        }
        sums
    }

    /// K of each body.
    fn inverses(&self) -> Vec<Option<Matrix6<f64>>> {
        let mut resistances: Vec<Option<Matrix6<f64>>> = vec![None; self.known.len()];
        for drag in self.boundary.drags().filter(|drag| self.bodies.is_free(drag.body as usize)) {
            let resistance = resistances[drag.body as usize].get_or_insert_with(Matrix6::zeros);
            for (column, unit) in units().into_iter().enumerate() {
                let impulse = self.mass * self.dt * drag.rate(unit[0] + unit[1].cross(drag.arm(self.bodies)));
                let both = vector([impulse, drag.arm(self.bodies).cross(impulse)]);
                resistance.set_column(column, &(resistance.column(column) + both));
            }
        }
        let inverse = |(body, resistance): (usize, Option<Matrix6<f64>>)| {
            let response = |[force, torque]: [DVec3; 2]| vector(self.bodies.response(body, force, torque));
            let response = Matrix6::from_columns(&units().map(response));
            (Matrix6::identity() + response * resistance?).lu().solve(&response)
        };
        resistances.into_iter().enumerate().map(inverse).collect()
    }
}

/// Along and about each axis.
fn units() -> [[DVec3; 2]; 6] {
    std::array::from_fn(|n| {
        let axis = DVec3::AXES[n % 3];
        if n < 3 { [axis, DVec3::ZERO] } else { [DVec3::ZERO, axis] }
    })
}

fn vector([linear, angular]: [DVec3; 2]) -> Vector6<f64> {
    Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

fn motion(vector: &Vector6<f64>) -> [DVec3; 2] {
    let at = |first: usize| DVec3::new(vector[first], vector[first + 1], vector[first + 2]);
    [at(0), at(3)]
}

/// The vector of a field at a particle.
pub(super) fn velocity([x, y, z, _]: Quad) -> DVec3 {
    DVec3::new(x.into(), y.into(), z.into())
}
