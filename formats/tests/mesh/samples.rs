//! A box of 2 x 3 x 5 from (1, -1, 0.5), hand-made in every format and variant.

use std::fmt::Write as _;
use std::io::Write as _;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use volmap_formats::mesh::MeshFormat;

pub struct Sample {
    pub name: &'static str,
    pub format: MeshFormat,
    pub bytes: Vec<u8>,
}

const QUADS: [[u32; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

fn points() -> Vec<[f64; 3]> {
    let corner = |k: usize, bit: usize| f64::from(u8::from(k >> bit & 1 == 1));
    (0..8).map(|k| [1.0 + 2.0 * corner(k, 0), -1.0 + 3.0 * corner(k, 1), 0.5 + 5.0 * corner(k, 2)]).collect()
}

fn triangles() -> Vec<[u32; 3]> {
    QUADS.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect()
}

fn text_points() -> String {
    points().iter().fold(String::new(), |s, p| s + &format!("{} {} {}\n", p[0], p[1], p[2]))
}

fn text_quads() -> String {
    QUADS.iter().fold(String::new(), |s, q| s + &format!("4 {} {} {} {}\n", q[0], q[1], q[2], q[3]))
}

fn obj() -> Vec<u8> {
    let mut text = String::from("# box\nmtllib gone.mtl\no box\n");
    points().iter().for_each(|p| writeln!(text, "v {} {} {}", p[0], p[1], p[2]).unwrap());
    QUADS.map(|q| q.map(|v| v + 1)).iter().for_each(|[a, b, c, d]| {
        writeln!(text, "f {a}/1 {b}//2 {c} {d}/1/1").unwrap();
    });
    text.into_bytes()
}

fn stl_ascii(first: &str) -> Vec<u8> {
    let mut text = format!("{first}\n");
    for t in triangles() {
        text += "facet normal nan 0 0\n outer loop\n";
        for p in t.map(|v| points()[v as usize]) {
            writeln!(text, "  vertex {:e} {:e} {:e}", p[0], p[1], p[2]).unwrap();
        }
        text += " endloop\nendfacet\n";
    }
    (text + "endsolid\n").into_bytes()
}

pub fn stl_binary() -> Vec<u8> {
    let mut bytes = b"solid but binary, with facet".to_vec();
    bytes.resize(80, b' ');
    bytes.extend((triangles().len() as u32).to_le_bytes());
    for t in triangles() {
        bytes.extend([0; 12]);
        for c in t.iter().flat_map(|&v| points()[v as usize]) {
            bytes.extend((c as f32).to_le_bytes());
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn ply(format: &str) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {format} 1.0\nelement vertex 8\nproperty double x\nproperty double y\n\
         property double z\nelement face 6\nproperty list uchar int vertex_index\nend_header\n"
    )
    .into_bytes();
    if format == "ascii" {
        bytes.extend((text_points() + &text_quads()).bytes());
        return bytes;
    }
    let big = format.contains("big");
    for c in points().into_iter().flatten() {
        bytes.extend(if big { c.to_be_bytes() } else { c.to_le_bytes() });
    }
    for quad in QUADS {
        bytes.push(4);
        quad.iter().for_each(|v| bytes.extend(if big { v.to_be_bytes() } else { v.to_le_bytes() }));
    }
    bytes
}

/// Positions, then indices as 16 bits.
fn gltf_buffer() -> Vec<u8> {
    let positions = points().into_iter().flatten().flat_map(|c| (c as f32).to_le_bytes());
    let indices = triangles().into_iter().flatten().flat_map(|v| (v as u16).to_le_bytes());
    positions.chain(indices).collect()
}

fn gltf_json(uri: Option<&str>) -> String {
    let uri = uri.map(|uri| format!("\"uri\":\"{uri}\",")).unwrap_or_default();
    format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[0]}}],\
         \"nodes\":[{{\"mesh\":0}}],\"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0}},\
         \"indices\":1}}]}}],\"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":8,\
         \"type\":\"VEC3\"}},{{\"bufferView\":1,\"componentType\":5123,\"count\":36,\"type\":\"SCALAR\"}}],\
         \"bufferViews\":[{{\"buffer\":0,\"byteLength\":96}},{{\"buffer\":0,\"byteOffset\":96,\
         \"byteLength\":72}}],\"buffers\":[{{{uri}\"byteLength\":168}}]}}"
    )
}

