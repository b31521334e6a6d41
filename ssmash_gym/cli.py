"""`ssmash <verb>`: the table of what the project does from the command line.

Nothing heavy is imported before a verb is chosen, so `ssmash --help` answers at once.
"""

from __future__ import annotations

import contextlib
import functools
import io
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Final

MISREAD: Final = 2  # words that no verb or option goes by, or values that cannot be read
INTERRUPTED: Final = 130  # what shells report after Ctrl-C


class Misread(Exception):
    """Words of the command line that cannot be read, in one sentence."""


@dataclass(frozen=True)
class Verb:
    """One line of the table.

    Args:
        summary: What the verb does, in one line.
        function: Where its function is, as ``module:name``; tyro makes its options from the signature.
    """

    summary: str
    function: str


VERBS = {
    "console": Verb("Drive the claw yourself, on a page in the browser", "ssmash_gym.console.verb:console"),
    "trial": Verb("A participant's session: practice, then scored seas", "ssmash_gym.console.verb:trial"),
    "replay": Verb("Simulate recorded trials once more, bit for bit; film one", "ssmash_gym.trials.verbs:replay_files"),
    "view": Verb("Show recordings in 3-D, several over one another", "ssmash_gym.console.view_verb:view"),
    "benchmark": Verb(
        "Compare recorded trials with policies and agents in the same seas", "ssmash_gym.benchmark.verb:benchmark"
    ),
    "export": Verb("Write trials or a policy's episodes as a Minari dataset", "ssmash_gym.trials.export:export"),
    "clone": Verb("Train an agent on recorded trials: behaviour cloning", "ssmash_gym.agents.cloning:clone"),
    "train": Verb("Train an agent from one YAML file; resume a run", "ssmash_gym.agents.training:train"),
    "evaluate": Verb("Compare an agent with the baselines on frozen seeds", "ssmash_gym.agents.evaluation:evaluate"),
    "ship": Verb("Make a folder of a trained agent that can be given away", "ssmash_gym.training.ship:ship"),
    "window": Verb("Sweep seas, courses and speeds: where limits are kept", "ssmash_gym.windows.verb:window"),
    "film": Verb("Film a sea of a study, driven by several side by side", "ssmash_gym.evaluation.film_study:film"),
    "simulate": Verb("Run one helicopter on a moving deck and record it", "ssmash_gym.simulate:simulate"),
    "run": Verb("Run a case: the thesis' input files, or a case in YAML", "ssmash_gym.thesis_files.verbs:run"),
    "convert": Verb("Turn the thesis' input files into YAML, and back", "ssmash_gym.thesis_files.verbs:convert"),
    "verify": Verb(
        "Show Table 3.1 of the thesis beside the simulation", "ssmash_gym.analysis.verification.verbs:verify"
    ),
    "identify": Verb(
        "Refit the generic tricycle to Table 3.1 and write its file", "ssmash_gym.analysis.verification.verbs:identify"
    ),
    "manoeuvre": Verb(
        "Replay the thesis' validation manoeuvres: figures, statements",
        "ssmash_gym.analysis.validation.verbs:manoeuvre",
    ),
    "systems": Verb(
        "Run a case through the other systems of the thesis: picture, table", "ssmash_gym.systems.verbs:systems"
    ),
    "ship-motion": Verb(
        "Write a ship's motion in a seaway: record, figures, picture", "ssmash_gym.ship_motion:ship_motion"
    ),
    "monitor": Verb(
        "Watch a deck's motion: margin, next quiet window, risk of starting now", "ssmash_gym.monitor.verb:monitor"
    ),
    "info": Verb("Show versions, the kernel cache and the catalogue", "ssmash_gym.info:info"),
}


def contents() -> str:
    """The text of `ssmash --help`."""
    width = max(map(len, VERBS))
    lines = [f"  {name:<{width}}  {verb.summary}" for name, verb in VERBS.items()]
    return "\n".join(["usage: ssmash VERB [options]", "", *lines, "", "`ssmash VERB --help` lists a verb's options."])


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb.

    Args:
        arguments: Words after `ssmash`; those of the command line by default.

    Returns:
        The exit status: 0 done, 1 the user's mistake told in one sentence, 2 the same of words that cannot be read
        (no such verb or option, letters for a number), 130 stopped by Ctrl-C.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    if not words or words[0] in ("-h", "--help", "help"):
        print(contents())
        return 0
    name, *rest = words
    if name not in VERBS:
        print(f"ssmash has no verb {name!r}; it has {', '.join(VERBS)}.", file=sys.stderr)
        return MISREAD
    return _run(name, rest)


def _run(name: str, rest: Sequence[str]) -> int:
    """Import the verb's function and call it with its options; a user's mistake becomes one line."""
    from ssmash_gym.errors import ConfigurationError, SolverError

    module, attribute = VERBS[name].function.split(":")
    try:
        _call(getattr(import_module(module), attribute), name, rest)()
    except Misread as mistake:
        print(f"ssmash {name}: {mistake} (`ssmash {name} --help` lists the options)", file=sys.stderr)
        return MISREAD
    except (ConfigurationError, SolverError, ImportError) as mistake:
        print(f"ssmash {name}: {mistake}", file=sys.stderr)
        return 1
    except OSError as refusal:
        print(f"ssmash {name}: {_of_the_system(refusal)}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print(f"ssmash {name}: stopped.", file=sys.stderr)
        return INTERRUPTED
    return 0


def _of_the_system(refusal: OSError) -> str:
    """What the operating system refuses, as a sentence: which file or folder, and why."""
    if refusal.filename is None or refusal.strerror is None:
        return str(refusal)
    return f"{refusal.filename}: cannot be read or written ({refusal.strerror.lower()})."


def _call(function: Callable[..., None], name: str, rest: Sequence[str]) -> Callable[[], None]:
    """The call that the words after a verb stand for.

    Raises:
        Misread: The words cannot be read.
        SystemExit: The help was asked for and has been printed.
    """
    import tyro

    @functools.wraps(function)
    def later(*values: Any, **options: Any) -> Callable[[], None]:
        return functools.partial(function, *values, **options)

    box = io.StringIO()
    try:
        with contextlib.redirect_stderr(box):
            return tyro.cli(later, prog=f"ssmash {name}", args=rest)
    except SystemExit as leaving:
        if not leaving.code:
            raise
        raise Misread(_first_words(box.getvalue())) from None


def _first_words(box: str) -> str:
    """What stands in a box of several lines between its title and the first rule, as one line."""
    lines = [line.strip(" │") for line in box.splitlines()[1:]]
    rule = next((k for k, line in enumerate(lines) if line.startswith(("─", "╰"))), len(lines))
    told = " ".join(" ".join(lines[:rule]).split()).split(". Got errors")[0]  # each of several readings has failed
    return told.rstrip(".") or "the options cannot be read"
