//! Lists of neighbours against all pairs.

use super::*;
use crate::fields::Fields;
use crate::pairs::lanes::{Plain, Vectorized};
use crate::pairs::{Pair, SLICE};
use crate::particles::Particles;
use std::ops::Range;
use volmap_bake::random::Random;
use volmap_runtime::{DVec3, Dimension, KernelKind};

/// Random numbers, 0 to 1.
pub(crate) fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut random = Random::new(seed);
    move || random.unit()
}

/// Points in a cube at the origin.
pub(crate) fn random_points(count: usize, edge: f64, seed: u64) -> Vec<DVec3> {
    let mut next = random(seed);
    (0..count).map(|_| edge * DVec3::new(next(), next(), next())).collect()
}

/// Particles in the order of their cells, with their lists.
pub(crate) struct Arranged {
    pub positions: Vec<DVec3>,
    pub fields: Fields,
    pub neighbours: Neighbours,
}

/// With bends; of particles of an eighth of the radius's cube.
pub(crate) fn arrange(positions: &[DVec3], support_radius: f64) -> Arranged {
    let volume = 0.125 * support_radius.powi(3);
    let kernel = KernelKind::CubicSpline;
    arrange_with(
        positions,
        Discretization {
            kernel,
            support_radius,
            volume,
            rest_sum: 1.0,
            gradient_scale: 1.0,
            dimension: Dimension::Three,
        },
    )
}

pub(crate) fn arrange_with(positions: &[DVec3], with: Discretization) -> Arranged {
    let mut particles = Particles::default();
    particles.add(positions, &vec![[0.0; 3]; positions.len()]);
    let (mut cells, mut order) = (Cells::default(), Vec::new());
    cells.sort(&particles.positions, with.support_radius, &mut order);
    particles.reorder(&order, &mut Particles::default());
    let (mut fields, mut neighbours) = (Fields::default(), Neighbours::default());
    fields.place(&particles, with.support_radius);
    let sought = Sought { with, bends: true };
    neighbours.find(&cells, &fields.places, sought, &mut fields.neighbourhoods).unwrap();
    Arranged { positions: particles.positions, fields, neighbours }
}

/// Cells of some points, and their places.
pub(crate) fn sorted(positions: &[DVec3], radius: f64) -> (Cells, Vec<Quad>) {
    let (mut cells, mut order) = (Cells::default(), Vec::new());
    cells.sort(positions, radius, &mut order);
    (cells, arrange(positions, radius).fields.places)
}

impl Neighbours {
    /// As [`Neighbours::find`], with bends, by plain lanes.
    pub(crate) fn find_plainly(
        cells: &Cells,
        places: &[Quad],
        with: Discretization,
        densities: &mut Vec<Density>,
    ) -> Neighbours {
        let blocks = blocks::divide(cells, places.len()).unwrap();
        densities.resize(places.len(), Density::default());
        let sought = Sought { with, bends: true };
        let build = |block: &CellBlock| {
            let (mut lists, mut room, mut table) = (Lists::default(), Room::default(), Quads::default());
            let out = &mut densities[block.particles.clone()];
            let (room, table, into) = (&mut room, &mut table, &mut lists);
            let work = Build { cells, block, places, sought, room, table, lists: into, out };
            WithKernel { kernel: with.kernel, work }.run::<Plain>();
            lists
        };
        let lists = blocks.iter().map(build).collect();
        Neighbours { lists }
    }
}

/// The neighbours of a particle of a block, and what they are to it.
pub(crate) fn listed(lists: &Lists, within: usize) -> Vec<(usize, Pair)> {
    let table: Vec<usize> = lists.table().iter().cloned().flatten().map(|n| n as usize).collect();
    let of_slice = |(particles, rows): (&[u16; SLICE], Range<usize>)| {
        let lane = particles.iter().position(|&particle| usize::from(particle) == within)?;
        Some(lists.rows()[rows].iter().map(|row| row.0[lane]).collect::<Vec<Pair>>())
    };
    let mut pairs = lists.slices().filter_map(of_slice);
    let own = pairs.next().expect("each particle is in a slice");
    assert!(pairs.next().is_none(), "and in one");
    let far = 2 * table.len() as u16;
    let real = own.into_iter().filter(|pair| pair[3] as u16 != far);
    real.map(|pair| (table[pair[3] as u16 as usize / 2], pair)).collect()
}

/// Each list has who is nearer than the radius, once; within `slack` of it rounding decides.
fn check(positions: &[DVec3], radius: f64, slack: f64) {
    let Arranged { positions, neighbours, .. } = arrange(positions, radius);
    let particles = neighbours.lists().iter().flat_map(Lists::particles);
    assert!(particles.eq(0..positions.len()));
    let mut all = 0;
    for lists in neighbours.lists() {
        for within in 0..lists.len() {
            let own = lists.first + within;
            let mut found: Vec<usize> = listed(lists, within).into_iter().map(|(other, _)| other).collect();
            all += found.len();
            found.sort_unstable();
            assert!(found.windows(2).all(|pair| pair[0] < pair[1]) && !found.contains(&own));
            for (other, x) in positions.iter().enumerate().filter(|(other, _)| *other != own) {
                let away = x.distance(positions[own]) / radius - 1.0;
                let is_listed = found.binary_search(&other).is_ok();
                assert!(is_listed == (away < 0.0) || away.abs() < slack, "{own} {other}: {away}");
            }
        }
    }
    assert_eq!(all % 2, 0, "who has a neighbour is one");
    assert_eq!(all, neighbours.entries());
}

