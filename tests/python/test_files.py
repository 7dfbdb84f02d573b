"""The one writer of files: whole or not at all, through links, into pipes, with owner and mode."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import steadyarm as sa
from scenes import drive, run, samples, tracker
from steadyarm import _files

pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs links, modes and pipes")

Save = Callable[[Path], object]

RECORD = run(tracker(), duration=0.01)
FIGURE = RECORD.plot()

SAVERS: dict[str, tuple[str, Save]] = {
    "record": ("run.npz", RECORD.save),
    "state": ("state", tracker().save),
    "picture": ("run.png", lambda path: FIGURE.savefig(path, dpi=30)),
    "vector picture": ("run.pdf", lambda path: FIGURE.savefig(path, dpi=30)),
    "film": ("run.gif", lambda path: RECORD.animate(sa.paper.nominal(), path)),
    "text": ("run.json", lambda path: _files.text(path, "{}")),
}
"""Everything that writes a file: a name for it, and how."""

each = pytest.mark.parametrize(("name", "save"), SAVERS.values(), ids=SAVERS)


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


@each
def test_old_file_stays_if_writing_fails(
    name: str, save: Save, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / name
    path.write_bytes(b"old")
    for stop in (OSError(28, "No space left on device"), KeyboardInterrupt(), ValueError("other")):

        def fail(file: int, stop: BaseException = stop) -> None:
            raise stop

        with monkeypatch.context() as patch, pytest.raises(type(stop)) as caught:
            patch.setattr(os, "fsync", fail)
            save(path)
        if isinstance(stop, OSError):
            assert caught.value.filename == str(path)
        assert path.read_bytes() == b"old"
        assert os.listdir(tmp_path) == [name]


@pytest.mark.parametrize("stop", [OSError(28, "full"), KeyboardInterrupt, ValueError, SystemExit])
def test_half_written_file_is_never_seen(stop: type[BaseException], tmp_path: Path) -> None:
    def write(part: Path) -> None:
        part.write_bytes(b"half")
        seen.append([path.read_bytes() for path in tmp_path.glob("[!.]*")])
        raise stop

    for old in ([], [b"old"]):
        seen: list[list[bytes]] = []
        for content in old:
            (tmp_path / "file").write_bytes(content)
        with pytest.raises(stop if isinstance(stop, type) else type(stop)):
            _files.replace(tmp_path / "file", write)
        assert seen == [old]
        assert [path.read_bytes() for path in tmp_path.iterdir()] == old


def test_threads_that_save_under_one_name_leave_no_half_file(tmp_path: Path) -> None:
    """The file is that of one of the two writers, to the byte, whenever it is read."""
    path = tmp_path / "state"
    writers = [tracker("grid"), tracker("grid")]
    drive(writers[1], samples(50))
    states = [writer.__getstate__() for writer in writers]
    assert states[0] != states[1]
    writers[0].save(path)
    done = threading.Event()
    failed: list[Exception] = []

    def save(writer: sa.ComputedTorque) -> None:
        try:
            for _ in range(100):
                writer.save(path)
        except Exception as error:
            failed.append(error)

    def read() -> None:
        while not done.is_set():
            content = path.read_bytes()
            reads.append(states.index(content) if content in states else -1)

    reads: list[int] = []
    reader = threading.Thread(target=read)
    threads = [threading.Thread(target=save, args=(writer,)) for writer in 2 * writers]
    for thread in (reader, *threads):
        thread.start()
    for thread in threads:
        thread.join()
    done.set()
    reader.join()
    assert failed == []
    assert set(reads) <= {0, 1}
    assert len(reads) > 20
    assert os.listdir(tmp_path) == ["state"]


@each
def test_links_stay_and_what_they_point_at_is_replaced(
    name: str, save: Save, tmp_path: Path
) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "here").mkdir()
    target, middle, link = (
        tmp_path / "there" / name,
        tmp_path / "there" / f"middle-{name}",
        tmp_path / "here" / name,
    )
    middle.symlink_to(name)  # relative, as links mostly are
    link.symlink_to(middle)
    for content in (None, b"old"):  # at first it points at nothing
        if content is not None:
            target.write_bytes(content)
        save(link)
        assert link.is_symlink()
        assert middle.is_symlink()
        assert target.read_bytes() not in (b"old", b"")
        assert not target.is_symlink()
        assert sorted(os.listdir(target.parent)) == sorted([name, middle.name])


def test_link_in_a_circle_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    with pytest.raises(OSError, match=r"symbolic links.*/a'"):
        tracker().save(tmp_path / "a")


@each
def test_pipe_is_written_to_and_stays_a_pipe(name: str, save: Save, tmp_path: Path) -> None:
    save(tmp_path / name)
    expected = (tmp_path / name).read_bytes()
    pipe = tmp_path / f"pipe-{name}"
    os.mkfifo(pipe)
    got: list[bytes] = []
    reader = threading.Thread(target=lambda: got.append(pipe.read_bytes()))
    reader.start()
    save(pipe)
    reader.join()
    assert len(got[0]) == len(expected)
    assert got[0][:4] == expected[:4]
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert sorted(os.listdir(tmp_path)) == sorted([name, pipe.name])


def test_controller_steps_in_another_thread_while_its_file_is_waited_for(tmp_path: Path) -> None:
    controller = tracker()
    saved = controller.__getstate__()
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    writer = threading.Thread(target=controller.save, args=(pipe,))
    writer.start()  # waits for somebody who reads
    time.sleep(0.05)
    drive(controller, samples(3))
    assert controller.steps == 3
    reader = tracker()
    drive(reader, samples(5, seed=1))
    reader.load(pipe)  # and reading waits for the one who writes
    writer.join()
    assert reader.steps == 0
    assert reader.__getstate__() == saved


@pytest.mark.skipif(sys.platform != "linux", reason="needs /dev/full")
@each
def test_device_is_written_to(name: str, save: Save, tmp_path: Path) -> None:
    ending = Path(name).suffix
    for device, error in (("null", None), ("full", "No space left on device")):
        link = tmp_path / f"{device}{ending}"
        link.symlink_to(f"/dev/{device}")
        if error is None:
            save(link)
        else:
            with pytest.raises(OSError, match=rf"{error}.*{link.name}"):
                save(link)
        assert stat.S_ISCHR(os.stat(f"/dev/{device}").st_mode)


@each
def test_mode_stays_and_a_new_file_has_that_of_the_umask(
    name: str, save: Save, tmp_path: Path
) -> None:
    path = tmp_path / name
    before = os.umask(0o027)
    try:
        save(path)
        assert mode(path) == 0o640
        for kept in (0o600, 0o664, 0o777):
            path.chmod(kept)
            save(path)
            assert mode(path) == kept
    finally:
        os.umask(before)


def test_file_is_no_more_open_to_others_while_it_is_written(tmp_path: Path) -> None:
    path = tmp_path / "secret"
    path.touch(0o600)
    modes: list[int] = []
    _files.replace(path, lambda part: modes.append(mode(part)))
    assert modes == [0o600]


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="needs root")
def test_owner_stays(tmp_path: Path) -> None:
    path = tmp_path / "state"
    path.touch()
    os.chown(path, 12345, 54321)
    tracker().save(path)
    assert (path.stat().st_uid, path.stat().st_gid) == (12345, 54321)


def test_file_is_on_the_disk_before_it_is_renamed_and_the_folder_after(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    events: list[str] = []
    plain_sync, plain_replace = os.fsync, os.replace

    def sync(file: int) -> None:
        events.append("folder" if stat.S_ISDIR(os.fstat(file).st_mode) else "file")
        plain_sync(file)

    def rename(*names: Path) -> None:
        events.append("rename")
        plain_replace(*names)

    monkeypatch.setattr(os, "fsync", sync)
    monkeypatch.setattr(os, "replace", rename)
    tracker().save(tmp_path / "state")
    assert events == ["file", "rename", "folder"]


def test_nobody_elses_file_is_written_to(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A link that waits under the name of the new file does not lead it elsewhere."""
    victim = tmp_path / "victim"
    victim.write_bytes(b"mine")
    monkeypatch.setattr("secrets.token_hex", lambda n: "known")
    (tmp_path / ".known").symlink_to(victim)
    with pytest.raises(FileExistsError):
        tracker().save(tmp_path / "state")
    assert victim.read_bytes() == b"mine"


