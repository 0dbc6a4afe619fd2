"""SPlisHSPlasH (PyPI: pysplishsplash), the peer of these benches: its scenes, its runs, and whether it computes the same.

What a run is compared under is in `Conditions`. The peer's are read from the program itself, not from what was asked of
it: its particles have had different volumes in different versions (0.8 (2 rp)^3 up to 2.17, all of it in 2.19).
"""
import json
import os
import re
import subprocess

# Read in the program: `fluid_conditions` before the first step, `tank_conditions` once bodies are there.
READ = """
import json, sys, time
import pysplishsplash as sph

def spread(values):
    return [float(min(values)), float(max(values))]

def fluid_conditions():
    simulation = sph.Simulation.getCurrent()
    step, fluid = simulation.getTimeStep(), simulation.getFluidModel(0)
    viscosity, count = fluid.getViscosityBase(), range(fluid.numActiveParticles())
    places = [fluid.getPosition(i) for i in count]
    kernels = {simulation.ENUM_KERNEL_CUBIC: "cubic spline", simulation.ENUM_KERNEL_PRECOMPUTED_CUBIC: "cubic spline"}
    return {
        "fluids": simulation.numberOfFluidModels(),
        "particles": len(count),
        "particle_mass": spread([fluid.getMass(i) for i in count]),
        "particle_volume": spread([fluid.getVolume(i) for i in count]),
        "fluid_box": [spread([place[axis] for place in places]) for axis in range(3)],
        "rest_density": fluid.getDensity0(),
        "viscosity": viscosity.getValueFloat(viscosity.VISCOSITY_COEFFICIENT),
        "particle_radius": simulation.getParticleRadius(),
        "support_radius": simulation.getSupportRadius(),
        "kernel": kernels.get(simulation.getKernel(), "another"),
        "gravity": [float(g) for g in simulation.getVec3ValueReal(simulation.GRAVITATION)],
        "cfl_factor": simulation.getValueFloat(simulation.CFL_FACTOR),
        "largest_step": simulation.getValueFloat(simulation.CFL_MAX_TIMESTEPSIZE),
        "least_step": simulation.getValueFloat(simulation.CFL_MIN_TIMESTEPSIZE),
        "first_step": sph.TimeManager.getCurrent().getTimeStepSize(),
        "density_error": step.getValueFloat(step.MAX_ERROR) / 100,
        "density_iterations": [step.getValueUInt(step.MIN_ITERATIONS), step.getValueUInt(step.MAX_ITERATIONS)],
        "divergence_solve": step.getValueBool(step.USE_DIVERGENCE_SOLVER),
        "divergence_error": step.getValueFloat(step.MAX_ERROR_V) / 100,
        "divergence_iterations": step.getValueUInt(step.MAX_ITERATIONS_V),
    }

def tank_conditions():
    simulation = sph.Simulation.getCurrent()
    vertices = simulation.getBoundaryModel(0).getRigidBodyObject().getVertices()
    box = [spread([vertex[axis] for vertex in vertices]) for axis in range(3)]
    return {"tank": box, "bodies": simulation.numberOfBoundaryModels()}

def begin():
    base = sph.Exec.SimulatorBase()
    base.init(sceneFile=sys.argv[1], useGui=False, initialPause=False, useCache=True, outputDir=sys.argv[2], stopAt=1e9)
    base.initSimulation()
    return base
"""

# f32 of what is metres, kilograms or parts; the peer's mass is rho_0 times a volume that is itself rounded.
CLOSE = 1e-5