pub fn gltf_external(uri: &str) -> (String, Vec<u8>) {
    (gltf_json(Some(uri)), gltf_buffer())
}

fn data_uri(bytes: &[u8]) -> String {
    format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(bytes))
}

fn glb() -> Vec<u8> {
    let mut json = gltf_json(None).into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let buffer = gltf_buffer();
    let mut bytes = b"glTF".to_vec();
    bytes.extend(2u32.to_le_bytes());
    bytes.extend((28 + json.len() as u32 + buffer.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &buffer)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

/// A unit square as a strip and as a fan under a node scaled by 2, and the fan again, mirrored.
/// The fan's positions are a sparse accessor without a buffer view.
pub fn gltf_scene() -> Vec<u8> {
    let square = [[0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let mut buffer: Vec<u8> = square.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
    // Sparse: items 1, 2 and 3 of the fan; item 0 stays at the origin.
    buffer.extend([1u8, 2, 3, 0]);
    for c in [square[1], square[3], square[2]].iter().flatten() {
        buffer.extend(c.to_le_bytes());
    }
    format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scenes\":[{{\"nodes\":[0,2]}}],\"nodes\":[\
         {{\"children\":[1],\"scale\":[2,2,2],\"rotation\":[0,0,0.7071067811865476,0.7071067811865476]}},\
         {{\"mesh\":0,\"translation\":[0,0,1]}},{{\"mesh\":1,\"matrix\":[-1,0,0,0,0,1,0,0,0,0,1,0,-9,0,0,1]}}],\
         \"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0}},\"mode\":5}},\
         {{\"attributes\":{{\"POSITION\":1}},\"mode\":6}},{{\"attributes\":{{\"POSITION\":0}},\"mode\":1}}]}},\
         {{\"primitives\":[{{\"attributes\":{{\"POSITION\":1}},\"mode\":6}}]}}],\
         \"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"}},\
         {{\"componentType\":5126,\"count\":4,\"type\":\"VEC3\",\"sparse\":{{\"count\":3,\
         \"indices\":{{\"bufferView\":1,\"componentType\":5121}},\"values\":{{\"bufferView\":2}}}}}}],\
         \"bufferViews\":[{{\"buffer\":0,\"byteLength\":48}},{{\"buffer\":0,\"byteOffset\":48,\"byteLength\":3}},\
         {{\"buffer\":0,\"byteOffset\":52,\"byteLength\":36}}],\
         \"buffers\":[{{\"uri\":\"{}\",\"byteLength\":{}}}]}}",
        data_uri(&buffer),
        buffer.len()
    )
    .into_bytes()
}

/// A glTF of its own scene with node 0 at its top, from accessors: as their types, component types and bytes.
fn gltf_of(nodes: &str, mesh: &str, more: &str, accessors: &[(&str, u32, Vec<u8>)]) -> Vec<u8> {
    let (mut buffer, mut views, mut entries) = (Vec::new(), Vec::new(), Vec::new());
    for (k, (shape, kind, bytes)) in accessors.iter().enumerate() {
        let width = [("SCALAR", 1), ("VEC3", 3), ("VEC4", 4), ("MAT4", 16)]
            .iter()
            .find(|(n, _)| n == shape)
            .unwrap()
            .1;
        let size = [(5121, 1), (5123, 2), (5126, 4)].iter().find(|(n, _)| n == kind).unwrap().1;
        views.push(format!(
            "{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":{}}}",
            buffer.len(),
            bytes.len()
        ));
        entries.push(format!(
            "{{\"bufferView\":{k},\"componentType\":{kind},\"type\":\"{shape}\",\"count\":{}}}",
            bytes.len() / width / size
        ));
        buffer.extend(bytes);
    }
    format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[0]}}],\"nodes\":[{nodes}],\
         \"meshes\":[{{\"primitives\":[{{{mesh}}}]}}]{more},\"accessors\":[{}],\"bufferViews\":[{}],\
         \"buffers\":[{{\"uri\":\"{}\",\"byteLength\":{}}}]}}",
        entries.join(","),
        views.join(","),
        data_uri(&buffer),
        buffer.len()
    )
    .into_bytes()
}

