"""Hydrodynamic data of a hull at zero speed: added mass, damping and wave forces, interpolated and Froude-scaled.

A database is one npz file: the result of a linear potential-flow computation (`tools/build_rao.py`), about
O = (longitudinal centre of buoyancy, centre plane, still waterline) in the BEM frame: x forward, y to port, z up, time
factor exp(-i omega t). Wave directions `beta` say where the waves travel to: 0 to +x (following), pi/2 to +y (port),
pi head. The port/starboard symmetry of the hull gives the other half of the circle. Page: docs/theory/hull.md.
"""

from __future__ import annotations

import json
from contextlib import closing
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, Final
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.errors import ConfigurationError, refusal
from ssmash_gym.ship.kinematics import FloatArray

ComplexArray = NDArray[np.complex128]

DATA: Final = Path(__file__).parent / "data"
TRIOS: Final = (slice(0, 6, 2), slice(1, 6, 2))  # surge, heave, pitch; sway, roll, yaw: the hull couples no others
ODD_IN_BETA: Final = (1, 3, 5)  # sway, roll, yaw change sign with the side the waves come from
SCALARS: Final = (
    "length_m",
    "beam_m",
    "draught_m",
    "volume_m3",
    "water_density",
    "gravity",
    "z_B",
    "I_T",
    "I_L",
    "A_wp",
    "S_x",
)
DIMENSIONS: Final = {"omega": 1, "beta": 1, "A": 3, "B": 3, "FK": 3, "FD": 3}
ARRAYS: Final = tuple(DIMENSIONS)
SCALES: Final = (0.01, 10.0)  # from a towing tank's model to more than any ship
COMPLEX: Final = ("FK", "FD")

_PER_STEP: Final = 6  # pieces of the refined frequency grid in one step of the table's
_HEADINGS: Final = 180  # steps of the refined heading grid, 1 degree each
_COLUMNS: Final = _HEADINGS + 3  # its columns: one more at either end
_NEIGHBOURS: Final = np.concatenate([np.arange(4), _COLUMNS + np.arange(4)])  # the eight entries about a place
_FADE: Final = 4  # beyond the last frequency B and the forces fall off with omega to this power


