//! Mesh readers and cleaning: hand-made files of each format with known geometry.

#[path = "mesh/samples.rs"]
mod samples;

use std::path::Path;

use proptest::prelude::*;
use volmap_formats::mesh::*;

type Point = [f64; 3];

fn read_clean(bytes: &[u8], format: MeshFormat) -> (TriangleMesh, CleanReport) {
    clean(read_mesh_bytes(bytes, format).unwrap(), &CleanSettings::default()).unwrap()
}

fn error(bytes: &[u8], format: MeshFormat) -> String {
    let result = read_mesh_bytes(bytes, format).and_then(|raw| clean(raw, &CleanSettings::default()));
    match result {
        Ok(_) => panic!("{format}: was read"),
        Err(MeshError::Panicked { message, .. }) => panic!("{format}: panicked: {message}"),
        Err(error) => error.to_string(),
    }
}

/// Area and volume.
fn measure(mesh: &TriangleMesh) -> (f64, f64) {
    let (mut area, mut volume) = (0.0, 0.0);
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|v| mesh.vertices[v as usize]);
        let (u, v): (Point, Point) = ([0, 1, 2].map(|i| b[i] - a[i]), [0, 1, 2].map(|i| c[i] - a[i]));
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        area += n.iter().map(|c| c * c).sum::<f64>().sqrt() / 2.0;
        volume += (a[0] * n[0] + a[1] * n[1] + a[2] * n[2]) / 6.0;
    }
    (area, volume)
}

/// Every edge has as many triangles on its left as on its right.
fn is_closed(mesh: &TriangleMesh) -> bool {
    let mut edges = std::collections::BTreeMap::<(u32, u32), i64>::new();
    for t in &mesh.triangles {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            *edges.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
        }
    }
    edges.values().all(|&count| count == 0)
}

#[test]
fn every_format_reads_the_box() {
    for sample in samples::boxes() {
        let (mesh, report) = read_clean(&sample.bytes, sample.format);
        let name = sample.name;
        assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (8, 12), "{name}: {report:?}");
        let (area, volume) = measure(&mesh);
        // 2 x 3 x 5, shifted.
        assert!((area - 62.0).abs() < 1e-5 && (volume - 30.0).abs() < 1e-5, "{name}: {area} {volume}");
        assert!(is_closed(&mesh), "{name}");
    }
    for format in MeshFormat::ALL {
        assert!(samples::boxes().iter().any(|sample| sample.format == format), "no sample of {format}");
    }
}

#[test]
fn the_readme_lists_every_format() {
    for format in MeshFormat::ALL {
        let extensions =
            format.extensions().iter().map(|extension| format!("`.{extension}`")).collect::<Vec<_>>();
        let row = format!("| {format} | {} | {} |", extensions.join(", "), format.description());
        assert!(include_str!("../README.md").contains(&row), "README.md has no row {row}");
    }
}

#[test]
fn content_wins_over_a_lying_name() {
    // Lines of nine numbers may be points with colours and normals: only the name tells.
    for sample in samples::boxes().into_iter().filter(|sample| sample.format != MeshFormat::RawTriangles) {
        for name in ["x.stl", "x.obj", "x.dat", "x"] {
            let format = MeshFormat::detect(Path::new(name), &sample.bytes).unwrap();
            assert_eq!(format, sample.format, "{} called {name}", sample.name);
        }
    }
}

#[test]
fn numbers_are_not_rounded_to_f32() {
    let text = "v 0.1 0.2 0.30000000000000004\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let raw = read_mesh_bytes(text.as_bytes(), MeshFormat::Obj).unwrap();
    assert_eq!(raw.positions[0], [0.1, 0.2, 0.30000000000000004]);
}

#[test]
fn obj_takes_what_exporters_write() {
    let text = b"mtllib none.mtl\r\no W\xFCrfel\r\nv 0 0 0 1 0 0\r\nv 1 0 \\\r\n0\r\nv 1 1 0\r\nv 0 1 0\r\n\
        vt 0 0\r\nusemtl a\\b\r\nf -4/1 -3/1/1 -2//1 \\\r\n -1 # end\r\nl 1 2\r\np 1\r\n";
    let raw = read_mesh_bytes(text, MeshFormat::Obj).unwrap();
    assert_eq!(raw.positions.len(), 4);
    assert_eq!(raw.faces.iter().collect::<Vec<_>>(), [&[0, 1, 2, 3]]);
    assert_eq!((raw.skipped.lines, raw.skipped.points), (1, 1));
}

