"""Writes meshes with meshio, trimesh and VTK, for volmap's readers to read.

    python write_meshes.py FOLDER

For every file NAME.EXT there is NAME.EXT.json: {"points": [[x, y, z]...], "polygons": [[i...]...],
"planar": bool, "tolerance": t}. Polygons of four or more corners may be triangulated in any way, so
they are compared by area and volume; a mesh of triangles is compared triangle by triangle.
"""

import json
import math
import pathlib
import sys

import meshio
import numpy as np
import trimesh
import vtk
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray

FOLDER = pathlib.Path(sys.argv[1])
F32 = 2e-7


def icosphere():
    mesh = trimesh.creation.icosphere(subdivisions=2, radius=1.5)
    points = mesh.vertices + np.array([0.1, -0.7, math.pi])
    return points, [list(map(int, face)) for face in mesh.faces]


def quad_cube():
    points = np.array([[x, y, z] for z in (-1.0, 2.0) for y in (0.0, 0.5) for x in (0.1, 1.3)])
    quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    return points, quads


def note(name, points, polygons, tolerance=1e-12, **more):
    data = {"points": np.asarray(points, float).tolist(), "polygons": polygons, "tolerance": tolerance}
    (FOLDER / f"{name}.json").write_text(json.dumps(data | more))


def with_meshio(shape, points, polygons):
    kind = "triangle" if len(polygons[0]) == 3 else "quad"
    mesh = meshio.Mesh(points, [(kind, np.array(polygons))])
    mesh.point_data["height"] = points[:, 2].copy()
    bare = meshio.Mesh(points, mesh.cells)
    files = [
        ("obj", "a.obj", bare, {}, 1e-12),
        ("ply", "ascii.ply", mesh, {"binary": False}, 1e-12),
        ("ply", "binary.ply", mesh, {"binary": True}, 1e-12),
        ("vtk", "ascii51.vtk", mesh, {"binary": False}, 1e-12),
        ("vtk", "binary51.vtk", mesh, {"binary": True}, 1e-12),
        ("vtk42", "ascii42.vtk", mesh, {"binary": False}, 1e-12),
        ("vtk42", "binary42.vtk", mesh, {"binary": True}, 1e-12),
        ("vtu", "ascii.vtu", mesh, {"binary": False}, 1e-10),
        ("vtu", "base64.vtu", mesh, {"binary": True, "compression": None}, 1e-12),
        ("vtu", "zlib.vtu", mesh, {"binary": True, "compression": "zlib"}, 1e-12),
    ]
    if kind == "triangle":
        files += [
            ("stl", "ascii.stl", bare, {"binary": False}, 1e-12),
            ("stl", "binary.stl", bare, {"binary": True}, F32),
            ("off", "a.off", bare, {}, 1e-12),
        ]
    for format, name, data, options, tolerance in files:
        name = f"meshio_{shape}_{name}"
        meshio.write(FOLDER / name, data, file_format=format, **options)
        note(name, points, polygons, tolerance)


