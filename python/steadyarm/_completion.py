"""The command ``steadyarm completion``: the script with which a shell completes this command.

shtab writes it, from the parser itself: no option is listed a second time. What stands for a file,
a SOURCE or a law is told by its metavar.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from . import laws
from ._extras import imported
from ._options import Parser, command
from ._sections import arm_names
from ._streams import say
from .bench import scenario_names

if TYPE_CHECKING:
    from ._options import Commands

SHELLS = ("bash", "zsh", "fish")


def add_completion(commands: Commands, parser: Callable[[], Parser]) -> None:
    """Add the command; ``parser`` makes the one that is completed."""
    added = command(
        commands,
        "completion",
        "the script with which bash, zsh or fish completes commands, options, names, files",
        "Print the script with which a shell completes commands, options, the names of robots,\n"
        'scenarios and laws, and files. It is made by shtab: pip install "steadyarm[completion]".\n'
        "It is needed to print the script alone, and not to complete.",
        lambda arguments: _completion(arguments, parser()),
        examples="  mkdir -p ~/.local/share/bash-completion/completions\n"
        "  steadyarm completion bash > ~/.local/share/bash-completion/completions/steadyarm\n"
        "  steadyarm completion zsh > ~/.zfunc/_steadyarm  # fpath+=~/.zfunc before compinit\n"
        "  steadyarm completion fish > ~/.config/fish/completions/steadyarm.fish",
    )
    added.add_argument("shell", choices=SHELLS)


def _completion(arguments: argparse.Namespace, parser: Parser) -> int:
    shtab = imported("shtab", "completion")
    for each in _parsers(parser):
        for action in each._actions:
            complete = _completed(shtab, action)
            if complete is not None:
                action.complete = complete  # type: ignore[attr-defined]
    say(shtab.complete(parser, arguments.shell).rstrip())
    return 0


def _parsers(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """The parser, and those of the commands, each described in a line as a menu wants it."""
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for choice in action._choices_actions:
                each = action.choices[choice.dest]
                each.description = choice.help
                yield each


def _completed(shtab: Any, action: argparse.Action) -> Any:
    """What stands for the value of an option: files, names; None: what argparse knows."""
    metavar = str(action.metavar)
    if metavar.startswith("FILE"):
        return shtab.FILE
    if metavar == "DIR":
        return shtab.DIRECTORY
    if metavar == "SOURCE":
        return _words("_steadyarm_source_file", [*arm_names(), *scenario_names()], files=True)
    if action.dest in ("controller", "only"):
        return _words("_steadyarm_law", ["recommended", *laws.__all__])
    return None


def _words(name: str, words: list[str], files: bool = False) -> dict[str, Any]:
    """A function of this name in each shell that completes words, and files too."""
    listed = " ".join(words)
    bash = f'  compgen -W "{listed}" -- "$1"\n' + '  compgen -f -- "$1"\n' * files
    zsh = f'  _alternative "names:name:({listed})"' + ' "files:file:_files"' * files
    return {
        "bash": name,
        "zsh": name,
        "fish": f"{listed} (__fish_complete_path)" if files else listed,
        "preamble": {
            "bash": f"{name}() {{\n{bash}}}",
            "zsh": f"{name}() {{\n{zsh}\n}}",
        },
    }
