"""Compare the speed of steadyarm with its alternatives; print each claim and whether it holds.

Usage: python benches/compare.py [--rounds N] [--quick]

The closed loop (peers/problem.py) runs through `sa.simulate` and through each peer, in turn: every
round runs ours directly before each peer. The peers record positions, ours velocities too. A
figure is the median over the rounds, a ratio one of medians. Before anything is timed, all must
agree on the RMS errors to 1e-7, and on the solution of the Riccati equation to 1e-9, so that it is
the same work; if they do not, nothing is timed.

Shared machines are noisy, so no figure stands alone: look at ratios. Each is printed for the clock
and for the thread's processor time, which leaves out the time when others hold the core (a long run
is interrupted more often than a short one, which flatters the short one). A claim holds if both
ratios reach it. No environment variable, affinity or thread count is set, with one exception: the
Riccati solver of SciPy is timed with the BLAS threads it finds and with one; the faster counts.

All figures go to ``results/<processor>.csv``; ``--quick`` neither keeps nor judges them. Ends with
1 where a claim falls short.

The C++ peer needs a compiler and Eigen (Debian: g++ libeigen3-dev); the Rust figures need cargo.
Without them their rows are left out, with a note.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import scipy.integrate
import scipy.linalg
import steadyarm as sa
from threadpoolctl import threadpool_limits

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "peers"))

import closed_loop_numba  # noqa: E402
import closed_loop_numpy  # noqa: E402
import closed_loop_scipy  # noqa: E402
from claims import Paired, medians, report, within  # noqa: E402
from problem import DURATION, GAIN, RMS, STEP, STEPS, rms, start, timed  # noqa: E402

RMS_TOL = 1e-7
P_TOL = 1e-9

# At these tolerances our error is not larger than that of SciPy's RK45 at rtol 1e-8, atol 1e-10;
# checked below. Ours are smaller because SciPy also controls the weights, which are no part of our
# integrator's state. They are equal because atol is all that is asked of a velocity that passes
# zero: with atol = rtol / 100 a tenth of our steps would go there. SciPy's error is a mean over
# 1254 entries, which does not notice: given rtol = atol = 2e-9, it needs 3 % fewer calls itself.
RTOL, ATOL = 1.55e-9, 1.55e-9
FINAL = {"record_every": STEPS, "record": "motion"}

EXCESS = 700.0
"""A step from Python may take so much longer than from Rust [ns]."""

MOTION = {"record": "motion"}
"""Positions and velocities; the peers keep the positions alone."""

SCENE = sa.paper.simulation(3, form="grid", normalized=True, gain=GAIN)


def simulate(method="rk4", **options):
    """Run our closed loop."""
    arguments = (SCENE.plant, SCENE.tracker, SCENE.reference, DURATION, STEP, method)
    return sa.simulate(*arguments, q0=(0.5, -0.5), **options)


def adaptive(**options):
    """Run ours with error control."""
    return simulate("dp54", rtol=RTOL, atol=ATOL, **options)


def scipy_final():
    """Run SciPy's RK45 for the final state only."""
    tolerance = {"rtol": closed_loop_scipy.RTOL, "atol": closed_loop_scipy.ATOL}
    span = (0.0, DURATION)
    return scipy.integrate.solve_ivp(closed_loop_numpy.rhs, span, start(), "RK45", **tolerance)


def batch(function, number):
    """Return clock and processor time of one of ``number`` calls."""
    clock, cpu = time.perf_counter(), time.thread_time()
    for _ in range(number):
        function()
    return (time.perf_counter() - clock) / number, (time.thread_time() - cpu) / number


def compile_eigen(folder):
    """Return a function that runs the C++ peer and returns its JSON, or why there is none."""
    compiler = os.environ.get("CXX") or shutil.which("g++") or shutil.which("clang++")
    if compiler is None:
        return None, "no C++ compiler (g++ or clang++)"
    flags = ["-I/usr/include/eigen3"]
    if shutil.which("pkg-config"):
        found = subprocess.run(["pkg-config", "--cflags", "eigen3"], capture_output=True, text=True)
        flags = found.stdout.split() or flags
    binary = Path(folder) / "closed_loop"
    source = HERE / "peers" / "closed_loop.cpp"
    command = [compiler, "-O3", "-march=native", *flags, str(source), "-o", str(binary)]
    built = subprocess.run(command, capture_output=True, text=True)
    if built.returncode != 0:
        return None, f"Eigen not found, or it does not compile: {' '.join(command)}"
    return lambda: json.loads(subprocess.check_output([binary])), ""


