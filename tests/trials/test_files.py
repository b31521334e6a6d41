"""Files of trials: what is read is what was written, and no damage passes."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path

import polars as pl
import pytest

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.trials import Trial, read_trial, read_trials, write_trial
from ssmash_gym.trials.files import trial_of
from tests.trials.rig import condition, recorded

DAMAGED = "the file is damaged|no recorded trial"


@pytest.fixture(scope="module")
def trial() -> Trial:
    return recorded(condition("calm"), 3, [[0.5, 0.1]] * 4)


@pytest.fixture
def path(trial: Trial, tmp_path: Path) -> Path:
    write_trial(tmp_path / "trial.parquet", trial)
    return tmp_path / "trial.parquet"


def test_what_is_read_is_what_was_written(trial: Trial, path: Path) -> None:
    again = read_trial(path)
    assert again.table.equals(trial.table, null_equal=True) and again.table.schema == trial.table.schema
    assert again.about == trial.about
    assert [p.name for p in path.parent.iterdir()] == ["trial.parquet"]
    assert [found[0] for found in read_trials(path.parent)] == [path]


def test_every_flipped_byte_is_found(path: Path) -> None:
    content = path.read_bytes()
    for k in range(len(content)):
        flipped = content[:k] + bytes([content[k] ^ 1 << k % 8]) + content[k + 1 :]
        with pytest.raises(ConfigurationError, match=DAMAGED):
            trial_of(flipped, "broken")


def test_every_bit_of_the_seal_counts(path: Path) -> None:
    content = path.read_bytes()
    start = content.index(b"ssmash_gym.seal")
    for k in range(start - 2, start + len(b"ssmash_gym.seal") + 70):
        for bit in range(8):
            flipped = content[:k] + bytes([content[k] ^ 1 << bit]) + content[k + 1 :]
            with pytest.raises(ConfigurationError, match=DAMAGED):
                trial_of(flipped, "broken")


def test_a_cut_or_longer_file_is_found(path: Path, tmp_path: Path) -> None:
    content = path.read_bytes()
    broken = tmp_path / "broken.parquet"
    for other in [content[:k] for k in range(0, len(content), 37)] + [content[1:], content + b"\0", content + content]:
        broken.write_bytes(other)
        with pytest.raises(ConfigurationError, match=DAMAGED):
            read_trial(broken)


def test_another_seal_does_not_fit(trial: Trial, path: Path, tmp_path: Path) -> None:
    write_trial(tmp_path / "other.parquet", replace(trial, about={**trial.about, "seed": 4}))
    own, other = path.read_bytes(), (tmp_path / "other.parquet").read_bytes()
    at = len(b"ssmash_gym.seal") + 2
    a, b = own.index(b"ssmash_gym.seal") + at, other.index(b"ssmash_gym.seal") + at
    for digest in (other[b : b + 64], b"0" * 64, hashlib.sha256(own).hexdigest().encode(), own[a : a + 64].upper()):
        (tmp_path / "swapped.parquet").write_bytes(own[:a] + digest + own[a + 64 :])
        with pytest.raises(ConfigurationError, match="damaged"):
            read_trial(tmp_path / "swapped.parquet")


def test_zeros_elsewhere_in_the_file_are_no_seal(trial: Trial, tmp_path: Path) -> None:
    zeros = replace(trial, about={**trial.about, "participant": "ssmash_gym.seal" + "0" * 64})
    write_trial(tmp_path / "zeros.parquet", zeros)
    assert read_trial(tmp_path / "zeros.parquet").about["participant"].endswith("0" * 64)


def test_other_files_are_refused_in_one_sentence(trial: Trial, tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="cannot be read"):
        read_trial(tmp_path / "none.parquet")
    with pytest.raises(ConfigurationError, match="cannot be read"):
        read_trial(tmp_path)
    with pytest.raises(ConfigurationError, match="no recorded trial in this folder"):
        read_trials(tmp_path)
    with pytest.raises(ConfigurationError, match="no such folder"):
        read_trials(tmp_path / "none")
    (tmp_path / "text.parquet").write_text("hello")
    with pytest.raises(ConfigurationError, match=r"this is no recorded trial\.$"):
        read_trial(tmp_path / "text.parquet")
    trial.table.write_parquet(tmp_path / "plain.parquet")
    with pytest.raises(ConfigurationError, match="no recorded trial"):
        read_trial(tmp_path / "plain.parquet")
    write_trial(tmp_path / "newer.parquet", replace(trial, about={**trial.about, "format": 2}))
    with pytest.raises(ConfigurationError, match=r"format 2 is unknown, this version reads 1; a newer"):
        read_trial(tmp_path / "newer.parquet")
    for name, about, sentence in (
        ("kind", {"kind": "poem"}, r"no recorded trial\.$"),
        ("timing", {"timing": {}}, "the key timing.interval_s is missing"),
    ):
        write_trial(tmp_path / f"{name}.parquet", replace(trial, about={**trial.about, **about}))
        with pytest.raises(ConfigurationError, match=sentence):
            read_trial(tmp_path / f"{name}.parquet")
    wild = trial.table.with_columns(command_along=pl.Series([0.0, float("nan"), 0.0, 0.0]))
    write_trial(tmp_path / "wild.parquet", replace(trial, table=wild))
    with pytest.raises(ConfigurationError, match="a command is not within -1 to 1"):
        read_trial(tmp_path / "wild.parquet")
    write_trial(tmp_path / "short.parquet", replace(trial, table=trial.table.drop("reward")))
    with pytest.raises(ConfigurationError, match="the column reward is missing"):
        read_trial(tmp_path / "short.parquet")
