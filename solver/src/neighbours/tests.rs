//! Lists of neighbours against all pairs.

use super::*;
use crate::fields::Fields;
use crate::particles::Particles;

/// The numbers of SplitMix64 (Steele et al. 2014), 0 to 1.
pub(crate) fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / u64::MAX as f64
    }
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

pub(crate) fn arrange(positions: &[DVec3], radius: f64) -> Arranged {
    let mut particles = Particles::default();
    particles.add(positions, &vec![[0.0; 3]; positions.len()]);
    let (mut cells, mut order) = (Cells::default(), Vec::new());
    cells.sort(&particles.positions, radius, &mut order);
    particles.reorder(&order);
    let (mut fields, mut neighbours) = (Fields::default(), Neighbours::default());
    fields.place(&particles, radius);
    neighbours.find(&cells, &particles.positions, &fields.places);
    Arranged { positions: particles.positions, fields, neighbours }
}

/// Each list has who is nearer than the radius, once; within `slack` of it rounding decides.
fn check(positions: &[DVec3], radius: f64, slack: f64) {
    let Arranged { positions, neighbours, .. } = arrange(positions, radius);
    assert_eq!(neighbours.chunks().iter().map(Lists::len).sum::<usize>(), positions.len());
    let mut all = 0;
    for lists in neighbours.chunks() {
        for within in 0..lists.len() {
            let own = lists.first + within;
            let listed: Vec<usize> =
                lists.pairs(within).flat_map(|(group, _)| group).map(|&begin| begin as usize / 4).collect();
            let filling = listed.iter().filter(|&&n| n == positions.len()).count();
            assert!(filling < LANES, "the last group alone is filled up");
            let mut found: Vec<usize> = listed.iter().copied().filter(|&n| n < positions.len()).collect();
            all += found.len() - 1;
            found.sort_unstable();
            assert!(found.windows(2).all(|pair| pair[0] < pair[1]) && found.contains(&own));
            for (other, x) in positions.iter().enumerate().filter(|(other, _)| *other != own) {
                let away = x.distance(positions[own]) / radius - 1.0;
                let is_listed = found.binary_search(&other).is_ok();
                assert!(is_listed == (away < 0.0) || away.abs() < slack, "{own} {other}: {away}");
            }
        }
    }
    assert_eq!(all % 2, 0, "who has a neighbour is one");
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
    // Cells are larger than the radius there, and places 1 km = 10,000 radii from the first one are within 1e-3.
    let mut wide = random_points(200, 0.3, 4);
    wide.extend(random_points(200, 0.3, 5).iter().map(|x| *x + DVec3::new(1e3, 0.0, 0.0)));
    check(&wide, 0.1, 3e-3);
}

/// Where two groups of tables end: the filling must be far from a particle at any place.
#[test]
fn filling_is_nobodys_neighbour() {
    for away in [1e5, 1e7] {
        let positions = [DVec3::ZERO, DVec3::splat(away), DVec3::new(away, 0.0, 0.0)];
        check(&positions, 0.1, 1e-5);
        assert_eq!(arrange(&positions, 0.1).neighbours.entries(), 3 * LANES, "each has itself");
    }
}
