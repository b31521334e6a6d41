"""`ssmash ship-motion` as the tests call it: a short record, its head, and the sea it is drawn from."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ssmash_gym.cli import main
from ssmash_gym.ship.config import parse_motion
from ssmash_gym.ship.seaway import Seaway

SHORT = ["--duration", "30", "--dt", "0.1", "--components", "32"]
BEAM = {"type": "seaway", "sea_state": 5, "heading_deg": 90.0, "speed_kn": 10.0}


def run(*words: str | Path) -> int:
    return main(["ship-motion", *map(str, words)])


def head(path: Path) -> dict[str, str]:
    """The comment lines of a record: what stands before and after their first colon."""
    lines = [line[2:] for line in path.read_text().splitlines() if line.startswith("# ")]
    return dict(line.partition(": ")[::2] for line in lines)


def sea(**changes: Any) -> Seaway:
    source = parse_motion({**BEAM, **changes})
    assert isinstance(source, Seaway)
    return source
