"""What other programs read of a frame's particles: VTK, meshio, splashsurf. The values follow the rules of
interop_simulation.rs: number n of a particle gives its place in a block of 20 x 16 x 24, and all else."""

import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import meshio
import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

RADIUS = 0.025
SHAPE = np.array([20, 16, 24])


def check(name, position, data):
    n = data["id"].astype(np.int64).ravel()
    assert sorted(n) == list(range(SHAPE.prod())), name
    place = 2 * RADIUS * (np.stack([n % 20, n // 20 % 16, n // 320], axis=1) + 0.5)
    assert (position == place.astype(np.float32)).all(), name
    assert (data["density"].ravel() == (1 + n / 1024).astype(np.float32)).all(), name
    assert (data["pressure"].ravel() == (10 * n).astype(np.float32)).all(), name
    velocity = np.stack([n, 0.5 + 0 * n, -2 * n], axis=1)
    assert (data["velocity"] == velocity.astype(np.float32)).all(), name
    print(f"{name}: {len(n)} particles, all values equal")


def read_with_vtk(path):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    assert grid.GetNumberOfCells() == SHAPE.prod() and grid.GetCellType(0) == vtk.VTK_VERTEX
    point_data = grid.GetPointData()
    names = [point_data.GetArrayName(n) for n in range(point_data.GetNumberOfArrays())]
    arrays = {name: vtk_to_numpy(point_data.GetArray(name)) for name in names}
    check("VTK, vtu", vtk_to_numpy(grid.GetPoints().GetData()), arrays)


def read_ply_with_vtk(path):
    reader = vtk.vtkPLYReader()
    reader.SetFileName(str(path))
    reader.Update()
    assert reader.GetOutput().GetNumberOfPoints() == SHAPE.prod()


def volume(path):
    mesh = meshio.read(path)
    corners = mesh.points[mesh.cells_dict["triangle"]].astype(np.float64)
    return abs(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6)


def surface(path):
    out = path.with_suffix(f"{path.suffix}.surface.ply")
    tool = Path(sys.executable).with_name("pysplashsurf")
    options = ["-r", str(RADIUS), "-l", "2.0", "-c", "0.5", "-t", "0.6", "-o", str(out), "-q"]
    subprocess.run([tool, "reconstruct", path, *options], check=True)
    found, true = volume(out), SHAPE.prod() * (2 * RADIUS) ** 3
    print(f"splashsurf, {path.suffix}: {found:.4f} m^3 of {true:.4f}")
    assert abs(found / true - 1) < 0.15
    return found


folder = Path(sys.argv[1])
collection = ElementTree.parse(folder / "particles.pvd").getroot()
[entry] = collection.iter("DataSet")
assert float(entry.get("timestep")) == 0.25
read_with_vtk(folder / entry.get("file"))
mesh = meshio.read(folder / "frame_000001.vtu")
check("meshio, vtu", mesh.points, mesh.point_data)
mesh = meshio.read(folder / "frame_000001.ply")
data = dict(mesh.point_data)
data["velocity"] = np.stack([data["vx"], data["vy"], data["vz"]], axis=1)
check("meshio, ply", mesh.points, data)
read_ply_with_vtk(folder / "frame_000001.ply")
volumes = [surface(folder / f"frame_000001.{format}") for format in ("vtu", "ply", "bgeo")]
assert max(volumes) - min(volumes) < 1e-5, "the same particles, whatever the format"
