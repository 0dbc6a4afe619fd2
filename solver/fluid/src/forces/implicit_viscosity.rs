//! Implicit viscosity and the drag of bodies: Weiler et al. 2018, *A Physically Consistent Implicit Viscosity Solver
//! for SPH Fluids*; boundaries by Bender et al. 2020, section 4.4 ([`drag`](crate::boundary::drag)).
//!
//! Unknown are the velocities v at the end of the step; v0 are those before it, with gravity:
//! ```text
//! v_i - dt nu (Laplacian v)_i + dt sum B (v_i - v_B) = v0_i      (Weiler et al.)
//! ```
//! the Laplacian as in Eq. 16 of Bender et al. 2020. Particles have one mass and one volume, so the matrix is
//! symmetric; its eigenvalues are 1 or more. Conjugate gradients without a matrix, in single precision with products
//! in double precision; the preconditioner is the inverse of its 3 x 3 diagonal blocks. A solve begins with the last
//! step's change of the velocities.
//!
//! Kept at any tolerance, and where a solve ends by its iterations: momentum, angular momentum, and energy, which never
//! grows. What is left of the residual when a solve ends is added to the velocities, which makes them v0 - w, w what
//! particles and bodies exchange: opposite forces along the lines between them, to the rounding of
//! [bends](crate::pairs). If w would add energy, the part of it is done that takes the most (`Carried::part`); the
//! rest stays undone, and the error tells.
//!
//! What is too stiff for single precision is solved for in double precision (`stiff.rs`).

mod carried;
mod stiff;

use super::viscosity::viscous_weights;
use super::{Force, ForceStep, Solved};
use crate::boundary::Boundary;
use crate::boundary::drag::Drag;
use crate::channels::{ChannelDeclaration, Channels, Initial};
use crate::coupling::Motions;
use crate::neighbours::Neighbours;
use crate::pairs::lists::Lists;
use crate::pairs::{Quad, Symmetric, sums, workspace};
use crate::particles::CHUNK;
use crate::report::SolveReport;
use crate::settings::{FluidSettings, ViscositySolveSettings, World};
use carried::{Carried, Exchanged};
use glam::DMat3;
use rayon::prelude::*;
use stiff::StiffSolver;
use volmap_runtime::DVec3;

/// Changes of the velocities in the last step, m/s: where the next solve begins.
pub(crate) const CHANGES: ChannelDeclaration =
    ChannelDeclaration { name: "viscous_changes", initial: Initial::Vector([0.0; 3]), in_frames: false };

/// Single precision is enough up to this: dt times the rate at which viscosity or drag takes a particle's velocity
/// from it. The velocities' rounding, 6e-8, times it is left of the residual, which must come below 1e-3.
const STIFF: f64 = 1e4;

/// dt times that rate of viscosity is taken for no larger: so much leaves neighbours 1e-6 of what would part them in a
/// step. More takes more iterations than solves are allowed, and then far less is done.
const RIGID: f64 = 1e6;

/// Viscosity and drag as a solve.
#[derive(Clone, Debug, Default)]
pub struct ImplicitViscosity {
    /// Kinematic viscosity of the fluid, nu, m^2/s; 0 for the bodies' drag alone.
    viscosity: f64,
    /// When to stop.
    settings: ViscositySolveSettings,
    /// See [`viscous_weights`], 1/m^2.
    weights: f64,
    solver: Solver,
    stiff: StiffSolver,
}

/// Room for the vectors of conjugate gradients, one for each particle.
#[derive(Clone, Debug, Default)]
struct Solver {
    residual: Vec<Quad>,
    direction: Vec<Quad>,
    /// The system times the direction, or the preconditioned residual.
    product: Vec<Quad>,
    /// The preconditioner.
    inverses: Vec<Symmetric>,
}

/// Squares of the residual: as it is, and times the preconditioner.
#[derive(Clone, Copy, Default)]
struct Squares {
    plain: f64,
    preconditioned: f64,
}

impl ImplicitViscosity {
    /// Of a fluid; its viscosity is none if it is explicit.
    pub fn new(fluid: &FluidSettings, world: &World, settings: &ViscositySolveSettings) -> ImplicitViscosity {
        let ([_, viscosity], weights) = (fluid.viscosities(), viscous_weights(world));
        ImplicitViscosity { viscosity, settings: settings.clone(), weights, ..ImplicitViscosity::default() }
    }

    /// Whether single precision isn't enough.
    fn is_stiff(&self, step: &ForceStep) -> bool {
        let strongest = step.boundary.drags().map(Drag::strongest).fold(0.0, f64::max);
        step.dt * (self.viscosity * self.weights).max(strongest) > STIFF
    }
}