fn f32s(values: impl IntoIterator<Item = f32>) -> Vec<u8> {
    values.into_iter().flat_map(f32::to_le_bytes).collect()
}

/// The box with accessors for instances (2: three places, 3: three scales) and skins (4: joints, 5: weights, 6: two
/// inverse bind matrices that move by 1 in x).
pub fn gltf_box(nodes: &str, attributes: &str, more: &str) -> Vec<u8> {
    let buffer = gltf_buffer();
    let weights = (0..8).flat_map(|k| if k < 4 { [1.0, 0.0, 0.0, 0.0] } else { [0.5, 0.5, 0.0, 0.0] });
    let mut bind = [0.0; 16];
    [0, 5, 10, 15, 12].into_iter().for_each(|k| bind[k] = 1.0);
    let accessors = [
        ("VEC3", 5126, buffer[..96].to_vec()),
        ("SCALAR", 5123, buffer[96..].to_vec()),
        ("VEC3", 5126, f32s([0.0, 0.0, 0.0, 100.0, 0.0, 0.0, 0.0, 100.0, 0.0])),
        ("VEC3", 5126, f32s([1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 3.0, 3.0, -3.0])),
        ("VEC4", 5121, [0u8, 1, 0, 0].repeat(8)),
        ("VEC4", 5126, f32s(weights)),
        ("MAT4", 5126, f32s(bind.into_iter().chain(bind))),
    ];
    let mesh = format!("\"attributes\":{{\"POSITION\":0{attributes}}},\"indices\":1");
    gltf_of(nodes, &mesh, more, &accessors)
}

/// The box with a morph target that moves its upper four vertices by 10 in z.
pub fn gltf_morph(node: &str, weights: &str) -> Vec<u8> {
    let buffer = gltf_buffer();
    let moves = (0..8).flat_map(|k| [0.0, 0.0, if k < 4 { 0.0 } else { 10.0 }]);
    let accessors = [
        ("VEC3", 5126, buffer[..96].to_vec()),
        ("SCALAR", 5123, buffer[96..].to_vec()),
        ("VEC3", 5126, f32s(moves)),
    ];
    let mesh = "\"attributes\":{\"POSITION\":0},\"indices\":1,\"targets\":[{\"POSITION\":2}]";
    let text = gltf_of(&format!("{{\"mesh\":0{node}}}"), mesh, "", &accessors);
    String::from_utf8(text)
        .unwrap()
        .replace("}]}]}],\"acc", &format!("}}]}}]{weights}}}],\"acc"))
        .into_bytes()
}