def test_longest_name_can_be_written(tmp_path: Path) -> None:
    for path in (tmp_path / ("x" * 251 + ".npz"), tmp_path / ("x." + "y" * 253)):
        RECORD.save(path)
        assert sa.Run.load(path).status == RECORD.status


@each
def test_folder_is_an_error(name: str, save: Save, tmp_path: Path) -> None:
    path = tmp_path / name
    path.mkdir()
    with pytest.raises(IsADirectoryError, match=name):
        save(path)
    with pytest.raises(IsADirectoryError, match=name):
        _files.check(path)
    assert os.listdir(tmp_path) == [name]
    assert os.listdir(path) == []


AS_NOBODY = """
import os, sys, steadyarm as sa
from steadyarm import _files
folder = sys.argv[1]
path = folder + "/run.png"
scene = sa.paper.simulation(2, duration=0.01)
run = scene.run()
figure = run.plot()
if os.geteuid() == 0:
    os.chown(folder, 65534, 65534), os.setgid(65534), os.setuid(65534)
with open(path, "w") as file:
    file.write("old")
def refused(call):
    try:
        call(path)
    except PermissionError as error:
        assert error.filename == path, error
    else:
        print(call, "wrote")
for mode, folder_mode in ((0o644, 0o555), (0o444, 0o755)):
    os.chmod(path, mode), os.chmod(folder, folder_mode)
    for call in run.save, scene.tracker.save, figure.savefig, _files.check:
        refused(call)
    os.chmod(folder, 0o755)
    with open(path) as file:
        assert file.read() == "old" and os.listdir(folder) == ["run.png"], os.listdir(folder)
os.chmod(path, 0o200)  # may be written and not be read
scene.tracker.save(path)
assert os.stat(path).st_mode & 0o777 == 0o200
print("done")
"""


