"""What a benchmark's page says in plain words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

from ssmash_gym.benchmark.figures import PEOPLE, SCRIPTED

MOST_NAMED: Final = 4  # recorded drivers in headings and figures of episodes; of more, the pools
FAIR: Final = (
    "No comparison between people and programs is completely fair (Canaan et al. 2019, arXiv 1903.07008). This is what "
    "differs here:"
)
UNEQUAL: Final = (
    "What is seen. A person sees a picture and gauges; a program reads the simulated sensors, or what else its task "
    "lists. No program here is restricted to what the screen shows, so there is one column of figures, that with all "
    "of its observation; a second one with what is displayed only would need programs made for it.",
    "When it is seen. A person answers after some tenths of a second, and the page adds the wait for the next control "
    "step. A program answers within the step. The added delays make its commands act later by a fixed time; they do "
    "not make it a person, whose delay varies and who looks ahead. The programs were not told of it, "
    "except that a planner's copies of the simulation hold it.",
    "What speed is worth. A program that wins by answering faster than anybody can has shown speed, no better judgment "
    "(Madan 2020); hence the columns with delays.",
    "Practice. A program may have been trained or tuned for millions of control steps in seas of the same kind; a "
    "person has had the practice trials shown below.",
    "Time. Who drives slower loads the probe less. Hence no peak load without its time beside it.",
    "The stake. Nobody is hurt and nothing breaks in a simulation, which changes how people drive.",
    "The model. Loads are those of a model with assumed numbers, the same for all; it says nothing about a real ship.",
)
ONLY_SCRIPTED: Final = (
    "All recorded trials were driven by a script (a delay, a gain and a dead band), in virtual time. No person's data "
    "stand behind any figure of this page: it shows that the comparison works, not how well people drive."
)
SOME_SCRIPTED: Final = "Drivers called “scripted” were a script in virtual time, no persons."
MEANING: Final = (
    ("peak load", "largest in-plane probe load of an episode after the grace time; a failed one counts with the "
     "ultimate load"),
    ("IQM", "interquartile mean: without the lowest and the highest quarter of the episodes"),
    ("over limit", "time with a probe load above the cost limit, mean of the episodes"),
    ("time", "median duration of the successes"),
    ("claw path", "length of the claw's way over the deck, from the places at the ends of the control intervals"),
    ("probability of improvement", "share of seas in which the first driver's peak load is the lower one, equal ones "
     "half (Agarwal et al. 2021)"),
)  # fmt: skip


def scripted_words(document: Mapping[str, Any]) -> str:
    """What must be said where a script held the claw; empty where none did."""
    kinds = {one["kind"] for one in document["drivers"].values()} & {PEOPLE, SCRIPTED}
    if SCRIPTED not in kinds:
        return ""
    return SOME_SCRIPTED if PEOPLE in kinds else ONLY_SCRIPTED


def recorded(document: Mapping[str, Any]) -> list[str]:
    """Names of those whose trials were recorded."""
    return [name for name, one in document["drivers"].items() if one["kind"] in (PEOPLE, SCRIPTED)]


def headed(document: Mapping[str, Any]) -> list[str]:
    """Those of them that stand for all: the pools, and who belongs to none."""
    drivers = document["drivers"]
    members = {one for name in recorded(document) if drivers[name]["pooled"] for one in drivers[name]["members"]}
    return [name for name in recorded(document) if name not in members]


def alone(document: Mapping[str, Any]) -> list[str]:
    """Those of them that are no pools."""
    return [name for name in recorded(document) if not document["drivers"][name]["pooled"]]


def programs(document: Mapping[str, Any]) -> list[str]:
    """Names of the programs without their delays, in order."""
    return list(dict.fromkeys(one["base"] for one in document["drivers"].values() if one["kind"] not in
                              (PEOPLE, SCRIPTED)))  # fmt: skip


def title(document: Mapping[str, Any]) -> str:
    """The page's title."""
    who, beside = alone(document), programs(document)
    who = who if len(who) <= MOST_NAMED else headed(document)
    return f"Benchmark: {_listed(who)} beside {_listed(beside)}"


def answer(document: Mapping[str, Any]) -> list[str]:
    """A sentence or two for each recorded driver."""
    told = []
    for name in recorded(document):
        own = document["drivers"][name]
        peak, success, time_s = own["peak_probe_kN"], own["success"]["value"], own["time_s"]
        told.append(
            f"{name[:1].upper()}{name[1:]}: {100.0 * success:.0f} % of {own['episodes']} episodes succeeded, peak "
            f"probe load {peak['mean']['value']:.1f} kN in the mean and {peak['p95']['value']:.1f} kN at the 95th "
            f"percentile, {_median(time_s['value'])}."
        )
        told += _repeats(name, own)
        if name in headed(document):
            pairs = [one for one in document["pairs"] if one["driver"] == name]
            told += [_beside(pairs, base) for base in programs(document) if _of(pairs, base)]
    return told


