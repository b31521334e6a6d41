"""Files of trials: Parquet with a seal over every byte, written whole or not at all.

The seal is the SHA-256 of the whole file, computed with 64 zeros in its own place in the file's key-value metadata. It
finds damage: a flipped byte anywhere (its own digits included), a missing or an additional end. It is no signature: who
wants to forge a file can seal it again; what the forgery claims must then still come out of the replay.
"""

from __future__ import annotations

import hashlib
import io
import json
import re
from pathlib import Path
from typing import Any, Final

import polars as pl

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.files import whole_file
from ssmash_gym.trials.trial import FORMAT, KIND, Trial, checked

SEAL: Final = "ssmash_gym.seal"
ABOUT: Final = "ssmash_gym.trial"
VERSION: Final = "ssmash_gym.version"
ZEROS: Final = b"0" * 64
MAGIC: Final = b"PAR1"
# The key, how Parquet announces a text of 64 bytes behind it, and the digits. JSON text holds no such bytes.
_PLACE: Final = re.compile(re.escape(SEAL.encode()) + rb"\x18\x40([0-9a-f]{64})")


def write_trial(path: str | Path, trial: Trial) -> None:
    """Write a trial's file, whole or not at all.

    Args:
        path: File to write; its folder is made.
        trial: The trial.
    """
    metadata = {
        VERSION: str(trial.about["version"]),
        ABOUT: json.dumps(trial.about, separators=(",", ":")),
        SEAL: ZEROS.decode(),
    }
    buffer = io.BytesIO()
    trial.table.write_parquet(buffer, compression_level=22, statistics=False, metadata=metadata)
    sealed = _sealed(buffer.getvalue())
    with whole_file(path) as temporary:
        temporary.write_bytes(sealed)


def _sealed(content: bytes) -> bytes:
    """The content with its digest in the place of the zeros."""
    places = list(_PLACE.finditer(content))
    if len(places) != 1 or places[0][1] != ZEROS:
        raise RuntimeError(f"a file of a trial has {len(places)} places for its seal, must be 1")
    start, end = places[0].span(1)
    return content[:start] + hashlib.sha256(content).hexdigest().encode() + content[end:]


def read_trial(path: str | Path) -> Trial:
    """Read a trial's file.

    Raises:
        ConfigurationError: There is none, it is no trial, it is damaged, or a newer version has written it; one
            sentence.
    """
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise ConfigurationError(
            f"{path}: the file cannot be read ({(error.strerror or str(error)).lower()})."
        ) from None
    return trial_of(content, str(path))


def trial_of(content: bytes, source: str) -> Trial:
    """The trial in the bytes of its file.

    Args:
        content: All of them.
        source: Their name in messages.

    Raises:
        ConfigurationError: They are no trial, damaged, or written by a newer version; one sentence.
    """
    _check_seal(source, content)
    try:
        about: dict[str, Any] = json.loads(pl.read_parquet_metadata(io.BytesIO(content))[ABOUT])
        kind, number = about["kind"], int(about["format"])
    except (KeyError, TypeError, ValueError, pl.exceptions.PolarsError):
        raise ConfigurationError(f"{source}: this is no recorded trial.") from None
    if kind != KIND:
        raise ConfigurationError(f"{source}: this is no recorded trial.")
    if number != FORMAT:
        remedy = "; a newer ssmash_gym has written it: update" if number > FORMAT else ""
        raise ConfigurationError(f"{source}: format {number} is unknown, this version reads {FORMAT}{remedy}.")
    try:
        return checked(Trial(pl.read_parquet(io.BytesIO(content)), about))
    except ConfigurationError as error:
        raise ConfigurationError(f"{source}: this is no recorded trial: {error}") from None


def _check_seal(path: str | Path, content: bytes) -> None:
    """Refuse content whose digest is not the one that it holds."""
    places = list(_PLACE.finditer(content))
    if not places and SEAL.encode() not in content and ABOUT.encode() not in content:
        whole = content[:4] == MAGIC or content[-4:] == MAGIC
        what = "this is no recorded trial, or its end is missing" if whole else "this is no recorded trial"
        raise ConfigurationError(f"{path}: {what}.")
    if len(places) == 1:
        start, end = places[0].span(1)
        if hashlib.sha256(content[:start] + ZEROS + content[end:]).hexdigest().encode() == places[0][1]:
            return
    raise ConfigurationError(f"{path}: the file is damaged: its seal does not fit its contents.")


def read_trials(folder: str | Path) -> list[tuple[Path, Trial]]:
    """The trials of a folder and of the folders in it, in the order of their paths.

    Raises:
        ConfigurationError: There is no such folder, no trial in it, or one cannot be read.
    """
    paths = trial_paths(folder)
    if not paths:
        raise ConfigurationError(f"{folder}: there is no recorded trial in this folder.")
    return [(path, read_trial(path)) for path in paths]


def trial_paths(folder: str | Path) -> list[Path]:
    """The Parquet files of a folder and of the folders in it, in order; hidden ones are left out.

    Raises:
        ConfigurationError: There is no such folder.
    """
    root = Path(folder)
    if not root.is_dir():
        raise ConfigurationError(f"{folder}: there is no such folder.")
    return sorted(path for path in root.rglob("*.parquet") if not path.name.startswith("."))
