#!/bin/sh
# Print the first Python 3.11-3.13 that can make a virtual environment; an argument is tried instead of the usual names.
for candidate in ${1:-python3 python3.13 python3.12 python3.11 python}; do
    if "$candidate" -c 'import sys, venv, ensurepip; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' 2>/dev/null; then
        command -v "$candidate"
        exit 0
    fi
done
echo "ssmash_gym needs Python 3.11, 3.12 or 3.13 with its venv module, and found none among: ${1:-python3 python3.13 python3.12 python3.11 python}" >&2
exit 1