def _repeats(name: str, own: Mapping[str, Any]) -> list[str]:
    """What must be known of seas that counted at a later attempt only."""
    if not own["repeated"]:
        return []
    first = own["first_attempts_kN"]
    rest = "no other is left" if first is None else f"without them the mean peak load is {first:.1f} kN"
    return [
        f"{name}: {own['repeated']} of these trials repeat a sea that was broken off or did not count before; {rest}."
    ]


def _median(time_s: float | None) -> str:
    return "no time, since it never arrived" if time_s is None else f"median time {time_s:.1f} s"


def _of(pairs: Sequence[Mapping[str, Any]], base: str) -> list[Mapping[str, Any]]:
    """Pairs with a program at all its delays."""
    return [one for one in pairs if one["other"].partition(" +")[0] == base]


def _beside(pairs: Sequence[Mapping[str, Any]], base: str) -> str:
    """A recorded driver and one program: the mean difference as it is and with the longest delay."""
    own = _of(pairs, base)
    first, last = own[0], own[-1]
    delay = last["other"].partition(" +")[2]
    told = f"{first['driver']} against {base} in the same {first['seas']} seas: mean peak load "
    told += difference(first["peak_mean_kN"])
    told += f" ({difference(last['peak_mean_kN'])} with its commands {delay} later)" if delay else ""
    if first["time_s"]["value"] is not None:
        told += f", time {difference(first['time_s'], 's')}"
    return f"{told}; the lower load in {100.0 * first['improvement']['value']:.0f} % of the seas."


def difference(figure: Mapping[str, Any], unit: str = "kN", digits: int = 1) -> str:
    """A difference with its interval in words."""
    value = signed(figure["value"], digits)
    ci = figure["ci"]
    return f"{value} {unit}" + (f" [{signed(ci[0], digits)}, {signed(ci[1], digits)}]" if ci else "")


def signed(value: float | None, digits: int = 1) -> str:
    """A number with its sign; a dash for none."""
    if value is None:
        return "–"
    text = f"{value:+.{digits}f}"
    return text.lstrip("+-") if not float(text) else text.replace("-", "−")


def _listed(words: Sequence[str]) -> str:
    return ", ".join(words[:-1]) + (" and " if len(words) > 1 else "") + words[-1] if words else ""


def taught(document: Mapping[str, Any]) -> list[str]:
    """Agents that have learned from recorded episodes in the very seas of the comparison, a sentence each."""
    seas = set(document["seeds"])
    found = {name: len(seas & set(seeds)) for name, seeds in document["learned_from"].items()}
    return [
        f"{name} has learned from recorded episodes of {count} of these {len(seas)} seas: its figures test nothing."
        for name, count in found.items()
        if count
    ]


def same_seas(document: Mapping[str, Any]) -> str:
    """Whether everybody has met the same seas."""
    fewer = [name for name, one in document["drivers"].items() if one["seas"] < len(document["seeds"])]
    if not fewer:
        return "Everybody in the same seas, programs without added delay."
    return (
        f"Programs in all {len(document['seeds'])} seas, without added delay; {_listed(fewer)} in fewer (column seas), "
        "so compare these by the differences sea by sea."
    )


def replay_words(document: Mapping[str, Any]) -> str:
    """How the trials came out when they were simulated once more."""
    told = document["replayed"]
    if told["agree"] == told["of"]:
        return "each was simulated once more and came out bit for bit as recorded"
    others = told["of"] - told["agree"]
    return (
        f"each was simulated once more; {others} of {told['of']} were recorded with other libraries "
        f"or on another processor and do not come out bit for bit, but with peak loads within {told['apart_kN']:.2g} kN"
    )


def reversal_words(document: Mapping[str, Any]) -> str:
    """How reversals are counted."""
    return (
        f"changes of sign of the applied command along and across, commands within ±{document['reversal_band']:g} of "
        "the claw's speed left out"
    )


def bound_words(document: Mapping[str, Any]) -> str:
    """What the normalised score is, or why there is none."""
    if document["bound"]:
        return (
            f"100 · (x − {document['baseline']}) / ({document['bound']} − {document['baseline']}) of the peak load: 0 "
            f"is {document['baseline']}, 100 is {document['bound']}, which plans with the true future. It is the best "
            "that a search has found, not a proven bound."
        )
    return f"No bound: {document['no_bound']}. So there is no score between the baseline and what can be reached."
