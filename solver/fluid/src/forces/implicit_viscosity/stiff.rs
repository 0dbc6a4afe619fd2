//! The same solve in double precision, for what is stiff. Velocities in single precision have a rounding of 6e-8, which
//! a large viscosity takes for strains and answers by many times their size; and bends in fixed point don't lie on the
//! line between their particles to 1e-5, so that it would stop what turns.
//!
//! Pairs have their bend in single precision, of the particles' places in double precision. When the solve ends, what
//! is exchanged is computed once more of the velocities that were found: opposite forces, whose sum is zero to double
//! precision however large the factor is.

use super::carried::{self, Exchanged};
use super::{Solved, System, inverse_of_one_plus};
use crate::coupling::Motions;
use crate::discretization::Discretization;
use crate::forces::ForceStep;
use crate::pairs::Quad;
use crate::pairs::lists::Lists;
use crate::particles::CHUNK;
use crate::report::SolveReport;
use crate::settings::ViscositySolveSettings;
use glam::DMat3;
use rayon::prelude::*;
use volmap_runtime::{DVec3, Kernel};

/// Room for the pairs, and for the vectors of conjugate gradients.
#[derive(Clone, Debug, Default)]
pub(super) struct StiffSolver {
    blocks: Vec<Pairs>,
    velocities: Vec<DVec3>,
    residual: Vec<DVec3>,
    direction: Vec<DVec3>,
    /// The system times the direction, or the preconditioned residual.
    product: Vec<DVec3>,
    inverses: Vec<DMat3>,
}

/// The pairs of a block's particles.
#[derive(Clone, Debug, Default)]
struct Pairs {
    /// Where those of each particle end.
    ends: Vec<u32>,
    pairs: Vec<Pair>,
}

/// The other particle, and the bend: the exchange in the step is h (h . (u_i - u_j)).
#[derive(Clone, Copy, Debug)]
struct Pair {
    other: u32,
    bend: [f32; 3],
}

impl StiffSolver {
    /// As the [plain solver](super::Solver).
    pub fn solve(
        &mut self,
        system: &System,
        step: &ForceStep,
        settings: &ViscositySolveSettings,
        velocities: &mut [Quad],
        changes: &mut [[f32; 3]],
    ) -> Solved {
        let carried = &system.carried;
        self.find_pairs(system, step);
        self.precondition(system, velocities.len());
        let before: Vec<DVec3> = velocities.iter().map(|&v| carried::velocity(v)).collect();
        let scale = squares(&before) + carried.square();
        self.begin(system, &before, changes);
        let mut report = SolveReport::default();
        let mut preconditioned = self.first_direction();
        loop {
            report.error = if scale > 0.0 { (squares(&self.residual) / scale).sqrt() } else { 0.0 };
            if report.error <= settings.max_error || report.iterations >= settings.max_iterations {
                break;
            }
            let bodies = carried.response(&|n| self.direction[n]);
            let mut product = std::mem::take(&mut self.product);
            let along = self.apply(system, &self.direction, &bodies, &mut product);
            self.product = product;
            if along.is_nan() || along <= 0.0 {
                break;
            }
            preconditioned = self.descend(preconditioned / along, preconditioned);
            report.iterations += 1;
        }
        self.end(system, &before, scale, report, velocities, changes)
    }

    /// Writes what the pairs are to each other.
    fn find_pairs(&mut self, system: &System, step: &ForceStep) {
        let factor = system.dt * system.viscosity;
        let lists = system.neighbours.lists();
        self.blocks.resize_with(lists.len(), Pairs::default);
        self.blocks.par_iter_mut().zip(lists).for_each(|(pairs, lists)| {
            pairs.find(lists, step.positions, step.with, factor);
        });
    }

    /// Inverts the diagonal blocks.
    fn precondition(&mut self, system: &System, count: usize) {
        self.inverses.resize(count, DMat3::IDENTITY);
        let work = system.neighbours.with(&mut self.inverses).zip(&self.blocks).enumerate();
        work.for_each(|(block, ((lists, out), pairs))| {
            let mut matrices: Vec<[f64; 6]> = (0..lists.len()).map(|n| pairs.square_of(n)).collect();
            for drag in system.boundary.drags_of_block(block) {
                let matrix = &mut matrices[drag.particle as usize - lists.first];
                for (sum, x) in matrix.iter_mut().zip(drag.matrix()) {
                    *sum += system.dt * x;
                }
            }
            for (out, matrix) in out.iter_mut().zip(matrices) {
                *out = inverse_of_one_plus(matrix);
            }
        });
    }

