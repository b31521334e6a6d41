"""Machine code of the kernels kept on disk, keyed by everything that goes into it.

Numba's own cache looks at the file of the function that is called and not at the files of the functions it calls, so
that an edited kernel could run stale. Here the key is a fingerprint of all kernel sources, of the versions of Numba,
llvmlite, NumPy and Python, of the processor and of the compiler's settings. Each fingerprint has its folder below the
user's cache folder; the newest few are kept. Only the kernels given to `enable_kernel_cache` are touched: Numba's
settings and other caches stay as they are.
"""

# Numba is typed in part only.
# mypy: disable-error-code="attr-defined, misc, no-untyped-call"
from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import re
import shutil
import sys
from pathlib import Path
from typing import Any, Final

import llvmlite
import numba
import numpy as np
from llvmlite import binding
from numba.core.caching import CompileResultCacheImpl, FunctionCache, _CacheLocator
from numba.core.dispatcher import Dispatcher
from numba.misc.appdirs import AppDirs

SOURCES: Final = Path(__file__).resolve().parent
KEPT: Final = 3  # folders of fingerprints, the one in use included
PREFIX: Final = "kernels-"


def enable_kernel_cache(kernel: Any) -> None:
    """Load the machine code of a kernel from disk where it is there, and save it where it is not.

    Where the cache folder cannot be written or read the kernel is compiled, as without a cache. A plain function
    (``NUMBA_DISABLE_JIT=1``) is left alone.

    Raises:
        ValueError: the kernel is not defined in this folder, so that an edit would go unnoticed.
    """
    if not isinstance(kernel, Dispatcher):
        return
    source = Path(kernel.py_func.__code__.co_filename).resolve()
    if SOURCES not in source.parents:
        raise ValueError(f"kernel {kernel.__name__} of {source} cannot be cached: only kernels in {SOURCES} can")
    with contextlib.suppress(OSError):  # sources that cannot be read cannot be vouched for
        kernel._cache = _KernelCache(kernel.py_func)


def cache_folder() -> Path:
    """Folder of all fingerprints: ``SSMASH_CACHE_DIR``, else the platform's cache folder of the user."""
    chosen = os.environ.get("SSMASH_CACHE_DIR")
    return Path(chosen) if chosen else Path(AppDirs("ssmash_gym", appauthor=False).user_cache_dir)


@functools.cache
def fingerprint() -> str:
    """Hash of all that decides the machine code, of the sources as they were when first asked for."""
    settings = (
        sys.version,
        numba.__version__,
        llvmlite.__version__,
        np.__version__,
        binding.get_process_triple(),
        numba.config.CPU_NAME or binding.get_host_cpu_name(),
        numba.config.CPU_FEATURES or sorted(binding.get_host_cpu_features().items()),
        numba.config.ENABLE_AVX,
        str(numba.config.OPT),
        numba.config.DEBUGINFO_DEFAULT,
        numba.config.BOUNDSCHECK,
    )
    digest = hashlib.sha256(repr(settings).encode())
    for source in sorted(SOURCES.rglob("*.py")):
        digest.update(hashlib.sha256(str(source.relative_to(SOURCES)).encode()).digest())
        digest.update(hashlib.sha256(source.read_bytes()).digest())
    return digest.hexdigest()


class _Locator(_CacheLocator):
    """Where the files of one kernel are."""

    def __init__(self, py_func: Any) -> None:
        self._py_file = py_func.__code__.co_filename
        self._line = py_func.__code__.co_firstlineno
        self._stamp = fingerprint()
        self._folder = cache_folder() / (PREFIX + self._stamp[:32])

    def ensure_cache_path(self) -> None:
        if not self._folder.is_dir():
            _remove_old(self._folder.parent)
        super().ensure_cache_path()

    def get_cache_path(self) -> str:
        return str(self._folder)

    def get_source_stamp(self) -> str:
        return self._stamp

    def get_disambiguator(self) -> str:
        return f"{Path(self._py_file).stem}-{self._line}"


def _remove_old(folder: Path) -> None:
    """Make room for one more fingerprint: remove all but the newest folders of others."""
    if not folder.is_dir():
        return
    others = [entry for entry in folder.iterdir() if re.fullmatch(PREFIX + "[0-9a-f]{32}", entry.name)]
    others.sort(key=lambda entry: entry.stat().st_mtime, reverse=True)
    for entry in others[KEPT - 1 :]:
        shutil.rmtree(entry, ignore_errors=True)


class _Results(CompileResultCacheImpl):
    """Serialisation as Numba's, in our place whatever Numba's settings say."""

    def __init__(self, py_func: Any) -> None:
        self._lineno = py_func.__code__.co_firstlineno
        self._locator = _Locator(py_func)
        self._filename_base = self.get_filename_base(py_func.__qualname__, getattr(sys, "abiflags", ""))


class _KernelCache(FunctionCache):
    """Numba's cache, in which a folder or file that is no good costs a compilation and nothing else."""

    _impl_class = _Results

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # whatever a damaged file makes of the unpickling, the answer is to compile and start anew
            with contextlib.suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        try:
            super().save_overload(sig, data)
        except Exception:  # a kernel that is not saved is compiled again next time, no more
            self.disable()
