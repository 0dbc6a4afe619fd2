"""Renders the sample meshes: render.py [data folder] [picture folder] [width]. Needs vtk, numpy and Pillow."""

import sys

import numpy as np
import vtk
from PIL import Image
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

YELLOW, ORANGE, BLACK = (1.0, 0.84, 0.12), (0.95, 0.42, 0.06), (0.05, 0.05, 0.06)
WHITE, STONE, STEEL = (1.0, 1.0, 1.0), (0.80, 0.55, 0.38), (0.62, 0.66, 0.70)
# src/duck.rs: its head, and its box before and after it is fitted.
HEAD, HALF = np.array((0.0, 0.96, 0.24)), np.array((0.65, 0.65, 0.75))
LOW, HIGH = np.array((-0.6565, 0.0558, -0.7899)), np.array((0.6565, 1.3851, 0.8447))


def read(path):
    reader = vtk.vtkOBJReader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def points(mesh):
    return vtk_to_numpy(mesh.GetPoints().GetData()).astype(float)


def inside(p, centre, radii, slope=0.0):
    """Whether points lie in an ellipsoid whose z axis points upwards with the given slope."""
    q = p - centre
    sine, cosine = np.array((slope, 1.0)) / np.hypot(slope, 1.0)
    q = np.stack((q[:, 0], q[:, 1] * cosine - q[:, 2] * sine, q[:, 1] * sine + q[:, 2] * cosine), 1)
    return ((q / radii) ** 2).sum(1) < 1


def paint_duck(mesh):
    """Colours each triangle by the part of src/duck.rs that it belongs to."""
    triangles = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    p = points(mesh)[triangles].mean(1)
    p[:, 0] = np.abs(p[:, 0])
    p = (p + HALF) / (2 * HALF) * (HIGH - LOW) + LOW
    colour = np.tile(YELLOW, (len(p), 1))
    colour[inside(p, HEAD + (0, -0.02, 0.41), (0.205, 0.085, 0.215), 0.25)] = ORANGE
    colour[inside(p, HEAD + (0, -0.115, 0.36), (0.16, 0.07, 0.19), -0.08)] = ORANGE
    colour[inside(p, HEAD + (0.175, 0.135, 0.275), (0.071, 0.093, 0.067))] = BLACK
    colour[inside(p, HEAD + (0.172, 0.175, 0.325), (0.021, 0.025, 0.03))] = WHITE
    mesh.GetCellData().SetScalars(numpy_to_vtk((255 * colour).astype(np.uint8), deep=1))


def smooth_normals(mesh, refinements=0):
    """The mesh with a normal at each vertex, each triangle cut into 4 as often as asked."""
    normals = vtk.vtkPolyDataNormals()
    normals.SetInputData(mesh)
    normals.SplittingOff()
    normals.ConsistencyOff()
    finer = vtk.vtkLinearSubdivisionFilter()
    finer.SetInputConnection(normals.GetOutputPort())
    finer.SetNumberOfSubdivisions(refinements)
    finer.Update()
    return finer.GetOutput()


def actor_of(mesh, colour, smooth, edges):
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputData(mesh)
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    look = actor.GetProperty()
    look.SetColor(colour)
    look.SetAmbient(0.22)
    look.SetDiffuse(0.85)
    look.SetSpecular(0.3 if smooth else 0.0)
    look.SetSpecularPower(40)
    look.SetInterpolation(2 if smooth else 0)
    look.SetEdgeVisibility(edges)
    inner = vtk.vtkProperty()
    inner.SetColor(0.8, 0.1, 0.3)
    actor.SetBackfaceProperty(inner)
    return actor


def render(actor, picture, eye, size, zoom=1.0, target=None, colours=None):
    """Draws one actor, seen from `eye`: a direction, or a place where there is a target."""
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    renderer.AddActor(actor)
    lights = vtk.vtkLightKit()
    lights.SetKeyLightIntensity(0.8)
    lights.SetKeyToFillRatio(2)
    lights.SetKeyLightAngle(45, 25)
    lights.AddLightsToRenderer(renderer)
    camera = renderer.GetActiveCamera()
    camera.SetViewUp(0, 1, 0)
    camera.SetViewAngle(25)
    camera.SetFocalPoint(*(target or (0, 0, 0)))
    camera.SetPosition(*eye)
    if target is None:
        renderer.ResetCamera()
    renderer.ResetCameraClippingRange()
    camera.Zoom(zoom)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(4)
    window.SetSize(2 * size[0], 2 * size[1])
    window.AddRenderer(renderer)
    window.Render()
    grab = vtk.vtkWindowToImageFilter()
    grab.SetInput(window)
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(picture)
    writer.SetInputConnection(grab.GetOutputPort())
    writer.Write()
    image = Image.open(picture).resize(size, Image.LANCZOS)
    (image.quantize(colours) if colours else image).save(picture, optimize=True)


def main(data=".", pictures="pictures", width="480"):
    width = int(width)
    square, wide = (width, width), (width, width * 2 // 3)
    duck = smooth_normals(read(f"{data}/duck.obj"), refinements=3)
    paint_duck(duck)
    duck = actor_of(duck, YELLOW, smooth=True, edges=False)
    render(duck, f"{pictures}/duck.png", (1.2, 0.45, 1.7), square, 1.4, colours=256)
    if width > 480:
        for name, eye in dict(front=(0, 0, 1), side=(1, 0, 0), back=(-0.6, 0.5, -1), top=(0, 1, 0.01)).items():
            render(duck, f"{pictures}/duck_{name}.png", eye, square, 1.3)
        triangles = actor_of(read(f"{data}/duck.obj"), YELLOW, smooth=False, edges=True)
        render(triangles, f"{pictures}/duck_edges.png", (1.2, 0.4, 1.7), square, 1.3)
    stone = actor_of(read(f"{data}/canyon.obj"), STONE, smooth=False, edges=False)
    render(stone, f"{pictures}/canyon.png", (-7, 13, -8), wide, target=(0.9, 0.1, 7), colours=96)
    if width > 480:
        render(stone, f"{pictures}/canyon_top.png", (0.01, 100, 18.1), wide, target=(0, 0, 18))
        render(stone, f"{pictures}/canyon_end.png", (-4, 12, 50), wide, target=(0, 0, 28))
    grid = actor_of(read(f"{data}/grid.obj"), STEEL, smooth=False, edges=True)
    render(grid, f"{pictures}/grid.png", (1, 1.5, 2), wide, 1.4, colours=32)
    bad = actor_of(read(f"{data}/bad_holes.obj"), YELLOW, smooth=False, edges=True)
    render(bad, f"{pictures}/bad_holes.png", (1.2, 1.3, -1.4), square, 1.4, colours=32)


main(*sys.argv[1:])