@dataclass(frozen=True, eq=False)
class HullDatabase:
    """Zero-speed hydrodynamic data of a hull about O, BEM frame (x forward, y port, z up), exp(-i omega t).

    Attributes:
        name: Name of the hull.
        provenance: What made the data: formula, numbers, code, date, command, what is assumed.
        length_m, beam_m, draught_m: Main dimensions [m].
        volume_m3: Displaced volume [m3].
        water_density, gravity: rho [kg/m3] and g [m/s2] of the computation.
        z_B: Height of the centre of buoyancy over the waterline [m], negative.
        I_T, I_L: Second moments of the waterplane about the x and y axes through O [m4].
        A_wp, S_x: Area [m2] and first moment about O's y axis, int x dA [m3], of the waterplane.
        omega: Frequencies (n,) [rad/s], increasing.
        beta: Wave directions (m,) [rad], evenly spaced from 0 to pi.
        A, B: Added mass [kg, kg m, kg m2] and radiation damping [the same per second] (n, 6, 6); symmetric, coupled
            only within (surge, heave, pitch) and (sway, roll, yaw).
        FK, FD: Froude-Krylov and diffraction force (n, m, 6) per metre of wave amplitude [N/m, N m/m], phase relative
            to the elevation at O.
    """

    name: str
    provenance: dict[str, Any]
    length_m: float
    beam_m: float
    draught_m: float
    volume_m3: float
    water_density: float
    gravity: float
    z_B: float
    I_T: float
    I_L: float
    A_wp: float
    S_x: float
    omega: FloatArray
    beta: FloatArray
    A: FloatArray
    B: FloatArray
    FK: ComplexArray
    FD: ComplexArray

    def scaled(self, factor: float) -> HullDatabase:
        """The geometrically similar hull, every length times `factor` (Froude's law: omega / sqrt(factor)).

        Raises:
            ConfigurationError: `factor` is not a number within `SCALES`.
        """
        if not SCALES[0] <= factor <= SCALES[1]:  # nan, too, is not
            allowed = f"a scale is a number from {SCALES[0]:g} to {SCALES[1]:g} (1 = as built)"
            raise refusal(f"hull {self.name}", "scale", factor, allowed)
        if factor == 1.0:
            return self
        turns = np.array([0, 0, 0, 1, 1, 1])  # a moment has one length more than a force
        inertia = float(factor) ** (3.0 + turns[:, None] + turns)
        force = float(factor) ** (2.0 + turns)
        powers = {"length_m": 1, "beam_m": 1, "draught_m": 1, "z_B": 1, "A_wp": 2, "S_x": 3, "volume_m3": 3}
        powers |= {"I_T": 4, "I_L": 4}
        return replace(
            self,
            provenance=self.provenance | {"scale": float(factor) * self.provenance.get("scale", 1.0)},
            omega=self.omega / np.sqrt(factor),
            A=self.A * inertia,
            B=self.B * inertia / np.sqrt(factor),
            FK=self.FK * force,
            FD=self.FD * force,
            **{key: getattr(self, key) * float(factor) ** power for key, power in powers.items()},
        )

    def radiation(self, omega_abs: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Added mass and damping at the encounter frequencies.

        Below the table's first frequency A keeps its first value and B goes smoothly to zero at zero; above the last
        one A keeps its last value and B falls off with the fourth power of the frequency.

        Args:
            omega_abs: Encounter frequencies (n,) [rad/s]; the sign is ignored.

        Returns:
            A [kg, kg m, kg m2] and B [per second], both (n, 6, 6), BEM frame about O.
        """
        trios = self.radiation_trios(omega_abs)
        both = np.zeros((2, trios.shape[-1], 6, 6))
        for trio, dofs in enumerate(TRIOS):
            both[:, :, dofs, dofs] = np.moveaxis(trios[:, trio], -1, 1)
        return both[0], both[1]

    def radiation_trios(self, omega_abs: FloatArray) -> FloatArray:
        """What is not zero in `radiation`, laid out for arithmetic over many frequencies.

        Args:
            omega_abs: Encounter frequencies (n,) [rad/s]; the sign is ignored.

        Returns:
            A and B of (surge, heave, pitch) and of (sway, roll, yaw): (2, 2, 3, 3, n), units as of `radiation`.
        """
        return self._radiation_at(omega_abs, self._radiation_table)

    def own_radiation(self, omega_abs: FloatArray) -> FloatArray:
        """Diagonals of `radiation_trios`, (2, 2, 3, n)."""
        return self._radiation_at(omega_abs, self._own_radiation_table)

    def _radiation_at(self, omega_abs: FloatArray, table: FloatArray) -> FloatArray:
        """Values of a table (2, ..., grid) at frequencies, (2, ..., n)."""
        low, share, fade = self._place(np.abs(np.asarray(omega_abs, dtype=np.float64)))
        values = table.take(low, axis=-1)
        values += share * (table.take(low + 1, axis=-1) - values)
        values[1] *= fade
        return values

    def excitation(self, omega: FloatArray, beta_bem: FloatArray) -> tuple[ComplexArray, ComplexArray]:
        """Froude-Krylov and diffraction force per metre of wave amplitude.

        Between zero and the table's first frequency the forces go smoothly to their hydrostatic limits (FK) and to
        zero (FD); above the last one they fall off with the fourth power of the frequency.

        Args:
            omega: Wave frequencies (n,) [rad/s]; the sign is ignored.
            beta_bem: Directions the waves travel to (n,) or (), from +x towards port [rad], any angle.

        Returns:
            FK and FD [N/m, N m/m], both (n, 6) complex, BEM frame about O, exp(-i omega t).
        """
        omega = np.abs(np.asarray(omega, dtype=np.float64))
        turned = np.remainder(np.asarray(beta_bem, dtype=np.float64) + np.pi, 2.0 * np.pi) - np.pi
        turned = np.broadcast_to(turned, omega.shape)
        row, along, fade = self._place(omega)
        place = np.abs(turned) * (_HEADINGS / np.pi)
        column = np.minimum(place.astype(np.intp), _HEADINGS - 1)
        across = _cubic_weights(place - column) * fade[:, None]
        weights = np.concatenate([across * (1.0 - along)[:, None], across * along[:, None]], axis=1)
        near = (row * _COLUMNS + column)[:, None] + _NEIGHBOURS
        parts = np.einsum("nk,nkp->np", weights, self._excitation_table.take(near, axis=0), optimize=False)
        both = parts.view(np.complex128).reshape(-1, 2, 6)
        both[:, :, ODD_IN_BETA] *= np.where(turned < 0.0, -1.0, 1.0)[:, None, None]
        return both[:, 0], both[:, 1]

    def _place(self, omega: FloatArray) -> tuple[NDArray[np.intp], FloatArray, FloatArray]:
        """Row below each frequency in the refined grid, share of the way to the next, and the fade above the last."""
        grid = self._omega_grid
        held = np.minimum(omega, grid[-1])
        low = np.minimum(np.searchsorted(grid, held, side="right") - 1, len(grid) - 2)
        share = (held - grid[low]) / (grid[low + 1] - grid[low])
        fade = (held / np.where(omega > 0.0, omega, 1.0)) ** _FADE
        return low, share, np.where(omega > grid[-1], fade, 1.0)

    @cached_property
    def _omega_grid(self) -> FloatArray:
        """Refined frequencies from 0; every frequency of the table is one of them."""
        step = float(np.median(np.diff(self.omega)))
        nodes = np.concatenate([[0.0], self.omega])
        pieces = np.maximum(np.ceil(_PER_STEP * np.diff(nodes) / step - 1e-6), 1.0).astype(int)
        parts = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(nodes[:-1], nodes[1:], pieces, strict=True)]
        return np.concatenate([*parts, nodes[-1:]])

    @cached_property
    def _radiation_table(self) -> FloatArray:
        """A and B of the two trios on the refined grid (2, 2, 3, 3, grid)."""
        grid, first = self._omega_grid, self.omega[0]
        both = _refined(self.omega, np.stack([self.A[0], self.B[0]]), np.stack([self.A, self.B], axis=1), grid).real
        # a multiple of the first matrix keeps damping damping; heave's grows with this power of omega in long waves
        low = grid < first
        both[low, 0] = self.A[0]
        both[low, 1] = (grid[low] / first)[:, None, None] ** 3 * self.B[0]
        trios = np.stack([both[:, :, dofs, dofs] for dofs in TRIOS], axis=2)
        return np.ascontiguousarray(np.moveaxis(trios, 0, -1))

    @cached_property
    def _own_radiation_table(self) -> FloatArray:
        """Diagonals of `_radiation_table` (2, 2, 3, grid)."""
        each = np.arange(3)
        return np.ascontiguousarray(self._radiation_table[:, :, each, each])

    @cached_property
    def _excitation_table(self) -> FloatArray:
        """Parts of FK and FD, a row (24,) for every refined frequency and heading; one heading more at either end."""
        fine: FloatArray = np.linspace(-np.pi / _HEADINGS, np.pi * (1.0 + 1.0 / _HEADINGS), _COLUMNS)
        both = np.stack([self.FK, self.FD], axis=2)
        dense: ComplexArray = np.einsum("ij,njfd->nifd", _cosine_weights(self.beta, fine), both, optimize=False)
        odd = np.einsum("ij,njfd->nifd", _sine_weights(self.beta, fine), both[..., ODD_IN_BETA], optimize=False)
        dense[..., ODD_IN_BETA] = odd
        rest = np.zeros(dense.shape[1:], dtype=np.complex128)
        rest[:, 0, 2] = self.water_density * self.gravity * self.A_wp
        rest[:, 0, 4] = -self.water_density * self.gravity * self.S_x
        table = _refined(self.omega, rest, dense, self._omega_grid)
        return table.reshape(-1, 12).view(np.float64)


def load_hull(name: str | Path) -> HullDatabase:
    """The database of a hull, read once and kept.

    Args:
        name: Name of a hull of the package (``frigate``) or path of an npz file.

    Raises:
        ConfigurationError: There is no such hull, or the file is not a hull database.
    """
    given = Path(name)
    path = given if given.suffix == ".npz" else DATA / f"{name}.npz"
    if not path.is_file():
        known = ", ".join(sorted(entry.stem for entry in DATA.glob("*.npz")))
        raise refusal("hull", "database", str(name), f"a hull of the package ({known}) or the path of an npz file")
    about = path.stat()
    return _read(path.resolve(), about.st_mtime_ns, about.st_size)


@lru_cache(maxsize=8)
def _read(path: Path, modified_ns: int, size: int) -> HullDatabase:
    """Read and check one file; its time and size are part of the cache's key."""
    try:
        with closing(np.load(path, allow_pickle=False)) as file:
            raw = {key: file[key] for key in file.files}
    except (OSError, EOFError, ValueError, AttributeError, BadZipFile) as error:
        raise ConfigurationError(f"{path}: this is not a hull database, an npz file without objects.") from error
    missing = [key for key in ("name", "provenance", *SCALARS, *ARRAYS) if key not in raw]
    if missing:
        raise ConfigurationError(f"{path}: the hull database lacks {', '.join(missing)}.")
    try:
        provenance = dict(json.loads(str(raw["provenance"])))
    except (ValueError, TypeError) as error:
        raise ConfigurationError(f"{path}: provenance is to be a JSON object.") from error
    for key in (*SCALARS, *ARRAYS):
        dimensions, kinds = DIMENSIONS.get(key, 0), "fiuc" if key in COMPLEX else "fiu"
        if raw[key].ndim != dimensions or raw[key].dtype.kind not in kinds:
            found = f"{raw[key].dtype} {raw[key].shape}"
            raise refusal(str(path), key, found, f"numbers in {dimensions} dimensions, complex only in FK and FD")
    arrays = {key: raw[key].astype(np.complex128 if key in COMPLEX else np.float64) for key in ARRAYS}
    scalars = {key: float(raw[key]) for key in SCALARS}
    _check(str(path), scalars, arrays)
    fields: dict[str, Any] = scalars | arrays
    return HullDatabase(name=str(raw["name"]), provenance=provenance, **fields)


def _check(source: str, scalars: dict[str, float], arrays: dict[str, NDArray[Any]]) -> None:
    """Refuse arrays that do not fit together, values that are not finite, and grids that are not as documented."""
    n, m = len(arrays["omega"]), len(arrays["beta"])
    shapes = {"omega": (n,), "beta": (m,), "A": (n, 6, 6), "B": (n, 6, 6), "FK": (n, m, 6), "FD": (n, m, 6)}
    for key, shape in shapes.items():
        if arrays[key].shape != shape:
            raise refusal(source, key, arrays[key].shape, f"its shape is to be {shape}")
    for key, value in (scalars | arrays).items():
        if not np.all(np.isfinite(np.asarray(value))):
            raise refusal(source, key, "nan or inf", "every number is to be finite")
    for key in ("length_m", "beam_m", "draught_m", "volume_m3", "water_density", "gravity", "A_wp", "I_T", "I_L"):
        if scalars[key] <= 0.0:
            raise refusal(source, key, scalars[key], "it is to be above 0")
    omega, beta = arrays["omega"], arrays["beta"]
    if n < 4 or omega[0] <= 0.0 or np.any(np.diff(omega) <= 0.0):
        raise refusal(source, "omega", omega.tolist(), "at least 4 increasing frequencies above 0")
    if m < 7 or not np.allclose(beta, np.linspace(0.0, np.pi, m), atol=1e-6):
        raise refusal(source, "beta", beta.tolist(), "at least 7 directions evenly spaced from 0 to pi")


def _refined(omega: FloatArray, rest: NDArray[Any], values: NDArray[Any], grid: FloatArray) -> ComplexArray:
    """Cubic spline over the frequency through `rest` at zero (slope 0 there) and `values` at `omega`, on `grid`."""
    from scipy.interpolate import CubicSpline

    nodes = np.concatenate([[0.0], omega])
    data = np.concatenate([rest[None], values]).astype(np.complex128)
    spline = CubicSpline(nodes, data, axis=0, bc_type=((1, np.zeros(data.shape[1:])), "not-a-knot"))
    return np.ascontiguousarray(spline(grid))


def _cubic_weights(share: FloatArray) -> FloatArray:
    """Weights (n, 4) of the cubic through four evenly spaced values, at `share` of the way from the second on."""
    before, after, beyond = share + 1.0, share - 1.0, share - 2.0
    return np.stack(
        [
            share * after * beyond / -6.0,
            before * after * beyond / 2.0,
            before * share * beyond / -2.0,
            before * share * after / 6.0,
        ],
        axis=1,
    )


def _cosine_weights(beta: FloatArray, fine: FloatArray) -> FloatArray:
    """Weights (fine, beta) of the cosine series through even values at evenly spaced directions from 0 to pi."""
    last = len(beta) - 1
    order = np.arange(last + 1)
    half = np.where((order == 0) | (order == last), 0.5, 1.0)
    waves = np.cos(np.outer(fine, order)) * half
    weights: FloatArray = np.einsum("im,jm->ij", waves, np.cos(np.outer(beta, order)), optimize=False)
    return weights * half * (2.0 / last)


def _sine_weights(beta: FloatArray, fine: FloatArray) -> FloatArray:
    """Weights (fine, beta) of the sine series through odd values at evenly spaced directions from 0 to pi."""
    last = len(beta) - 1
    order = np.arange(1, last)
    waves = np.sin(np.outer(fine, order)) * (2.0 / last)
    weights: FloatArray = np.einsum("im,jm->ij", waves, np.sin(np.outer(beta, order)), optimize=False)
    return weights
