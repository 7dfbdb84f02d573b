"""Compare many runs at a time with one at a time, Numba and JAX; print each claim and its verdict.

Usage: python benches/many.py [--rounds N] [--quick] [--full]

Runs of 2 s by RK4 of 1 ms with the controller in continuous time: the paper's arm with 25 rules a
joint or 625 in a grid, masses and start other in each run; and a Panda with 25 rules a joint and a
payload of its own in each, also sampled at 1 kHz, and there with encoders and a delay, with other
laws, and with the recommended controller. `sa.simulate_many` runs them in one thread, in turn with
`sa.simulate` and `Run.metrics` one at a time, and, those of the paper with 25 rules a joint, with
the peers (``peers/many_*.py``): Numba with a loop over plants, JAX with the fastest of three
batches, each in one thread and compiled before. Ours returns seven figures a run, the peers one,
the RMS error. Before anything is timed all must agree on that: ours to the bit, whatever the
threads, the peers to 1e-9 of it. If they do not, nothing is timed.

Times are those of a run, medians over the rounds; of processor time their inverse is runs per
core-second. Ratios are of processor time and of the clock, and both count; of a second core it is
the clock alone. ``--full`` adds 100 000 runs on two threads, by the clock (the plants are made
before). ``--quick`` runs everything once and judges nothing. Ends with 1 where a claim falls short.
"""

import argparse
import os
import sys
import time
import warnings
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np
import steadyarm as sa

sys.path.insert(0, str(Path(__file__).parent / "peers"))

import many_jax
import many_numba
from claims import Paired, report, within
from many_problem import DURATION, LENGTH, STEP, inertias, plants
from problem import GAIN

RMS_TOL = 1e-9
"""Of an RMS error: how far peers may be."""

CHECKED = 16
RUNS = 1024
"""At a time of the paper's arm with 25 rules a joint, of ours and of Numba."""
BATCHES = (1000, 3000, 10_000)
"""Plants at a time in JAX."""

FULL, FULL_SECONDS = 100_000, 15.0

LOAD = 3.0
"""The largest payload of the Panda [kg]."""
BANDWIDTH = 10.0
"""Of the other laws [rad/s]."""


@dataclass(frozen=True)
class Loop:
    """A controller and its path, and a plant and initial position for each run."""

    tracker: sa.ComputedTorque
    reference: sa.Sines
    plants: list[sa.Plant]
    q0: np.ndarray
    options: dict = field(default_factory=dict)

    def alone(self, count):
        """Return the RMS errors of so many runs, one at a time."""
        loop = self.tracker, self.reference, DURATION, STEP
        pairs = zip(self.plants[:count], self.q0[:count], strict=True)
        runs = (sa.simulate(plant, *loop, q0=q0, **self.options) for plant, q0 in pairs)
        return np.array([run.metrics().rms_e for run in runs])

    def many(self, count, threads=1):
        """Return the RMS errors of so many runs at a time."""
        loop = self.plants[:count], self.tracker, self.reference, DURATION, STEP
        options = {"threads": threads, "progress": False, **self.options}
        return sa.simulate_many(*loop, q0=self.q0[:count], **options).rms_e


def two_link(form, count):
    """Return the paper's third simulation on arms that differ."""
    scene = sa.paper.simulation(3, form=form, normalized=True, gain=GAIN)
    mass, q0 = plants(count)
    sizes = zip(mass, inertias(mass), strict=True)
    arms = (sa.TwoLink(mass=m, length=(LENGTH, LENGTH), inertia=i) for m, i in sizes)
    made = [sa.Plant(arm, disturbance=sa.paper.disturbance()) for arm in arms]
    return Loop(scene.tracker, scene.reference, made, q0)


def panda(count):
    """Return a Panda about a pose in the middle of its range, with payloads that differ."""
    arm, rest = sa.Serial.shipped("panda"), (0.0, -0.6, 0.0, -2.0, 0.0, 1.6, 0.8)
    path = sa.Sines(frequency=[1.0], sin=[[0.2] * 7], cos=[[0.0] * 7], offset=rest)
    sets = {"centers": sa.paper.CENTERS, "width": sa.paper.WIDTH, "normalized": True}
    basis = sa.FuzzyBasis(form="per_joint", **sets)
    fuzzy = sa.FuzzyCompensator(basis, gain=GAIN)
    tracker = sa.ComputedTorque(arm, 100.0, 20.0, compensator=fuzzy)
    made = [sa.Plant(arm.with_payload(load)) for load in np.linspace(0.0, LOAD, count)]
    return Loop(tracker, path, made, np.tile(rest, (count, 1)))


def sampled(loop):
    """Return the same loop with a controller that is called at 1 kHz."""
    return replace(loop, options={"control_period": STEP})


def sensed(loop):
    """Return the sampled loop with encoders and a delay."""
    machine = sa.Effects(encoder_bits=16, velocity="difference", delay=1)
    return replace(loop, options={"control_period": STEP, "effects": machine})


def told(loop):
    """Return the sensed loop with a tracker that knows of the delay."""
    loop = sensed(loop)
    return replace(loop, tracker=loop.tracker.__replace__(delay=1))


def by_law(loop, law):
    """Return the sampled loop with another law."""
    tracker = law(loop.tracker.arm, bandwidth=BANDWIDTH)
    return replace(sampled(loop), tracker=tracker)


