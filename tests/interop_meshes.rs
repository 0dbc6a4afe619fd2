//! Interop, meshes: what meshio, trimesh and VTK write is read as what they meant.

use std::path::Path;

use serde_json::Value;
use volmap_formats::mesh::{CleanSettings, TriangleMesh, load};
use volmap_tests::python;

type Point = [f64; 3];

struct Expected {
    points: Vec<Point>,
    polygons: Vec<Vec<u32>>,
    /// Relative to the size of the mesh.
    tolerance: f64,
    unit: Option<f64>,
}

fn expected(file: &Path) -> Expected {
    let text = std::fs::read_to_string(file).unwrap();
    let json: Value = serde_json::from_str(&text).unwrap();
    let list = |value: &Value| value.as_array().unwrap().clone();
    let point = |value: &Value| {
        let c: Vec<f64> = list(value).iter().map(|c| c.as_f64().unwrap()).collect();
        [c[0], c[1], c[2]]
    };
    let polygon = |value: &Value| list(value).iter().map(|i| i.as_u64().unwrap() as u32).collect();
    Expected {
        points: list(&json["points"]).iter().map(point).collect(),
        polygons: list(&json["polygons"]).iter().map(polygon).collect(),
        tolerance: json["tolerance"].as_f64().unwrap(),
        unit: json["unit"].as_f64(),
    }
}

/// Fans: the expected polygons are convex and planar.
fn triangles(expected: &Expected) -> Vec<[Point; 3]> {
    let at = |k: u32| expected.points[k as usize];
    let fan = |p: &Vec<u32>| (1..p.len() - 1).map(|k| [at(p[0]), at(p[k]), at(p[k + 1])]).collect();
    expected.polygons.iter().flat_map(|p| -> Vec<[Point; 3]> { fan(p) }).collect()
}

fn corners(mesh: &TriangleMesh) -> Vec<[Point; 3]> {
    let at = |k: u32| mesh.vertices[k as usize];
    mesh.triangles.iter().map(|t| t.map(at)).collect()
}

/// Area, signed volume about the box' centre, and the vector area.
fn measures(triangles: &[[Point; 3]], centre: Point) -> [f64; 5] {
    let mut sums = [0.0; 5];
    for t in triangles {
        let [a, b, c] = t.map(|p| [p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]]);
        let (u, v) = ([0, 1, 2].map(|i| b[i] - a[i]), [0, 1, 2].map(|i| c[i] - a[i]));
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        sums[0] += (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt() / 2.0;
        sums[1] += (a[0] * n[0] + a[1] * n[1] + a[2] * n[2]) / 6.0;
        for i in 0..3 {
            sums[2 + i] += n[i] / 2.0;
        }
    }
    sums
}

fn bounds(triangles: &[[Point; 3]]) -> (Point, f64) {
    let points = || triangles.iter().flatten();
    let low = [0, 1, 2].map(|i| points().map(|p| p[i]).fold(f64::INFINITY, f64::min));
    let high = [0, 1, 2].map(|i| points().map(|p| p[i]).fold(f64::NEG_INFINITY, f64::max));
    let size = (0..3).map(|i| (high[i] - low[i]).max(high[i].abs())).fold(0.0, f64::max);
    ([0, 1, 2].map(|i| (low[i] + high[i]) / 2.0), size)
}

/// The triangles of both as sets, corners in cyclic order, coordinates rounded to a lattice that is
/// far coarser than the tolerance and far finer than the mesh.
fn keys(triangles: &[[Point; 3]], step: f64, shift: f64) -> Vec<[[i64; 3]; 3]> {
    let round = |p: &Point| p.map(|c| (c / step + shift).floor() as i64);
    let mut keys: Vec<_> = triangles
        .iter()
        .map(|t| {
            let mut key = [round(&t[0]), round(&t[1]), round(&t[2])];
            let least = (0..3).min_by_key(|&k| key[k]).unwrap();
            key.rotate_left(least);
            key
        })
        .collect();
    keys.sort_unstable();
    keys
}

fn compare(name: &str, mesh: &TriangleMesh, expected: &Expected) {
    let (found, wanted) = (corners(mesh), triangles(expected));
    assert_eq!(found.len(), wanted.len(), "{name}: triangles");
    let (centre, size) = bounds(&wanted);
    let (a, b) = (measures(&found, centre), measures(&wanted, centre));
    for (k, (a, b)) in a.iter().zip(&b).enumerate() {
        let scale = size.powi(if k == 1 { 3 } else { 2 });
        assert!((a - b).abs() <= 20.0 * expected.tolerance * scale, "{name}: measure {k}: {a} {b}");
    }
    if expected.polygons.iter().all(|p| p.len() == 3) {
        // Two lattices, one shifted by an irrational part: a value that rounding moves over an edge
        // of the one stays inside a cell of the other.
        let step = 1000.0 * expected.tolerance * size;
        let same =
            [0.327, 0.827].iter().any(|&shift| keys(&found, step, shift) == keys(&wanted, step, shift));
        assert!(same, "{name}: other triangles");
    }
}

#[test]
fn meshes_of_other_programs_are_read_as_meant() {
    let folder = tempfile::tempdir().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("interop/write_meshes.py");
    let output = std::process::Command::new(python())
        .arg(&script)
        .arg(folder.path())
        .output()
        .expect("Python with meshio, trimesh (and networkx, lxml) and vtk: set VOLMAP_PYTHON");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut count = 0;
    for entry in std::fs::read_dir(folder.path()).unwrap() {
        let json = entry.unwrap().path();
        let mesh_file = json.with_extension("");
        if json.extension().is_none_or(|e| e != "json") || !mesh_file.exists() {
            continue;
        }
        let expected = expected(&json);
        let name = mesh_file.file_name().unwrap().to_string_lossy().into_owned();
        let (mesh, report) =
            load(&mesh_file, &CleanSettings::default()).unwrap_or_else(|error| panic!("{error}"));
        compare(&name, &mesh, &expected);
        if expected.unit.is_some() {
            assert_eq!(report.unit, expected.unit, "{name}: unit");
        }
        count += 1;
    }
    assert!(count > 100, "only {count} files");
}