    /// Begins as far along the last step's change as makes the residual smallest.
    fn begin(&mut self, system: &System, before: &[DVec3], changes: &[[f32; 3]]) {
        let carried = &system.carried;
        let warm: Vec<DVec3> = changes.iter().map(|c| DVec3::from_array(c.map(f64::from))).collect();
        let [mut at_before, mut of_change] = [(); 2].map(|()| vec![DVec3::ZERO; before.len()]);
        self.apply(system, before, &carried.velocities(&|n| before[n]), &mut at_before);
        self.apply(system, &warm, &carried.response(&|n| warm[n]), &mut of_change);
        self.residual.clear();
        self.residual.extend(before.iter().zip(&at_before).map(|(before, product)| *before - *product));
        let square = squares(&of_change);
        let part = if square > 0.0 { dots(&self.residual, &of_change) / square } else { 0.0 };
        self.velocities.clear();
        self.velocities.extend(before.iter().zip(&warm).map(|(before, change)| *before + part * *change));
        add(&mut self.residual, -part, &of_change);
        self.product.resize(before.len(), DVec3::ZERO);
    }

    /// The preconditioned residual as direction; its product with the residual.
    fn first_direction(&mut self) -> f64 {
        self.direction.clear();
        self.direction.extend(self.residual.iter().zip(&self.inverses).map(|(r, inverse)| *inverse * *r));
        dots(&self.residual, &self.direction)
    }

    /// Goes `step` far, and turns; the next residual times the preconditioned one.
    fn descend(&mut self, step: f64, last: f64) -> f64 {
        add(&mut self.velocities, step, &self.direction);
        add(&mut self.residual, -step, &self.product);
        let all = self.product.par_iter_mut().zip(&self.residual).zip(&self.inverses).with_min_len(CHUNK);
        all.for_each(|((z, r), inverse)| *z = *inverse * *r);
        let next = dots(&self.residual, &self.product);
        let all = self.direction.par_iter_mut().zip(&self.product).with_min_len(CHUNK);
        all.for_each(|(direction, z)| *direction = *z + next / last * *direction);
        next
    }

    /// Computes what is exchanged at these velocities, and does it or a part of it.
    fn end(
        &mut self,
        system: &System,
        before: &[DVec3],
        scale: f64,
        mut report: SolveReport,
        velocities: &mut [Quad],
        changes: &mut [[f32; 3]],
    ) -> Solved {
        let carried = &system.carried;
        let bodies = carried.velocities(&|n| self.velocities[n]);
        let impulses = carried.impulses(&|n| self.velocities[n], &bodies);
        let mut lost = std::mem::take(&mut self.product);
        self.apply(system, &self.velocities, &bodies, &mut lost);
        add(&mut lost, -1.0, &self.velocities);
        let (mut exchanged, mut left) = (Exchanged::default(), 0.0);
        for ((before, lost), found) in before.iter().zip(&lost).zip(&self.velocities) {
            exchanged.add(*before, *lost);
            left += (*before - *lost - *found).length_squared();
        }
        if scale > 0.0 {
            report.error = (left / scale).sqrt();
        }
        let part = carried.part(exchanged, &impulses);
        for (((velocity, change), before), lost) in velocities.iter_mut().zip(changes).zip(before).zip(&lost)
        {
            let [x, y, z] = (*before - part * *lost).as_vec3().to_array();
            *velocity = [x, y, z, 0.0];
            *change = (-part * *lost).as_vec3().to_array();
        }
        self.product = lost;
        Solved { report, on_bodies: system.forces(&impulses, part) }
    }

