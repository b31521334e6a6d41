"""Writes the example trials that ship with the package: a session of the scripted operator by the standard protocol.

python tools/example_trials.py

Nobody takes part. Run it again when a change of the simulation's sources or numbers makes the trials come out otherwise
(tests/trials/test_examples.py tells).
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
from pathlib import Path
from typing import Final

from ssmash_gym.progress import progress_bar
from ssmash_gym.training.agent import whole_folder
from ssmash_gym.trials.protocol import load_protocol
from ssmash_gym.trials.scripted import OPERATOR, run_scripted
from ssmash_gym.trials.session import PARTICIPANT, Session
from ssmash_gym.trials.trial import SCORED, Trial

NAME: Final = "scripted_operator"
FOLDER: Final = Path(__file__).parent.parent / "configs" / "trials" / "examples" / NAME
README: Final = """# Example trials: a scripted operator

A session by the standard protocol (`configs/trials/standard.yaml`): {practice} practice trials and {scored} scored
ones, as a person's session would be kept. **No person took part.** The driver is the package's scripted operator model
(`agents/operator.py`: pure delay, gain, lag and dead bands, see docs/guide/baselines.md) in virtual time, and every
file says so: driver `scripted operator`, origin `script`, participant `{name}`. The times in the stamps are virtual.
Nothing here says anything about how people do.

The files are made by `python tools/example_trials.py` and never edited by hand. Simulate them once more, bit for bit:

    ssmash replay configs/trials/examples/{name}

What the columns and keys mean: docs/guide/trials.md.
"""


def main() -> None:
    """Drive the session and put it in the place of the old one."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=FOLDER, help="folder to write")
    out: Path = parser.parse_args().out
    protocol = load_protocol()
    most = protocol.practice.most + protocol.scored.seas
    with tempfile.TemporaryDirectory() as temporary:
        with Session.open(protocol, NAME, temporary, experience="script") as session, progress_bar("trials") as advance:
            done: list[Path] = []

            def told(trial: Trial, path: Path) -> None:
                done.append(path)
                advance(len(done) / most)

            paths = run_scripted(session, OPERATOR, told=told)
        scored = sum(SCORED in path.name for path in paths)
        with whole_folder(out) as folder:
            for path in [*paths, session.folder / PARTICIPANT]:
                shutil.copy(path, folder / path.name)
            text = README.format(name=NAME, practice=len(paths) - scored, scored=scored)
            (folder / "README.md").write_text(text, encoding="utf-8")
    size = sum(path.stat().st_size for path in out.iterdir())
    print(f"{out}: {len(paths)} trials, {size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
