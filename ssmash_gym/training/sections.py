"""The sections of a training's configuration; every key says what it is."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Share = Annotated[float, Field(gt=0.0, le=1.0)]
Count = Annotated[int, Field(ge=1)]
Choice = str | dict[str, Any]  # a name in configs, the path of a YAML file, or changes to one
LimitName = Literal["probe_in_plane", "main_vertical", "lift_off", "roll", "corridor"]  # keys of `limits.LIMITS`


class Section(BaseModel):
    """Part of the configuration: frozen, and no key but its own."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Environment(Section):
    """Where the agent learns."""

    task: Choice = Field("traverse", description="task: name, file, or changes to the default one")
    scenario: Choice = Field("default", description="scenario: name, file, or changes to the default one")
    count: Count = Field(64, description="helicopters that are simulated side by side")
    threads: Count = Field(2, description="threads of the simulation; the result does not depend on them")


class Stage(Section):
    """What changes from a step on: first to arrive at all, then to do it well; easy seas first, then all of them."""

    from_step: Count = Field(description="control intervals of all helicopters together from which it holds")
    reward: dict[str, float] = Field({}, description="keys of the task's reward to change, with all stages before")
    scenario: dict[str, Any] = Field(
        {}, description="changes to the scenario, nested or by dotted keys, with all stages before; running episodes "
        "are finished as they were drawn"
    )  # fmt: skip


class Cost(Section):
    """What exceeding a limit costs: reward minus multiplier times the environment's cost.

    The multiplier is ``integral + proportional * excess``, between 0 and `largest`. After each update the integral
    grows by ``rate * excess``, where the excess is the mean cost of the episodes that ended, minus `limit_per_episode`.
    """

    limit_per_episode: NotNegative = Field(0.0, description="control intervals beyond the limit that are allowed")
    weight: NotNegative = Field(0.0, description="first multiplier, reward for an interval beyond the limit [1]")
    rate: NotNegative = Field(0.0, description="growth of the multiplier an update, for each interval of excess [1]")
    proportional: NotNegative = Field(0.0, description="part of the multiplier that follows the excess at once [1]")
    largest: Positive = Field(10.0, description="bound of the multiplier [1]")

    @model_validator(mode="after")
    def _bounded(self) -> Self:
        if self.weight > self.largest:
            raise ValueError(f"weight = {self.weight:g}: must not exceed largest = {self.largest:g}")
        return self


class Network(Section):
    """Policy and value networks: separate perceptrons of the same shape."""

    layers: tuple[Count, ...] = Field((64, 64), description="units of the hidden layers")
    activation: Literal["tanh", "relu", "elu"] = Field("tanh", description="of the hidden layers")
    log_std: float = Field(-1.0, ge=-5.0, le=1.0, description="logarithm of the initial exploration, per action")
    initial_action: tuple[float, float] = Field(
        (0.0, 0.0), description="mean action before any learning (along, across): a claw that moves learns sooner"
    )

    @model_validator(mode="after")
    def _within_box(self) -> Self:
        if any(abs(value) > 1.0 for value in self.initial_action):
            raise ValueError(f"initial_action = {list(self.initial_action)}: must be within -1 to 1")
        return self


class Ppo(Section):
    """Proximal policy optimisation; the names are those of Stable-Baselines3, written out."""

    steps_per_update: Count = Field(128, description="control intervals of each helicopter between two updates")
    batch_size: Annotated[int, Field(ge=2)] = Field(2048, description="samples of a gradient step")
    epochs: Count = Field(5, description="passes over the samples of an update")
    learning_rate: Positive = Field(3e-4, description="at the start")
    learning_rate_end: NotNegative = Field(3e-5, description="at the end; linear in between")
    gamma: Share = Field(0.997, description="discount of a control interval: 0.997 looks 33 s ahead at 0.1 s")
    gae_lambda: Share = Field(0.95, description="generalised advantage estimation")
    clip_range: Positive = Field(0.2, description="bound of the probability ratio's change")
    entropy: NotNegative = Field(0.0, description="weight of the entropy bonus")
    value_weight: NotNegative = Field(0.5, description="weight of the value loss")
    gradient_norm: Positive = Field(0.5, description="bound of the gradient's norm")
    target_kl: Positive | None = Field(None, description="divergence at which an update stops early")


