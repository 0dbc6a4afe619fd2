//! What people give by mistake.

const STARTS: [(&[u8], &str); 11] = [
    (b"\x1f\x8b", "the file is compressed with gzip: unpack it first"),
    (b"BZh", "the file is compressed with bzip2: unpack it first"),
    (b"\xFD7zXZ", "the file is compressed with xz: unpack it first"),
    (b"\x28\xB5\x2F\xFD", "the file is compressed with zstd: unpack it first"),
    (b"\xFF\xFE", "the file is UTF-16 text: save it as UTF-8"),
    (b"\xFE\xFF", "the file is UTF-16 text: save it as UTF-8"),
    (b"version https://git-lfs", "the file is a Git LFS pointer, not a mesh: run `git lfs pull`"),
    (b"<!DOCTYPE", "the file is a web page, not a mesh: download it again"),
    (b"<html", "the file is a web page, not a mesh: download it again"),
    (b"Kaydara FBX", "the file is FBX: export it as glTF or OBJ"),
    (b"\x89HDF", "the file is HDF5: export its surface as VTP or PLY"),
];

/// What a file is instead of a mesh, and the cure.
pub fn known(bytes: &[u8]) -> Option<&'static str> {
    if bytes.is_empty() {
        return Some("the file is empty (0 bytes): export or download it again");
    }
    STARTS.iter().find(|(start, _)| bytes.starts_with(start)).map(|(_, problem)| *problem)
}