fn zip(files: &[(&str, String)], method: zip::CompressionMethod) -> Vec<u8> {
    let mut writer = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default().compression_method(method);
    for (name, text) in files {
        writer.start_file(*name, options).unwrap();
        writer.write_all(text.as_bytes()).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

const RELS: &str = "<?xml version=\"1.0\"?><Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/\
    relationships\"><Relationship Target=\"/3D/main.model\" Id=\"r\" Type=\"http://schemas.microsoft.com/\
    3dmanufacturing/2013/01/3dmodel\"/></Relationships>";

fn threemf_object(id: u32) -> String {
    let mut text = format!("<object id=\"{id}\" type=\"model\"><mesh><vertices>");
    points().iter().for_each(|p| {
        write!(text, "<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>", p[0], p[1], p[2]).unwrap();
    });
    text += "</vertices><triangles>";
    triangles().iter().for_each(|t| {
        write!(text, "<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\"/>", t[0], t[1], t[2]).unwrap();
    });
    text + "</triangles></mesh></object>"
}

fn threemf(unit: &str, resources: &str, build: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?><model unit=\"{unit}\" xmlns=\"http://schemas.microsoft.com/\
         3dmanufacturing/core/2015/02\"><resources>{resources}</resources><build>{build}</build></model>"
    )
}

/// The box, the box doubled in x, and from another part the box mirrored; in inches.
pub fn threemf_assembly() -> Vec<u8> {
    let components = "<basematerials id=\"9\"><base name=\"a\" displaycolor=\"#FFFFFF\"/></basematerials>\
        <object id=\"2\"><components><component objectid=\"1\" transform=\"2 0 0 0 1 0 0 0 1 50 0 0\"/>\
        <component objectid=\"7\" p:path=\"/3D/other.model\" transform=\"1 0 0 0 1 0 0 0 -1 0 50 0\"/>\
        </components></object>";
    let resources = threemf_object(1) + components;
    let main = threemf("inch", &resources, "<item objectid=\"1\"/><item objectid=\"2\"/>");
    let other = threemf("inch", &threemf_object(7), "");
    let files = [("_rels/.rels", RELS.into()), ("3D/other.model", other), ("3D/main.model", main)];
    zip(&files, zip::CompressionMethod::Deflated)
}

/// Object 1, object 3 of such a type, and object 4 with object 3 as its component; a further file.
pub fn threemf_parts(kind: &str, item: &str, (path, text): (&str, &str)) -> Vec<u8> {
    let rib = threemf_object(3).replace("type=\"model\"", &format!("type=\"{kind}\" name=\"rib\""));
    let moved = "transform=\"1 0 0 0 1 0 0 0 1 50 0 0\"";
    let whole =
        format!("<object id=\"4\"><components><component objectid=\"3\" {moved}/></components></object>");
    let items = format!(
        "<item objectid=\"1\"/><item objectid=\"3\" transform=\"1 0 0 0 1 0 0 0 1 0 50 0\" {item}/><item objectid=\"4\"/>"
    );
    let main = threemf("meter", &(threemf_object(1) + &rib + &whole), &items);
    zip(
        &[("_rels/.rels", RELS.into()), ("3D/main.model", main), (path, text.into())],
        zip::CompressionMethod::Stored,
    )
}

/// Object 1, with more in its mesh, is built, object 2 not; the model has more attributes.
pub fn threemf_model(attributes: &str, mesh: &str) -> Vec<u8> {
    let first = threemf_object(1).replace("</triangles>", &format!("</triangles>{mesh}"));
    let text = threemf("meter", &(first + &threemf_object(2)), "<item objectid=\"1\"/>");
    let text = text.replace("<model ", &format!("<model {attributes} "));
    zip(&[("_rels/.rels", RELS.into()), ("3D/main.model", text)], zip::CompressionMethod::Stored)
}

/// Forty objects, each twice the one before it.
pub fn threemf_bomb() -> Vec<u8> {
    let mut resources = threemf_object(1);
    for id in 2..42 {
        let half = format!("<component objectid=\"{}\"/>", id - 1);
        write!(resources, "<object id=\"{id}\"><components>{half}{half}</components></object>").unwrap();
    }
    let main = threemf("millimeter", &resources, "<item objectid=\"41\"/>");
    zip(&[("_rels/.rels", RELS.into()), ("3D/main.model", main)], zip::CompressionMethod::Deflated)
}

fn vtk_ascii() -> Vec<u8> {
    format!(
        "# vtk DataFile Version 3.0\nbox\nASCII\nDATASET POLYDATA\nPOINTS 8 double\n{}POLYGONS 6 30\n{}\
         POINT_DATA 8\nSCALARS s float 1\nLOOKUP_TABLE default\n0 0 0 0 0 0 0 0\n",
        text_points(),
        text_quads()
    )
    .into_bytes()
}

/// Version 5.1, a hexahedron.
fn vtk_binary() -> Vec<u8> {
    let mut bytes =
        b"# vtk DataFile Version 5.1\nbox\nBINARY\nDATASET UNSTRUCTURED_GRID\nFIELD FieldData 1\n\
        TIME 1 1 double\n\0\0\0\0\0\0\0\0\nPOINTS 8 float\n"
            .to_vec();
    points().iter().flatten().for_each(|&c| bytes.extend((c as f32).to_be_bytes()));
    bytes.extend(b"\nMETADATA\nINFORMATION 0\n\nCELLS 2 8\nOFFSETS vtktypeint64\n");
    [0i64, 8].iter().for_each(|v| bytes.extend(v.to_be_bytes()));
    bytes.extend(b"\nCONNECTIVITY vtktypeint64\n");
    [0i64, 1, 3, 2, 4, 5, 7, 6].iter().for_each(|v| bytes.extend(v.to_be_bytes()));
    bytes.extend(b"\nCELL_TYPES 1\n\0\0\0\x0C\n");
    bytes
}

fn vtp_ascii() -> Vec<u8> {
    let quads = QUADS.iter().flatten().fold(String::new(), |s, v| s + &format!("{v} "));
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\">\n<PolyData>\
         \n<Piece NumberOfPoints=\"8\" NumberOfPolys=\"6\">\n<PointData/>\n<Points>\n<DataArray type=\"Float64\" \
         NumberOfComponents=\"3\" format=\"ascii\">\n{}</DataArray>\n</Points>\n<Polys>\n<DataArray type=\"Int32\" \
         Name=\"connectivity\" format=\"ascii\">\n{quads}\n</DataArray>\n<DataArray type=\"Int32\" Name=\"offsets\" \
         format=\"ascii\">\n4 8 12 16 20 24\n</DataArray>\n</Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n",
        text_points()
    )
    .into_bytes()
}

