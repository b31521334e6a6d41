"""Sessions: each scored sea once, in an order of one's own; a stop, a kill or a second process spoils nothing."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import polars as pl
import pytest
import yaml

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.trials import Trial, read_trial, write_trial
from ssmash_gym.trials.protocol import TrialProtocol, load_protocol
from ssmash_gym.trials.session import LOCK, PARTICIPANT, Assignment, Session
from tests.trials.rig import batch_for, recorded

SMALL: dict[str, Any] = {
    "task": {"horizon_s": 1.0},
    "scenario": "calm",
    "practice": {"least": 2, "most": 3, "plateau": {"last": 2}},
    "scored": {"seas": 4},
}


@pytest.fixture(scope="module")
def protocol() -> TrialProtocol:
    return load_protocol(SMALL)


@pytest.fixture(scope="module")
def batch(protocol: TrialProtocol) -> Any:
    return batch_for(protocol.condition)


def driven(session: Session, batch: Any, *, steps: int = 10, late: int = 0) -> Trial:
    """The trial that comes next, for the whole second or broken off."""
    assignment = session.next()
    assert assignment is not None
    commands = [[0.1 * assignment.number, 0.0]] * steps
    return recorded(
        session.condition, assignment.seed, commands, batch=batch, about=session.about(assignment), late=late
    )


def test_a_session_from_its_start_to_its_end(protocol: TrialProtocol, batch: Any, tmp_path: Path) -> None:
    met: list[Assignment] = []
    with Session.open(protocol, "p01", tmp_path, experience="none") as session:
        while (assignment := session.next()) is not None:
            met.append(assignment)
            session.keep(driven(session, batch))
        with pytest.raises(ConfigurationError, match="the session is done"):
            session.keep(read_trial(tmp_path / "p01" / "007_scored_04.parquet"))
    assert [(a.phase, a.number, a.of) for a in met] == [("practice", k, 3) for k in (1, 2, 3)] + [
        ("scored", k, 4) for k in (1, 2, 3, 4)
    ]
    assert [a.seed for a in met[:3]] == protocol.practice_seeds
    assert [a.seed for a in met[3:]] == protocol.order("p01")
    assert sorted(a.seed for a in met[3:]) == sorted(protocol.scored_seeds)
    document = yaml.safe_load((tmp_path / "p01" / PARTICIPANT).read_text())
    assert set(document) == {"participant", "experience", "protocol", "scored_order", "trials"}
    assert [entry["result"] for entry in document["trials"]] == ["kept"] * 7
    trial = read_trial(tmp_path / "p01" / document["trials"][-1]["file"])
    assert trial.scored and trial.about["participant"] == "p01" and trial.about["experience"] == "none"


def test_orders_differ_and_are_the_same_again(protocol: TrialProtocol) -> None:
    orders = {participant: protocol.order(participant) for participant in ("a", "b", "c", "d", "e")}
    assert len({tuple(order) for order in orders.values()}) > 1
    assert orders["a"] == load_protocol(SMALL).order("a")
    many = load_protocol({**SMALL, "scored": {"seas": 12}})
    assert len({tuple(many.order(f"p{k}")) for k in range(20)}) == 20


def test_practice_and_scored_seas_have_none_in_common() -> None:
    standard, longer = load_protocol(), load_protocol({"practice": {"most": 500}, "scored": {"seas": 500}})
    assert len({*longer.practice_seeds, *longer.scored_seeds}) == 1000
    assert longer.scored_seeds[:12] == standard.scored_seeds
    assert longer.practice_seeds[:20] == standard.practice_seeds


def test_the_plateau() -> None:
    protocol = load_protocol()

    def trials(*times: float, lost: int = -1) -> list[dict[str, Any]]:
        return [{"time_s": t, "reason": "corridor" if k == lost else "goal"} for k, t in enumerate(times)]

    settled = (60.0, 44.0, 45.0, 46.0, 47.0, 48.0)
    assert protocol.practised(trials(*settled))
    assert not protocol.practised(trials(*settled[1:])), "fewer than `least`"
    assert not protocol.practised(trials(*settled, lost=3)), "a lost one among the last"
    assert protocol.practised(trials(*settled, lost=0)), "a lost one before them"
    # mean 46.8: allowed is up to 51.48 s
    assert protocol.practised(trials(60.0, 45.0, 45.0, 46.0, 47.0, 51.0))
    assert not protocol.practised(trials(60.0, 45.0, 45.0, 45.0, 45.0, 53.0))  # mean 46.6: up to 51.26 s
    assert protocol.practised(trials(*range(20, 60, 2)))  # `most` is reached


def test_a_trial_that_was_killed_in_the_middle_leaves_a_trace(
    protocol: TrialProtocol, batch: Any, tmp_path: Path
) -> None:
    """Else a sea could be looked at as often as one likes."""
    with Session.open(protocol, "p03", tmp_path) as session:
        first = session.next()
        assert first is not None
        session.begin(first)
        trial = driven(session, batch)
    for attempt in (2, 2):  # that it was opened again is no attempt
        with Session.open(protocol, "p03", tmp_path) as session:
            again = session.next()
            assert again is not None and (again.seed, again.attempt) == (first.seed, attempt)
            with pytest.raises(ConfigurationError, match="its session is"):
                session.keep(trial)  # it is that of the first attempt
    with Session.open(protocol, "p03", tmp_path) as session:
        session.begin(again)
        session.keep(driven(session, batch))
    document = yaml.safe_load((tmp_path / "p03" / PARTICIPANT).read_text())
    assert [(entry.get("file"), entry["result"]) for entry in document["trials"]] == [
        (None, "incomplete"), ("002_practice_01.parquet", "kept"),
    ]  # fmt: skip
    assert "under_way" not in document


@pytest.mark.parametrize("code", ["1e5", "007", "null", "2026-01-01", "0x10", "on", "-"])
def test_a_code_that_looks_like_something_else_stays_a_code(protocol: TrialProtocol, code: str, tmp_path: Path) -> None:
    for _ in range(2):
        with Session.open(protocol, code, tmp_path, experience=code) as session:
            assert session.record.participant == session.record.experience == code


def test_a_trial_with_nobody_at_the_claw_comes_again(protocol: TrialProtocol, batch: Any, tmp_path: Path) -> None:
    with Session.open(protocol, "p04", tmp_path) as session:
        trial = driven(session, batch)
        away = trial.table.with_columns(driver=pl.when(pl.col("step") == 5).then(pl.lit("none")).otherwise("driver"))
        assert session.keep(Trial(away, trial.about)).name == "001_practice_01_invalid.parquet"
        again = session.next()
        assert again is not None and again.attempt == 2


def test_invalid_and_broken_off_trials_come_again(protocol: TrialProtocol, batch: Any, tmp_path: Path) -> None:
    with Session.open(protocol, "p02", tmp_path) as session:
        first = session.next()
        assert first is not None
        assert session.keep(driven(session, batch, steps=4)).name == "001_practice_01_incomplete.parquet"
        again = session.next()
        assert again is not None and (again.seed, again.number, again.attempt) == (first.seed, 1, 2)
        assert session.keep(driven(session, batch, late=3)).name == "002_practice_01_invalid.parquet"
        for _ in range(3):
            session.keep(driven(session, batch))
        order = protocol.order("p02")
        assert session.keep(driven(session, batch, late=1)).name == "006_scored_01_invalid.parquet"
        met = []
        while (assignment := session.next()) is not None:
            met.append((assignment.seed, assignment.number, assignment.attempt))
            session.keep(driven(session, batch))
    numbered = [(seed, k + 1) for k, seed in enumerate(order)]
    assert met == [(*one, 1) for one in numbered[1:]] + [(*numbered[0], 2)]  # the sea seen before comes last
    scored = [read_trial(path) for path in (tmp_path / "p02").glob("*scored*.parquet")]
    assert sorted(trial.seed for trial in scored if trial.scored) == sorted(order)


def test_a_session_goes_on_after_a_stop(protocol: TrialProtocol, batch: Any, tmp_path: Path) -> None:
    whole, stopped = [], []
    with Session.open(protocol, "p03", tmp_path / "whole") as session:
        while (assignment := session.next()) is not None:
            whole.append(assignment)
            session.keep(driven(session, batch))
    while True:
        with Session.open(protocol, "p03", tmp_path / "stopped") as session:
            if (assignment := session.next()) is None:
                break
            stopped.append(assignment)
            session.keep(driven(session, batch))
    assert stopped == whole
    texts = [(tmp_path / name / "p03" / PARTICIPANT).read_text() for name in ("whole", "stopped")]
    assert texts[0] == texts[1]


def test_a_trial_written_before_a_kill_is_booked(protocol: TrialProtocol, batch: Any, tmp_path: Path) -> None:
    folder = tmp_path / "p04"
    with Session.open(protocol, "p04", tmp_path) as session:
        session.keep(driven(session, batch))
        before = (folder / PARTICIPANT).read_text()
        session.keep(driven(session, batch))
    (folder / PARTICIPANT).write_text(before)  # as if the process had been killed between the two files
    (folder / ".003_practice_03.parquet.abc").write_text("half a file")
    with Session.open(protocol, "p04", tmp_path) as session:
        following = session.next()
        assert following is not None and following.number == 3
    assert "002_practice_02" in (folder / PARTICIPANT).read_text()


def test_a_second_process_is_refused(protocol: TrialProtocol, tmp_path: Path) -> None:
    code = (
        "import sys\nfrom filelock import FileLock\nlock = FileLock(sys.argv[1])\nlock.acquire()\n"
        "print('held', flush=True)\nsys.stdin.read()\n"
    )
    (tmp_path / "p05").mkdir()
    words = [sys.executable, "-c", code, str(tmp_path / "p05" / LOCK)]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None and other.stdout.readline() == "held\n"
        with pytest.raises(ConfigurationError, match="another process has this participant's session open"):
            Session.open(protocol, "p05", tmp_path)
        other.kill()
        other.wait()
        with Session.open(protocol, "p05", tmp_path):  # a dead process holds nothing
            with pytest.raises(ConfigurationError, match="another process"):
                Session.open(protocol, "p05", tmp_path)
            Session.open(protocol, "p06", tmp_path).close()


def test_another_protocol_underneath_is_refused(protocol: TrialProtocol, batch: Any, tmp_path: Path) -> None:
    with Session.open(protocol, "p07", tmp_path) as session:
        session.keep(driven(session, batch))
    before = (tmp_path / "p07" / PARTICIPANT).read_text()
    for other in ({"scored": {"seas": 5}}, {"seed": 1}, {"task": {"horizon_s": 2.0}}, {"late": {"share": 0.5}}):
        with pytest.raises(ConfigurationError, match="begun by another protocol"):
            Session.open(load_protocol({**SMALL, **other}), "p07", tmp_path)
    Session.open(load_protocol({**SMALL, "description": "other words"}), "p07", tmp_path).close()
    assert (tmp_path / "p07" / PARTICIPANT).read_text() == before


@pytest.mark.parametrize(
    "code", ["", "a@b.org", "Jane Doe", "x" * 33, "../p01", "p01/..", "p01\n", "é", ".hidden", "p.1"]
)
def test_what_is_no_code_is_refused(protocol: TrialProtocol, tmp_path: Path, code: str) -> None:
    with pytest.raises(ConfigurationError, match=r"^participant .* is refused: give a code of 1 to 32 letters"):
        Session.open(protocol, code, tmp_path)
    if code:
        with pytest.raises(ConfigurationError, match=r"^experience .* is refused"):
            Session.open(protocol, "p01", tmp_path, experience=code)
    assert not list(tmp_path.iterdir())


def test_a_folder_that_was_tampered_with_is_refused(protocol: TrialProtocol, batch: Any, tmp_path: Path) -> None:
    folder = tmp_path / "p08"
    with Session.open(protocol, "p08", tmp_path, experience="some") as session:
        first = session.keep(driven(session, batch))
        second = session.keep(driven(session, batch))
        with pytest.raises(ConfigurationError, match="a trial is refused: its session is"):
            session.keep(read_trial(first))
    text, content = (folder / PARTICIPANT).read_text(), first.read_bytes()

    def refused(sentence: str, **options: Any) -> None:
        with pytest.raises(ConfigurationError, match=sentence):
            Session.open(protocol, "p08", tmp_path, **options)
        first.write_bytes(content)
        (folder / PARTICIPANT).write_text(text)

    refused("experience 'none' is refused", experience="none")
    (folder / PARTICIPANT).write_text(text.replace(str(protocol.order("p08")[0]), "1"))
    refused("scored_order is not what the protocol gives")
    (folder / PARTICIPANT).write_text(text.replace("p08", "p09"))
    refused("participant is not what the protocol gives")
    (folder / PARTICIPANT).write_text(text.replace("experience: some\n", ""))
    refused("the key experience is missing")
    (folder / PARTICIPANT).write_text(text.replace("001_practice_01.parquet", "../x.parquet"))
    refused("is refused")
    first.write_bytes(content[:-1])
    refused("damaged|no recorded trial")
    first.unlink()
    refused("cannot be read")
    first.write_bytes(second.read_bytes())
    refused("not the trial that was kept here")
    (folder / PARTICIPANT).unlink()
    refused(f"{PARTICIPANT} is missing")
    Session.open(protocol, "p08", tmp_path, experience="some").close()


def test_a_trial_that_is_not_next_is_refused(protocol: TrialProtocol, batch: Any, tmp_path: Path) -> None:
    with Session.open(protocol, "p09", tmp_path) as session:
        assignment = session.next()
        assert assignment is not None
        about = session.about(assignment)
        commands = [[0.1, 0.0]] * 10
        other_seed = recorded(session.condition, assignment.seed + 1, commands, batch=batch, about=about)
        with pytest.raises(ConfigurationError, match="its seed is"):
            session.keep(other_seed)
        stranger = recorded(
            session.condition, assignment.seed, commands, batch=batch, about={**about, "participant": "p10"}
        )
        with pytest.raises(ConfigurationError, match="its participant is 'p10', next is 'p09'"):
            session.keep(stranger)
        write_trial(tmp_path / "p09" / "001_practice_01.parquet", stranger)
    with pytest.raises(ConfigurationError, match="its participant is"):
        Session.open(protocol, "p09", tmp_path)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"practice": {"least": 30}}, "least = 30: must lie between"),
        ({"practice": {"plateau": {"figure": "luck"}}}, "practice.plateau.figure"),
        ({"scored": {"seas": 0}}, "scored.seas"),
        ({"late": {"share": 1.5}}, "late.share"),
        ({"scenario": "ss99"}, "scenarios: there is none called 'ss99'"),
        ({"helicopter": "none"}, "no helicopter"),
        ({"sea": 3}, "there is no key sea"),
    ],
)
def test_a_protocol_that_cannot_be_is_refused(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ConfigurationError, match=sentence):
        load_protocol(changes)
