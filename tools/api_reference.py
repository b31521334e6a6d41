"""Writes the API reference with pdoc; a warning of pdoc is an error.

python tools/api_reference.py build/docs/api
"""

from __future__ import annotations

import inspect
import sys
import typing
import warnings
from pathlib import Path

import pdoc
import pdoc.render

PACKAGE = "ssmash_gym"


def resolve_named_tuples(module: pdoc.doc.Module) -> None:
    """Give the constructors of named tuples types for their strings: they do not know the module they stem from."""
    for cls in vars(module.obj).values():
        if inspect.isclass(cls) and issubclass(cls, tuple) and hasattr(cls, "_fields"):
            cls.__new__.__annotations__ |= typing.get_type_hints(cls)
    for inner in module.submodules:
        resolve_named_tuples(inner)


def main(out: Path) -> int:
    """Write the pages; the exit status says whether pdoc warned."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        pdoc.render.configure(docformat="google")
        resolve_named_tuples(pdoc.doc.Module(pdoc.extract.load_module(PACKAGE)))
        pdoc.pdoc(PACKAGE, output_directory=out)
    lines = [str(w.message) for w in told if "pdoc" in Path(w.filename).parts]
    print("\n".join(lines) or f"API reference written to {out}")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
