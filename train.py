"""Train an agent: `python train.py --config configs/training/ppo_traverse.yaml`; the same as `ssmash train`."""

from __future__ import annotations

import sys

from ssmash_gym.cli import main

if __name__ == "__main__":
    sys.exit(main(["train", *sys.argv[1:]]))