#[test]
fn a_concave_polygon_of_an_obj_keeps_its_area() {
    let text = "v 0 0 1\nv 4 0 1\nv 4 4 1\nv 2 1 1\nv 0 4 1\nf 1 2 3 4 5\n";
    let (mesh, report) = read_clean(text.as_bytes(), MeshFormat::Obj);
    assert_eq!((report.polygons, report.fan_fallbacks, mesh.triangles.len()), (1, 0, 3));
    assert!((measure(&mesh).0 - 10.0).abs() < 1e-12);
}

#[test]
fn errors_name_place_and_cure() {
    let vtk_points = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 9999 float\n0 0 0\n";
    let cases: [(&str, MeshFormat, &[&str]); 18] = [
        ("# vtk Datafile\nt\nASCII\n", MeshFormat::Vtk, &["line 1:", "# vtk DataFile Version"]),
        (vtk_points, MeshFormat::Vtk, &["line 5:", "29997 point coordinates are announced"]),
        ("plx\nformat ascii 1.0\n", MeshFormat::Ply, &["line 1:", "the line `ply`"]),
        ("SKELOFF\n3 1 0\n", MeshFormat::Off, &["line 1:", "`SKELOFF` is not a kind of OFF"]),
        ("v 0 0 0\nv 1 x 0\n", MeshFormat::Obj, &["line 2", "`x` is not a number"]),
        ("v 0 0 0\nv 1 0,5 0\n", MeshFormat::Obj, &["line 2", "decimal point"]),
        ("v 0 0 0\nv nan 0 0\n", MeshFormat::Obj, &["line 2", "not finite"]),
        ("v 0 0 0\nv 1e200 0 0\n", MeshFormat::Obj, &["line 2", "1e100"]),
        ("v 0 0 0\nv 1 0 0\nf 1 2 7\nf 1 2 1\n", MeshFormat::Obj, &["line 3", "vertex 7", "only 2"]),
        ("v 0 0 0\nf 1 -2 1\n", MeshFormat::Obj, &["line 2", "`-2`"]),
        ("v 0 0 0\nf 0 1 1\n", MeshFormat::Obj, &["line 2", "`0`"]),
        ("v 0 0 0\nv 1 0 0\n", MeshFormat::Obj, &["point cloud: 2 points"]),
        ("", MeshFormat::Obj, &["no faces"]),
        ("v 0 0 0\nv 1 0 0\nf 1 2 2\n", MeshFormat::Obj, &["all faces (1) collapse"]),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", MeshFormat::Off, &["line 6", "`3`", "0 to 2"]),
        ("OFF\n4000000000 1 0\n0 0 0\n", MeshFormat::Off, &["4000000000 vertices", "cut"]),
        ("OFF BINARY\n", MeshFormat::Off, &["binary OFF", "ASCII"]),
        ("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", MeshFormat::Stl, &["line 5", "cut"]),
    ];
    for (text, format, parts) in cases {
        let message = error(text.as_bytes(), format);
        for part in parts {
            assert!(message.contains(part), "`{part}` is not in: {message}");
        }
    }
}

#[test]
fn a_comment_or_a_name_that_ends_in_a_backslash_goes_on_in_no_other_line() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n# faces of C:\\models\\\nf 1 3 2\nf 1 2 4 # C:\\\nf 2 3 4\n\
                g C:\\\nf 1 4 \\ # goes on\n3\n";
    let raw = read_mesh_bytes(text.as_bytes(), MeshFormat::Obj).unwrap();
    assert_eq!(raw.faces.iter().collect::<Vec<_>>(), [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]);
    assert!(raw.notes.is_empty(), "{:?}", raw.notes);
}

#[test]
fn capitals_and_fortran_exponents_are_read() {
    let expected = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 20.0, 0.25]];
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty double X\nproperty double Y\nproperty double Z\n\
               element face 1\nproperty list uchar int vertex_indices\nend_header\n\
               0 0 0\n1.0D+00 0 0\n0 2.d1 25D-2\n3 0 1 2\n";
    let vtk = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 3 double\n0 0 0 1.0D+00 0 0\n\
               0 2.d1 25D-2\nPOLYGONS 1 4\n3 0 1 2\n";
    let cases = [
        (MeshFormat::Obj, "O a\nV 0 0 0\nV 1.0D+00 0 0\nVN 0 0 1\nV 0 2.d1 25D-2\nF 1 2 3\n"),
        (MeshFormat::Off, "OFF 3 1 0\n0 0 0\n1.0D+00 0 0\n0 2.d1 25D-2\n3 0 1 2\n"),
        (MeshFormat::RawTriangles, "0 0 0 1.0D+00 0 0 0 2.d1 25D-2\n"),
        (
            MeshFormat::Stl,
            "solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1.0D+00 0 0\nvertex 0 2.d1 25D-2\n\
                           endloop\nendfacet\nendsolid\n",
        ),
        (MeshFormat::Ply, ply),
        (MeshFormat::Vtk, vtk),
    ];
    for (format, text) in cases {
        let raw = read_mesh_bytes(text.as_bytes(), format).unwrap();
        assert_eq!((raw.positions.as_slice(), raw.faces.len()), (&expected[..], 1), "{format}");
        assert!(raw.notes.is_empty(), "{format}: {:?}", raw.notes);
    }
    assert_eq!(MeshFormat::detect(Path::new("x"), cases[0].1.as_bytes()).unwrap(), MeshFormat::Obj);
}

