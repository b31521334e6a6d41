"""Matched delays: programs act as late as a person does, by a longer delay of the claw's commands."""

from __future__ import annotations

from typing import Final

from ssmash_gym.document import listed
from ssmash_gym.envs.ranges import Choice, Constant, Normal, Range, Uniform
from ssmash_gym.envs.scenario import Claw, ScenarioConfig
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.conditions import Condition

DELAYS: Final = "0,50,100,200"  # of a benchmark [ms]
LONGEST_MS: Final = 1000.0  # beyond it nobody would be driving what is seen


def delays_of(words: str, substep_s: float) -> tuple[float, ...]:
    """Delays from the command line, in order; none (0) is always among them, for what a delay costs is told beside it.

    Args:
        words: Milliseconds with commas between them.
        substep_s: Step of the integrator [s]: the claw's delay is a whole number of them.

    Raises:
        ConfigurationError: One is no number, out of bounds, or between two steps of the integrator.
    """
    found: list[float] = []
    for word in listed(words):
        try:
            value = float(word)
        except ValueError:
            raise ConfigurationError(f"--delays {word!r} is refused: milliseconds with commas between them.") from None
        steps = 1e-3 * value / substep_s
        if not 0.0 <= value <= LONGEST_MS or abs(steps - round(steps)) > 1e-6:
            raise ConfigurationError(
                f"--delays {word} is refused: from 0 to {LONGEST_MS:g} ms, in steps of {1e3 * substep_s:g} ms."
            )
        found.append(value)
    if not found:
        raise ConfigurationError(f"--delays {words!r} is refused: at least one; 0 is no delay.")
    return tuple(sorted({0.0, *found}))


def labelled(name: str, delay_ms: float) -> str:
    """A program with its added delay, as tables and figures call it."""
    return name if delay_ms == 0.0 else f"{name} +{delay_ms:g} ms"


def later(condition: Condition, delay_ms: float) -> Condition:
    """The same episodes with the claw's command delay longer by so much.

    Every other number that a seed draws stays, because each quantity has its own place among a draw's random numbers.

    Args:
        condition: The benchmark's.
        delay_ms: Added to each episode's own delay [ms].

    Raises:
        ConfigurationError: The delay is beyond what a scenario may have.
    """
    if delay_ms == 0.0:
        return condition
    longer = _shifted(condition.scenario.claw.delay_s, condition.task, 1e-3 * delay_ms)
    sections = {key: getattr(condition.scenario.claw, key) for key in Claw.model_fields}
    claw = Claw(**{**sections, "delay_s": longer})
    scenario: ScenarioConfig = condition.scenario.model_copy(update={"claw": claw})
    return Condition(condition.name, condition.description, condition.task, scenario, condition.helicopter)


def _shifted(delay: Range | None, task: TaskConfig, extra_s: float) -> Range:
    """A range of delays, each of its values longer by so much; None is the task's own delay."""
    if delay is None:
        return Constant(constant=task.claw.delay_s + extra_s)
    if isinstance(delay, Constant):
        return Constant(constant=delay.constant + extra_s)
    if isinstance(delay, Uniform):
        return Uniform(uniform=(delay.uniform[0] + extra_s, delay.uniform[1] + extra_s))
    if isinstance(delay, Choice):
        return Choice(choice=tuple(value + extra_s for value in delay.choice))
    low, high = delay.within
    middle, deviation = delay.normal
    return Normal(normal=(middle + extra_s, deviation), within=(low + extra_s, high + extra_s))
