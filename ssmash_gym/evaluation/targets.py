"""The project's aims, checked against a study's figures; each with its figure, whatever it is."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Final

from ssmash_gym.evaluation.figure_text import number
from ssmash_gym.evaluation.study import StudyConfig

REQUIRED_SUCCESS: Final = 0.95  # of all episodes: goal reached, straight, held
SLOWER: Final = 1.10  # of the book's median time, at most
OF_THE_BOOK: Final = 0.30  # of its 95th percentile of the peak load, at most
OF_THE_LAW: Final = 0.75  # of the best law's, with initial yaw
OF_THE_LAW_STRAIGHT: Final = 0.90  # the same, landed straight
COVERED: Final = 0.5  # of the way from the best law to the clairvoyant, at least

HOLDS: Final = "holds"
HOLDS_NOT: Final = "does not hold"
WITHIN: Final = "within the interval"  # above the law's, but not distinguishable from it
NO_DATA: Final = "no data"


@dataclass(frozen=True)
class Check:
    """One aim and what became of it.

    Attributes:
        line: Number of the aim.
        policy, condition: Who, and in which seas.
        statement: What should hold.
        figure: What was found, in a few words.
        verdict: ``holds``, ``does not hold``, ``within the interval`` or ``no data``.
    """

    line: int
    policy: str
    condition: str
    statement: str
    figure: str
    verdict: str


def checked(study: StudyConfig, conditions: Mapping[str, Any], agents: list[str]) -> list[dict[str, Any]]:
    """Check the aims for each agent.

    Args:
        study: Says in which conditions, and which policies are the book, the laws and the clairvoyant.
        conditions: Figures by condition, as in ``summary.json``.
        agents: Names.

    Returns:
        The checks as mappings (see `Check`), in the order of the aims.
    """
    if study.targets is None:
        return []
    found: list[Check] = []
    for agent in agents:
        main = _Place(study.targets.main, agent, conditions)
        found += _success_and_time(main, study.roles.book)
        found.append(_below(main, 1, study.roles.book, OF_THE_BOOK))
        found.append(_below(main, 1, main.law, OF_THE_LAW))
        if study.targets.straight is not None:
            straight = _Place(study.targets.straight, agent, conditions)
            found.append(_below(straight, 2, straight.law, OF_THE_LAW_STRAIGHT))
        found.append(_gap(main))
        found += _nothing_traded(main)
    return [asdict(check) for check in found]


def sentences(checks: list[dict[str, Any]]) -> list[str]:
    """The checks, a sentence each."""
    return [
        f"{check['line']}. {check['policy']} in {check['condition']}: {check['statement']}: {check['figure']}: "
        f"{check['verdict']}"
        for check in checks
    ]


class _Place:
    """Figures of one agent in one condition."""

    def __init__(self, condition: str, agent: str, conditions: Mapping[str, Any]) -> None:
        self.condition, self.agent = condition, agent
        here = conditions.get(condition, {})
        self.own = here.get("policies", {}).get(agent)
        self.law: str | None = here.get("best_law", {}).get(agent)
        self.gap = here.get("gap", {}).get(agent)
        self.pairs = {pair["other"]: pair for pair in here.get("pairs", ()) if pair["policy"] == agent}

    def check(self, line: int, statement: str, figure: str, verdict: str | bool) -> Check:
        told = (HOLDS if verdict else HOLDS_NOT) if isinstance(verdict, bool) else verdict
        return Check(line, self.agent, self.condition, statement, figure, told)

    def nothing(self, line: int, statement: str, why: str) -> Check:
        return self.check(line, statement, why, NO_DATA)


def _success_and_time(place: _Place, book: str) -> list[Check]:
    aligned = f"at least {100 * REQUIRED_SUCCESS:g} % of the episodes succeed, aligned"
    in_time = f"median time at most {100 * SLOWER:g} % of that of {book}"
    if place.own is None:
        return [place.nothing(1, statement, "not run") for statement in (aligned, in_time)]
    success = place.own["success"]
    found = [place.check(1, aligned, _percent(success), success["value"] >= REQUIRED_SUCCESS)]
    if book not in place.pairs:
        return [*found, place.nothing(1, in_time, f"{book} was not run")]
    if not success["value"]:
        return [*found, place.nothing(1, in_time, "no episode succeeded")]
    times = place.pairs[book]["time_ratio"]
    median = f"{place.own['time_s']['value']:.1f} s, {_percent(times)}"
    return [*found, place.check(1, in_time, median, times["value"] is not None and times["value"] <= SLOWER)]


def _below(place: _Place, line: int, other: str | None, most: float) -> Check:
    """P95 of the peak load against another policy's: far enough below, and the difference's interval below zero."""
    statement = f"P95 of the peak load at least {100 * (1.0 - most):.0f} % below that of {other or 'the best law'}"
    if place.own is None or other not in place.pairs:
        return place.nothing(line, statement, "not run")
    pair = place.pairs[other]
    own, theirs = (pair[key]["value"] for key in ("p95_kN", "other_p95_kN"))
    difference = pair["p95_difference_kN"]
    told = (
        f"{own:.1f} against {theirs:.1f} kN, {_percent(pair['p95_ratio'])} of it, difference {_number(difference)} kN"
    )
    apart = difference["ci"] is not None and difference["ci"][1] < 0.0
    ratio = pair["p95_ratio"]["value"]
    return place.check(line, statement, told, ratio is not None and ratio <= most and apart)


def _gap(place: _Place) -> Check:
    statement = f"at least {100 * COVERED:g} % of the way from the best law's mean peak to the clairvoyant's covered"
    if place.gap is None:
        return place.nothing(3, statement, "not run")
    if place.gap["mean"]["value"] is None:
        return place.nothing(3, statement, f"the clairvoyant's mean peak is not below that of {place.gap['law']}")
    told = f"{_percent(place.gap['mean'])} from {place.gap['law']} in {place.gap['seas']} seas"
    if place.gap["p95"]["value"] is not None:
        told += f" (by P95 {_percent(place.gap['p95'])})"
    return place.check(3, statement, told, place.gap["mean"]["value"] >= COVERED)


def _nothing_traded(place: _Place) -> list[Check]:
    """Tire loads, lift-offs and the corridor: not above the law's."""
    kinds = (
        ("main_p95_difference_kN", "P95 of the main tires' peak load", "kN", 1.0),
        ("lift_offs_difference", "lift-offs an episode", "", 1.0),
        ("corridor_difference", "share of episodes beyond the corridor", "%", 100.0),
    )
    found = []
    for key, what, unit, factor in kinds:
        statement = f"{what} not above that of {place.law or 'the best law'}"
        if place.own is None or place.law not in place.pairs:
            found.append(place.nothing(4, statement, "not run"))
            continue
        difference = place.pairs[place.law][key]
        verdict: str | bool = difference["value"] <= 0.0
        if not verdict and difference["ci"] is not None and difference["ci"][0] <= 0.0:
            verdict = WITHIN
        told = f"difference {_number(difference, 2, factor=factor)} {unit}".rstrip()
        # Who fails early has no time to load anything.
        if verdict and place.own["success"]["value"] < REQUIRED_SUCCESS:
            verdict, told = NO_DATA, f"{told}, too few successes to say"
        found.append(place.check(4, statement, told, verdict))
    return found


def _percent(figure: Mapping[str, Any]) -> str:
    return f"{_number(figure, factor=100.0)} %"


_number = functools.partial(number, none="none")