/// A voxel; its arrays are packed by `pack`.
fn vtu(attributes: &str, format: &str, pack: impl Fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
    let data: [Vec<u8>; 4] = [
        points().iter().flatten().flat_map(|c| c.to_le_bytes()).collect(),
        (0..8i64).flat_map(|v| v.to_le_bytes()).collect(),
        8i64.to_le_bytes().to_vec(),
        vec![11],
    ];
    let heads = [("Float64", "Points"), ("Int64", "connectivity"), ("Int64", "offsets"), ("UInt8", "types")];
    let mut appended = b"_".to_vec();
    let mut arrays: Vec<String> = Vec::new();
    for ((kind, name), data) in heads.iter().zip(&data) {
        let head = format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"3\" format=\"{format}\""
        );
        let packed = pack(data);
        arrays.push(match format {
            "appended" => format!("{head} offset=\"{}\"/>\n", appended.len() - 1),
            _ => format!("{head}>\n{}\n</DataArray>\n", String::from_utf8(packed.clone()).unwrap()),
        });
        appended.extend(packed);
    }
    let mut bytes = format!(
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" {attributes}>\n\
         <UnstructuredGrid>\n<Piece NumberOfPoints=\"8\" NumberOfCells=\"1\">\n<Points>\n{}</Points>\n<Cells>\n\
         {}{}{}</Cells>\n</Piece>\n</UnstructuredGrid>\n",
        arrays[0], arrays[1], arrays[2], arrays[3]
    )
    .into_bytes();
    if format == "appended" {
        bytes.extend(b"<AppendedData encoding=\"raw\">\n");
        bytes.extend(appended);
        bytes.extend(b"\n</AppendedData>\n");
    }
    bytes.extend(b"</VTKFile>\n");
    bytes
}

fn raw_block(data: &[u8]) -> Vec<u8> {
    [&(data.len() as u64).to_le_bytes()[..], data].concat()
}

fn zlib(block: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(block).unwrap();
    encoder.finish().unwrap()
}

