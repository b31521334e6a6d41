"""Evaluate agents and baselines on the same frozen seeds: `evaluate.py --help`; the same as `ssmash evaluate`."""

from __future__ import annotations

import sys

from ssmash_gym.cli import main

if __name__ == "__main__":
    sys.exit(main(["evaluate", *sys.argv[1:]]))
