"""Print the share of robot files that load, and why the others do not.

Usage: python benches/robot_files.py [--notes] [--unphysical POLICY] [FOLDER_OR_FILE ...]

Without arguments: the URDFs of ``example-robot-data``, and those in ``tests``. Of every file each
chain is read as it stands, unedited: from a leaf back to the root, to a floating or planar joint,
or over eight joints that move. A chain that ends in joints which follow others (``mimic``) ends
before them. Prints chains and files that load, the reasons of the others with their numbers, and
with ``--notes`` what is noted. POLICY: "refuse", "note" or "nearest", as of `Serial.from_urdf`.
"""

import argparse
import collections
import importlib.metadata
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import steadyarm as sa

MOST_JOINTS = 8
MOVING = ("revolute", "continuous", "prismatic")
TESTS = Path(__file__).parents[1] / "tests"


def files(paths):
    """Yield the URDFs of these folders."""
    for path in map(Path, paths):
        yield from sorted(path.rglob("*.urdf")) if path.is_dir() else [path]


def example_robot_data():
    """Return the folder of the robots of the package, a list of none or one."""
    try:
        package = importlib.metadata.distribution("example-robot-data")
    except importlib.metadata.PackageNotFoundError:
        return []
    return [Path(package.locate_file("cmeel.prefix/share/example-robot-data/robots"))]


def chains(path):
    """Return {(base, tip)} of a file; none if it is too odd for Python's reader of XML."""
    try:
        root = ElementTree.fromstring(path.read_bytes().strip())
    except ElementTree.ParseError:
        return [(None, None)]
    into = {
        child.get("link"): joint
        for joint in root.findall("joint")
        if (child := joint.find("child")) is not None and joint.find("parent") is not None
    }
    parents = {joint.find("parent").get("link") for joint in into.values()}
    found = {chain(into, tip) for tip in set(into) - parents}
    return sorted(pair for pair in found if pair is not None)


def chain(into, tip):
    """Return (base, tip) of the chain that ends in a leaf, or None if nothing moves."""
    link, moving = tip, 0
    while link in into:
        joint = into[link]
        kind = joint.get("type")
        if kind not in (*MOVING, "fixed") or (kind in MOVING and moving == MOST_JOINTS):
            break
        link = joint.find("parent").get("link")
        moving += kind in MOVING
        if joint.find("mimic") is not None:
            tip, moving = link, 0
    return (link, tip) if moving else None


def reason(message):
    """Return a refusal without its line, names and numbers."""
    message = re.sub(r"^.*?line \d+: ", "", message)
    message = re.sub(r'"[^"]*"', "…", message)
    return re.sub(r"-?\b\d+(\.\d+)?(e-?\d+)?\b", "N", message)


def read(path, base, tip, options):
    """Return (the reason of a refusal or None, notes)."""
    try:
        return None, sa.Serial.from_urdf(path, base=base, tip=tip, **options).notes
    except ValueError as error:
        return reason(str(error)), []


def table(heading, counts, of):
    """Print how often each happens."""
    print(f"\n{heading}")
    for what, count in counts.most_common():
        print(f"  {count:5} of {of}  {what}")


def main():
    """Read everything and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("paths", nargs="*", type=Path)
    parser.add_argument("--notes", action="store_true", help="what is noted, too")
    parser.add_argument("--unphysical", metavar="POLICY", help="for links that no body can be")
    arguments = parser.parse_args()
    options = {"unphysical": arguments.unphysical} if arguments.unphysical else {}
    refusals, notes, refused = collections.Counter(), collections.Counter(), {}
    every, total, whole = 0, 0, 0
    for path in files(arguments.paths or [*example_robot_data(), TESTS]):
        results = [read(path, *pair, options) for pair in chains(path)]
        why = [why for why, _ in results if why]
        every += bool(results)
        total += len(results)
        whole += bool(results) and not why
        refusals.update(why)
        if why:
            refused[path.name] = (len(why), len(results))
        for _, said in results:
            notes.update({reason(note) for note in said})
    good = total - sum(refusals.values())
    print(f"chains: {good} of {total} load, {good / max(total, 1):.1%}")
    print(f"files: {whole} of {every} load with all their chains, {whole / max(every, 1):.1%}")
    table("refused, chains by reason:", refusals, total)
    print("\nfiles with refused chains:")
    for name, (count, of) in refused.items():
        print(f"  {name}: {count} of {of}")
    if arguments.notes:
        table("noted, chains by note:", notes, good)


if __name__ == "__main__":
    main()
