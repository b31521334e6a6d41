"""What a study's page says in words: the answer, the main figures, and what does not follow from them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from ssmash_gym import __version__
from ssmash_gym.evaluation.page_data import AGENT, StudyData
from ssmash_gym.evaluation.page_tables import DASH, number
from ssmash_gym.evaluation.targets import HOLDS, HOLDS_NOT, NO_DATA, WITHIN

QUESTION: Final = (
    "Can a policy bring the helicopter along the track into the hangar, straight and no slower, with lower peak probe "
    "loads than driving by the book, and than the best law tuned by hand or search?"
)
COUNTED: Final = (  # verdict, and how one or several are told
    (HOLDS, "holds", "hold"),
    (HOLDS_NOT, "does not", "do not"),
    (WITHIN, "cannot be told apart from the law", "cannot be told apart from the law"),
    (NO_DATA, "has no data", "have no data"),
)


@dataclass(frozen=True)
class Card:
    """One main figure, large, and what it is."""

    figure: str
    words: str


def facts(data: StudyData) -> list[tuple[str, str]]:
    """What identifies the data: below the title."""
    episodes = sum(frame.height for frame in data.rows.frames.values())
    return [
        ("data of", data.date),
        ("ssmash_gym", str(data.document["versions"]["ssmash_gym"])),
        ("configuration", str(data.document["configuration"])),
        ("seed of the seas", str(data.document["seed"])),
        ("seas", f"{data.rows.seas(data.main, data.first).size} in {data.main}"),
        ("conditions", str(len(data.conditions))),
        ("policies", str(len(data.policies))),
        ("episodes", f"{episodes:,}"),
    ]


def answer(data: StudyData) -> list[str]:
    """Sentences with the main figures, whatever they are."""
    own = data.of(data.main, data.first)
    if own is None:
        return [f"{data.first} has not been run in {data.main}: there is no answer yet."]
    told = []
    if data.kind(data.first) != AGENT:
        told.append("No trained agent takes part: these are figures of scripted policies.")
    success, load = own["success"], own["peak_probe_kN"]["p95"]
    told.append(
        f"{data.first} in {data.main}: {number(100 * success['value'])} %{_interval(success, 100)} of "
        f"{own['episodes']} episodes end in the hangar position, straight and held; 95 % of the peak probe loads lie "
        f"below {number(load['value'])}{_interval(load)} kN; median time {number(own['time_s']['value'])} s."
    )
    against = [
        f"{_less(pair['p95_ratio'])} that of {pair['other']}" for pair in _beside(data) if pair["p95_ratio"]["value"]
    ]
    if against:
        told.append(f"In the same seas, this P95 is {' and '.join(against)}.")
    checks = [one["verdict"] for one in data.summary.get("targets", ()) if one["policy"] == data.first]
    parts = [
        f"{checks.count(verdict)} {one if checks.count(verdict) == 1 else many}"
        for verdict, one, many in COUNTED
        if verdict in checks
    ]
    if parts:
        told.append(f"Of the {len(checks)} checks of the aims below, {', '.join(parts)}.")
    return told


def _interval(figure: Mapping[str, Any], factor: float = 1.0, digits: int = 1) -> str:
    if not figure.get("ci"):
        return ""
    low, high = (number(factor * bound, digits) for bound in figure["ci"])
    return f" [{low}, {high}]"


def _beside(data: StudyData) -> list[Mapping[str, Any]]:
    """The first policy beside the book and beside the best law."""
    others = [other for other in (data.config.roles.book, data.law) if other and other != data.first]
    pairs = (data.pair(data.main, data.first, other) for other in others)
    return [pair for pair in pairs if pair is not None]


def _less(ratio: Mapping[str, Any], digits: int = 0) -> str:
    """A ratio as so many percent below or above, with its interval."""
    side, factor = ("below", -100.0) if ratio["value"] <= 1.0 else ("above", 100.0)
    bounds = sorted(factor * (bound - 1.0) for bound in ratio["ci"]) if ratio.get("ci") else []
    interval = f" [{number(bounds[0], digits)}, {number(bounds[1], digits)}]" if bounds else ""
    return f"{number(factor * (ratio['value'] - 1.0), digits)} %{interval} {side}"


def cards(data: StudyData) -> list[Card]:
    """The main figures."""
    own = data.of(data.main, data.first)
    if own is None:
        return []
    load, success = own["peak_probe_kN"]["p95"]["value"], own["success"]["value"]
    found = [
        Card(f"{number(load)} kN", f"P95 of the peak probe load, {data.first} in {data.main}"),
        Card(f"{number(100 * success)} %", "of the episodes succeed, aligned and held"),
    ]
    for pair in (one for one in _beside(data) if one["p95_ratio"]["value"] is not None):
        theirs = data.of(data.main, pair["other"]) or {}
        same = theirs.get("seas") == pair["seas"] == own["seas"]
        load_kN = f" ({number(theirs['peak_probe_kN']['p95']['value'])} kN)" if same else ""
        change = number(100.0 * (pair["p95_ratio"]["value"] - 1.0), 0, sign=True)
        found.append(Card(f"{change} %", f"P95 against {pair['other']}{load_kN} in the same {pair['seas']} seas"))
    gap = data.figures(data.main).get("gap", {}).get(data.first)
    if gap and gap["mean"]["value"] is not None:
        words = f"of the way from {gap['law']} to {gap['clairvoyant']}, by mean peak load"
        found.append(Card(f"{number(100 * gap['mean']['value'], 0)} %", words))
    return found


def tables_words(data: StudyData) -> str:
    """How the numbers of the tables are made."""
    resamples, level = data.summary.get("resamples"), data.summary.get("level", 0.95)
    return (
        f"In brackets: {100 * level:g} % intervals (shares of scripted policies: Wilson's; all else: bootstrap of "
        f"{resamples or DASH} resamples over seas and, where there are several, training seeds). A failed episode "
        f"counts with the probe's ultimate load of {data.limit('probe_ultimate_kN'):g} kN. IQM: interquartile mean. "
        "Aligned: ended straight and on the centre line. Time: of the successes; of all episodes where there is none. "
        f"Beyond holding: less {data.config.roles.hold} in the same sea."
    )


def says_not(data: StudyData) -> list[str]:
    """The limits of the study."""
    section = data.document["conditions"][data.main]
    ship = section["scenario"].get("motion", {}).get("ship", "the ship")
    vehicle = section["helicopter"].get("name") or data.config.helicopter
    beyond = 1.0 - data.values(data.main, data.first, "within_validity").mean()
    told = [
        "No operational limit follows from these figures. They are of a model on assumed numbers, not of a ship: "
        "nothing here may be used to decide on a real deck.",
        f"The task is assumed: track, speeds, goal, cost limit ({data.limit('probe_in_plane_kN'):g} kN) and ultimate "
        f"load ({data.limit('probe_ultimate_kN'):g} kN) have no public operational source; neither have the ranges of "
        "seas, courses, speeds, landing poses, noise and delay.",
        f"One helicopter ({vehicle}) and one ship ({ship if isinstance(ship, str) else 'described in the scenario'}): "
        "how far the order of the policies carries over to others is unknown.",
        f"The ship's motion is linear in the waves; in {number(100 * beyond)} % of the episodes of {data.main} the "
        "ship rolls more than that model bears.",
        "No person took part: scripted policies and models of operators are not human operators.",
        "The intervals say how much the draw of the seas (and of training seeds) matters. They say nothing of errors "
        "of the model, which are common to all policies.",
        "The best law is chosen by the same episodes in which it is then compared, which is to its advantage.",
    ]
    clairvoyant = data.config.roles.clairvoyant
    if clairvoyant in data.policies:
        told.append(
            f"{clairvoyant} knows the deck's future and searches for a limited time: an estimate of what could be "
            "reached, no bound and no policy that could be used."
        )
    return told


def made(data: StudyData) -> str:
    """Where the page comes from."""
    states, versions = data.summary.get("code_states", 1), data.document["versions"]
    mixed = "" if states == 1 else f" The rows were made by {states} states of the code."
    return (
        f"Study “{data.name}”, configuration {data.document['configuration']}, code {versions.get('code', DASH)}, "
        f"made by ssmash_gym {versions['ssmash_gym']}; page written by ssmash_gym {__version__}. Episode seeds: up "
        f"to {data.config.episodes} of block {data.document['seed']} for evaluation, which no training or tuning "
        f"draws from; they stand in rows/*.parquet with every figure of every episode.{mixed}"
    )
