//! The examples do what they say.

#[allow(dead_code)]
#[path = "../examples/read_mesh.rs"]
mod read_mesh;
#[allow(dead_code)]
#[path = "../examples/write_asset.rs"]
mod write_asset;

#[test]
fn read_mesh_says_what_a_mesh_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tetrahedron.off");
    std::fs::write(&path, "OFF\n4 4 6\n0 0 0\n1 0 0\n0 2 0\n0 0 3\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n")
        .unwrap();
    let text = read_mesh::describe(&path).unwrap();
    assert!(text.starts_with("OFF: 4 vertices, 4 faces\n"), "{text}");
    assert!(text.ends_with("x from 0 to 1 m\ny from 0 to 3 m\nz from -2 to 0 m\n"), "{text}");
}

#[test]
fn write_asset_reads_back_what_it_wrote_and_finds_damage() {
    let folder = tempfile::tempdir().unwrap();
    let text = write_asset::write_and_read(&folder.path().join("two_cells.h5")).unwrap();
    assert!(text.starts_with("format version 1, 52 nodes\nwith a bit changed: "), "{text}");
}