def test_what_may_not_be_written_is_not() -> None:
    """A folder without write permission, and a file without: the file is not replaced either."""
    with tempfile.TemporaryDirectory() as folder:  # pytest's is root's alone
        command = [sys.executable, "-c", AS_NOBODY, folder]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr, done.returncode) == ("done\n", "", 0)


SMALL_DISK = """
import resource, sys, steadyarm as sa
from pathlib import Path
resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))
import signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
sys.path.insert(0, {here!r})
import os; os.umask(0o022)
scene = sa.paper.simulation(3, "claimed", duration=0.2)
run = scene.run()
folder = Path({folder!r})
for name, save in (("run.npz", run.save), ("state", scene.tracker.save),
                   ("run.png", run.plot().savefig), ("run.pdf", run.plot().savefig),
                   ("run.gif", lambda path: run.animate(sa.paper.nominal(), path))):
    path = folder / name
    path.write_bytes(b"old")
    try:
        save(path)
    except OSError as error:
        print(error.strerror, error.filename == str(path), path.read_bytes())
print(sorted(os.listdir(folder)))
"""


def test_full_disk_keeps_every_old_file(tmp_path: Path) -> None:
    code = SMALL_DISK.format(here=str(Path(__file__).parent), folder=str(tmp_path))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    names = ["run.gif", "run.npz", "run.pdf", "run.png", "state"]
    assert done.stdout.splitlines() == 5 * ["File too large True b'old'"] + [str(names)], done


@pytest.fixture
def slow_film(tmp_path: Path) -> Iterator[tuple[Path, subprocess.Popen[str]]]:
    """A process that films for a minute over an old film."""
    path = tmp_path / "arm.gif"
    path.write_bytes(b"old")
    code = (
        "import sys, steadyarm as sa; run = sa.paper.simulation(2, duration=40.0).run();"
        "print('ready', flush=True); run.animate(sa.paper.nominal(), sys.argv[1])"
    )
    command = [sys.executable, "-c", code, str(path)]
    child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    yield path, child
    child.kill()
    child.communicate()


def test_ctrl_c_keeps_the_old_film(slow_film: tuple[Path, subprocess.Popen[str]]) -> None:
    import signal

    path, child = slow_film
    assert child.stdout is not None
    assert child.stdout.readline() == "ready\n"
    while len(os.listdir(path.parent)) < 2:
        assert child.poll() is None
        time.sleep(0.01)
    time.sleep(0.5)
    child.send_signal(signal.SIGINT)
    _, err = child.communicate(timeout=120)
    assert err.rstrip().endswith("KeyboardInterrupt")
    assert path.read_bytes() == b"old"
    assert os.listdir(path.parent) == ["arm.gif"]


def test_figure_without_an_ending_is_a_png_as_in_matplotlib(tmp_path: Path) -> None:
    figure = RECORD.plot()
    figure.savefig(tmp_path / "bare")
    figure.savefig(str(tmp_path / "named.dat"), format="svg", dpi=50)
    with (tmp_path / "open").open("wb") as file:
        figure.savefig(file, format="pdf")
    heads = {path.name: path.read_bytes()[:5] for path in tmp_path.iterdir()}
    assert heads == {"bare.png": b"\x89PNG\r", "named.dat": b"<?xml", "open": b"%PDF-"}
    with pytest.raises(ValueError, match="bmp"):
        figure.savefig(tmp_path / "run.bmp")
    assert len(os.listdir(tmp_path)) == 3
