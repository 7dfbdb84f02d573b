"""Play a run with the meshes of its robot in a browser; where it should be is see-through.

python examples/view_meshes.py [run.npz] [--urdf robot.urdf] [--port 8080]

Without a run, a Panda carries 2 kg that its controller knows nothing of. Joints are matched by
name; those of the URDF that the run does not have stay at 0.
"""

import argparse
import time
from pathlib import Path

import steadyarm as sa

try:
    import viser
    import yourdfpy
    from viser.extras import ViserUrdf
except ImportError as error:
    raise SystemExit(f'view_meshes: {error}; pip install "steadyarm[view]"') from error

GHOST = (0.9, 0.5, 0.1, 0.35)


def example():
    """Return a run of the Panda."""
    arm, start = sa.Serial.shipped("panda"), (0, -0.6, 0, -2, 0, 1.6, 0.8)
    path = sa.Quintic(start, goal=(0.9, 0, 0.3, -1, 0, 2, 1), duration=3.0)
    tracker = sa.ComputedTorque(arm.without_friction(), kp=100, kv=20)
    return sa.simulate(sa.Plant(arm.with_payload(2.0)), tracker, path, 5.0, q0=start)


def panda():
    """Return the URDF of the Panda of example-robot-data."""
    share = Path(viser.__file__).parents[1] / "cmeel.prefix/share/example-robot-data"
    urdf = share / "robots/panda_description/urdf/panda.urdf"
    return urdf if urdf.exists() else None


def robot(urdf):
    """Read a robot with its meshes: "package://x/y" is x/y in a folder above the file."""

    def place(fname):
        part = fname.partition("://")[2] or fname
        there = (str(folder / part) for folder in urdf.parents if (folder / part).exists())
        return next(there, fname)

    return yourdfpy.URDF.load(str(urdf), filename_handler=place)


def played(run, urdf, port):
    """Serve the page, and play the run on it again and again."""
    server = viser.ViserServer(port=port)
    server.initial_camera.position, server.initial_camera.look_at = (1.5, -1.3, 0.9), (0.2, 0, 0.4)
    server.scene.add_grid("/ground", width=2, height=2)
    arm = ViserUrdf(server, robot(urdf), root_node_name="/arm")
    ghost = ViserUrdf(server, robot(urdf), root_node_name="/ghost", mesh_color_override=GHOST)
    names = arm.get_actuated_joint_names()
    missing = [name for name in run.joint_names if name not in names]
    if missing:
        raise SystemExit(f"--urdf: has no joints {', '.join(missing)}, of which the run is")
    slider = server.gui.add_slider("time [s]", 0.0, max(float(run.t[-1]), 1e-3), 0.01, 0.0)
    playing = server.gui.add_checkbox("play", True)
    speed = server.gui.add_slider("speed", 0.1, 4.0, 0.1, 1.0)
    error = server.gui.add_text("error [mrad]", "", disabled=True)
    while True:
        k = min(int(run.t.searchsorted(slider.value)), len(run.t) - 1)
        for shown, q in ((arm, run.q[k]), (ghost, run.q_d[k])):
            pose = dict(zip(run.joint_names, q, strict=True))
            shown.update_cfg([pose.get(name, 0.0) for name in names])
        error.value = ", ".join(f"{1e3 * e:.3g}" for e in run.e[k])
        time.sleep(1 / 30)
        if playing.value:
            after = slider.value + speed.value / 30
            slider.value = after if after <= run.t[-1] else 0.0


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("run", nargs="?", help="file of Run.save")
    parser.add_argument("--urdf", type=Path, default=panda(), help="robot with meshes")
    parser.add_argument("--port", type=int, default=8080)
    given = parser.parse_args()
    if given.urdf is None:
        parser.error("--urdf: wants a file; that of the Panda is in example-robot-data")
    loaded = sa.Run.load(given.run) if given.run else example()
    played(loaded, given.urdf.resolve(), given.port)