/// An xz stream with LZMA2 chunks that are stored, as the .xz file format 1.2 has it, without a check.
fn xz(block: &[u8]) -> Vec<u8> {
    let crc = |bytes: &[u8]| flate2_crc(bytes).to_le_bytes();
    let mut out = b"\xFD7zXZ\0".to_vec();
    let flags = [0u8, 0];
    out.extend(flags);
    out.extend(crc(&flags));
    // Size 8 bytes with the CRC after it; one filter, LZMA2 (0x21) with a dictionary of 4 KiB.
    let mut head = vec![2u8, 0, 0x21, 1, 0, 0, 0, 0];
    head.extend(crc(&head.clone()));
    let start = out.len();
    out.extend(&head);
    out.push(1);
    out.extend((block.len() as u16 - 1).to_be_bytes());
    out.extend(block);
    out.push(0);
    let unpadded = out.len() - start;
    out.resize(out.len().next_multiple_of(4), 0);
    let mut index = vec![0u8, 1];
    for mut n in [unpadded, block.len()] {
        while n > 127 {
            index.push(n as u8 | 128);
            n >>= 7;
        }
        index.push(n as u8);
    }
    index.resize(index.len().next_multiple_of(4), 0);
    index.extend(crc(&index.clone()));
    let backward = ((index.len() / 4 - 1) as u32).to_le_bytes();
    out.extend(&index);
    let foot = [&backward[..], &flags].concat();
    out.extend(crc(&foot));
    out.extend(&foot);
    out.extend(b"YZ");
    out
}

fn flate2_crc(bytes: &[u8]) -> u32 {
    let mut crc = flate2::Crc::new();
    crc.update(bytes);
    crc.sum()
}

/// Blocks of 100 bytes, each packed by `pack`.
fn blocks(data: &[u8], pack: impl Fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
    let (mut sizes, mut packed) = (Vec::new(), Vec::new());
    for block in data.chunks(100) {
        let block = pack(block);
        sizes.push(block.len() as u32);
        packed.extend(block);
    }
    let head = [sizes.len() as u32, 100, (data.len() % 100) as u32];
    let head: Vec<u8> = head.iter().chain(&sizes).flat_map(|v| v.to_le_bytes()).collect();
    (BASE64_STANDARD.encode(head) + &BASE64_STANDARD.encode(packed)).into_bytes()
}

/// Every array is said to have 600 blocks of 1 MB of zeros, of 1 kB each.
pub fn vtu_bomb() -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    encoder.write_all(&vec![0; 1_000_000]).unwrap();
    let block = encoder.finish().unwrap();
    let count = 600;
    let sizes = vec![block.len() as u32; count];
    let head = [count as u32, 1_000_000, 0];
    let head: Vec<u8> = head.iter().chain(&sizes).flat_map(|v| v.to_le_bytes()).collect();
    let packed = BASE64_STANDARD.encode(head) + &BASE64_STANDARD.encode(block.repeat(count));
    vtu("compressor=\"vtkZLibDataCompressor\"", "binary", |_| packed.clone().into_bytes())
}

fn raw_triangles() -> Vec<u8> {
    let mut text = String::from("# box\n");
    for t in triangles() {
        let [a, b, c] = t.map(|v| points()[v as usize].map(|x| x.to_string()).join(" "));
        writeln!(text, "{a}  {b}\t{c}").unwrap();
    }
    text.into_bytes()
}

/// The box as two polyhedra, the second turned inside out. The face between them has five corners.
const POLYHEDRA: [[&[u32]; 6]; 2] = [
    [&[0, 2, 3, 1], &[8, 12, 9, 11, 10], &[0, 1, 9, 12, 8], &[2, 10, 11, 3], &[0, 8, 10, 2], &[1, 3, 11, 9]],
    [&[9, 11, 10, 8, 12], &[6, 7, 5, 4], &[4, 5, 9, 12, 8], &[11, 7, 6, 10], &[10, 6, 4, 8], &[5, 7, 11, 9]],
];