def with_trimesh(points, faces):
    mesh = trimesh.Trimesh(points, faces, process=False)
    for name, options, tolerance in [
        ("a.obj", {}, 1e-7),
        ("a.off", {}, 1e-7),
        ("ascii.stl", {"file_type": "stl_ascii"}, 1e-6),
        ("binary.stl", {"file_type": "stl"}, F32),
        ("ascii.ply", {"encoding": "ascii"}, 1e-6),
        ("binary.ply", {}, F32),
        ("a.glb", {}, F32),
    ]:
        name = f"trimesh_{name}"
        mesh.export(FOLDER / name, **options)
        note(name, points, faces, tolerance)
    scene = trimesh.Scene()
    # Two instances, one of them mirrored, so that the winding has to be turned.
    turn = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3], [0.5, 0, 0])
    mirror = np.diag([-2.0, 1.0, 0.5, 1.0])
    mirror[:3, 3] = [10, 20, 30]
    scene.add_geometry(mesh, node_name="turned", transform=turn)
    scene.add_geometry(mesh, node_name="mirrored", parent_node_name="turned", transform=mirror)
    parts, corners = [], []
    for matrix in (turn, turn @ mirror):
        flip = np.linalg.det(matrix[:3, :3]) < 0
        first = len(points) * len(parts)
        parts.append(points @ matrix[:3, :3].T + matrix[:3, 3])
        corners += [[first + i for i in (face[::-1] if flip else face)] for face in faces]
    for name in ("scene.glb", "scene.gltf"):
        name = f"trimesh_{name}"
        if name.endswith("gltf"):
            for file, data in trimesh.exchange.gltf.export_gltf(scene).items():
                file = name if file == "model.gltf" else file
                (FOLDER / file).write_bytes(data)
        else:
            scene.export(FOLDER / name)
        note(name, np.vstack(parts), corners, 1e-6)
    scaled = trimesh.Trimesh(points, faces, process=False)
    scaled.units = "mm"
    scaled.export(FOLDER / "trimesh_a.3mf")
    note("trimesh_a.3mf", points, faces, 1e-6, unit=1e-3)


def poly_data(points, polygons):
    data = vtk.vtkPolyData()
    vtk_points = vtk.vtkPoints()
    vtk_points.SetDataTypeToDouble()
    vtk_points.SetData(numpy_to_vtk(np.ascontiguousarray(points), deep=True))
    data.SetPoints(vtk_points)
    cells = vtk.vtkCellArray()
    offsets = np.cumsum([0] + [len(p) for p in polygons])
    cells.SetData(
        numpy_to_vtkIdTypeArray(offsets.astype(np.int64), deep=True),
        numpy_to_vtkIdTypeArray(np.concatenate(polygons).astype(np.int64), deep=True),
    )
    data.SetPolys(cells)
    height = numpy_to_vtk(np.ascontiguousarray(points[:, 2]), deep=True)
    height.SetName("height")
    data.GetPointData().SetScalars(height)
    return data


def write(writer, data, name):
    writer.SetInputData(data)
    writer.SetFileName(str(FOLDER / name))
    assert writer.Write() == 1, name


def xml_variants(writer_class):
    for mode, set_mode in [
        ("ascii", lambda w: w.SetDataModeToAscii()),
        ("binary", lambda w: w.SetDataModeToBinary()),
        ("raw", lambda w: (w.SetDataModeToAppended(), w.EncodeAppendedDataOff())),
        ("appended64", lambda w: (w.SetDataModeToAppended(), w.EncodeAppendedDataOn())),
    ]:
        for compressor in ("none", "zlib"):
            for bits in (32, 64):
                for order in ("little", "big"):
                    writer = writer_class()
                    set_mode(writer)
                    if compressor == "none":
                        writer.SetCompressorTypeToNone()
                    else:
                        writer.SetCompressorTypeToZLib()
                        writer.SetBlockSize(1024)
                    if bits == 32:
                        writer.SetHeaderTypeToUInt32()
                    else:
                        writer.SetHeaderTypeToUInt64()
                    if order == "big":
                        writer.SetByteOrderToBigEndian()
                    yield f"{mode}_{compressor}_{bits}_{order}", writer


def with_vtk(shape, points, polygons):
    data = poly_data(points, polygons)
    for version in (42, 51):
        for binary in (False, True):
            writer = vtk.vtkPolyDataWriter()
            writer.SetFileVersion(version)
            writer.SetFileTypeToBinary() if binary else writer.SetFileTypeToASCII()
            name = f"vtk_{shape}_{version}_{'binary' if binary else 'ascii'}.vtk"
            write(writer, data, name)
            note(name, points, polygons, 1e-5 if not binary else 1e-12)
    for variant, writer in xml_variants(vtk.vtkXMLPolyDataWriter):
        name = f"vtk_{shape}_{variant}.vtp"
        write(writer, data, name)
        note(name, points, polygons, 1e-10)
    writer = vtk.vtkPLYWriter()
    writer.SetDataByteOrderToBigEndian()
    write(writer, data, f"vtk_{shape}_big.ply")
    note(f"vtk_{shape}_big.ply", points, polygons, F32)