/// What programs are shown is what the sums read.
#[test]
fn each_particle_is_shown_with_its_neighbours() {
    let Arranged { positions, neighbours, .. } = arrange(&random_points(700, 0.4, 8), 0.1);
    let mut shown = vec![Vec::new(); positions.len()];
    neighbours.each(&mut shown, |own, near, out| *out = near.iter().map(|one| (own, *one)).collect());
    for lists in neighbours.lists() {
        for within in 0..lists.len() {
            let own = lists.first + within;
            let gradient = |[x, y, z, _]: Pair| [x, y, z].map(|number| lists.unit() * f32::from(number));
            let wanted = listed(lists, within).into_iter();
            let wanted =
                wanted.map(|(particle, pair)| (own, Neighbour { particle, gradient: gradient(pair) }));
            assert!(shown[own].iter().copied().eq(wanted));
        }
    }
}

#[test]
fn lists_are_those_of_all_pairs() {
    for count in [0, 1, 2, 7, 8, 9, 255, 256, 257, 512, 1500] {
        check(&random_points(count, 0.45, count as u64), 0.1, 1e-5);
    }
}

#[test]
fn clusters_and_coincident_particles_are_found() {
    let mut positions = vec![DVec3::splat(0.21); 30];
    positions.extend(random_points(400, 0.02, 1));
    positions.extend(random_points(300, 0.05, 2).iter().map(|x| *x + 0.6));
    positions.extend([DVec3::new(-3.0, 0.0, 0.0), DVec3::new(0.0, 4.0, 9.0)]);
    check(&positions, 0.1, 1e-5);
}

#[test]
fn far_and_wide_domains_are_searched() {
    let shift = DVec3::new(1e5, -1e5, 1e5);
    let far: Vec<DVec3> = random_points(500, 0.45, 3).iter().map(|x| *x + shift).collect();
    check(&far, 0.1, 1e-5);
    // Places 1 km = 10,000 radii from the first one are within 1e-3.
    let mut wide = random_points(200, 0.3, 4);
    wide.extend(random_points(200, 0.3, 5).iter().map(|x| *x + DVec3::new(1e3, 0.0, 0.0)));
    check(&wide, 0.1, 3e-3);
}

/// Two blobs 40 m apart, and drops on all sides: as all pairs have it, and with as many particles a block.
#[test]
fn clusters_that_lie_far_apart_are_searched_as_close_ones() {
    let near = random_points(1500, 0.45, 11);
    let there = DVec3::new(40.0, 3.0, -7.0);
    let mut positions = near.clone();
    positions.extend(near.iter().map(|x| *x + there));
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        positions.extend(random_points(3, 0.1, 12).iter().map(|x| *x - 25.0 * axis));
        positions.push(60.0 * axis);
    }
    // 1,100 radii from the first one.
    check(&positions, 0.1, 2e-4);
    let blocks = arrange(&positions, 0.1).neighbours.lists().len();
    assert!(blocks >= 2 * arrange(&near, 0.1).neighbours.lists().len());
}

/// So many particles in so wide a box that they would all be in one cell if cells grew with it.
#[test]
fn one_drop_far_away_costs_nothing() {
    let spacing = 0.002;
    let at = |n: usize| spacing * DVec3::new((n % 40) as f64, (n / 40 % 40) as f64, (n / 1600) as f64);
    let mut positions: Vec<DVec3> = (0..64_000).map(at).collect();
    let alone = arrange(&positions, 4e-3).neighbours;
    positions.push(DVec3::new(0.0, 4.0, 0.0));
    let with_drop = arrange(&positions, 4e-3).neighbours;
    assert_eq!(with_drop.entries(), alone.entries());
    let largest = |neighbours: &Neighbours| neighbours.lists().iter().map(Lists::len).max().unwrap();
    assert_eq!(largest(&with_drop), 512);
    assert_eq!(largest(&alone), 512);
}

#[test]
fn nobody_is_a_neighbour_of_those_alone() {
    for away in [1e5, 1e7] {
        let positions = [DVec3::ZERO, DVec3::splat(away), DVec3::new(away, 0.0, 0.0)];
        check(&positions, 0.1, 1e-5);
        assert_eq!(arrange(&positions, 0.1).neighbours.entries(), 0);
    }
}

/// Of many particles blocks are larger; who is near whom isn't another.
#[test]
fn large_blocks_have_the_same_pairs() {
    let points = random_points(9000, 1.1, 8);
    let Arranged { fields, neighbours, .. } = arrange(&points, 0.1);
    let mut shifted = points.clone();
    // Far away, and enough of them.
    shifted.extend(random_points(200_000, 3.0, 9).iter().map(|x| *x + DVec3::new(0.0, 0.0, 4.0)));
    let all = arrange(&shifted, 0.1);
    assert!(all.neighbours.lists().len() < 4 * neighbours.lists().len());
    let find = |x: &DVec3| all.positions.iter().position(|y| x == y).unwrap();
    for (n, x) in arrange(&points, 0.1).positions.iter().enumerate().step_by(97) {
        let [own, other] =
            [fields.neighbourhoods[n], all.fields.neighbourhoods[find(x)]].map(|of| of.density);
        assert!((own - other).abs() < 1e-5 * own, "{own} {other}");
    }
}