/// What a reader leaves out.
fn notes(bytes: &[u8], format: MeshFormat) -> String {
    read_mesh_bytes(bytes, format).unwrap().notes.join("\n")
}

#[test]
fn what_is_left_out_is_named() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let obj = |more: &str| notes(format!("{triangle}{more}").as_bytes(), MeshFormat::Obj);
    assert_eq!(obj("call other.obj\n"), "line 5 begins with `call`, which is not read: left out");
    assert_eq!(
        obj("\nsolid\nfoo 1\nsolid\n"),
        "3 lines begin with words that are not read, the first with `solid` in line 6: left out"
    );
    let off = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n# end\n";
    assert_eq!(notes(off.as_bytes(), MeshFormat::Off), "");
    assert_eq!(
        notes(format!("{off}3 2 1 0\n").as_bytes(), MeshFormat::Off),
        "what follows the last face, from line 8 on, is left out: `3 2 1 0`"
    );
    let mut stl = samples::stl_binary();
    stl.extend([7; 120]);
    assert_eq!(
        notes(&stl, MeshFormat::Stl),
        "the header announces 12 triangles (14 triangles would fit); 120 bytes after them are left out"
    );
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
               element face 1\nproperty list uchar int vertex_indices\nelement patch 2\nproperty int a\nend_header\n\
               0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n5\n6\n3 2 1 0\n";
    assert_eq!(
        notes(ply.as_bytes(), MeshFormat::Ply),
        "the element `patch` (2 of them) is not read: left out\n9 bytes after the last element that the header \
         announces are left out"
    );
}

#[test]
fn a_count_of_0_is_named() {
    let mut stl = samples::stl_binary();
    stl[80..84].fill(0);
    let message = error(&stl, MeshFormat::Stl);
    assert!(
        message.contains("announces 0 triangles, and 600 bytes follow (12 triangles would fit)"),
        "{message}"
    );
}

#[test]
fn strangers_are_told_apart() {
    let cases: [(&[u8], &str); 4] = [
        (b"", "empty"),
        (b"\x1f\x8b\x08abc", "gzip"),
        (b"version https://git-lfs.github.com/spec/v1\n", "git lfs pull"),
        (b"\xFF\xFEv\0 \0", "UTF-16"),
    ];
    for (bytes, part) in cases {
        let error = MeshFormat::detect(Path::new("a.obj"), bytes).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
    let error = MeshFormat::detect(Path::new("a.xyz"), b"hello\n").unwrap_err();
    assert!(matches!(error, MeshError::UnknownFormat { .. }));
    assert!(error.to_string().ends_with(&MeshFormat::list()), "{error}");
}

#[test]
fn lists_of_points_are_no_triangles() {
    for (line, part) in [
        ("1 2 3", "point cloud"),
        ("1 2 3 0 0 1", "point cloud"),
        ("1 2 3 255 0 0 0 0 1", "name the file `.tri`"),
    ] {
        let text = format!("# a comment\n{line}\n{line}\n");
        for name in ["a.xyz", "a.txt", "a"] {
            let error = MeshFormat::detect(Path::new(name), text.as_bytes()).unwrap_err();
            assert!(
                matches!(error, MeshError::UnknownFormat { .. }) && error.to_string().contains(part),
                "{error}"
            );
        }
    }
    for name in ["a.tri", "a.RAW"] {
        let format = MeshFormat::detect(Path::new(name), b"0 0 0 1 0 0 0 1 0\n").unwrap();
        assert_eq!(format, MeshFormat::RawTriangles);
    }
}

#[test]
fn load_names_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("broken.obj");
    std::fs::write(&path, "v 0 0 0\nf 1 2 3\n").unwrap();
    let error = load(&path, &CleanSettings::default()).unwrap_err().to_string();
    assert!(error.contains("broken.obj: OBJ, line 2"), "{error}");
    assert!(load(folder.path(), &CleanSettings::default()).is_err());
}