def strips(points, faces):
    stripper = vtk.vtkStripper()
    stripper.SetInputData(poly_data(points, faces))
    stripper.Update()
    assert stripper.GetOutput().GetNumberOfStrips() > 0
    for name, writer in [("vtk_strips.vtp", vtk.vtkXMLPolyDataWriter()), ("vtk_strips.vtk", vtk.vtkPolyDataWriter())]:
        if name.endswith("vtk"):
            writer.SetFileTypeToBinary()
        write(writer, stripper.GetOutput(), name)
        note(name, points, faces, 1e-12)


def volume(name, points, cells):
    """A grid of volume cells: the expected surface is VTK's own boundary of it."""
    grid = vtk.vtkUnstructuredGrid()
    vtk_points = vtk.vtkPoints()
    vtk_points.SetDataTypeToDouble()
    for p in points:
        vtk_points.InsertNextPoint(*p)
    grid.SetPoints(vtk_points)
    for kind, corners in cells:
        grid.InsertNextCell(kind, len(corners), corners)
    surface = vtk.vtkGeometryFilter()
    surface.SetInputData(grid)
    surface.Update()
    out = surface.GetOutput()
    found = np.array([out.GetPoint(i) for i in range(out.GetNumberOfPoints())])
    polygons = [
        [out.GetCell(i).GetPointId(k) for k in range(out.GetCell(i).GetNumberOfPoints())]
        for i in range(out.GetNumberOfCells())
    ]
    for variant, writer in xml_variants(vtk.vtkXMLUnstructuredGridWriter):
        write(writer, grid, f"vtk_{name}_{variant}.vtu")
        note(f"vtk_{name}_{variant}.vtu", found, polygons, 1e-10, orientation=False)
    writer = vtk.vtkUnstructuredGridWriter()
    writer.SetFileTypeToBinary()
    write(writer, grid, f"vtk_{name}.vtk")
    note(f"vtk_{name}.vtk", found, polygons, 1e-10, orientation=False)


def volumes():
    points = [[x, y, z] for z in range(3) for y in range(3) for x in range(3)]
    at = lambda x, y, z: x + 3 * (y + 3 * z)
    cells = []
    for z in range(2):
        for y in range(2):
            for x in range(2):
                c = [at(x + i, y + j, z + k) for k in (0, 1) for j in (0, 1) for i in (0, 1)]
                hexa = [c[0], c[1], c[3], c[2], c[4], c[5], c[7], c[6]]
                if (x, y) == (0, 0):
                    cells.append((vtk.VTK_VOXEL, c))
                elif (x, y) == (1, 1):
                    cells.append((vtk.VTK_WEDGE, [hexa[i] for i in (0, 1, 2, 4, 5, 6)]))
                    cells.append((vtk.VTK_WEDGE, [hexa[i] for i in (0, 2, 3, 4, 6, 7)]))
                else:
                    cells.append((vtk.VTK_HEXAHEDRON, hexa))
    # On top: a pyramid and a tetrahedron.
    points += [[0.5, 0.5, 3.0], [3.0, 3.0, 3.0]]
    top = [at(0, 0, 2), at(1, 0, 2), at(1, 1, 2), at(0, 1, 2)]
    cells.append((vtk.VTK_PYRAMID, top + [27]))
    cells.append((vtk.VTK_TETRA, [at(1, 1, 2), at(2, 1, 2), at(2, 2, 2), 28]))
    volume("cells", points, cells)


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    for shape, (points, polygons) in {"sphere": icosphere(), "cube": quad_cube()}.items():
        with_meshio(shape, points, polygons)
        with_vtk(shape, points, polygons)
    points, faces = icosphere()
    with_trimesh(points, faces)
    strips(points, faces)
    volumes()


main()
