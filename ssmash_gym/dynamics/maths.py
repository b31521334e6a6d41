"""Elementary functions of numbers, written once for lanes and NumPy, with the same bits in both.

Short polynomials after a range reduction, in plain IEEE-754 arithmetic: no library function is called, so that the
same input gives the same bits on any machine. Errors are a few units in the last place (ulp), stated with each
function. A finite argument never gives an infinite result or one that is not a number, however far outside the
stated domain it lies; one that is not a number gives one that is not a number.

The fdlibm polynomials of ``log``, ``sin`` and ``cos`` are Sun Microsystems' (1993); the others are minimax fits.
"""

from __future__ import annotations

from typing import Any, Final

from ssmash_gym.dynamics.lane import (
    copysign,
    exponent,
    fabs,
    integer_bit,
    kernel,
    mantissa,
    maximum,
    minimum,
    pow2,
    sqrt,
    where,
)

__all__ = ["asin", "atan2", "cbrt", "cos", "exp", "expm1", "log", "power", "round_integer", "sign", "sin", "sincos"]

ROUNDER: Final = 6755399441055744.0  # 1.5 * 2**52
TINY: Final = 2.2250738585072014e-308  # smallest normal number
HUGE: Final = 1.7976931348623157e308  # largest finite number

INV_LN2: Final = 1.4426950408889634
LN2_HI: Final = 0.6931471803691238  # 32 bits, so that products with whole exponents are exact
LN2_LO: Final = 1.9082149292705877e-10
EXP_LEAST: Final = -708.0  # below it exp is 0
EXP_MOST: Final = 709.78  # from there on exp stays at its value
EXPM1_LEAST: Final = -60.0  # exp(x) - 1 is -1 to the last bit
EXPM1_MOST: Final = 709.0

INV_PI_2: Final = 0.6366197723675814
PI_2_A: Final = 1.5707963267341256  # pi / 2 in three parts, the first two of 33 bits
PI_2_B: Final = 6.077100506303966e-11
PI_2_C: Final = 2.0222662487959506e-21
PI_4: Final = 0.7853981633974483
PI_4_LO: Final = 3.061616997868383e-17
PI_2: Final = 1.5707963267948966
PI_2_LO: Final = 6.123233995736766e-17
PI: Final = 3.141592653589793
PI_LO: Final = 1.2246467991473532e-16


@kernel
def round_integer(x: Any) -> Any:
    """Nearest whole number, halves to the even one, for ``|x| < 2**51``."""
    return (x + ROUNDER) - ROUNDER


@kernel
def sign(x: Any) -> Any:
    """1, 0 or -1."""
    return where(x > 0.0, 1.0, where(x < 0.0, -1.0, 0.0))


@kernel
def _exp_parts(x: Any) -> tuple[Any, Any]:
    """``(n, e^r - 1)`` with ``x = n ln 2 + r``, ``n`` whole, ``|r| <= ln 2 / 2``."""
    n = round_integer(x * INV_LN2)
    r = (x - n * LN2_HI) - n * LN2_LO
    r2 = r * r
    r4 = r2 * r2
    low = (0.1666666666666668 + 0.04166666666661954 * r) + r2 * (0.008333333333318965 + 0.0013888888920710457 * r)
    high = (0.00019841269894331425 + 2.4801516069993785e-05 * r) + r2 * (
        2.7557235126971275e-06 + 2.7622345709165994e-07 * r
    )
    cubic = low + r4 * (high + r4 * 2.5112365545872352e-08)
    return n, r + r2 * (0.5 + r * cubic)


@kernel
def exp(x: Any) -> Any:
    """``e^x`` within 1 ulp for -708 <= x <= 709.78; 0 below, ``e^709.78`` above."""
    bounded = minimum(EXP_MOST, maximum(EXP_LEAST, x))
    n, rest = _exp_parts(bounded)
    value = rest + 1.0
    return where(x < EXP_LEAST, 0.0, (value + value) * pow2(n - 1.0))


@kernel
def expm1(x: Any) -> Any:
    """``e^x - 1`` within 2.5 ulp for x <= 709, near 0 too; ``e^709`` above."""
    n, rest = _exp_parts(minimum(EXPM1_MOST, maximum(EXPM1_LEAST, x)))
    scale = pow2(n)
    return scale * rest + (scale - 1.0)


@kernel
def log(x: Any) -> Any:
    """Natural logarithm within 1 ulp for x >= 2.3e-308; below (zero and negative numbers too) it stays at -708.4."""
    bounded = maximum(TINY, x)
    n = exponent(bounded)
    m = mantissa(bounded)
    upper = m > 1.4142135623730951
    n = where(upper, n + 1.0, n)
    f = where(upper, 0.5 * m, m) - 1.0
    s = f / (2.0 + f)
    z = s * s
    w = z * z
    odd = w * (0.3999999999940941908 + w * (0.2222219843214978396 + w * 0.1531383769920937332))
    even = z * (
        0.6666666666666735130 + w * (0.2857142874366239149 + w * (0.1818357216161805012 + w * 0.1479819860511658591))
    )
    half = 0.5 * f * f
    value = n * LN2_HI - ((half - (s * (half + (odd + even)) + n * LN2_LO)) - f)
    return where(x <= HUGE, value, x)