#[test]
fn gltf_buffers_beside_the_file_are_read_and_others_refused() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("model");
    std::fs::create_dir(&inner).unwrap();
    let (json, buffer) = samples::gltf_external("my%20box.bin");
    std::fs::write(inner.join("my box.bin"), &buffer).unwrap();
    std::fs::write(folder.path().join("secret.bin"), &buffer).unwrap();
    let path = inner.join("a.gltf");
    std::fs::write(&path, json).unwrap();
    let (mesh, report) = load(&path, &CleanSettings::default()).unwrap();
    assert_eq!((mesh.triangles.len(), report.unit), (12, Some(1.0)));
    for uri in ["../secret.bin", "%2e%2e/secret.bin"] {
        std::fs::write(&path, samples::gltf_external(uri).0).unwrap();
        let error = load(&path, &CleanSettings::default()).unwrap_err().to_string();
        assert!(error.contains("leads out"), "{error}");
    }
    std::fs::write(&path, samples::gltf_external("gone.bin").0).unwrap();
    let error = load(&path, &CleanSettings::default()).unwrap_err().to_string();
    assert!(error.contains("gone.bin"), "{error}");
}

#[test]
fn gltf_transforms_strips_fans_and_sparse_accessors() {
    let (mesh, report) = read_clean(&samples::gltf_scene(), MeshFormat::Gltf);
    // A strip and a fan of two triangles each, a fan once more under a mirroring node; lines skipped.
    assert_eq!((mesh.triangles.len(), report.skipped.lines, report.objects), (6, 1, 2));
    let (area, _) = measure(&mesh);
    // Twice the unit square, scaled by 2 in the parent; and a mirrored one at its own size.
    assert!((area - 2.0 * 4.0 - 1.0).abs() < 1e-6, "{area}");
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|v| mesh.vertices[v as usize]);
        let z = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        assert!(z > 0.0, "faces down: {t:?}");
    }
    // The sparse accessor lifts the fan's first corner.
    assert!(mesh.vertices.iter().any(|v| v[2] == 0.0) && mesh.vertices.iter().all(|v| v[2] >= 0.0));
}

#[test]
fn gltf_instances_are_read_wherever_a_node_has_them() {
    let instanced = |attributes: &str| {
        let node = format!(
            "{{\"mesh\":0,\"scale\":[2,1,1],\"extensions\":{{\"EXT_mesh_gpu_instancing\":{{\"attributes\":{attributes}}}}}}}"
        );
        samples::gltf_box(&node, "", "")
    };
    let volume = |bytes: &[u8]| volume_and_notes(bytes, MeshFormat::Gltf);
    // Three boxes of 30, doubled in x by the node.
    assert_eq!(volume(&instanced("{\"TRANSLATION\":2}")), (180.0, String::new()));
    // With scales: 1, 2 and 3 times as large, the last one mirrored.
    let (mesh, _) = read_clean(&instanced("{\"TRANSLATION\":2,\"SCALE\":3}"), MeshFormat::Gltf);
    assert!((measure(&mesh).1 - 60.0 * (1.0 + 8.0 + 27.0)).abs() < 1e-9, "{}", measure(&mesh).1);
    assert!(
        error(&instanced("{\"TRANSLATION\":0,\"SCALE\":3}"), MeshFormat::Gltf).contains("different lengths")
    );
    assert!(error(&instanced("{}"), MeshFormat::Gltf).contains("node 0: EXT_mesh_gpu_instancing"));
}

/// Lowest corner and highest.
fn bounds(mesh: &TriangleMesh) -> [Point; 2] {
    let fold = |f: fn(f64, f64) -> f64, start: f64| {
        mesh.vertices.iter().fold([start; 3], |a, v| [0, 1, 2].map(|i| f(a[i], v[i])))
    };
    [fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY)]
}

