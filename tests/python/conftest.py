"""What every test of the Python face starts from."""

import signal

import pytest

LONG = {
    "test_verdicts.py",
    "test_sweep_kills.py",
    "test_riccati.py",
    "test_recommended_oracle.py",
    "test_cli.py",
    "test_docs.py",
}
"""Files that take long, few as their tests are: begun last, they would keep one process waiting."""

# Who starts the tests in the background may ignore Ctrl-C, and programs that they run inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the long files."""
    items.sort(key=lambda item: item.path.name not in LONG)