fn joined(numbers: impl IntoIterator<Item = impl ToString>) -> String {
    numbers.into_iter().map(|n| n.to_string()).collect::<Vec<_>>().join(" ")
}

/// Where parts of these lengths end.
fn ends(lengths: impl IntoIterator<Item = usize>) -> String {
    let mut sum = 0;
    joined(lengths.into_iter().map(|length| {
        sum += length;
        sum
    }))
}

fn vtu_ascii(points: (usize, &str), cells: usize, arrays: &[(&str, &str)], more: &str) -> Vec<u8> {
    let array = |name: &str, values: &str| {
        format!("<DataArray type=\"Int64\" Name=\"{name}\" format=\"ascii\">{values}</DataArray>\n")
    };
    let arrays: String = arrays.iter().map(|(name, values)| array(name, values)).collect();
    format!(
        "<VTKFile type=\"UnstructuredGrid\" version=\"2.3\" byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n\
         <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{cells}\">\n{more}<Points>\n<DataArray type=\"Float64\" \
         NumberOfComponents=\"3\" format=\"ascii\">\n{}</DataArray>\n</Points>\n<Cells>\n{arrays}</Cells>\n</Piece>\n\
         </UnstructuredGrid>\n</VTKFile>\n",
        points.0, points.1
    )
    .into_bytes()
}

/// Polyhedra in the two ways of VTU, and in that of VTK legacy.
pub fn polyhedra() -> [Sample; 3] {
    let middle = "1 -1 2.5\n3 -1 2.5\n1 2 2.5\n3 2 2.5\n2 -1 2.5\n";
    let points = text_points() + middle;
    let streams = POLYHEDRA.map(|cell| {
        let faces = cell.iter().map(|face| format!("{} {}", face.len(), joined(*face)));
        format!("{} {}", cell.len(), joined(faces))
    });
    let lengths = streams.each_ref().map(|stream| stream.split(' ').count());
    let common = [
        ("connectivity", joined((0..13).chain(4..13))),
        ("offsets", "13 22".into()),
        ("types", "42 42".into()),
    ];
    let old = [("faces", streams.join(" ")), ("faceoffsets", ends(lengths))];
    let faces = || POLYHEDRA.iter().flatten();
    let new = [
        ("face_connectivity", joined(faces().copied().flatten())),
        ("face_offsets", ends(faces().map(|face| face.len()))),
        ("polyhedron_to_faces", joined(0..12)),
        ("polyhedron_offsets", "6 12".into()),
    ];
    let vtu = |more: &[(&str, String)]| {
        let arrays: Vec<_> =
            common.iter().chain(more).map(|(name, values)| (*name, values.as_str())).collect();
        vtu_ascii((13, &points), 2, &arrays, "")
    };
    let legacy = format!(
        "# vtk DataFile Version 4.2\nbox\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 13 double\n{points}CELLS 2 {}\n\
         {} {}\n{} {}\nCELL_TYPES 2\n42\n42\n",
        2 + lengths[0] + lengths[1],
        lengths[0],
        streams[0],
        lengths[1],
        streams[1]
    );
    let sample = |name, format, bytes| Sample { name, format, bytes };
    [
        sample("VTU polyhedra", MeshFormat::Vtu, vtu(&old)),
        sample("VTU polyhedra by faces", MeshFormat::Vtu, vtu(&new)),
        sample("VTK polyhedra", MeshFormat::Vtk, legacy.into_bytes()),
    ]
}