impl Force for ImplicitViscosity {
    fn name(&self) -> &'static str {
        "implicit viscosity"
    }

    fn channels(&self) -> Vec<ChannelDeclaration> {
        vec![CHANGES]
    }

    fn needs_bends(&self) -> bool {
        self.viscosity > 0.0
    }

    fn solve(
        &mut self,
        step: &ForceStep,
        velocities: &mut [Quad],
        channels: &mut Channels,
    ) -> Option<Solved> {
        if self.viscosity == 0.0 && step.boundary.drags().next().is_none() {
            return None;
        }
        let carried = Carried::new(step.bodies, step.boundary, step.particle_mass, step.dt);
        let system = System {
            neighbours: step.neighbours,
            boundary: step.boundary,
            carried,
            viscosity: self.viscosity.min(RIGID / (step.dt * self.weights)),
            dt: step.dt,
        };
        let changes = channels.vectors_mut(CHANGES.name);
        Some(if self.is_stiff(step) {
            self.stiff.solve(&system, step, &self.settings, velocities, changes)
        } else {
            self.solver.solve(&system, &self.settings, velocities, changes)
        })
    }

    fn memory_bytes(&self) -> usize {
        let Solver { residual, direction, product, inverses } = &self.solver;
        let quads = residual.capacity() + direction.capacity() + product.capacity();
        let plain = size_of::<Quad>() * quads + size_of::<Symmetric>() * inverses.capacity();
        plain + self.stiff.memory_bytes()
    }
}

/// The system of equations of a step.
struct System<'a> {
    /// Who is near whom; with bends where there is viscosity.
    neighbours: &'a Neighbours,
    /// Whose drag is near.
    boundary: &'a Boundary,
    carried: Carried<'a>,
    viscosity: f64,
    dt: f64,
}

/// A vector for each particle, and the motions of the bodies that belong to it.
struct Unknowns<'a> {
    fluid: &'a [Quad],
    bodies: &'a Motions,
}

impl Solver {
    /// Solves for the velocities. `changes` are those of the velocities in the last step, with which it begins, and
    /// in this one.
    fn solve(
        &mut self,
        system: &System,
        settings: &ViscositySolveSettings,
        velocities: &mut [Quad],
        changes: &mut [[f32; 3]],
    ) -> Solved {
        let (carried, mut room) = (&system.carried, std::mem::take(&mut self.product));
        room.resize(velocities.len(), [0.0; 4]);
        let scale = begin(velocities, changes) + carried.square();
        self.precondition(system, velocities.len());
        let mut squares = self.begin_at(system, velocities, changes, &mut room);
        if squares.plain > scale {
            squares = self.begin_again(system, velocities, changes, squares, &mut room);
        }
        let mut report = SolveReport::default();
        loop {
            report.error = if scale > 0.0 { (squares.plain / scale).sqrt() } else { 0.0 };
            if report.error <= settings.max_error || report.iterations >= settings.max_iterations {
                break;
            }
            let bodies = carried.response(&of(&self.direction));
            let product = system.apply(&Unknowns { fluid: &self.direction, bodies: &bodies }, &mut room);
            if product.is_nan() || product <= 0.0 {
                break;
            }
            let step = (squares.preconditioned / product) as f32;
            let next = self.descend(step, velocities, &mut room);
            self.turn((next.preconditioned / squares.preconditioned) as f32, &room);
            squares = next;
            report.iterations += 1;
        }
        self.product = room;
        let impulses = carried.impulses(&of(velocities), &carried.velocities(&of(velocities)));
        let part = carried.part(self.exchanged(velocities, changes), &impulses);
        let on_bodies = system.forces(&impulses, part);
        self.end(part as f32, velocities, changes);
        Solved { report, on_bodies }
    }

    /// The first residual and direction of these velocities; `before` are those before the solve.
    fn begin_at(
        &mut self,
        system: &System,
        velocities: &[Quad],
        before: &[[f32; 3]],
        room: &mut [Quad],
    ) -> Squares {
        let bodies = system.carried.velocities(&of(velocities));
        system.apply(&Unknowns { fluid: velocities, bodies: &bodies }, room);
        self.first_residual(before, room)
    }

    /// The last step's change leads astray: begins with the velocities before, unless that is worse.
    fn begin_again(
        &mut self,
        system: &System,
        velocities: &mut [Quad],
        before: &[[f32; 3]],
        warm: Squares,
        room: &mut [Quad],
    ) -> Squares {
        let start = velocities.to_vec();
        for (velocity, &[x, y, z]) in velocities.iter_mut().zip(before) {
            *velocity = [x, y, z, 0.0];
        }
        let cold = self.begin_at(system, velocities, before, room);
        if cold.plain <= warm.plain {
            return cold;
        }
        velocities.copy_from_slice(&start);
        self.begin_at(system, velocities, before, room)
    }