@kernel
def power(x: Any, y: Any) -> Any:
    """``x^y`` for x > 0, as ``exp(y log x)``: within ``3 + 1.5 |y log x|`` ulp; 0 where that is below ``e^-708``."""
    return exp(y * log(x))


@kernel
def cbrt(x: Any) -> Any:
    """Cube root within 1 ulp for x >= 2.3e-308; 0 below (zero and negative numbers too)."""
    n = exponent(x)
    m = mantissa(x)
    third = round_integer((n - 1.0) * 0.3333333333333333)
    rest = n - 3.0 * third  # 0, 1 or 2
    two = rest > 1.5
    one = rest > 0.5
    m2 = m * m
    guess = (0.4733307024958717 + 0.8381599506592102 * m) + m2 * (
        (-0.4692286049119944 + 0.2027771516270553 * m) + m2 * (-0.05038651307376131 + 0.005348544149595137 * m)
    )
    guess = guess * where(two, 1.5874010519681994, where(one, 1.2599210498948732, 1.0))
    m = m * where(two, 4.0, where(one, 2.0, 1.0))
    cube = guess * guess * guess
    root = guess + guess * (m - cube) / (cube + cube + m)  # Halley
    return where(x < TINY, 0.0, where(x <= HUGE, root * pow2(third), x))


@kernel
def sincos(x: Any) -> tuple[Any, Any]:
    """``(sin x, cos x)`` within 2.5 ulp for ``|x| <= 1e6``; beyond, some number in [-1, 1]."""
    n = round_integer(x * INV_PI_2)
    r = ((x - n * PI_2_A) - n * PI_2_B) - n * PI_2_C
    r = minimum(0.7853982, maximum(-0.7853982, r))  # only beyond the domain
    z = r * r
    w = z * z
    s = r + r * z * (
        (-1.66666666666666324348e-01 + 8.33333333332248946124e-03 * z)
        + w
        * (
            (-1.98412698298579493134e-04 + 2.75573137070700676789e-06 * z)
            + w * (-2.50507602534068634195e-08 + 1.58969099521155010221e-10 * z)
        )
    )
    tail = (4.16666666666666019037e-02 - 1.38888888888741095749e-03 * z) + w * (
        (2.48015872894767294178e-05 - 2.75573143513906633035e-07 * z)
        + w * (2.08757232129817482790e-09 - 1.13596475577881948265e-11 * z)
    )
    half = 0.5 * z
    near = 1.0 - half
    c = near + (((1.0 - near) - half) + w * tail)
    swap = integer_bit(n, 0)
    sine = where(swap, c, s)
    cosine = where(swap, s, c)
    return (
        where(integer_bit(n, 1), -sine, sine),
        where(integer_bit(n + 1.0, 1), -cosine, cosine),
    )


@kernel
def sin(x: Any) -> Any:
    """Sine within 2.5 ulp for ``|x| <= 1e6``; beyond, some number in [-1, 1]."""
    return sincos(x)[0]


@kernel
def cos(x: Any) -> Any:
    """Cosine within 2.5 ulp for ``|x| <= 1e6``; beyond, some number in [-1, 1]."""
    return sincos(x)[1]


@kernel
def atan2(y: Any, x: Any) -> Any:
    """Angle of the point ``(x, y)`` from the x axis, -pi to pi, within 2 ulp; 0 at the origin.

    A negative zero x counts as zero; the result has the sign bit of y.
    """
    ax = fabs(x)
    ay = fabs(y)
    swap = ay > ax
    most = where(swap, ay, ax)
    least = where(swap, ax, ay)
    diagonal = least > 0.4142135623730951 * most  # over tan(pi / 8): angle from the diagonal
    below = where(diagonal, most + least, most)
    t = where(diagonal, least - most, least) / where(most <= 0.0, 1.0, below)
    z = t * t
    w = z * z
    w2 = w * w
    low = (0.333333333333332 - 0.1999999999995404 * z) + w * (0.1428571428024414 - 0.11111110785908708 * z)
    middle = (0.09090897829588745 - 0.07692061510743156 * z) + w * (0.0666311890237485 - 0.05847997834426511 * z)
    high = (0.05039794315107756 - 0.03807699020679718 * z) + w * 0.017920791080588916
    a = t - t * z * (low + w2 * (middle + w2 * high))
    a = where(diagonal, PI_4 + (a + PI_4_LO), a)
    a = where(swap, PI_2 - (a - PI_2_LO), a)
    a = where(x < 0.0, PI - (a - PI_LO), a)
    return copysign(a, y)


@kernel
def asin(x: Any) -> Any:
    """Arc sine within 3 ulp for ``|x| <= 1``; the argument is held within [-1, 1]."""
    bounded = minimum(1.0, maximum(-1.0, x))
    return atan2(bounded, sqrt((1.0 - bounded) * (1.0 + bounded)))
