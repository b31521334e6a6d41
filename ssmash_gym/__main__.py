"""`python -m ssmash_gym` is `ssmash`."""

from __future__ import annotations

import sys

from ssmash_gym.cli import main

if __name__ == "__main__":
    sys.exit(main())
