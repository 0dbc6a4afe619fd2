//! The order-30 rule against SPlisHSPlasH, the papers' own program: same mesh, box, radius and resolution
//! (`peer/README.md`).

use std::path::PathBuf;
use volmap_bake::bake::{Bake, BakeSettings, bake};
use volmap_bake::density_map::DensitySettings;
use volmap_bake::input::{InputSettings, load};
use volmap_bake::plan::{GridChoice, MapSettings, Precision};
use volmap_bake::volume_map::quadrature::Rule;
use volmap_bake::watch::Watch;
use volmap_formats::asset::Array;
use volmap_formats::mesh::Placement;
use volmap_runtime::layout::{Family, Nodes};

struct Peer {
    domain: [[f64; 3]; 2],
    resolution: [u32; 3],
    nodes: Vec<u32>,
    distance: Vec<f64>,
    volume: Vec<f64>,
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("peer")
}

fn read_peer(name: &str) -> Peer {
    let bytes = std::fs::read(folder().join(format!("{name}.nodes"))).unwrap();
    let f64_at = |at: usize| f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
    let u32_at = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let n = u32_at(60) as usize;
    let (distances, volumes) = (64 + 4 * n, 64 + 12 * n);
    Peer {
        domain: [0, 24].map(|at| [0, 8, 16].map(|axis| f64_at(at + axis))),
        resolution: [48, 52, 56].map(u32_at),
        nodes: (0..n).map(|i| u32_at(64 + 4 * i)).collect(),
        distance: (0..n).map(|i| f64_at(distances + 8 * i)).collect(),
        volume: (0..n).map(|i| f64_at(volumes + 8 * i)).collect(),
    }
}

/// The peer's node number as our family, lattice point and third.
fn place([nx, ny, nz]: [u32; 3], node: u32) -> (Family, [u32; 3], u32) {
    let corners = (nx + 1) * (ny + 1) * (nz + 1);
    if node < corners {
        let at = [node % (nx + 1), node / (nx + 1) % (ny + 1), node / ((nx + 1) * (ny + 1))];
        return (Family::Corner, at, 0);
    }
    let (edge, third) = ((node - corners) / 2, (node - corners) % 2);
    let x_edges = nx * (ny + 1) * (nz + 1);
    let y_edges = (nx + 1) * ny * (nz + 1);
    if edge < x_edges {
        let at = [edge % nx, edge / nx % (ny + 1), edge / (nx * (ny + 1))];
        (Family::EdgeX, at, third)
    } else if edge < x_edges + y_edges {
        let e = edge - x_edges;
        let at = [e / (ny * (nz + 1)), e % ny, e / ny % (nz + 1)];
        (Family::EdgeY, at, third)
    } else {
        let e = edge - x_edges - y_edges;
        let at = [e / nz % (nx + 1), e / (nz * (nx + 1)), e % nz];
        (Family::EdgeZ, at, third)
    }
}

fn bake_as_peer(mesh: &str, scale: f64, peer: &Peer, density: Option<DensitySettings>) -> Bake {
    let placement = Placement { scale: [scale; 3], ..Placement::default() };
    let input = load(&folder().join(mesh), &InputSettings { placement, ..InputSettings::default() }).unwrap();
    let map = MapSettings {
        support_radius: Some(f64::from(0.1f32)),
        grid: GridChoice::Resolution(peer.resolution),
        domain: Some(peer.domain),
        precision: Precision::F64,
        rule: Rule::GaussLegendre(30),
        density,
        ..MapSettings::default()
    };
    bake(input, &BakeSettings { map, ..BakeSettings::default() }, &Watch::default()).unwrap()
}

/// Our number of a node, if it is in the band.
fn number(nodes: &Nodes, family: Family, [i, j, k]: [u32; 3], third: u32) -> Option<usize> {
    let holds = |(y, z, it): &(u32, u32, volmap_runtime::layout::NodeInterval)| {
        (*y, *z) == (j, k) && (it.first..it.end).contains(&i)
    };
    let (.., it) = nodes.intervals(family).find(holds)?;
    Some((it.start + (i - it.first) * family.nodes_per_point() + third) as usize)
}

fn compare(name: &str, mesh: &str, scale: f64) {
    let peer = read_peer(name);
    let asset = bake_as_peer(mesh, scale, &peer, None).asset;
    let (Array::F64(distance), Array::F64(volume)) = (&asset.signed_distance, &asset.volume) else {
        panic!("f64 was asked for")
    };
    let nodes = Nodes::new(asset.grid.resolution.into(), &asset.band_cells).unwrap();
    let ball = 4.0 / 3.0 * std::f64::consts::PI * 1e-3;
    let (mut worst_phi, mut worst_volume, mut worst_relative) = (0.0f64, 0.0f64, 0.0f64);
    for (index, &node) in peer.nodes.iter().enumerate() {
        let (family, at, third) = place(peer.resolution, node);
        let own = number(&nodes, family, at, third)
            .unwrap_or_else(|| panic!("{family:?} {at:?} isn't in the band"));
        worst_phi = worst_phi.max((distance[own] - peer.distance[index]).abs());
        let difference = (volume[own] - peer.volume[index]).abs();
        worst_volume = worst_volume.max(difference / ball);
        if peer.volume[index] > 1e-5 * ball {
            worst_relative = worst_relative.max(difference / peer.volume[index]);
        }
    }
    println!(
        "{name:7} {:5} nodes: distance {worst_phi:.1e} m, volume {worst_volume:.1e} of the ball, \
        {worst_relative:.1e} relative",
        peer.nodes.len()
    );
    assert!(worst_phi < 1e-7, "{name}: distances differ by {worst_phi}");
    assert!(worst_volume < 1e-6 && worst_relative < 1e-5, "{name}: {worst_volume} {worst_relative}");
}

#[test]
fn node_values_are_those_of_splishsplash() {
    compare("box", "UnitBox.obj", 1.0);
    compare("sphere", "sphere.obj", 0.5);
    compare("torus", "torus.obj", 0.5);
}

/// SPlisHSPlasH's density map is that of Eq. 9 but for the extension function, which it ends at r / 5.
fn compare_density(name: &str, mesh: &str, scale: f64) {
    let peer = read_peer(&format!("{name}.density"));
    let rule = Rule::GaussLegendre(50);
    let settings = DensitySettings { rule, extension: 0.2, ..DensitySettings::default() };
    let asset = bake_as_peer(mesh, scale, &peer, Some(settings)).asset;
    let Some(Array::F64(density)) = asset.density.map(|density| density.values) else {
        panic!("f64 was asked for")
    };
    let nodes = Nodes::new(asset.grid.resolution.into(), &asset.band_cells).unwrap();
    let mut worst = 0.0f64;
    for (index, &node) in peer.nodes.iter().enumerate() {
        let (family, at, third) = place(peer.resolution, node);
        let own = number(&nodes, family, at, third).unwrap_or_else(|| panic!("{at:?} isn't in the band"));
        // The peer's third column.
        worst = worst.max((density[own] - peer.volume[index]).abs() / (1.0 + peer.volume[index]));
    }
    println!("{name:7} {:5} nodes: density {worst:.1e}", peer.nodes.len());
    assert!(worst < 1e-5, "{name}: {worst}");
}

#[test]
fn densities_are_those_of_splishsplash() {
    compare_density("box", "UnitBox.obj", 1.0);
    compare_density("sphere", "sphere.obj", 0.5);
}