    /// Writes A u; the product u . A u.
    fn apply(&self, system: &System, field: &[DVec3], bodies: &Motions, out: &mut [DVec3]) -> f64 {
        let work = system.neighbours.with(out).zip(&self.blocks).enumerate();
        let products: Vec<f64> = work
            .map(|(block, ((lists, out), pairs))| {
                let own = &field[lists.particles()];
                for (n, out) in out.iter_mut().enumerate() {
                    *out = own[n] + pairs.exchange_of(n, own[n], field);
                }
                for drag in system.boundary.drags_of_block(block) {
                    let own = field[drag.particle as usize];
                    let lost = system.dt * drag.rate(own - system.carried.at(drag, bodies));
                    out[drag.particle as usize - lists.first] += lost;
                }
                own.iter().zip(out).map(|(own, out)| own.dot(*out)).sum()
            })
            .collect();
        products.iter().sum()
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        let StiffSolver { blocks, velocities, residual, direction, product, inverses } = self;
        let vectors = velocities.capacity() + residual.capacity() + direction.capacity() + product.capacity();
        let pairs = |block: &Pairs| 4 * block.ends.capacity() + size_of::<Pair>() * block.pairs.capacity();
        size_of::<DVec3>() * vectors
            + size_of::<DMat3>() * inverses.capacity()
            + blocks.iter().map(pairs).sum::<usize>()
    }
}

impl Pairs {
    /// Of a block; `factor` is dt nu, m^2.
    fn find(&mut self, lists: &Lists, positions: &[DVec3], with: Discretization, factor: f64) {
        let mut near: Vec<Vec<Pair>> = vec![Vec::new(); lists.len()];
        if factor > 0.0 {
            let kernel = Kernel::new(with.kernel, with.support_radius);
            let small = 0.01 * with.support_radius * with.support_radius;
            let scale = factor * 2.0 * (with.dimension.count() as f64 + 2.0) * with.volume;
            lists.each(&mut Vec::new(), &mut Vec::new(), |within, neighbours| {
                let own = positions[lists.first + within];
                near[within].extend(neighbours.iter().map(|neighbour| {
                    let way = own - positions[neighbour.particle];
                    let square = way.length_squared();
                    let distance = square.sqrt();
                    let weight = -kernel.derivative(distance) / distance.max(f64::MIN_POSITIVE);
                    let bend = (scale * weight / (square + small)).max(0.0).sqrt() * way;
                    Pair { other: neighbour.particle as u32, bend: bend.as_vec3().to_array() }
                }));
            });
        }
        self.pairs.clear();
        self.ends.clear();
        for near in near {
            self.pairs.extend(near);
            self.ends.push(self.pairs.len() as u32);
        }
    }

    fn of(&self, within: usize) -> impl Iterator<Item = (usize, DVec3)> {
        let begin = if within == 0 { 0 } else { self.ends[within - 1] };
        let pairs = &self.pairs[begin as usize..self.ends[within] as usize];
        pairs.iter().map(|pair| (pair.other as usize, DVec3::from_array(pair.bend.map(f64::from))))
    }

    /// The sum of h (h . (u_i - u_j)).
    fn exchange_of(&self, within: usize, own: DVec3, field: &[DVec3]) -> DVec3 {
        self.of(within).map(|(other, bend)| bend.dot(own - field[other]) * bend).sum()
    }

    /// The sum of h h^T.
    fn square_of(&self, within: usize) -> [f64; 6] {
        let mut sum = [0.0; 6];
        for (_, DVec3 { x, y, z }) in self.of(within) {
            for (sum, product) in sum.iter_mut().zip([x * x, y * y, z * z, x * y, x * z, y * z]) {
                *sum += product;
            }
        }
        sum
    }
}

/// a <- a + part b.
fn add(a: &mut [DVec3], part: f64, b: &[DVec3]) {
    a.par_iter_mut().zip(b).with_min_len(CHUNK).for_each(|(a, b)| *a += part * *b);
}

fn squares(a: &[DVec3]) -> f64 {
    dots(a, a)
}

/// In the chunks' order, on any number of threads.
fn dots(a: &[DVec3], b: &[DVec3]) -> f64 {
    let chunks = a.par_chunks(CHUNK).zip(b.par_chunks(CHUNK));
    let parts = chunks.map(|(a, b)| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum());
    parts.collect::<Vec<f64>>().iter().sum()
}
