"""06: what was learnt goes into a file, and another controller goes on with it."""

from pathlib import Path
from tempfile import TemporaryDirectory

import steadyarm as sa

believed = sa.TwoLink(mass=(4, 4), length=(0.5, 0.5), inertia=(0.2, 0.2))
plant = sa.Plant(sa.TwoLink(mass=(8, 8), length=(0.5, 0.5), inertia=(0.4, 0.4)))
path = sa.Sines(frequency=(1, 3), sin=((0, -0.2), (0.2, 0)), cos=((0.5, -0.5), (0, 0)))
basis = sa.FuzzyBasis("grid", (-1.5, -0.5, 0.0, 0.5, 1.5), 0.5**0.5)
compensator = sa.FuzzyCompensator(basis, q=10, gain=1000.0)

new = sa.ComputedTorque(believed, kp=8, kv=5.5, compensator=compensator)
restored = sa.ComputedTorque(believed, kp=8, kv=5.5, compensator=compensator)
q0, dq0, _ = path(0.0)


def run(name, tracker, duration):
    """Follow the path from its start; return the controller with what it has learnt."""
    result = sa.simulate(plant, tracker, path, duration, control_period=1e-3, q0=q0, dq0=dq0)
    e, done = result.metrics(window=(0, 5)).rms_e, result.tracker.steps
    print(f"{name:9} RMS of e = {e[0]:.4f} {e[1]:.4f} rad   {done} steps")
    return result.tracker


learnt = run("new:", new, 40.0)
with TemporaryDirectory() as folder:
    learnt.save(Path(folder) / "learnt.bin")
    restored.load(Path(folder) / "learnt.bin")
run("goes on:", learnt, 5.0)
run("restored:", restored, 5.0)