    /// What the particles get of the whole exchange.
    fn exchanged(&self, velocities: &[Quad], before: &[[f32; 3]]) -> Exchanged {
        let chunks = velocities.par_chunks(CHUNK).zip(before.par_chunks(CHUNK));
        let parts = chunks.zip(self.residual.par_chunks(CHUNK)).map(|((velocities, before), residual)| {
            let mut sum = Exchanged::default();
            for ((velocity, before), residual) in velocities.iter().zip(before).zip(residual) {
                let before = DVec3::from_array(before.map(f64::from));
                sum.add(before, before - carried::velocity(*velocity) - carried::velocity(*residual));
            }
            sum
        });
        parts.collect::<Vec<_>>().into_iter().fold(Exchanged::default(), Exchanged::and)
    }

    /// Inverts the diagonal blocks.
    fn precondition(&mut self, system: &System, count: usize) {
        self.inverses.resize(count, [0.0; 6]);
        let step = system.dt * system.viscosity;
        system.neighbours.with(&mut self.inverses).enumerate().for_each(|(block, (lists, out))| {
            out.fill([0.0; 6]);
            if step > 0.0 {
                let bends = lists.bends().expect("asked for where there is viscosity");
                sums::squares_of_bends(lists, bends, out);
            }
            let unit = step * f64::from(lists.unit_of_bends());
            let mut matrices: Vec<[f64; 6]> =
                out.iter().map(|own| own.map(|x| unit * f64::from(x))).collect();
            for drag in system.boundary.drags_of_block(block) {
                let matrix = &mut matrices[drag.particle as usize - lists.first];
                for (sum, x) in matrix.iter_mut().zip(drag.matrix()) {
                    *sum += system.dt * x;
                }
            }
            for (out, matrix) in out.iter_mut().zip(matrices) {
                let DMat3 { x_axis: x, y_axis: y, z_axis: z } = inverse_of_one_plus(matrix);
                *out = [x.x, y.y, z.z, x.y, x.z, y.z].map(|number| number as f32);
            }
        });
    }

    /// r = v0 - A v, of v0 as `before` and A v as `product`; the first direction.
    fn first_residual(&mut self, before: &[[f32; 3]], product: &[Quad]) -> Squares {
        self.residual.resize(product.len(), [0.0; 4]);
        self.direction.clear();
        self.direction.resize(product.len(), [0.0; 4]);
        let chunks = self.residual.par_chunks_mut(CHUNK).zip(self.direction.par_chunks_mut(CHUNK));
        let given =
            before.par_chunks(CHUNK).zip(product.par_chunks(CHUNK)).zip(self.inverses.par_chunks(CHUNK));
        let parts = chunks.zip(given).map(|((residual, direction), ((before, product), inverses))| {
            let mut squares = Squares::default();
            for (n, inverse) in inverses.iter().enumerate() {
                for axis in 0..3 {
                    residual[n][axis] = before[n][axis] - product[n][axis];
                }
                direction[n] = multiply(inverse, residual[n]);
                squares.add(residual[n], direction[n]);
            }
            squares
        });
        sum(parts.collect())
    }

    /// Goes `step` far: v <- v + step p, r <- r - step A p; the preconditioned residual takes the place of A p.
    fn descend(&mut self, step: f32, velocities: &mut [Quad], product: &mut [Quad]) -> Squares {
        let chunks = velocities.par_chunks_mut(CHUNK).zip(self.residual.par_chunks_mut(CHUNK));
        let given = self.direction.par_chunks(CHUNK).zip(self.inverses.par_chunks(CHUNK));
        let all = chunks.zip(product.par_chunks_mut(CHUNK)).zip(given);
        let parts = all.map(|(((velocities, residual), product), (direction, inverses))| {
            let mut squares = Squares::default();
            for (n, inverse) in inverses.iter().enumerate() {
                for axis in 0..3 {
                    velocities[n][axis] += step * direction[n][axis];
                    residual[n][axis] -= step * product[n][axis];
                }
                product[n] = multiply(inverse, residual[n]);
                squares.add(residual[n], product[n]);
            }
            squares
        });
        sum(parts.collect())
    }

    /// The next direction: p <- z + part p.
    fn turn(&mut self, part: f32, preconditioned: &[Quad]) {
        let all = self.direction.par_iter_mut().zip(preconditioned).with_min_len(CHUNK);
        all.for_each(|(direction, z)| {
            for axis in 0..3 {
                direction[axis] = z[axis] + part * direction[axis];
            }
        });
    }

