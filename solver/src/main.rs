//! The `volmap-sim` program: parses, reports progress, maps errors to exit codes. All else is in the library.
use volmap_solver::{bodies::Bodies, settings::*, simulation::Simulation};
use volmap_runtime::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let end: f64 = a[2].parse().unwrap();
    let map = VolumeMap::open(std::path::Path::new("/tmp/w/lead/rest.h5")).unwrap();
    let bodies = Bodies { maps: vec![PosedMap { map: std::sync::Arc::new(map), pose: Pose::default() }] };
    let get = |i: usize, d: f64| a.get(i).map_or(d, |v| v.parse().unwrap());
    let rp = 0.025;
    let fluid = FluidSettings { volume_factor: get(3, 1.0), ..Default::default() };
    let mut solver = SolverSettings::default();
    solver.warm_start = get(4, 0.5);
    solver.relaxation = get(5, 0.5);
    let env = |n: &str, d: f64| std::env::var(n).map_or(d, |v| v.parse().unwrap());
    solver.density.max_error = env("ED", 5e-4); solver.divergence.max_error = env("EV", 1e-3); solver.time_step.max = env("DT", 5e-3);
    let world = World { closure: a[1].parse().unwrap(), kernel: a.get(6).map_or(KernelKind::CubicSpline, |k| k.parse().unwrap()), ..Default::default() };
    let mut s = Simulation::new(world, fluid, solver, bodies);
    let mut p = Vec::new();
    // 18 x 11 x 18 particles in a tank of 1 x 1.2 x 1: 3564.
    for k in 0..18 { for j in 0..11 { for i in 0..18 {
        p.push(DVec3::new(-0.425 + i as f64 * 0.05, 0.05 + j as f64 * 0.05, -0.425 + k as f64 * 0.05));
    } } }
    let v = vec![[0.0; 3]; p.len()];
    s.particles.add(&p, &v);
    let mut next = 0.0;
    let (mut it, mut itv, mut n) = (0, 0, 0);
    while s.time < end {
        let r = s.step();
        if std::env::var("PROBE").is_ok() && s.time > 3.0 && s.time < 3.1 { let k = s.particles.ids.iter().position(|i| *i == 1500).unwrap(); println!("{:.4} y={:.4} P={:.4} Pv={:.4} D={:.5} v={:?} it {}", s.time, s.particles.positions[k].y, s.particles.pressures[k], s.particles.divergence_pressures[k], s.fields.densities[k], s.particles.velocities[k], r.density.iterations); }
        it += r.density.iterations; itv += r.divergence.iterations; n += 1;
        if s.time >= next {
            next += end / 10.0;
            let y = &s.particles.positions;
            let rms = (s.particles.velocities.iter().map(|v| (v[0]*v[0]+v[1]*v[1]+v[2]*v[2]) as f64).sum::<f64>() / p.len() as f64).sqrt();
            let mut ys: Vec<f64> = y.iter().map(|p| p.y).collect(); ys.sort_by(f64::total_cmp);
            let mut walls: Vec<f64> = y.iter().map(|p| (0.5 - p.x.abs()).min(0.5 - p.z.abs())).collect(); walls.sort_by(f64::total_cmp);
            let d = s.fields.densities.iter().cloned().fold(0.0, f32::max);
            let mean = s.fields.densities.iter().map(|d| *d as f64).sum::<f64>() / p.len() as f64;
            // pressure near the floor, against rho g h with the true volume's height
            let h = p.len() as f64 * s.particle_volume();
            let mut pr: Vec<(f64, f64)> = y.iter().zip(&s.particles.pressures).zip(&s.fields.densities).map(|((p, q), d)| (p.y, *q as f64 * (*d as f64).powi(2) / 9.81)).collect();
            pr.sort_by(|a, b| a.0.total_cmp(&b.0));
            let low = pr.iter().filter(|p| p.0 < 0.05).map(|p| p.1 + p.0).collect::<Vec<_>>();
            let mid = pr.iter().filter(|p| p.0 > 0.15 && p.0 < 0.2).map(|p| p.1 + p.0).collect::<Vec<_>>();
            let m = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
            println!("t={:.3} dt={:.1e} it={:.1}/{:.1} rms={:.4} maxv={:.3} first={:.2}rp n1={} wall={:.2}rp p99={:.3} ideal={:.3} Dmax={:.4} Dmean={:.4} inside={} head floor {:.3} mid {:.3}", s.time, r.dt, it as f64 / n as f64, itv as f64 / n as f64, rms, r.max_speed,
              ys[72]/rp, ys.iter().filter(|y| **y < 0.05).count(), walls[p.len()/20]/rp, ys[p.len()*99/100], h, d, mean, r.inside, m(&low), m(&mid));
            if std::env::var("HIST").is_ok() { let mut h = [0; 30]; for y in &ys { let b = ((y / rp * 2.0) as usize).min(29); h[b] += 1; } println!("  {h:?}"); let mut e = [[0.0f64; 3]; 10]; for (y, v) in y.iter().zip(&s.particles.velocities) { let b = ((y.y / 0.05) as usize).min(9); e[b][0] += 1.0; e[b][1] += (v[0]*v[0]+v[2]*v[2]) as f64; e[b][2] += (v[1]*v[1]) as f64; } for e in e { print!(" [{} h {:.4} v {:.4}]", e[0], (e[1]/e[0]).sqrt(), (e[2]/e[0]).sqrt()); } println!(); }
            (it, itv, n) = (0, 0, 0);
        }
    }
}
