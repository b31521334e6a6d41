"""The grid of a window: cells by number, and the scenario of each."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ssmash_gym.envs.loading import BASE_KEY
from ssmash_gym.envs.scenario import ScenarioConfig, changed_scenario, load_scenario
from ssmash_gym.envs.starts import Starter
from ssmash_gym.envs.task import TaskConfig, load_task
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.conditions import digest, hashed
from ssmash_gym.vehicle import Helicopter, load_helicopter
from ssmash_gym.windows.axes import AXES, WIND
from ssmash_gym.windows.config import WindowConfig
from ssmash_gym.windows.stages import STAGES


@dataclass(frozen=True)
class Grid:
    """Cells in order: the last axis runs fastest.

    Attributes:
        axes: Values of each axis, by name.
    """

    axes: Mapping[str, tuple[float, ...]]

    def __len__(self) -> int:
        return math.prod(map(len, self.axes.values()))

    def cell(self, number: int) -> dict[str, float]:
        """Values of a cell, by axis."""
        found: dict[str, float] = {}
        for name in reversed(list(self.axes)):
            number, place = divmod(number, len(self.axes[name]))
            found[name] = float(self.axes[name][place])
        return {name: found[name] for name in self.axes}

    def corners(self) -> Iterator[dict[str, float]]:
        """Cells of the least and greatest value of every axis, and those closest to head seas, the fastest met."""
        ends = [sorted({min(values), max(values), *self._ahead(name)}) for name, values in self.axes.items()]
        for values in itertools.product(*ends):
            yield dict(zip(self.axes, map(float, values), strict=True))

    def _ahead(self, name: str) -> tuple[float, ...]:
        values = self.axes[name]
        return (max(values, key=lambda v: math.cos(math.radians(v))),) if name == "waves_from_deg" else ()


@dataclass(frozen=True)
class Setting:
    """A stage of a window, resolved; can be pickled.

    Attributes:
        stage: Its name.
        task: As it is judged; a policy observes it in its own way.
        scenario: What all cells share.
        helicopter: The helicopter.
    """

    stage: str
    task: TaskConfig
    scenario: ScenarioConfig
    helicopter: Helicopter

    def of(self, cell: Mapping[str, float]) -> ScenarioConfig:
        """The scenario of a cell.

        Raises:
            ConfigurationError: The scenario refuses the cell.
        """
        scenario = self.scenario
        for name, value in cell.items():
            try:
                scenario = changed_scenario(scenario, AXES[name].changes(value))
            except ConfigurationError as error:
                raise ConfigurationError(f"window: axes.{name} = {value:g} is refused: {error}") from None
        return scenario

    @property
    def configuration(self) -> str:
        """Hash of all that is resolved; what is only said about it does not count."""
        return digest(self.stage, *hashed(self.task, self.scenario, self.helicopter))


def settings(config: WindowConfig) -> dict[str, Setting]:
    """The stages of a window with all that they name, by name, each tried at the corners of the grid.

    Raises:
        ConfigurationError: A name, a file or a cell is refused; one sentence.
    """
    helicopter = load_helicopter(config.helicopter)
    found: dict[str, Setting] = {stage: _setting(config, stage, helicopter) for stage in config.stages}
    for setting in found.values():
        for corner in Grid(config.axes).corners():
            scenario = setting.of(corner)
            try:
                Starter(setting.helicopter, setting.task, scenario)
            except ConfigurationError as error:
                where = ", ".join(f"{name} = {value:g}" for name, value in corner.items())
                raise ConfigurationError(f"window: the cell {where} is refused: {error}") from None
    return found


def _setting(config: WindowConfig, stage: str, helicopter: Helicopter) -> Setting:
    one = STAGES[stage]
    scenario = load_scenario(config.scenario)
    if scenario.motion.type != "seaway" and {"sea_state", "hs_m", "waves_from_deg", "speed_kn"} & set(config.axes):
        raise ConfigurationError(
            f"window: scenario.motion.type = {scenario.motion.type!r} is refused: axes of the sea need a seaway."
        )
    if scenario.wind.type != "free" and set(WIND) & set(config.axes):
        raise ConfigurationError(
            f"window: scenario.wind.type = {scenario.wind.type!r} is refused with an axis of the wind: give the "
            "wind by itself ({type: free, ...})."
        )
    task: dict[str, Any] = config.task if isinstance(config.task, dict) else {BASE_KEY: config.task}
    judged = load_task(load_task(task).model_dump(mode="json") | dict(one.task))
    if one.sinks and scenario.start.sink_rate_m_s is None:  # what the scenario says itself stays
        scenario = changed_scenario(scenario, {"start": {"sink_rate_m_s": one.sinks}})
    return Setting(stage, judged, scenario, helicopter)