    /// Adds the residual, and does a part of the whole change; `changes`, which are the velocities before, become it.
    fn end(&self, part: f32, velocities: &mut [Quad], changes: &mut [[f32; 3]]) {
        let all = velocities.par_iter_mut().zip(changes).zip(&self.residual).with_min_len(CHUNK);
        all.for_each(|((velocity, change), residual)| {
            for axis in 0..3 {
                velocity[axis] += residual[axis];
                if part < 1.0 {
                    velocity[axis] = change[axis] + part * (velocity[axis] - change[axis]);
                }
                change[axis] = velocity[axis] - change[axis];
            }
        });
    }
}

/// The vectors of a field.
fn of(field: &[Quad]) -> impl Fn(usize) -> DVec3 + '_ {
    |particle| carried::velocity(field[particle])
}

impl System<'_> {
    /// Forces and torques of a part of these impulses.
    fn forces(&self, impulses: &[[DVec3; 2]], part: f64) -> Motions {
        impulses.iter().map(|&[push, turn]| [part * push / self.dt, part * turn / self.dt]).collect()
    }

    /// Writes A u; the product u . A u.
    fn apply(&self, of: &Unknowns, out: &mut [Quad]) -> f64 {
        let Unknowns { fluid: field, bodies } = of;
        let viscous = (self.dt * self.viscosity) as f32;
        let blocks = self.neighbours.with(out).enumerate();
        let products: Vec<f64> = blocks
            .map(|(block, (lists, out))| {
                let own = &field[lists.particles()];
                out.copy_from_slice(own);
                if viscous > 0.0 {
                    self.subtract_laplacian(lists, field, viscous, out);
                }
                for drag in self.boundary.drags_of_block(block) {
                    let own = carried::velocity(field[drag.particle as usize]);
                    let lost = self.dt * drag.rate(own - self.carried.at(drag, bodies));
                    let out = &mut out[drag.particle as usize - lists.first];
                    for (out, lost) in out.iter_mut().zip(lost.to_array()) {
                        *out += lost as f32;
                    }
                }
                own.iter().zip(out).map(|(own, out)| dot(*own, *out)).sum()
            })
            .collect();
        products.iter().sum()
    }

    fn subtract_laplacian(&self, lists: &Lists, field: &[Quad], factor: f32, out: &mut [Quad]) {
        let bends = lists.bends().expect("asked for where there is viscosity");
        workspace::work(lists, |workspace| {
            workspace.vectors.fill(lists.table(), field);
            sums::bends(lists, bends, &workspace.vectors, &mut workspace.sums);
            for (out, sum) in out.iter_mut().zip(&workspace.sums) {
                for axis in 0..3 {
                    out[axis] -= factor * lists.unit_of_bends() * sum[axis];
                }
            }
        });
    }
}

/// Puts the velocities into `changes` and adds the changes to them; the sum of their squares before.
fn begin(velocities: &mut [Quad], changes: &mut [[f32; 3]]) -> f64 {
    let chunks = velocities.par_chunks_mut(CHUNK).zip(changes.par_chunks_mut(CHUNK));
    let parts = chunks.map(|(velocities, changes)| {
        let mut square = 0.0;
        for (velocity, change) in velocities.iter_mut().zip(changes) {
            square += dot(*velocity, *velocity);
            for axis in 0..3 {
                let before = velocity[axis];
                velocity[axis] += change[axis];
                change[axis] = before;
            }
        }
        square
    });
    parts.collect::<Vec<f64>>().iter().sum()
}

impl Squares {
    fn add(&mut self, residual: Quad, preconditioned: Quad) {
        self.plain += dot(residual, residual);
        self.preconditioned += dot(residual, preconditioned);
    }
}

/// In the chunks' order, on any number of threads.
fn sum(parts: Vec<Squares>) -> Squares {
    let add = |a: Squares, b: &Squares| Squares {
        plain: a.plain + b.plain,
        preconditioned: a.preconditioned + b.preconditioned,
    };
    parts.iter().fold(Squares::default(), add)
}

fn dot(a: Quad, b: Quad) -> f64 {
    (0..3).map(|axis| f64::from(a[axis]) * f64::from(b[axis])).sum()
}

/// A symmetric matrix times a vector.
fn multiply([xx, yy, zz, xy, xz, yz]: &Symmetric, [x, y, z, _]: Quad) -> Quad {
    [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z, 0.0]
}

fn inverse_of_one_plus([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> DMat3 {
    let columns = [DVec3::new(1.0 + xx, xy, xz), DVec3::new(xy, 1.0 + yy, yz), DVec3::new(xz, yz, 1.0 + zz)];
    DMat3::from_cols(columns[0], columns[1], columns[2]).inverse()
}

#[cfg(test)]
mod tests;