def rust_times():
    """Return the figures of benches/step_time.rs [ns], or None without cargo."""
    if shutil.which("cargo") is None:
        return None
    command = ["cargo", "bench", "--locked", "--quiet", "--bench", "step_time"]
    return json.loads(subprocess.check_output(command, cwd=HERE.parent))


def check_closed_loops(eigen):
    """Leave unless every contestant computes the same run."""
    results = {
        "steadyarm rk4": rms(simulate().q[1:]),
        "steadyarm dp54": rms(adaptive().q[1:]),
        "numba": rms(closed_loop_numba.run()),
        "numpy": rms(closed_loop_numpy.run()),
        "scipy": rms(closed_loop_scipy.run()),
    }
    if eigen:
        results["eigen"] = eigen()["rms"]
    print("RMS errors of the run [rad]")
    for name, errors in results.items():
        print(f"  {name:<15} {errors[0]:.10f} {errors[1]:.10f}")
    if any(np.abs(np.subtract(errors, RMS)).max() > RMS_TOL for errors in results.values()):
        sys.exit(f"not the same work: the RMS errors should be {RMS} to {RMS_TOL}")


def check_accuracy():
    """Leave unless our error-controlled run is as accurate as SciPy's."""
    exact = closed_loop_scipy.solve("DOP853", 1e-12, 1e-14)
    ours = adaptive()
    ours = np.column_stack([ours.q, ours.dq]), ours.weights.ravel()
    theirs = closed_loop_scipy.solve()
    theirs = theirs[:, :4], theirs[-1, 4:]

    def errors(motion, weights):
        off = np.abs(motion - exact[:, :4])
        return off[-1].max(), off.max(), np.abs(weights - exact[-1, 4:]).max()

    ours, theirs = errors(*ours), errors(*theirs)
    print(
        "\nLargest errors against DOP853 at 1e-12: motion at the end, anywhere, weights at the end"
    )
    print(f"  steadyarm dp54, rtol {RTOL:g}: " + ", ".join(f"{x:.2e}" for x in ours))
    tolerance = closed_loop_scipy.RTOL
    print(f"  solve_ivp RK45, rtol {tolerance:g}: " + ", ".join(f"{x:.2e}" for x in theirs))
    if any(a > b for a, b in zip(ours, theirs, strict=True)):
        sys.exit("not the same accuracy: ours is lower")


def riccati_problem(joints):
    """Return A, B, Q of equation (19) with the paper's gains for ``joints`` joints."""
    zero, eye = np.zeros((joints, joints)), np.eye(joints)
    a = np.block([[zero, eye], [-8.0 * eye, -5.5 * eye]])
    return a, np.vstack([zero, eye]), 10.0 * np.eye(2 * joints)


def check_riccati(joints):
    """Leave unless both solvers return the same P."""
    a, b, q = riccati_problem(joints)
    ours = sa.bounded_real_riccati(a, b, q).P
    theirs = scipy.linalg.solve_continuous_are(a, b, q, -np.eye(joints))
    if np.abs(ours - theirs).max() > P_TOL * np.abs(theirs).max():
        sys.exit(f"not the same work: the solutions of (19) for {joints} joints differ")


def compare_closed_loops(rounds, eigen):
    """Time ours directly before each peer, round by round."""
    peers = {"Numba": (closed_loop_numba.run, 2.5), "NumPy": (closed_loop_numpy.run, 120)}
    rows = []
    if eigen:
        rows.append(Paired("RK4, 625 rules, 20 s: Eigen -O3 -march=native", 3.5))
    rows += [Paired(f"RK4, 625 rules, 20 s: {name}", want) for name, (_, want) in peers.items()]
    rows.append(Paired("DP5(4), a row every 1 ms: SciPy solve_ivp", 300))
    rows.append(Paired("the same, torque, rho, V in the rows too: SciPy, motion"))
    rows.append(Paired("DP5(4), only the final state: SciPy solve_ivp"))
    pairs = [(lambda: simulate(**MOTION), run) for run, _ in peers.values()]
    pairs += [(lambda: adaptive(**MOTION), closed_loop_scipy.run)]
    pairs += [(adaptive, closed_loop_scipy.run), (lambda: adaptive(**FINAL), scipy_final)]
    for _ in range(rounds):
        if eigen:
            rows[0].ours.append(timed(lambda: simulate(**MOTION))[:2])
            result = eigen()
            rows[0].theirs.append((result["seconds"], result["cpu"]))
        for row, (ours, theirs) in zip(rows[-len(pairs) :], pairs, strict=True):
            row.ours.append(timed(ours)[:2])
            row.theirs.append(timed(theirs)[:2])
    return [row.claim() for row in rows]


