"""Tune a controller for two ends at once, a small error and a quiet torque, with Optuna.

    pip install "steadyarm[plot]" optuna
    python tune_optuna.py

Three gains of a PID on the paper's arm, twice as heavy as believed, with noisy 16-bit encoders and
torques a sample late. Each trial runs with several seeds of the noise at a time, and counts by the
worst. The table has the trials that no other beats; the picture has all of them.
"""

import argparse

import optuna
import steadyarm as sa
from steadyarm.comparison import Comparison, Row

SCENE = sa.Scenario.read("paper_sensors")
NOISY = SCENE.effects.__replace__(noise=1e-5)
SEEDS = range(4)
RANGES = {"kp": (10.0, 3000.0), "kv": (2.0, 200.0), "ki": (10.0, 30000.0)}


def simulated(law, name):
    """Run a law on the scene with all seeds, and return the figures of each."""
    options = {**SCENE.options, "duration": 20.0, "effects": NOISY, "seeds": SEEDS}
    scene = (SCENE.plant, SCENE.controller(law), SCENE.reference)
    runs = sa.simulate_many(*scene, record="all", **options)
    return [Row.of(run, controller=name, seed=seed) for seed, run in enumerate(runs)]


def objective(trial):
    """Return steady RMS error [rad] and torque variation [N·m/s] of the worst seed.

    Gains that are refused, or that a seed does not get through with, are pruned.
    """
    gains = {name: trial.suggest_float(name, *ends, log=True) for name, ends in RANGES.items()}
    name = " ".join(f"{gain} {value:.0f}" for gain, value in gains.items())
    try:
        rows = simulated({"law": "pid", **gains}, name)
    except ValueError as refused:
        raise optuna.TrialPruned(str(refused)) from refused
    for row in rows:
        if not row.finished:
            raise optuna.TrialPruned(row.reason)
    trial.set_user_attr("rows", rows)
    return max(row.steady_rms_e for row in rows), max(row.torque_variation for row in rows)


def main():
    """Tune, print the table and draw the picture."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--trials", type=int, default=100)
    parser.add_argument("--out", default="pareto.png", help="the picture: .png, .pdf or .svg")
    arguments = parser.parse_args()
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    study = optuna.create_study(
        directions=["minimize"] * 2, sampler=optuna.samplers.TPESampler(seed=1)
    )
    study.optimize(objective, n_trials=arguments.trials)
    laws = SCENE.controllers
    rules = simulated(laws["pid"], "the rule for 12 rad/s")
    rules += simulated(laws["recommended"], "recommended")
    best = [row for trial in study.best_trials for row in trial.user_attrs["rows"]]
    print(Comparison([*best, *rules]))
    tried = [trial.user_attrs["rows"] for trial in study.trials if "rows" in trial.user_attrs]
    rows = [row for rows in tried for row in rows]
    sa.plots.pareto(Comparison([*rows, *rules])).savefig(arguments.out)
    print(f"\n{len(tried)} of {arguments.trials} trials finished; {arguments.out} shows them")


if __name__ == "__main__":
    main()
