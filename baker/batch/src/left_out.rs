//! Files of other programs' formats that a pattern meets: none is read, so each is named, with how to convert it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

const WITH_ASSIMP: &str = "convert with `assimp export FILE OUT.glb`, or export glTF from Blender";
const WITH_BLENDER: &str = "import into Blender and export glTF";
const BY_ITS_PROGRAM: &str = "export glTF or OBJ from the program that wrote it";
const AS_TRIANGLES: &str =
    "export as STL or 3MF from a CAD program, or triangulate with `gmsh -2 FILE -o OUT.stl`";

/// Formats of solids, their extensions (lower case), and the cure.
const FORMATS: [(&str, &[&str], &str); 19] = [
    ("FBX", &["fbx"], WITH_ASSIMP),
    ("Collada", &["dae"], WITH_ASSIMP),
    ("3D Studio", &["3ds"], WITH_ASSIMP),
    ("X3D", &["x3d", "x3db", "wrl"], WITH_ASSIMP),
    ("LightWave", &["lwo"], WITH_ASSIMP),
    ("AMF", &["amf"], WITH_ASSIMP),
    ("USD", &["usd", "usda", "usdc", "usdz"], WITH_BLENDER),
    ("Alembic", &["abc"], WITH_BLENDER),
    ("Blender", &["blend"], "export glTF or OBJ from Blender"),
    ("3ds Max", &["max"], BY_ITS_PROGRAM),
    ("Maya", &["ma", "mb"], BY_ITS_PROGRAM),
    ("Cinema 4D", &["c4d"], BY_ITS_PROGRAM),
    ("Houdini", &["bgeo"], BY_ITS_PROGRAM),
    ("SketchUp", &["skp"], BY_ITS_PROGRAM),
    ("Rhino", &["3dm"], BY_ITS_PROGRAM),
    ("STEP", &["step", "stp"], AS_TRIANGLES),
    ("IGES", &["iges", "igs"], AS_TRIANGLES),
    ("BREP", &["brep"], AS_TRIANGLES),
    ("SolidWorks", &["sldprt", "sldasm"], BY_ITS_PROGRAM),
];

/// Files of one format that aren't read.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LeftOut {
    /// The format's name.
    pub format: String,
    /// The files, as the manifest's folder sees them.
    pub files: Vec<String>,
    /// How to make meshes of them that are read.
    pub cure: String,
}

/// Files that a line names.
const NAMED: usize = 4;

impl LeftOut {
    /// `2 FBX files (a.fbx, b.fbx) aren't read: ...`.
    pub fn told(&self) -> String {
        let n = self.files.len();
        let names = self.files.iter().take(NAMED).cloned().collect::<Vec<_>>().join(", ");
        let more = if n > NAMED { format!(" and {} more", n - NAMED) } else { String::new() };
        let (files, are) = if n == 1 { ("file", "isn't") } else { ("files", "aren't") };
        format!("{n} {} {files} ({names}{more}) {are} read: {}", self.format, self.cure)
    }
}

/// Whether a file is of such a format, by its extension.
pub fn is_foreign(path: &str) -> bool {
    format(path).is_some()
}

fn format(path: &str) -> Option<usize> {
    let extension = Path::new(path).extension()?.to_str()?.to_ascii_lowercase();
    FORMATS.iter().position(|(_, extensions, _)| extensions.contains(&extension.as_str()))
}

/// The files by their formats, each once.
pub fn by_format(mut paths: Vec<String>) -> Vec<LeftOut> {
    paths.sort_unstable();
    paths.dedup();
    let of = |(index, (name, _, cure)): (usize, &(&str, &[&str], &str))| {
        let files: Vec<String> = paths.iter().filter(|path| format(path) == Some(index)).cloned().collect();
        (!files.is_empty()).then(|| LeftOut { format: (*name).into(), files, cure: (*cure).into() })
    };
    FORMATS.iter().enumerate().filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use volmap_formats::mesh::MeshFormat;

    #[test]
    fn files_are_told_by_format() {
        let paths = ["b.STEP", "a.fbx", "c/d.fbx", "a.fbx", "x.usda"].map(str::to_owned).to_vec();
        let told: Vec<String> = by_format(paths).iter().map(LeftOut::told).collect();
        assert!(told[0].starts_with("2 FBX files (a.fbx, c/d.fbx) aren't read: convert with `assimp export"));
        assert!(told[1].starts_with("1 USD file (x.usda) isn't read: ") && told[2].contains("(b.STEP)"));
        let many = (0..9).map(|i| format!("{i}.dae")).collect();
        assert!(
            by_format(many)[0].told().starts_with("9 Collada files (0.dae, 1.dae, 2.dae, 3.dae and 5 more)")
        );
    }

    #[test]
    fn none_of_them_is_read() {
        let extensions = FORMATS.iter().flat_map(|(_, extensions, _)| *extensions);
        for extension in extensions {
            let path = format!("a.{extension}");
            assert_eq!(MeshFormat::from_extension(Path::new(&path)), None, "{extension}");
            assert!(is_foreign(&path) && !is_foreign("a.txt") && !is_foreign(extension));
        }
    }
}