#[test]
fn gltf_skins_are_placed_by_their_joints() {
    // The node's own transform counts for nothing; the joints' count. Half of the vertices hang on each.
    let nodes = "{\"mesh\":0,\"skin\":0,\"translation\":[100,0,0]},{\"translation\":[0,0,7],\"children\":[2]},\
                 {\"translation\":[0,0,3]}";
    let skin = ",\"JOINTS_0\":4,\"WEIGHTS_0\":5";
    let skins = ",\"skins\":[{\"joints\":[1,2],\"inverseBindMatrices\":6}]";
    let (mesh, report) = read_clean(&samples::gltf_box(nodes, skin, skins), MeshFormat::Gltf);
    // The box is 2 x 3 x 5 from (1, -1, 0.5). Inverse bind matrices move by 1 in x. Joint 1 is at z = 7, joint 2 at 10;
    // the lower four vertices hang on joint 1, the upper ones half on each.
    assert_eq!(bounds(&mesh), [[2.0, -1.0, 7.5], [4.0, 2.0, 14.0]]);
    assert_eq!(report.notes, ["skins are applied in the pose that the file's nodes have to mesh 0"]);
    // Without joints and weights: where its vertices are.
    let (mesh, report) = read_clean(&samples::gltf_box(nodes, "", skins), MeshFormat::Gltf);
    assert_eq!(bounds(&mesh), [[1.0, -1.0, 0.5], [3.0, 2.0, 5.5]]);
    assert!(report.notes[0].contains("no joints and weights"), "{:?}", report.notes);
}

#[test]
fn gltf_morph_targets_are_applied_by_their_weights() {
    // The target moves the upper vertices by 10 in z.
    let of = |node: &str, mesh: &str| read_clean(&samples::gltf_morph(node, mesh), MeshFormat::Gltf);
    let note = "morph targets are applied by the file's default weights to mesh 0";
    for (node, mesh, volume) in
        [("", ",\"weights\":[0.5]", 60.0), (",\"weights\":[1]", ",\"weights\":[0.5]", 90.0), ("", "", 30.0)]
    {
        let (found, report) = of(node, mesh);
        assert!((measure(&found).1 - volume).abs() < 1e-9, "{node} {mesh}: {}", measure(&found).1);
        assert_eq!(report.notes.is_empty(), volume == 30.0);
        assert!(report.notes.iter().all(|found| found == note));
    }
}

#[test]
fn gltf_hidden_nodes_and_those_outside_of_the_scene_are_named() {
    let hidden = "\"extensions\":{\"KHR_node_visibility\":{\"visible\":false}}";
    let nodes = format!(
        "{{\"mesh\":0,\"children\":[1]}},{{\"name\":\"lid\",{hidden},\"mesh\":0,\"translation\":[9,0,0],\
         \"children\":[2]}},{{\"mesh\":0,\"translation\":[9,0,0]}},{{\"mesh\":0}}"
    );
    assert_eq!(
        volume_and_notes(&samples::gltf_box(&nodes, "", ""), MeshFormat::Gltf),
        (
            30.0,
            "hidden by KHR_node_visibility, left out: node 1 (lid), node 2\noutside of the scene, left out: node 3".into()
        )
    );
    let strange = "{\"mesh\":0,\"extensions\":{\"ACME_holes\":{},\"KHR_lights_punctual\":{\"light\":0}}}";
    let (volume, notes) = volume_and_notes(&samples::gltf_box(strange, "", ""), MeshFormat::Gltf);
    assert_eq!((volume, notes.as_str()), (30.0, "extensions that are not read: ACME_holes"));
}

#[test]
fn threemf_units_components_and_mirrors() {
    let (mesh, report) = read_clean(&samples::threemf_assembly(), MeshFormat::ThreeMf);
    assert_eq!((report.unit, report.objects, mesh.triangles.len()), (Some(0.0254), 3, 36));
    let (_, volume) = measure(&mesh);
    // One box, one doubled in x, one mirrored: all outward.
    assert!((volume - 30.0 * 4.0).abs() < 1e-9, "{volume}");
}

