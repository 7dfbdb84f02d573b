"""Compare the dynamics of the Panda, 7 joints, with Pinocchio's C++ and with dynibo.

Usage: python benches/compare_dynamics.py [--rounds N]

Every round runs the three in turn; a figure is the median over the rounds of each program's best
batch, a ratio one of medians. Pinocchio is the library inside the ``pin`` wheel, called from C++;
of its two CRBAs the faster counts. The figures go to ``results/<processor>.csv``. Needs cargo, a
C++ compiler and, on Debian, libeigen3-dev and liburdfdom-headers-dev; compiling Pinocchio's headers
takes minutes.
"""

import argparse
import importlib.util
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pinocchio
import steadyarm as sa
from claims import Claim, report

HERE = Path(__file__).parent
PREFIX = Path(pinocchio.__file__).parents[4]
DEFINES = (
    "-DNDEBUG", "-DBOOST_MPL_LIMIT_LIST_SIZE=30", "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS", "-DBOOST_FUSION_INVOKE_MAX_ARITY=12",
    "-DPINOCCHIO_WITH_URDFDOM",
)  # fmt: skip
LIBRARIES = ("pinocchio_default", "pinocchio_parsers", "boost_filesystem", "boost_serialization")
TORQUE_TOL = 1e-10

CLAIMS = (
    ("inverse dynamics, RNEA: Pinocchio", "rnea", "pinocchio", ("rnea",), 2.7),
    ("mass matrix, CRBA: Pinocchio", "crba", "pinocchio", ("crba", "crba_local"), 2.0),
    ("forward dynamics: Pinocchio's ABA", "aba", "pinocchio", ("aba",), 3.0),
    ("mass matrix and bias: Pinocchio", "crba+nle", "pinocchio", ("crba+nle",), None),
    ("inverse dynamics, RNEA: dynibo", "rnea", "dynibo", ("rnea",), 1.3),
)


def panda():
    """Return the URDF of the Panda without its fingers and its meshes."""
    example = HERE.parent / "examples" / "mujoco_payload.py"
    spec = importlib.util.spec_from_file_location("mujoco_payload", example)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.bare(module.panda(), module.PANDA["base"], module.PANDA["tip"])


def compile_pinocchio(folder):
    """Return the C++ peer's program."""
    compiler = os.environ.get("CXX") or shutil.which("g++") or shutil.which("clang++")
    if compiler is None:
        sys.exit("no C++ compiler (g++ or clang++)")
    binary = Path(folder) / "dynamics"
    command = [compiler, "-std=c++17", "-O3", *DEFINES, "-I/usr/include/eigen3"]
    command += [f"-I{PREFIX / 'include'}", str(HERE / "peers" / "dynamics.cpp"), "-o", str(binary)]
    command += [f"-L{PREFIX / 'lib'}", *(f"-l{name}" for name in LIBRARIES)]
    subprocess.run([*command, f"-Wl,-rpath,{PREFIX / 'lib'}"], check=True)
    return binary


def check(urdf):
    """Leave unless ours and Pinocchio compute the same torques."""
    arm = sa.Serial.from_urdf(urdf).without_friction()
    model = pinocchio.buildModelFromXML(urdf)
    data, random = model.createData(), np.random.default_rng(0)
    for _ in range(100):
        q, dq, ddq = random.uniform(-1, 1, (3, 7))
        theirs = pinocchio.rnea(model, data, q, dq, ddq)
        if np.abs(arm.inverse_dynamics(q, dq, ddq) - theirs).max() > TORQUE_TOL:
            sys.exit("not the same work: the torques differ")


def times(command):
    """Run a program that prints lines of JSON; return its times [ns] by library and operation."""
    lines = subprocess.check_output(command, text=True).splitlines()
    rows = [json.loads(line) for line in lines]
    return {(row.get("library") or row["peer"], row["op"]): row["ns"] for row in rows}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=7, help="rounds of the comparison (7)")
    rounds = parser.parse_args().rounds
    urdf = panda()
    check(urdf)
    with tempfile.TemporaryDirectory() as folder:
        robot = Path(folder) / "panda.urdf"
        robot.write_text(urdf)
        pinocchio_peer = compile_pinocchio(folder)
        manifest = HERE / "dynamics_peers" / "Cargo.toml"
        cargo = ["cargo", "run", "--release", "--locked", "--quiet"]
        rust = [*cargo, "--manifest-path", str(manifest), "--", str(robot)]
        found = {}
        for _ in range(rounds):
            for row in (times(rust), times([str(pinocchio_peer), str(robot)])):
                for key, ns in row.items():
                    found.setdefault(key, []).append(ns)
    median = {key: statistics.median(values) for key, values in found.items()}
    rows = []
    for claim, operation, library, theirs, wanted in CLAIMS:
        ours = median["steadyarm", operation]
        best = min(median[library, name] for name in theirs)
        rows.append(Claim(f"Panda, {claim}", ours, best, best / ours, wanted=wanted))
    return report("compare_dynamics", rows)


if __name__ == "__main__":
    sys.exit(main())