def compare_steps(rounds, eigen):
    """Time a sampled step from Rust and from Python, and a step of RK4 of the C++ peer."""
    run = simulate(record_every=20)
    columns = (run.q, run.dq, run.q_d, run.dq_d, run.ddq_d)
    # Arrays of their own, as a user's are.
    samples = [tuple(column[k].copy() for column in columns) for k in range(len(run.t) - 1)]
    step = sa.paper.simulation(3, form="grid", normalized=True, gain=GAIN).tracker.step

    def steps(some):
        for q, dq, q_d, dq_d, ddq_d in some:
            step(q, dq, q_d, dq_d, ddq_d, STEP)

    # Short batches are rarely interrupted; their medians leave out those that were.
    batches = [samples[k : k + 100] for k in range(0, len(samples), 100)]

    python, rust, closed, rk4 = [], [], [], []
    for _ in range(rounds):
        many = [timed(lambda: steps(some))[:2] for some in 30 * batches]  # noqa: B023
        python.append(tuple(x / 100 for x in medians(many)))
        figures = rust_times()
        if figures is not None:
            rust.append((figures["step_ns"] * 1e-9,) * 2)
            closed.append((figures["riccati_joints_ns"] * 1e-9,) * 2)
        if eigen:
            result = eigen()
            rk4.append((result["seconds"] / STEPS, result["cpu"] / STEPS))
    rows = []
    if rust and rk4:
        figure = "a sampled step, 625 rules: a step of RK4 in Eigen"
        rows.append(Paired(figure, 10, ours=rust, theirs=rk4).claim())
    if rust:
        ours, most = 1e9 * medians(python)[0], 1e9 * medians(rust)[0] + EXCESS
        rows.append(within("a sampled step from Python: from Rust, and 0.7 us", ours, most))
    return rows, closed


def compare_riccati(rounds, closed):
    """Time equation (19): in closed form (Rust), in a whole controller, and on matrices."""
    nominal, basis = sa.paper.nominal(), SCENE.tracker.compensator.basis
    fuzzy = sa.FuzzyCompensator(basis)
    built = [
        often(lambda: sa.ComputedTorque(nominal, 8.0, 5.5, compensator=fuzzy))
        for _ in range(rounds)
    ]
    small, large = compare_matrices(rounds, 2, 10), compare_matrices(rounds, 7, 3)
    building = "Riccati, 2 joints, building the controller: SciPy"
    rows = [Paired(building, ours=built, theirs=small.theirs)]
    if closed:
        form = "Riccati, 2 joints, closed form, Rust: SciPy"
        rows.append(Paired(form, 40, ours=closed, theirs=small.theirs))
    return [row.claim() for row in (*rows, small, large)]


def compare_matrices(rounds, joints, wanted):
    """Time both solvers of the general equation."""
    a, b, q = riccati_problem(joints)
    r = -np.eye(joints)

    def theirs():
        return scipy.linalg.solve_continuous_are(a, b, q, r)

    ours, found, single = [], [], []
    for _ in range(rounds):
        ours.append(often(lambda: sa.bounded_real_riccati(a, b, q)))
        found.append(often(theirs))
        with threadpool_limits(limits=1, user_api="blas"):
            single.append(often(theirs))
    faster = min(found, single, key=lambda times: medians(times)[0])
    threads = "one BLAS thread" if faster is single else "BLAS threads as found"
    print(f"Riccati, {joints} joints: SciPy's time is that with {threads}")
    return Paired(f"Riccati, {joints} joints, matrices: SciPy", wanted, ours=ours, theirs=faster)


def often(function):
    """Return the median times of a short call, over batches of 20."""
    return medians([batch(function, 20) for _ in range(20)])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=7, help="rounds of every comparison (7)")
    parser.add_argument("--quick", action="store_true", help="two rounds, to see that all runs")
    options = parser.parse_args()
    rounds = 2 if options.quick else max(options.rounds, 1)

    with tempfile.TemporaryDirectory() as folder:
        eigen, missing = compile_eigen(folder)
        check_closed_loops(eigen)
        check_accuracy()
        check_riccati(2)
        check_riccati(7)
        rows = compare_closed_loops(rounds, eigen)
        steps, closed = compare_steps(rounds, eigen)
    rows += steps + compare_riccati(rounds, closed)

    if eigen is None:
        print(f"left out: Eigen ({missing})")
    if not closed:
        print("left out: the figures from Rust (no cargo)")
    return report("compare", rows, keep=not options.quick)


if __name__ == "__main__":
    sys.exit(main())