#[test]
fn threemf_leaves_out_what_is_no_part_of_the_solid() {
    let of = |kind: &str, item: &str, file: (&str, &str)| {
        volume_and_notes(&samples::threemf_parts(kind, item, file), MeshFormat::ThreeMf)
    };
    let (none, nothing) = (("Metadata/x.config", "<config/>"), String::new());
    // Object 1, and object 3 as an item and as the component of object 4, which stands elsewhere.
    assert_eq!(of("model", "", none), (90.0, nothing.clone()));
    for kind in ["support", "solidsupport", "other"] {
        let note = format!("left out, of the type `{kind}`: object 3 (rib), object 3 (rib)");
        assert_eq!(of(kind, "", none), (30.0, note));
    }
    assert_eq!(
        of("model", "printable=\"0\"", none),
        (60.0, "left out, not to be printed: object 3 (rib)".into())
    );
    let prusa = |kind: &str| {
        format!(
            "<config><object id=\"1\"><volume firstid=\"0\" lastid=\"11\"><metadata type=\"volume\" key=\"name\" \
             value=\"bore\"/><metadata type=\"volume\" key=\"volume_type\" value=\"{kind}\"/></volume></object></config>"
        )
    };
    let prusa = |kind: &str| of("model", "", ("Metadata/Slic3r_PE_model.config", &prusa(kind)));
    assert_eq!(prusa("ModelPart"), (90.0, nothing.clone()));
    let note = "left out, a negative part of the slicer, which is not cut away: object 1 (bore)";
    assert_eq!(prusa("NegativeVolume"), (60.0, note.into()));
    assert_eq!(
        prusa("ParameterModifier"),
        (60.0, "left out, a modifier of the slicer: object 1 (bore)".into())
    );
    let bambu = "<config><object id=\"4\"><part id=\"3\" subtype=\"modifier_part\"><metadata key=\"name\" value=\"m\"/>\
                 </part></object></config>";
    let note = "left out, a modifier of the slicer: object 3 (rib)";
    assert_eq!(of("model", "", ("Metadata/model_settings.config", bambu)), (60.0, note.into()));
}

#[test]
fn threemf_names_objects_that_are_not_built_and_refuses_extensions_that_it_needs() {
    let (volume, notes) = volume_and_notes(
        &samples::threemf_model("", "<beamlattice><beams/></beamlattice>"),
        MeshFormat::ThreeMf,
    );
    assert_eq!(volume, 30.0);
    assert_eq!(
        notes,
        "left out, elements that are not read: `beamlattice`, `beams`\nleft out, not in the build: object 2"
    );
    let core = "xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\" requiredextensions=\"p\"";
    assert_eq!(volume_and_notes(&samples::threemf_model(core, ""), MeshFormat::ThreeMf).0, 30.0);
    let beams = "xmlns:b=\"http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02\" requiredextensions=\"b\"";
    let message = error(&samples::threemf_model(beams, ""), MeshFormat::ThreeMf);
    assert!(
        message.contains("the required extension") && message.contains("beamlattice/2017/02"),
        "{message}"
    );
    assert!(
        error(&samples::threemf_model("requiredextensions=\"q\"", ""), MeshFormat::ThreeMf)
            .contains("extension q")
    );
}

#[test]
fn threemf_bombs_are_refused() {
    let error = error(&samples::threemf_bomb(), MeshFormat::ThreeMf);
    assert!(error.contains("MiB") || error.contains("million"), "{error}");
}

/// The solid's volume, and what was left out.
fn volume_and_notes(bytes: &[u8], format: MeshFormat) -> (f64, String) {
    let (mesh, report) = read_clean(bytes, format);
    ((measure(&mesh).1 * 1e12).round() / 1e12, report.notes.join("\n"))
}

#[test]
fn polyhedra_count_by_their_outer_faces() {
    for sample in samples::polyhedra() {
        let (mesh, report) = read_clean(&sample.bytes, sample.format);
        assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (13, 22), "{}: {report:?}", sample.name);
        let (area, volume) = measure(&mesh);
        assert!(
            (area - 62.0).abs() < 1e-9 && (volume - 30.0).abs() < 1e-9,
            "{}: {area} {volume}",
            sample.name
        );
        assert!(is_closed(&mesh) && report.notes.is_empty(), "{}", sample.name);
    }
}

#[test]
fn hidden_and_duplicate_cells_of_vtk_are_left_out() {
    // Four unit cubes in a row: a hidden one, a duplicate, two that are there.
    let (vtu, vtk) = samples::vtk_ghosts("1 0 32 0");
    let note = "left out by `vtkGhostType`: 1 hidden cell and 1 duplicate cell";
    assert_eq!(volume_and_notes(&vtu, MeshFormat::Vtu), (2.0, note.into()));
    assert_eq!(volume_and_notes(&vtk, MeshFormat::Vtk), (2.0, note.into()));
    let (vtu, vtk) = samples::vtk_ghosts("0 16 0 4");
    assert_eq!(volume_and_notes(&vtu, MeshFormat::Vtu), (4.0, String::new()));
    assert_eq!(volume_and_notes(&vtk, MeshFormat::Vtk), (4.0, String::new()));
    assert!(error(&samples::vtk_ghosts("0 0 0").0, MeshFormat::Vtu).contains("3 values for 4 cells"));
}

