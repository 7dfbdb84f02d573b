"""The command line: files, numbers, messages, exit codes."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
import steadyarm as sa
from steadyarm import _files, _rivals, cli, reproduction

GOLDEN_TOLERANCE = 1e-5
"""RMS errors [rad] agree with two independent programs to this."""

GOLDEN = {
    (2, None, None, None, None): (0.193026, 0.447902),
    (3, "shared", True, 1 / 7, "error"): (0.192160, 0.443569),
    (3, "grid", True, 1 / 7, "error"): (0.192933, 0.447706),
    (3, "shared", True, 7.0, "error"): (0.170362, 0.332090),
    (3, "shared", False, 7.0, "error"): (0.169970, 0.295614),
    (3, "shared", True, 70.0, "error"): (0.064579, 0.107421),
    (3, "shared", False, 70.0, "error"): (0.021925, 0.040805),
    (3, "concat", False, 7.0, "error"): (0.030918, 0.057160),
    (3, "concat", False, 70.0, "error"): (0.003015, 0.006027),
    (3, "grid", True, 7.0, "error"): (0.188632, 0.438626),
    (3, "grid", True, 70.0, "error"): (0.159819, 0.376522),
    (3, "grid", False, 7.0, "error"): (0.010938, 0.021588),
    (3, "grid", True, 7.0, "state"): (0.184484, 0.427863),
}
"""Steady RMS errors of joints 1 and 2 [rad]."""

GOLDEN_TORQUE = {
    (2, None, None, None, None): 15.350,
    (3, "shared", True, 70.0, "error"): 19.551,
    (3, "shared", False, 70.0, "error"): 23.860,
    (3, "concat", False, 70.0, "error"): 64.278,
    (3, "grid", False, 7.0, "error"): 25.302,
}
"""Largest torque of joint 1 [N·m]."""

PICTURES = {"figure1.png", "figure2.png", "figure3.png", "figure3_claimed.png", "errors.png"}

COMPARISON = {"compare.md", "compare.csv", "compare.html"}


posix = pytest.mark.skipif(os.name != "posix", reason="needs links, limits, devices and pipes")


def run_command(capsys, *arguments):
    """Exit code, standard output and error of a command."""
    try:
        code = cli.main([str(argument) for argument in arguments])
    except SystemExit as stop:
        code = stop.code
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def key(row):
    return tuple(row[name] for name in ("simulation", "form", "normalized", "gain", "inputs"))


@pytest.fixture(scope="module")
def reproduced(tmp_path_factory):
    """Directory, output and rows of one `reproduce`."""
    out = tmp_path_factory.mktemp("reproduce") / "new" / "directory"
    command = [sys.executable, "-m", "steadyarm", "reproduce", "--out", str(out)]
    done = subprocess.run(command, check=True, capture_output=True, encoding="utf-8")
    return out, done.stdout, json.loads((out / "results.json").read_text(encoding="utf-8"))


def test_reproduce_writes_pictures_and_numbers_and_nothing_else(reproduced):
    out, text, _ = reproduced
    assert {path.name for path in out.iterdir()} == PICTURES | COMPARISON | {"results.json"}
    assert all((out / name).read_bytes().startswith(b"\x89PNG") for name in PICTURES)
    assert f"Pictures and numbers are in {out}" in text


def test_results_hold_every_reading_once(reproduced):
    _, _, rows = reproduced
    wanted = {(1, None, None, None, None), (2, None, None, None, None)}
    wanted |= {
        (3, form, normalized, gain, "error")
        for form in ("grid", "shared", "concat", "per_joint")
        for normalized in (True, False)
        for gain in (1 / 7, 7.0, 70.0)
    }
    wanted.add((3, "grid", True, 7.0, "state"))
    assert len(rows) == len(wanted)
    assert {key(row) for row in rows} == wanted
    presets = {row["preset"]: key(row) for row in rows if row["preset"]}
    assert presets == {
        "printed": (3, "shared", True, 1 / 7, "error"),
        "claimed": (3, "grid", False, 7.0, "error"),
    }
    for row in rows:
        assert row["status"] == "finished"
        for name in ("rms_e", "max_abs_e", "max_abs_tau"):
            assert len(row[name]) == 2
            assert all(np.isfinite(row[name]))


def test_results_equal_the_golden_values(reproduced):
    _, _, rows = reproduced
    rows = {key(row): row for row in rows}
    assert max(rows[1, None, None, None, None]["rms_e"]) < 1e-9
    for which, rms in GOLDEN.items():
        assert rows[which]["rms_e"] == pytest.approx(rms, abs=GOLDEN_TOLERANCE), which
    for which, torque in GOLDEN_TORQUE.items():
        assert rows[which]["max_abs_tau"][0] == pytest.approx(torque, abs=1e-3), which


def test_the_verdict_is_computed_from_the_numbers(reproduced):
    _, text, rows = reproduced
    verdict = reproduction.verdict(rows)
    assert verdict in text
    as_printed, as_claimed = verdict.split("Read with")
    for word in ("is inert", "0.192 / 0.444", "0.193 / 0.448"):
        assert word in as_printed
    for word in ("does what the paper claims", "0.011 / 0.022", "17.6 / 20.7 times"):
        assert word in as_claimed


def test_rivals_are_printed_with_what_they_show_and_written(reproduced):
    out, text, _ = reproduced
    table = sa.Comparison.from_csv(out / "compare.csv")
    assert len(table.rows) == 2 * 20
    assert {row.scenario for row in table.rows} == {"paper_rivals", "paper_sensors"}
    said = _rivals.sentences(list(table.rows))
    words = " ".join(text.split())
    assert len(said) == 6
    assert all(" ".join(sentence.split()) in words for sentence in said)
    assert "super\\_twisting" in (out / "compare.md").read_text(encoding="utf-8")
    assert "The printed method is inert" in (out / "compare.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("rms", "words"),
    [
        ([0.1, 0.2], "is inert"),
        ([0.2, 0.1], "makes the error larger"),
        ([0.06, 0.1], "helps, but"),
        ([0.01, 0.02], "does what the paper claims"),
        (None, "cannot be judged"),
    ],
)
def test_other_numbers_give_another_verdict(rms, words):
    rows = [
        {"simulation": 2, "preset": None, "rms_e": [0.1, 0.2]},
        {"simulation": 3, "preset": "printed", "rms_e": rms},
        {"simulation": 3, "preset": "claimed", "rms_e": rms},
    ]
    verdict = reproduction.verdict(rows)
    assert verdict.count(words) == 2


def test_the_table_is_aligned_and_has_units(reproduced):
    _, text, rows = reproduced
    table = reproduction.table(rows)
    assert table in text
    head, names, _, *lines = table.splitlines()
    assert "RMS error [rad]" in head
    assert "max |torque| [N·m]" in head
    assert len(lines) == len(rows)
    bars = [n for n, letter in enumerate(names) if letter == "|"]
    assert all([n for n, letter in enumerate(line) if letter == "|"] == bars for line in lines)
    assert len({len(line) for line in (names, *lines)}) == 1


def test_a_diverged_run_becomes_a_row_without_figures():
    case = reproduction.Case(3, "grid", False, 7.0, "error")
    run = sa.paper.simulation(3, "claimed").run(control_period=0.4)
    row = case.row(run)
    assert row["rms_e"] is row["max_abs_e"] is row["max_abs_tau"] is None
    assert row["status"] == str(run.status)
    assert row["status"].startswith("diverged at t = ")
    assert "diverged" in reproduction.table([row])
    json.dumps(row, allow_nan=False)


@posix
def test_a_directory_that_cannot_be_made_is_one_clear_line(capsys, tmp_path):
    file = tmp_path / "file"
    file.write_text("")
    code, out, err = run_command(capsys, "reproduce", "--out", file / "directory")
    assert (code, out) == (1, "")
    assert err == f"steadyarm: cannot write {file / 'directory'}: Not a directory\n"


@posix
def test_a_full_disk_leaves_no_half_file_and_keeps_the_old_one(tmp_path):
    (tmp_path / "figure1.png").write_bytes(b"old")
    script = (
        "import resource, sys; from steadyarm.cli import main;"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000));"
        f"sys.exit(main(['reproduce', '--out', {str(tmp_path)!r}]))"
    )
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", check=False)
    assert done.returncode == 1
    assert f"steadyarm: cannot write {tmp_path / 'figure1.png'}: File too large" in done.stderr
    assert "Traceback" not in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["figure1.png"]
    assert (tmp_path / "figure1.png").read_bytes() == b"old"


@pytest.mark.parametrize("way", ["exception", "status"])
def test_ctrl_c_keeps_what_is_written_and_says_so(capsys, tmp_path, monkeypatch, way):
    plain = reproduction.Case.run

    def stop_at_the_third(case):
        if case.simulation < 3:
            return plain(case)
        if way == "exception":
            raise KeyboardInterrupt
        run = sa.paper.simulation(2, duration=0.1).run()
        object.__setattr__(run, "status", sa.Status("interrupted", 0.1, "it was stopped"))
        return run

    monkeypatch.setattr(reproduction.Case, "run", stop_at_the_third)
    code, _, err = run_command(capsys, "reproduce", "--out", tmp_path)
    assert code == 130
    kept = f"kept in {tmp_path}: figure1.png, figure2.png; results.json was not written"
    assert f"steadyarm: stopped; {kept}\n" in err
    assert {path.name for path in tmp_path.iterdir()} == {"figure1.png", "figure2.png"}


@posix
def test_writing_goes_through_links_and_straight_into_devices(tmp_path):
    target, link = tmp_path / "target", tmp_path / "link"
    target.write_text("old")
    link.symlink_to(target)
    _files.text(link, "new")
    assert link.is_symlink()
    assert target.read_text() == "new"
    _files.text(_files.Path("/dev/null"), "away")
    assert not _files.Path("/dev/null").is_file()


def test_simulate_reports_the_run_and_keeps_it(capsys, tmp_path):
    plot, save = tmp_path / "run.svg", tmp_path / "run.npz"
    options = ("--preset", "claimed", "--duration", "2", "--plot", plot, "--save", save)
    code, out, err = run_command(capsys, "simulate", *options)
    assert (code, err) == (0, "")
    run = sa.Run.load(save)
    expected = sa.paper.simulation(3, "claimed", duration=2.0).run()
    assert np.array_equal(run.q, expected.q)
    assert "<svg" in plot.read_text(encoding="utf-8")
    assert "simulation 3, preset claimed, duration 2" in out
    assert "finished" in out
    for value in expected.metrics((1.0, 2.0)).rms_e:
        assert f"{1e3 * value:.4g}" in out
    for words in ("RMS error", "[mrad]", "peak torque", "Lyapunov identity kept", str(plot)):
        assert words in out


def test_simulate_takes_every_setting(capsys, tmp_path):
    save = tmp_path / "run.npz"
    options = "--form concat --raw --gain 7,1/7 --inputs e,de --kp 9 --kv 6 --leak-rate 0.1"
    options += " --gamma 2 --duration 1 --dt 0.002 --control-period 0.004"
    code, out, _ = run_command(capsys, "simulate", *options.split(), "--save", save)
    assert code == 0
    assert "certificate none: sampled control" in out
    scene = sa.paper.simulation(
        3, form="concat", normalized=False, gain=[7, 1 / 7], inputs=["e", "de"],
        kp=9, kv=6, leak_rate=0.1, gamma=2, duration=1, dt=0.002,
    )  # fmt: skip
    assert np.array_equal(sa.Run.load(save).q, scene.run(control_period=0.004).q)


def test_simulate_says_what_a_useless_compensator_does(capsys):
    code, out, _ = run_command(capsys, "simulate", "--preset", "printed")
    assert code == 0
    assert "of what the model leaves out: joint 1 0.3 %, joint 2 1.0 %" in out


def test_a_run_that_blows_up_fails_with_advice(capsys):
    options = "--form concat --raw --gain 70 --control-period 0.04"
    code, out, _ = run_command(capsys, "simulate", *options.split())
    assert code == 1
    assert "diverged at t = " in out
    assert "shorten --control-period or lower --gain" in out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("--gain -1", "gain[0]: got -1, wants a number > 0"),
        ("--gain x", "argument --gain: got 'x', wants a number"),
        ("--gain 1/0", "argument --gain: got '1/0', wants a number"),
        ("--simulation 2 --gain 7", "gain: simulation 2 has no such setting"),
        ("--simulation 4", "invalid choice: "),
        ("--gamma 0.1", "gamma: got 0.1, wants more than 0.614"),
        ("--dt 0", "dt: got 0, wants a number > 0"),
        ("--inputs q,zz", 'inputs: got "zz", wants one of'),
        ("--plot run.bmp", "wants a name that ends in .png or .svg or .pdf"),
        ("--save run.csv", "wants a name that ends in .npz"),
        ("--raw --normalized", "not allowed with"),
        ("--bogus", "unrecognized arguments: --bogus"),
    ],
)
def test_arguments_that_make_no_sense_are_refused_by_name(capsys, options, message):
    code, out, err = run_command(capsys, "simulate", *options.split())
    assert (code, out) == (2, "")
    assert message in err


def test_a_scenario_that_the_command_wrote_runs_and_can_be_changed(capsys, tmp_path):
    code, text, _ = run_command(capsys, "scenario", "--preset", "claimed")
    assert code == 0
    file = tmp_path / "mine.toml"
    file.write_text(text)
    _, of_paper, _ = run_command(capsys, "simulate", "--preset", "claimed", "--duration", 1)
    _, of_file, _ = run_command(capsys, "simulate", "--scenario", file, "--duration", 1)
    assert of_file.splitlines()[1:] == of_paper.splitlines()[1:]
    assert str(file) in of_file
    file.write_text(text.replace("gain = 7.0", "gain = -7.0"))
    code, _, err = run_command(capsys, "design", "--scenario", file)
    assert code == 2
    assert f"{file}: compensator.gain[0]: got -7, wants a number > 0" in err
    code, _, err = run_command(capsys, "simulate", "--scenario", tmp_path / "none.toml")
    assert code == 2
    assert "--scenario: cannot read" in err


def test_a_missing_directory_is_noticed_before_the_run(capsys, tmp_path):
    missing = tmp_path / "missing"
    code, out, err = run_command(capsys, "simulate", "--plot", missing / "run.png")
    assert (code, out) == (1, "")
    assert err == f"steadyarm: cannot write {missing}: no such directory\n"


def test_approximate_shows_the_error_falling(capsys, tmp_path):
    picture = tmp_path / "approximation.png"
    code, out, _ = run_command(capsys, "approximate", "--out", picture)
    assert code == 0
    rows = [line.split() for line in out.splitlines()[1:12]]
    rules, error = zip(*((int(a), float(b)) for a, b in rows), strict=True)
    assert (rules[0], rules[-1]) == (4, 576)
    assert all(np.diff(error) < 0)
    assert error[-1] < 5e-3
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert str(picture) in out


def test_help_teaches_with_examples_and_symptoms(capsys):
    code, out, _ = run_command(capsys, "--help")
    assert code == 0
    for words in ("reproduce", "simulate", "approximate", "tracking error", "torque jumps"):
        assert words in out


@pytest.mark.parametrize("command", ["reproduce", "simulate", "approximate"])
def test_every_command_explains_itself(capsys, command):
    code, out, _ = run_command(capsys, command, "--help")
    assert code == 0
    assert f"usage: steadyarm {command}" in out


def test_every_command_line_of_the_help_works(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for line in cli.EPILOG.splitlines():
        # Those with a file of one's own are in test_cli_robot.py.
        if not line.strip().startswith("steadyarm simulate") or "robot.urdf" in line:
            continue
        arguments = line.strip().split("  ")[0].split()[1:]
        code, out, _ = run_command(capsys, *arguments)
        assert code == (1 if "diverged" in out else 0), line


def test_no_command_prints_the_help(capsys):
    code, out, _ = run_command(capsys)
    assert code == 2
    assert out.startswith("usage: steadyarm")


def test_version(capsys):
    code, out, _ = run_command(capsys, "--version")
    assert (code, out) == (0, f"steadyarm {sa.__version__}\n")


@posix
def test_a_closed_pipe_is_no_traceback():
    command = f"{sys.executable} -m steadyarm approximate | head -n 1"
    done = subprocess.run(command, shell=True, capture_output=True, encoding="utf-8", check=True)
    assert done.stderr == ""
