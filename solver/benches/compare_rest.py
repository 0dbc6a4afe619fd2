#!/usr/bin/env python3
"""Water at rest in SPlisHSPlasH (PyPI: pysplishsplash), measured as `volmap-sim validate hydrostatic` measures its block.

compare_rest.py --python VENV/bin/python [--threads 2] [--cells 2] [METHOD ...]

2,890 particles of radius 0.025 m and volume (2 rp)^3 spread over the floor of a tank of 1 x 1.2 x 1 m and come to rest,
8 s, steps of 5 ms at most. The rows of VALIDATION.md: first layer above the floor and at the walls (rp), particles in
the first layer, height of the water (m), its excess over the particles' volume, rms speed of the last second (m/s),
iterations of the density solve. The peer's own settings and masses are read from it, and the bench ends if they aren't
those. METHOD: particles, density, volume, tube (maps); default: all.
"""
import argparse
import pathlib
import tempfile

import splishsplash

BLOCK = ([-0.425, 0.075, -0.425], [0.425, 0.575, 0.425])
REST = splishsplash.Conditions([[-0.5, 0.5], [0.0, 1.2], [-0.5, 0.5]], [BLOCK])
TRUE_HEIGHT = REST.count() * (2 * REST.particle_radius) ** 3 / 1.0
METHODS = {"particles": 0, "density": 1, "volume": 2, "tube": 3}
END = 8.0

PEER = """
end = float(sys.argv[3])
base = begin()
base.setValueFloat(base.STOP_AT, end)
found, squares, iterations = fluid_conditions(), [], []
fluid = sph.Simulation.getCurrent().getFluidModel(0)
def after_step():
    if "tank" not in found:
        found.update(tank_conditions())
    if sph.TimeManager.getCurrent().getTime() > end - 1.0:
        step, count = sph.Simulation.getCurrent().getTimeStep(), fluid.numActiveParticles()
        squares.append(sum(float(c) ** 2 for i in range(count) for c in fluid.getVelocity(i)) / count)
        iterations.append(step.getValueUInt(step.SOLVER_ITERATIONS))
base.setTimeStepCB(after_step)
base.runSimulation()
result = {
    "places": [[float(c) for c in fluid.getPosition(i)] for i in range(fluid.numActiveParticles())],
    "rms": (sum(squares) / len(squares)) ** 0.5,
    "iterations": sum(iterations) / len(iterations),
}
print("RESULT", json.dumps({"conditions": found, "result": result}), flush=True)
"""


def percentile(values, part):
    """As `observe::percentile` of volmap-fluid: the value below which this part of the others is."""
    values, place = sorted(values), part * (len(values) - 1)
    below, above = values[int(place)], values[min(int(place) + 1, len(values) - 1)]
    return below + (place - int(place)) * (above - below)


def first_layer(distances):
    """Median distance of the layer nearest to a wall in rp, and its particles: up to rp farther than the nearest 20."""
    distances = sorted(distances)
    limit = sum(distances[:20]) / 20 + REST.particle_radius
    layer = [distance for distance in distances if distance < limit]
    return percentile(layer, 0.5) / REST.particle_radius, len(layer)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("methods", nargs="*", metavar="METHOD", choices=[[], *METHODS], default=[])
    parser.add_argument("--python", required=True)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--cells", type=float, default=2, help="cells of its maps in a support radius")
    args = parser.parse_args()
    print("| boundary | floor, rp | wall, rp | in the first layer | top, m | over the true height | rms, m/s | iterations |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for method in args.methods or METHODS:
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            scene = REST.peer_scene(folder, METHODS[method], REST.resolution(args.cells))
            found, _ = splishsplash.run_peer(args.python, PEER, scene, folder / "out", args.threads, END)
        REST.check("SPlisHSPlasH", found["conditions"])
        places, result = found["result"]["places"], found["result"]
        floor, in_layer = first_layer([place[1] for place in places])
        wall, _ = first_layer([0.5 - side for x, _, z in places for side in (x, -x, z, -z)])
        top = percentile([place[1] for place in places], 0.99) + REST.particle_radius
        print(f"| {method} | {floor:.2f} | {wall:.2f} | {in_layer} | {top:.3f} | {100 * (top / TRUE_HEIGHT - 1):+.0f} % | "
              f"{result['rms']:.4f} | {result['iterations']:.1f} |", flush=True)
    print(f"true height {TRUE_HEIGHT:.3f} m")


if __name__ == "__main__":
    main()
