"""Tune a controller for two ends at once, a small error and a quiet torque, with Optuna.

    pip install "steadyarm[plot]" optuna
    python tune_optuna.py

Three gains of a PID on the paper's arm, twice as heavy as believed, with 16-bit encoders and
torques a sample late. The table has the trials that no other beats; the picture has all of them.
"""

import argparse

import optuna
import steadyarm as sa
from steadyarm.comparison import Comparison, Row

SCENE = sa.Scenario.read("paper_sensors")
RANGES = {"kp": (10.0, 3000.0), "kv": (2.0, 200.0), "ki": (10.0, 30000.0)}


def simulated(law, name):
    """Run a law on the scene, and return its figures."""
    return Row.of(SCENE.simulate(law, duration=20.0), controller=name)


def objective(trial):
    """Return steady RMS error [rad] and torque variation [N·m/s]; refused gains are pruned."""
    gains = {name: trial.suggest_float(name, *ends, log=True) for name, ends in RANGES.items()}
    name = " ".join(f"{gain} {value:.0f}" for gain, value in gains.items())
    try:
        row = simulated({"law": "pid", **gains}, name)
    except ValueError as refused:
        raise optuna.TrialPruned(str(refused)) from refused
    if not row.finished:
        raise optuna.TrialPruned(row.reason)
    trial.set_user_attr("row", row)
    return row.steady_rms_e, row.torque_variation


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
    rules = [simulated("pid", "the rule for 12 rad/s"), simulated("recommended", "recommended")]
    best = [trial.user_attrs["row"] for trial in study.best_trials]
    print(Comparison([*best, *rules]))
    tried = [trial.user_attrs["row"] for trial in study.trials if "row" in trial.user_attrs]
    sa.plots.pareto(Comparison([*tried, *rules])).savefig(arguments.out)
    print(f"\n{len(tried)} of {arguments.trials} trials finished; {arguments.out} shows them")


if __name__ == "__main__":
    main()