class Conditions:
    """Of a run: a tank that is a box, blocks of water in it, a step rule and error targets."""

    def __init__(self, tank, blocks, particle_radius=0.025, largest_step=0.005):
        self.tank, self.blocks = tank, blocks
        self.particle_radius, self.largest_step = particle_radius, largest_step

    def count(self):
        """Particles: cubes of 2 rp in the blocks."""
        spacing = 2 * self.particle_radius
        return sum(round((b[0] - a[0]) / spacing) * round((b[1] - a[1]) / spacing) * round((b[2] - a[2]) / spacing)
                   for a, b in self.blocks)

    def expected(self):
        """What both programs must have, by the names of READ."""
        rp = self.particle_radius
        lowest = [min(a[axis] for a, _ in self.blocks) + rp for axis in range(3)]
        highest = [max(b[axis] for _, b in self.blocks) - rp for axis in range(3)]
        volume = (2 * rp) ** 3
        return {
            "fluids": 1, "bodies": 1, "particles": self.count(),
            "particle_mass": [1000 * volume] * 2, "particle_volume": [volume] * 2,
            "fluid_box": [list(pair) for pair in zip(lowest, highest)], "tank": self.tank,
            "rest_density": 1000, "viscosity": 0.01, "particle_radius": rp, "support_radius": 4 * rp,
            "kernel": "cubic spline", "gravity": [0, -9.81, 0],
            "cfl_factor": 1, "largest_step": self.largest_step, "least_step": 1e-4, "first_step": 1e-3,
            "density_error": 5e-4, "density_iterations": [2, 100],
            "divergence_solve": True, "divergence_error": 1e-3, "divergence_iterations": 100,
        }

    def resolution(self, cells):
        """Of the peer's map, whose grid is the tank's box and 8 support radii around it, for cells of r / `cells`."""
        support = 4 * self.particle_radius
        return [round(((high - low) / support + 16) * cells) for low, high in self.tank]

    def peer_scene(self, folder, method, resolution):
        """The peer's scene: the file, whose fluid blocks begin a layer farther out, as it leaves out that layer."""
        mesh, expected = folder / "box.obj", self.expected()
        lines = ["v %.9g %.9g %.9g" % (x, y, z) for z in self.tank[2] for y in self.tank[1] for x in self.tank[0]]
        quads = [(1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)]
        lines += [f"f {a} {b} {c}\nf {a} {c} {d}" for a, b, c, d in quads]
        mesh.write_text("\n".join(lines) + "\n")
        rp = self.particle_radius
        scene = {
            "Configuration": {
                "particleRadius": rp, "simulationMethod": 4, "gravitation": expected["gravity"], "cflMethod": 1,
                "cflFactor": 1, "cflMaxTimeStepSize": self.largest_step, "cflMinTimeStepSize": expected["least_step"],
                "timeStepSize": expected["first_step"], "boundaryHandlingMethod": method,
                "DFSPH": {"minIterations": 2, "maxIterations": 100, "maxError": 0.05, "maxIterationsV": 100,
                          "maxErrorV": 0.1, "enableDivergenceSolver": True}},
            "Materials": [{"id": "Fluid", "density0": 1000, "viscosityMethod": 1,
                           "Standard viscosity": {"viscosity": expected["viscosity"]}}],
            "RigidBodies": [{"geometryFile": str(mesh), "translation": [0, 0, 0], "rotationAxis": [1, 0, 0],
                             "rotationAngle": 0, "scale": [1, 1, 1], "isDynamic": False, "isWall": True,
                             "mapInvert": True, "mapThickness": 0.0, "mapResolution": resolution}],
            "FluidBlocks": [{"denseMode": 0, "start": [a - rp for a in low], "end": [b + rp for b in high]}
                            for low, high in self.blocks]}
        path = folder / "peer.json"
        path.write_text(json.dumps(scene))
        return path

    def our_scene(self, folder, closure):
        """Ours, with everything that is compared given, whatever the defaults are."""
        expected, mesh = self.expected(), folder / "box.obj"
        low, high = expected["density_iterations"]
        path = folder / f"{closure}.json"
        path.write_text(json.dumps({
            "version": 1, "particle_radius": self.particle_radius, "support_radius": expected["support_radius"],
            "kernel": "cubic_spline", "closure": closure, "gravity": expected["gravity"],
            "fluid": {"volume_factor": 1.0, "rest_density": 1000.0, "viscosity": expected["viscosity"]},
            "solver": {
                "density": {"max_error": expected["density_error"], "min_iterations": low, "max_iterations": high},
                "divergence": {"max_error": expected["divergence_error"],
                               "max_iterations": expected["divergence_iterations"]},
                "time_step": {"cfl_factor": 1.0, "initial": expected["first_step"], "min": expected["least_step"],
                              "max": self.largest_step}},
            "blocks": [{"min": low, "max": high} for low, high in self.blocks],
            "bodies": [{"name": "tank", "mesh": str(mesh), "bake": {"invert": True}}],
            "output": {"frames_per_second": 0, "preview": [], "formats": [], "checkpoint_interval": 0}}))
        return path

    def check(self, program, found):
        """Ends the bench, by name, where a program has anything else than is expected."""
        wrong = [f"  {name}: {text(found[name])} instead of {text(value)}" for name, value in self.expected().items()
                 if name in found and not same(found[name], value)]
        if wrong:
            raise SystemExit(f"{program} doesn't compute the same, so there is nothing to compare:\n" + "\n".join(wrong))


def same(found, expected):
    """Whether two numbers, names or lists of them are the same but for rounding to f32."""
    if isinstance(expected, list):
        return len(found) == len(expected) and all(map(same, found, expected))
    if isinstance(expected, (int, float)):
        return abs(found - expected) <= CLOSE * max(abs(expected), 1e-4)
    return found == expected


def text(value):
    """For a message: numbers as f32 has them, and lists of them."""
    if isinstance(value, list):
        return "[" + ", ".join(map(text, value)) + "]"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def run_peer(python, program, scene, out, threads, *more):
    """Runs a program in the peer's Python; what it prints after RESULT, and all it prints."""
    env = dict(os.environ, LD_PRELOAD="libGLdispatch.so.0", OMP_NUM_THREADS=str(threads))
    done = subprocess.run([python, "-c", READ + program, scene, out, *map(str, more)], env=env, capture_output=True,
                          text=True)
    text = done.stdout + done.stderr
    found = re.findall(r"RESULT (.*)", done.stdout)
    if not found:
        raise SystemExit(f"the peer ended with {done.returncode}:\n{text[-2000:]}")
    return json.loads(found[0]), text
