"""The verdicts of `design` against runs of random designs; ``benches/verdicts.py`` has 1000."""

from __future__ import annotations

import functools

import pytest
from verdict_scenes import RANGE, SOUND, Outcome, judged

SEEDS = range(40)


@functools.cache
def outcomes() -> list[Outcome]:
    return [outcome for seed in SEEDS if (outcome := judged(seed)) is not None]


def test_the_designs_are_of_every_class() -> None:
    called = [outcome.called for outcome in outcomes()]
    assert len(called) >= 35
    for name, least in (("sound", 10), ("sound, warned of", 4), ("refused: unstable", 4)):
        assert called.count(name) >= least
    shares = [outcome.control_period / outcome.longest for outcome in outcomes()]
    assert min(shares) < 0.1 and max(shares) > 1.5
    assert all(RANGE[0] * 0.999 <= share <= RANGE[1] * 1.001 for share in shares)


@pytest.mark.parametrize("seed", SEEDS)
def test_no_loop_that_is_called_sound_diverges(seed: int) -> None:
    for outcome in outcomes():
        if outcome.design.seed == seed and outcome.called in SOUND:
            assert not outcome.diverged, outcome.row()


def test_what_is_refused_for_its_radius_does_not_run_well() -> None:
    refused = [it for it in outcomes() if it.called == "refused: unstable"]
    assert not [it.row() for it in refused if it.well]


def test_a_verdict_has_its_finding_and_a_period_to_take() -> None:
    for outcome in outcomes():
        words = " ".join(outcome.report.findings)
        share = outcome.control_period / outcome.longest
        assert outcome.report.sound == (share <= 0.75) or abs(share - 0.75) < 1e-3
        assert ("of the longest stable one" in words or "will be unstable" in words) == (
            share > 1 / 3
        ) or abs(share - 1 / 3) < 1e-3
        if not outcome.report.sound:
            assert "sample every" in words
            shorter = outcome.design.report(outcome.longest / 3.1)
            assert shorter.sound, shorter.findings
