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
FAR = np.array([500_000.0, 0.0, 4_650_000.0])


def check(name, position, data, origin=0.0):
    """`origin`: that of the particles, where places aren't relative to it."""
    n = data["id"].astype(np.int64).ravel()
    assert sorted(n) == list(range(SHAPE.prod())), name
    place = 2 * RADIUS * (np.stack([n % 20, n // 20 % 16, n // 320], axis=1) + 0.5)
    if position.dtype.itemsize == 8:
        assert (position == origin + place).all(), name
    else:
        # As exact near the origin and far from it.
        assert abs(position - place).max() < 1e-3 * RADIUS, name
    assert (data["density"].ravel() == (1000 * (1 + n / 1024)).astype(np.float32)).all(), name
    assert (data["pressure"].ravel() == (10 * n).astype(np.float32)).all(), name
    velocity = np.stack([n, 0.5 + 0 * n, -2 * n], axis=1)
    assert (data["velocity"] == velocity.astype(np.float32)).all(), name
    print(f"{name}: {len(n)} particles, all values equal")


def read_with_vtk(path, origin=0.0):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    assert grid.GetNumberOfCells() == SHAPE.prod() and grid.GetCellType(0) == vtk.VTK_VERTEX
    point_data = grid.GetPointData()
    names = [point_data.GetArrayName(n) for n in range(point_data.GetNumberOfArrays())]
    arrays = {name: vtk_to_numpy(point_data.GetArray(name)) for name in names}
    assert (arrays["radius"] == np.float32(RADIUS)).all() and (arrays["mass"] == 0.125).all()
    field = grid.GetFieldData()
    facts = {"TimeValue": 0.25, "particle_radius [m]": RADIUS, "particle_mass [kg]": 0.125, "rest_density [kg/m^3]": 1000}
    for name, value in facts.items():
        assert field.GetArray(name).GetValue(0) == value, name
    # What ParaView takes for the time of a single file.
    steps = vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS()
    assert reader.GetOutputInformation(0).Get(steps, 0) == 0.25
    check("VTK, vtu", vtk_to_numpy(grid.GetPoints().GetData()), arrays, origin)


def read_ply_with_vtk(path):
    reader = vtk.vtkPLYReader()
    reader.SetFileName(str(path))
    reader.Update()
    assert reader.GetOutput().GetNumberOfPoints() == SHAPE.prod()


def volume(path):
    mesh = meshio.read(path)
    # About a point of it: differences of large numbers otherwise.
    corners = (mesh.points.astype(np.float64) - mesh.points[0])[mesh.cells_dict["triangle"]]
    return abs(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6)


def surface(path, *more):
    out = path.with_suffix(f"{path.suffix}.surface.vtk")
    tool = Path(sys.executable).with_name("pysplashsurf")
    options = ["-r", str(RADIUS), "-l", "2.0", "-c", "0.5", "-t", "0.6", "-o", str(out), "-q", *more]
    subprocess.run([tool, "reconstruct", path, *options], check=True)
    found, true = volume(out), SHAPE.prod() * (2 * RADIUS) ** 3
    print(f"splashsurf, {path.suffix}: {found:.4f} m^3 of {true:.4f}")
    assert abs(found / true - 1) < 0.15
    return found


def read_all(folder, origin=None):
    [entry] = ElementTree.parse(folder / "particles.pvd").getroot().iter("DataSet")
    assert float(entry.get("timestep")) == 0.25
    read_with_vtk(folder / entry.get("file"), 0.0 if origin is None else origin)
    mesh = meshio.read(folder / "frame_000001.vtu")
    assert mesh.points.dtype.itemsize == (4 if origin is None else 8)
    check("meshio, vtu", mesh.points, mesh.point_data, 0.0 if origin is None else origin)
    mesh = meshio.read(folder / "frame_000001.ply")
    data = dict(mesh.point_data)
    data["velocity"] = np.stack([data["vx"], data["vy"], data["vz"]], axis=1)
    # Relative to the origin that each particle has.
    if origin is not None:
        assert (np.stack([data["origin_x"], data["origin_y"], data["origin_z"]], axis=1) == origin).all()
    check("meshio, ply", mesh.points, data)
    read_ply_with_vtk(folder / "frame_000001.ply")
    double = [] if origin is None else ["--double-precision=on"]
    volumes = [surface(folder / "frame_000001.vtu", *double)]
    volumes += [surface(folder / f"frame_000001.{format}") for format in ("ply", "bgeo")]
    assert max(volumes) - min(volumes) < 1e-5, "the same particles, whatever the format"
    if origin is not None:
        points = meshio.read(folder / "frame_000001.vtu.surface.vtk").points
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        assert abs(middle - origin - RADIUS * SHAPE).max() < 0.1 * RADIUS, middle


folder = Path(sys.argv[1])
read_all(folder)
read_all(folder / "far", FAR)
