"""`python -m ssmash_gym` is `ssmash`."""

from __future__ import annotations

import sys

from ssmash_gym.cli import main

sys.exit(main())
