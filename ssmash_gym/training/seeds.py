"""Blocks of episode seeds that never meet: for training, for evaluation, and for choosing between variants.

Seeds are drawn from `numpy.random.SeedSequence` with a spawn key for each purpose, never counted up from a base seed,
so that neighbouring seeds of a run, or training and evaluation with the same number, share no episode.
"""

from __future__ import annotations

from typing import Final

import numpy as np

TRAINING: Final = 1
EVALUATION: Final = 2
TUNING: Final = 3  # searches of gains and settings, choice between trained agents
EVOLUTION: Final = 4  # seas in which evolving policies are compared
WINDOWS: Final = 5  # seas of operating windows: a policy that was chosen by an evaluation meets new ones
TRIALS: Final = 6  # seas of trials with a person, or a program in a person's place, at the claw
DEMONSTRATIONS: Final = 7  # episodes of policies that are exported to learn from: no evaluation meets their seas


def block(seed: int, purpose: int, count: int) -> list[int]:
    """The first `count` episode seeds of a purpose; a longer block starts with the shorter one.

    Args:
        seed: The user's number.
        purpose: `TRAINING`, `EVALUATION`, `TUNING`, `EVOLUTION`, `WINDOWS`, `TRIALS` or
            `DEMONSTRATIONS`.
        count: How many.
    """
    numbers = np.random.SeedSequence(seed, spawn_key=(purpose,)).generate_state(2 * count, np.uint32)
    pairs = numbers.reshape(count, 2).astype(np.uint64)
    return [int(high << np.uint64(21) | low >> np.uint64(11)) for high, low in pairs]  # 53 bits: exact in JSON


def network_seed(seed: int) -> int:
    """Seed of the networks' first weights and of the exploration."""
    return int(np.random.SeedSequence(seed, spawn_key=(0,)).generate_state(1, np.uint32)[0])


def generation_seed(seed: int, generation: int) -> int:
    """Seed of the candidates that a generation of an evolution draws."""
    return int(np.random.SeedSequence(seed, spawn_key=(EVOLUTION, generation)).generate_state(1, np.uint32)[0])