def recommended(loop):
    """Return the sensed loop with the recommended controller."""
    loop = sensed(loop)
    arm = loop.tracker.arm.with_armature(0.1)
    made = [sa.Plant(arm.with_payload(load)) for load in np.linspace(0.0, LOAD, len(loop.plants))]
    tracker = sa.recommended(arm, payload=LOAD, path=loop.reference, duration=DURATION)
    return replace(loop, tracker=tracker, plants=made)


def check(loops):
    """Leave unless everybody computes the same runs."""
    for name, loop in loops.items():
        alone = loop.alone(CHECKED)
        if not all(np.array_equal(loop.many(CHECKED, threads), alone) for threads in (1, 2)):
            sys.exit(f"not the same work: {name}: many runs differ from one at a time")
    wanted = loops["per_joint"].alone(CHECKED)
    for peer in (many_numba, many_jax):
        off = np.abs(peer.prepare(CHECKED)() / wanted - 1.0).max()
        print(f"RMS errors of {peer.__name__}: {off:.1e} from ours")
        if not off <= RMS_TOL:
            sys.exit(f"not the same work: the RMS errors should be ours to {RMS_TOL} of them")


def timed(function, count):
    """Return clock and processor time of a run [s]; ``function`` computes ``count`` of them."""
    clock, cpu = time.perf_counter(), time.process_time()
    function()
    return (time.perf_counter() - clock) / count, (time.process_time() - cpu) / count


def fastest_batch(sizes):
    """Return JAX's function and number of runs: of these sizes the fastest a run."""
    tried = [(many_jax.prepare(size), size) for size in sizes]
    return min(tried, key=lambda batch: timed(*batch)[1])


def contests(loops, quick):
    """Return (claim, ours, theirs) of each comparison; ours and theirs: (function, runs)."""

    def runs(function, count, *options):
        count = CHECKED if quick else count
        return partial(function, count, *options), count

    def against(figure, wanted, ours, theirs, of=("cpu", "clock")):
        return Paired(figure, wanted, of), ours, theirs

    two, grid, panda = (loops[name] for name in ("per_joint", "grid", "panda"))
    rules = "two-link, 25 rules a joint"
    many = runs(two.many, RUNS)
    numba = CHECKED if quick else RUNS
    jax = fastest_batch((CHECKED,) if quick else BATCHES)
    print(f"JAX: batches of {jax[1]}")
    single = "one at a time"
    grids = runs(grid.many, 128), runs(grid.alone, 64)
    pandas = runs(panda.many, 128), runs(panda.alone, 16)
    others = {
        "Panda, 25 rules a joint at 1 kHz": loops["sampled"],
        "Panda, 25 rules a joint, encoders, delay": loops["sensed"],
        "Panda, 25 rules a joint, encoders, delay=1": loops["told"],
        "Panda, PID at 1 kHz": loops["pid"],
        "Panda, momentum observer at 1 kHz": loops["observer"],
        "Panda, recommended, encoders, delay": loops["recommended"],
    }
    found = [
        against(f"{rules}: {single}", 8, many, runs(two.alone, 64)),
        against(f"two-link, 625 rules: {single}", 1.8, *grids),
        against(f"Panda, 25 rules a joint: {single}", 7, *pandas),
        *(
            against(f"{name}: {single}", None, runs(loop.many, 128), runs(loop.alone, 16))
            for name, loop in others.items()
        ),
        against(f"{rules}: Numba, prange", 10, many, (many_numba.prepare(numba), numba)),
        against(f"{rules}: JAX, vmap", 10, many, jax),
    ]
    if os.cpu_count() > 1:
        both = runs(two.many, RUNS, 2)
        found.append(against(f"{rules}, two threads: one thread", 1.9, both, many, ("clock",)))
    return found


def full():
    """Return the claim of 100 000 runs."""
    loop = two_link("per_joint", FULL)
    clock = time.perf_counter()
    errors = loop.many(FULL, threads=2)
    seconds = time.perf_counter() - clock
    if not np.isfinite(errors).all():
        sys.exit("some of the runs did not finish")
    return within(f"{FULL} runs of 2 s, two threads", 1e9 * seconds, 1e9 * FULL_SECONDS)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=7, help="rounds of every comparison (7)")
    parser.add_argument("--quick", action="store_true", help="everything once, without a verdict")
    parser.add_argument("--full", action="store_true", help="100 000 runs too")
    options = parser.parse_args()
    warnings.simplefilter("ignore", sa.DesignWarning)
    loops = {form: two_link(form, RUNS) for form in ("per_joint", "grid")}
    loops["panda"] = panda(128)
    loops |= {
        "sampled": sampled(loops["panda"]),
        "sensed": sensed(loops["panda"]),
        "told": told(loops["panda"]),
        "pid": by_law(loops["panda"], sa.laws.pid),
        "observer": by_law(loops["panda"], sa.laws.momentum_observer),
        "recommended": recommended(loops["panda"]),
    }
    check(loops)
    found = contests(loops, options.quick)
    for _ in range(1 if options.quick else max(options.rounds, 1)):
        for paired, ours, theirs in found:
            paired.ours.append(timed(*ours))
            paired.theirs.append(timed(*theirs))
    claims = [paired.claim() for paired, *_ in found]
    for claim in claims:
        if claim.cpu:
            ours, theirs = 1e9 / claim.ours, 1e9 / claim.theirs
            print(f"runs per core-second: {ours:.0f}, {theirs:.0f}: {claim.figure}")
    if options.full:
        claims.append(full())
    return report("many", claims, keep=not options.quick)


if __name__ == "__main__":
    sys.exit(main())