/// Four unit cubes in a row with `vtkGhostType`, as VTU and as VTK legacy.
pub fn vtk_ghosts(types: &str) -> (Vec<u8>, Vec<u8>) {
    let corner = |k: usize| format!("{} {} {}\n", k / 4, k / 2 % 2, k % 2);
    let points: String = (0..20).map(corner).collect();
    let voxel = |k: usize| [0, 4, 2, 6, 1, 5, 3, 7].map(|c| (4 * k + c).to_string()).join(" ");
    let cells: Vec<String> = (0..4).map(voxel).collect();
    let arrays = [
        ("connectivity", cells.join(" ")),
        ("offsets", "8 16 24 32".into()),
        ("types", "11 11 11 11".into()),
    ];
    let arrays = arrays.each_ref().map(|(name, values)| (*name, values.as_str()));
    let data = format!(
        "<CellData><DataArray type=\"UInt8\" Name=\"vtkGhostType\" format=\"ascii\">{types}</DataArray></CellData>\n"
    );
    let vtu = vtu_ascii((20, &points), 4, &arrays, &data);
    let cells: String = cells.iter().map(|cell| format!("8 {cell}\n")).collect();
    let vtk = format!(
        "# vtk DataFile Version 3.0\nrow\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 20 float\n{points}CELLS 4 36\n\
         {cells}CELL_TYPES 4\n11\n11\n11\n11\nPOINT_DATA 20\nSCALARS a float 1\nLOOKUP_TABLE default\n{}\n\
         CELL_DATA 4\nSCALARS b int\nLOOKUP_TABLE default\n1 2 3 4\nFIELD f 1\nvtkGhostType 1 4 unsigned_char\n\
         {types}\n",
        "0 ".repeat(20)
    );
    (vtu, vtk.into_bytes())
}

pub fn boxes() -> Vec<Sample> {
    let off = format!("OFF\n# box\n8 6 12\n{}{}", text_points(), text_quads()).into_bytes();
    let build = threemf("millimeter", &threemf_object(1), "<item objectid=\"1\"/>");
    let files = [("_rels/.rels", RELS.into()), ("3D/main.model", build)];
    let base64 = |data: &[u8]| BASE64_STANDARD.encode(raw_block(data)).into_bytes();
    let vtu_packed = |compressor: &str, pack: fn(&[u8]) -> Vec<u8>| {
        vtu(&format!("compressor=\"{compressor}\""), "binary", |data| blocks(data, pack))
    };
    let samples = [
        ("OBJ", MeshFormat::Obj, obj()),
        ("STL ASCII", MeshFormat::Stl, stl_ascii("solid box")),
        ("STL ASCII, no name", MeshFormat::Stl, stl_ascii("solid")),
        ("STL binary", MeshFormat::Stl, stl_binary()),
        ("PLY ASCII", MeshFormat::Ply, ply("ascii")),
        ("PLY little endian", MeshFormat::Ply, ply("binary_little_endian")),
        ("PLY big endian", MeshFormat::Ply, ply("binary_big_endian")),
        ("OFF", MeshFormat::Off, off),
        ("glTF", MeshFormat::Gltf, gltf_json(Some(&data_uri(&gltf_buffer()))).into_bytes()),
        ("GLB", MeshFormat::Glb, glb()),
        ("3MF deflated", MeshFormat::ThreeMf, zip(&files, zip::CompressionMethod::Deflated)),
        ("3MF stored", MeshFormat::ThreeMf, zip(&files, zip::CompressionMethod::Stored)),
        ("VTK ASCII polygons", MeshFormat::Vtk, vtk_ascii()),
        ("VTK binary 5.1 hexahedron", MeshFormat::Vtk, vtk_binary()),
        ("VTP ASCII", MeshFormat::Vtp, vtp_ascii()),
        ("VTU base64", MeshFormat::Vtu, vtu("header_type=\"UInt64\"", "binary", base64)),
        ("VTU raw", MeshFormat::Vtu, vtu("header_type=\"UInt64\"", "appended", raw_block)),
        ("VTU zlib", MeshFormat::Vtu, vtu_packed("vtkZLibDataCompressor", zlib)),
        ("VTU LZ4", MeshFormat::Vtu, vtu_packed("vtkLZ4DataCompressor", lz4_flex::block::compress)),
        ("VTU LZMA", MeshFormat::Vtu, vtu_packed("vtkLZMADataCompressor", xz)),
        ("raw triangles", MeshFormat::RawTriangles, raw_triangles()),
    ];
    samples.map(|(name, format, bytes)| Sample { name, format, bytes }).into()
}