class Sac(Section):
    """Soft actor-critic: learns from a store of past transitions; the names are those of Stable-Baselines3."""

    steps_per_update: Count = Field(
        128, description="control intervals of each helicopter between two lines of the curve; checkpoints fall there"
    )
    train_every: Count = Field(1, description="control intervals of each helicopter between two trainings")
    gradient_steps: Count = Field(8, description="gradient steps of a training")
    batch_size: Annotated[int, Field(ge=2)] = Field(512, description="transitions of a gradient step")
    buffer_size: Count = Field(500_000, description="transitions that are kept: the newest")
    learning_starts: Count = Field(
        100_000, description="control intervals of all that the first policy drives before it is trained"
    )
    learning_rate: Positive = Field(3e-4, description="at the start")
    learning_rate_end: NotNegative = Field(3e-5, description="at the end; linear in between")
    gamma: Share = Field(0.997, description="discount of a control interval")
    n_steps: Count = Field(1, description="rewards that are summed before the critic's value; needs SB3 2.7")
    tau: Share = Field(0.005, description="share of the critic that its target takes over at each gradient step")
    entropy: NotNegative | None = Field(None, description="weight of the entropy; None learns it")
    first_entropy: Positive = Field(0.1, description="weight of the entropy at the start, where it is learned")
    target_entropy: float | None = Field(None, description="entropy to keep, where learned; None: minus the actions")


class Tqc(Sac):
    """Truncated quantile critics (sb3-contrib): SAC whose critics know the distribution and distrust its top."""

    quantiles: Count = Field(25, description="quantiles of each critic")
    critics: Count = Field(2, description="how many critics")
    dropped: Annotated[int, Field(ge=0)] = Field(2, description="top quantiles of each critic that targets leave out")

    @model_validator(mode="after")
    def _some_are_left(self) -> Self:
        if self.dropped >= self.quantiles:
            raise ValueError(f"dropped = {self.dropped}: must be below quantiles = {self.quantiles}")
        return self


class Normalise(Section):
    """Running normalisation; observations are scaled by physical limits already, so they need none."""

    reward: bool = Field(True, description="divide rewards by the running deviation of the return")
    observation: bool = Field(False, description="shift and scale observations by their running moments")
    clip: Positive = Field(10.0, description="bound of normalised values")


class Checkpoints(Section):
    """What is kept along the way."""

    every_steps: Count = Field(1_000_000, description="control intervals (of all helicopters) between two of them")
    keep: Count = Field(2, description="how many are kept: the newest")
    replay_buffer: bool = Field(True, description="keep SAC's and TQC's past transitions too: some 300 B each")


class Judgement(Section):
    """What an evolution minimises, in kN: a mean of the peaks in which large ones count more, their tail, misses."""

    power: Annotated[float, Field(ge=1.0, le=20.0)] = Field(4.0, description="of the mean over the seas' peaks")
    tail: NotNegative = Field(0.25, description="weight of the 95th percentile [1]")
    success: Share = Field(0.99, description="share of successes below which the score rises")
    success_kN: NotNegative = Field(12.0, description="for a share that is lower by 1 [kN]")
    yaw_deg: NotNegative = Field(0.6, description="final yaw that costs nothing [deg]: misses shall be clear ones")
    yaw_kN_per_deg: NotNegative = Field(2.0, description="for the mean of what is beyond, up to 4 deg [kN/deg]")
    time_s: Positive = Field(46.0, description="median time of all episodes above which the score rises [s]")
    time_kN_per_s: NotNegative = Field(0.3, description="for each second [kN/s]")


class Evolution(Section):
    """After the gradient: CMA-ES on the last layer, without exploration, on what episodes are judged by."""

    generations: Count = Field(40, description="how often candidates are drawn")
    population: Annotated[int, Field(ge=4)] = Field(20, description="candidates of a generation")
    spread: Positive = Field(0.015, description="first standard deviation of a weight")
    episodes: Annotated[int, Field(ge=1, le=256)] = Field(64, description="seas that each candidate drives in")
    sets: Annotated[int, Field(ge=1, le=16)] = Field(4, description="sets of so many seas that take turns")
    turn: Count = Field(3, description="generations that meet the same set")
    unseen: Annotated[int, Field(ge=1, le=256)] = Field(192, description="seas that decide whether the result is kept")
    scenario: Choice | None = Field(
        None,
        description="seas: name, file, or changes to the default scenario; the training's last one by default",
    )
    substep_s: Positive | None = Field(None, description="of the integrator; the task's by default")
    judgement: Judgement = Field(Judgement(), description="what is minimised")