#[test]
fn lists_of_vtk_files_name_a_file_with_a_mesh() {
    let xml = |kind: &str, body: &str| {
        let text = format!("<VTKFile type=\"{kind}\" byte_order=\"LittleEndian\">{body}</VTKFile>\n");
        error(text.as_bytes(), MeshFormat::Vtu)
    };
    let pvd = xml("Collection", "<Collection><DataSet timestep=\"0\" file=\"a.vtu\"/></Collection>");
    assert!(pvd.contains("it names the file with the mesh: give `a.vtu`"), "{pvd}");
    let pieces: String = (0..5).map(|k| format!("<Piece Source=\"p_{k}.vtu\"/>")).collect();
    let pvtu = xml("PUnstructuredGrid", &pieces);
    assert!(pvtu.contains("give one of `p_0.vtu`, `p_1.vtu`, `p_2.vtu` and 2 more"), "{pvtu}");
    let vtm =
        xml("vtkMultiBlockDataSet", "<Block><DataSet file=\"b/x.vtp\"/><DataSet file=\"y.vtp\"/></Block>");
    assert!(vtm.contains("give one of `b/x.vtp`, `y.vtp`"), "{vtm}");
    assert!(xml("ImageData", "<Piece/>").contains("extract its surface"));
}

#[test]
fn vtu_bombs_are_refused() {
    let error = error(&samples::vtu_bomb(), MeshFormat::Vtu);
    assert!(error.contains("MiB"), "{error}");
}

#[test]
fn ply_strips_extra_elements_and_doubles() {
    let text = "ply\nformat ascii 1.0\ncomment x\nelement vertex 4\nproperty double x\nproperty double y\n\
        property double z\nproperty uchar scalar_C2C[<0.1]\nelement edge 1\nproperty int a\nproperty int b\n\
        element empty 4000000000\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n\
        0 0 0 1\n1 0 0 1\n0 1 0 1\n1 1 0.1 1\n0 1\n8 0 1 2 3 -1 0 2 1\n";
    let raw = read_mesh_bytes(text.as_bytes(), MeshFormat::Ply).unwrap();
    let faces: Vec<_> = raw.faces.iter().collect();
    assert_eq!(faces, [[0, 1, 2], [1, 3, 2], [0, 2, 1]]);
    assert_eq!((raw.positions[3][2], raw.skipped.lines), (0.1, 1));
}

#[test]
fn off_variants_have_positions_first() {
    let variants = [
        "NOFF 3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n",
        "# c\nSTCNOFF\n\n3 1 0 # counts\n0 0 0 0 0 1 9 9 9 9 5 5\n1 0 0 0 0 1 9 9 9 9 5 5\n\
         0 1 0 0 0 1 9 9 9 9 5 5\n3 0 1 2 0.5 0.5 0.5\n",
        "4OFF\n3 1\n0 0 0 2\n2 0 0 2\n0 2 0 2\n3 0 1\n2\n",
        "nOFF\n3\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        "3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        // pymeshlab, and the glued headers of ModelNet40.
        "NCOFF\n3 1 0\n0 0 0 255 255 255 255 -1.5 0 0 \n1 0 0 9 9 9 9 0 0 1\n0 1 0 9 9 9 9 0 0 1\n3 0 1 2 \n",
        "OFF3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        "COFF3 1 0\n0 0 0 9 9 9 9\n1 0 0 9 9 9 9\n0 1 0 9 9 9 9\n3 0 1 2\n",
        "4NOFF3 1 0\n0 0 0 2 0 0 1\n2 0 0 2 0 0 1\n0 2 0 2 0 0 1\n3 0 1 2\n",
        "off\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    ];
    for text in variants {
        let found = MeshFormat::detect(Path::new("x.off"), text.as_bytes()).unwrap();
        assert_eq!(found, MeshFormat::Off, "{text}");
        let raw = read_mesh_bytes(text.as_bytes(), MeshFormat::Off).unwrap();
        assert_eq!(raw.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], "{text}");
        assert_eq!(raw.faces.iter().collect::<Vec<_>>(), [[0, 1, 2]], "{text}");
    }
}

#[test]
fn cleaning_counts_what_it_does() {
    let mut raw = RawMesh::new("OBJ");
    raw.positions = vec![
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [-0.0, 0.0, 0.0],
        [0.5, 0.0, 0.0],
        [9.0, 9.0, 9.0],
    ];
    for face in [[0, 1, 2], [1, 2, 3], [2, 1, 0], [0, 3, 1], [0, 4, 1]] {
        raw.add_face(&face);
    }
    let (mesh, report) = clean(raw, &CleanSettings::default()).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [2, 1, 0], [0, 3, 1]]);
    assert_eq!((report.welded, report.duplicates, report.degenerate), (1, 1, 1));
    assert_eq!((report.zero_area, report.unreferenced), (1, 1));
}

