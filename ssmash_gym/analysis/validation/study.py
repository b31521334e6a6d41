"""A manoeuvre run: as its case says, with what was asked for beside it, and every statement measured."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

from ssmash_gym.analysis.validation.agreement import Agreement, agreement
from ssmash_gym.analysis.validation.manoeuvres import Manoeuvre, Variant, friction_variant, suspects_of
from ssmash_gym.analysis.validation.statements import Finding, Runs
from ssmash_gym.cases import Case, History, load_case, run_case
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.simulate import realised

Progress = Callable[[float, str], None]  # share done, what is being run


@dataclass(frozen=True)
class Asked:
    """What is run beside a manoeuvre.

    Args:
        friction: Another friction law of the tires, "" for none.
        solvers: Other integrators.
        systems: Names of other systems of the thesis.
        suspects: Whether the manoeuvre's suspects are run.
    """

    friction: str = ""
    solvers: tuple[str, ...] = ()
    systems: tuple[str, ...] = ()
    suspects: bool = False


@dataclass(frozen=True)
class Study:
    """A manoeuvre with its runs and findings.

    Attributes:
        manoeuvre: The manoeuvre.
        case: Its case.
        runs: Its histories.
        variants: Those that were run, by name.
        findings: Every statement that could be measured.
        agreements: One for each other integrator.
        systems: Histories of other systems, by the label of their curves.
        remarks: What must be known of the runs: validity, systems that cannot do the manoeuvre.
    """

    manoeuvre: Manoeuvre
    case: Case
    runs: Runs
    variants: Mapping[str, Variant] = field(default_factory=dict)
    findings: tuple[Finding, ...] = ()
    agreements: tuple[Agreement, ...] = ()
    systems: Mapping[str, History] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()

    @property
    def holding(self) -> int:
        """Number of statements that hold."""
        return sum(finding.holds for finding in self.findings)


def study(manoeuvre: Manoeuvre, asked: Asked | None = None, progress: Progress | None = None) -> Study:
    """Run a manoeuvre and what is asked for beside it.

    Args:
        manoeuvre: The manoeuvre.
        asked: What is run beside it; nothing unless given.
        progress: Told the share that is done and what is being run.

    Raises:
        ConfigurationError: A run cannot be made or diverged.
    """
    asked = asked or Asked()
    case = load_case(manoeuvre.case_name)
    variants = {variant.name: variant for variant in _variants(manoeuvre, asked)}
    cases: dict[str, Case] = {"": case}
    cases |= {f"variant {name}": case.changed(variant.changes) for name, variant in variants.items()}
    cases |= {f"solver {name}": case.changed({"solution.solver": name}) for name in asked.solvers}
    systems, refused = _systems(case, asked.systems)
    cases |= {f"system {label}": changed for label, (changed, _) in systems.items()}
    found = _run_all(manoeuvre, cases, progress)

    runs = Runs(found[""], {name: found[f"variant {name}"] for name in variants})
    statements = [*manoeuvre.statements, *(s for variant in variants.values() for s in variant.statements)]
    findings = [statement.check(runs) for statement in statements]
    return Study(
        manoeuvre=manoeuvre,
        case=case,
        runs=runs,
        variants=variants,
        findings=tuple(finding for finding in findings if finding is not None),
        agreements=tuple(agreement(found[""], found[f"solver {name}"], manoeuvre.loads) for name in asked.solvers),
        systems={label: back(found[f"system {label}"]) for label, (_, back) in systems.items()},
        remarks=(*_validity(case), *refused),
    )


def _variants(manoeuvre: Manoeuvre, asked: Asked) -> Sequence[Variant]:
    """Variants that are asked for."""
    friction = [friction_variant(asked.friction)] if asked.friction else []
    return [*friction, *(suspects_of(manoeuvre.name) if asked.suspects else ())]


def _systems(
    case: Case, names: Sequence[str]
) -> tuple[dict[str, tuple[Case, Callable[[History], History]]], list[str]]:
    """Cases of other systems with what tells their histories at full scale, by label; and why some cannot do it."""
    if not names:
        return {}, []
    from ssmash_gym.systems import apply, at_full_scale, label, load_system, why_not

    made: dict[str, tuple[Case, Callable[[History], History]]] = {}
    refused = []
    for name in names:
        system = load_system(name)
        if (reason := why_not(system, case)) is not None:
            refused.append(reason)
            continue
        made[label(system, case)] = (
            apply(system, case),
            partial(at_full_scale, case=case, scale=system.scale) if system.scale != 1.0 else _as_it_is,
        )
    return made, refused


def _as_it_is(history: History) -> History:
    return history


def _run_all(manoeuvre: Manoeuvre, cases: Mapping[str, Case], progress: Progress | None) -> dict[str, History]:
    """Run cases one after the other.

    Raises:
        ConfigurationError: One of them diverged, or its integrator gave up.
    """
    found: dict[str, History] = {}
    for k, (name, case) in enumerate(cases.items()):
        words = f"{manoeuvre.name} {name}".strip()

        def told(share: float, k: int = k, words: str = words) -> None:
            if progress is not None:
                progress((k + share) / len(cases), words)

        told(0.0)
        try:
            found[name] = run_case(case, told)
        except RuntimeError as error:
            raise ConfigurationError(f"manoeuvre {words}: the run is given up: {error}.") from None
        if (why := found[name].diverged) is not None:
            raise ConfigurationError(f"manoeuvre {words}: {why}.")
    return found


def _validity(case: Case) -> list[str]:
    """What is to be said of the deck's motion: its flag of validity and its warnings."""
    motion, warned = realised(case.deck, case.seed)
    flag = motion.outside_validity
    return ([f"Deck motion outside validity: {flag}"] if flag else []) + [f"Warning: {text}" for text in warned]