#[test]
fn a_needle_keeps_a_closed_mesh_closed() {
    // A tetrahedron with a vertex in the middle of an edge that only one side has.
    let mut raw = RawMesh::new("OBJ");
    raw.positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.5, 0.0, 0.0]];
    for face in [[0, 2, 1], [0, 4, 3], [4, 1, 3], [1, 2, 3], [2, 0, 3], [0, 1, 4]] {
        raw.add_face(&face);
    }
    let (mesh, report) = clean(raw, &CleanSettings::default()).unwrap();
    assert_eq!((report.zero_area, report.degenerate), (1, 0));
    assert!(is_closed(&mesh));
}

#[test]
fn a_weld_tolerance_closes_cracks() {
    let mut raw = read_mesh_bytes(&samples::boxes()[0].bytes, MeshFormat::Obj).unwrap();
    let mut split = RawMesh::new("OBJ");
    for (k, face) in raw.faces.iter().enumerate() {
        let first = split.positions.len() as u32;
        let shift = k as f64 * 1e-5;
        split.positions.extend(face.iter().map(|&c| raw.positions[c as usize].map(|c| c + shift)));
        let corners: Vec<u32> = (0..face.len() as u32).map(|k| first + k).collect();
        split.add_face(&corners);
    }
    let (open, _) = clean(split.clone(), &CleanSettings::default()).unwrap();
    assert!(!is_closed(&open));
    let (closed, report) = clean(split, &CleanSettings { weld_tolerance: 1e-3 }).unwrap();
    assert!(is_closed(&closed) && closed.vertices.len() == 8, "{report:?}");
    raw.positions[0][0] = f64::NAN;
    assert!(clean(raw.clone(), &CleanSettings::default()).is_err());
    assert!(clean(raw, &CleanSettings { weld_tolerance: -1.0 }).is_err());
}

fn raw_mesh() -> impl Strategy<Value = RawMesh> {
    // Few different coordinates, so that vertices, lines and planes often coincide.
    let coordinate = prop_oneof![(-3i32..4).prop_map(f64::from), -1e3..1e3, Just(-0.0), Just(1e99)];
    let positions = prop::collection::vec([coordinate.clone(), coordinate.clone(), coordinate], 1..24);
    let faces = prop::collection::vec(prop::collection::vec(0u32..26, 0..9), 0..20);
    (positions, faces).prop_map(|(positions, faces)| {
        let mut raw = RawMesh::new("OFF");
        raw.positions = positions;
        faces.iter().for_each(|face| raw.add_face(face));
        raw
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn cleaning_never_makes_an_invalid_mesh(raw in raw_mesh(), tolerance in prop_oneof![Just(0.0), 1e-3..2.0]) {
        let settings = CleanSettings { weld_tolerance: tolerance };
        if let Ok((mesh, report)) = clean(raw.clone(), &settings) {
            let count = mesh.vertices.len();
            prop_assert!(mesh.vertices.iter().flatten().all(|c| c.is_finite()));
            let mut used = vec![false; count];
            for t in &mesh.triangles {
                prop_assert!(t.iter().all(|&v| (v as usize) < count));
                prop_assert!(t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
                t.iter().for_each(|&v| used[v as usize] = true);
            }
            prop_assert!(used.into_iter().all(|used| used) && !mesh.triangles.is_empty());
            prop_assert_eq!(count + report.welded + report.unreferenced, raw.positions.len());
            prop_assert_eq!(report.triangles + report.quads + report.polygons, raw.faces.len());
            // Cleaning what is clean changes nothing.
            let mut again = RawMesh::new("OFF");
            again.positions = mesh.vertices.clone();
            mesh.triangles.iter().for_each(|t| again.add_face(t));
            prop_assert_eq!(&clean(again, &CleanSettings::default()).unwrap().0, &mesh);
        }
    }

    #[test]
    fn a_closed_mesh_of_polygons_stays_closed(
        points in prop::collection::vec([-1.0f64..1.0, -1.0..1.0, -1.0..1.0], 8),
        tolerance in prop_oneof![Just(0.0), 1e-3..1.0],
    ) {
        // A box with its corners moved anywhere: faces bend, cross, collapse.
        let mut raw = read_mesh_bytes(&samples::boxes()[0].bytes, MeshFormat::Obj).unwrap();
        raw.positions = points;
        if let Ok((mesh, report)) = clean(raw, &CleanSettings { weld_tolerance: tolerance }) {
            prop_assert!(report.duplicates > 0 || is_closed(&mesh), "{:?}", report);
        }
    }
}
