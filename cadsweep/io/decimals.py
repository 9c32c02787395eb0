"""Numbers as decimal text, many at once: the digits of whole columns by integer arithmetic.

Place in the flow: for :mod:`.text`. What comes out is a table (width, n) of characters, one column a number, with 0
where a number has no character: such places are squeezed out, or blanked, when rows are put together.

A float times a power of ten up to 1e22 is exact as the sum of two floats (Dekker's product), so its digits are those of
the nearest integer. Fifteen digits are taken where they give the same float back, else sixteen, else all seventeen.
Numbers that this does not reach (tiny, huge) are written by Python, one by one.

References
----------
T. J. Dekker, "A floating-point technique for extending the available precision", 1971: the exact product.
W. D. Clinger, "How to read floating point numbers accurately", 1990: up to 2**53 divided by up to 1e22 is exact.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import FloatArray, IntArray

_POWERS = 10.0 ** np.arange(-5, 23)
_SPLIT = 134217729.0  # 2**27 + 1
_ZERO, _MINUS, _POINT, _SPACE = 48, 45, 46, 32
_DIGITS = 17
"""Digits that tell every float from its neighbours."""

_LEAST, _MOST = -4, 15
"""Exponents of ten that are written without one, as Python does."""


def whole_texts(values: IntArray, *, width: int = 0, base: int = 10) -> np.ndarray:
    """Integers (n,), not negative, in as many characters as the greatest needs; with `width`, blanked to the left."""
    greatest = int(np.max(values, initial=0))
    n_digits = 1
    while greatest >= base**n_digits:
        n_digits += 1
    if width and n_digits > width:
        raise OverflowError(f"{greatest} has more than {width} digits")
    rest: np.ndarray = values.astype(np.uint32 if greatest < 1 << 32 else np.uint64)
    table = np.zeros((max(width, n_digits), len(values)), dtype=np.uint8)
    if width:
        table[: width - n_digits] = _SPACE
    for row in range(len(table) - 1, len(table) - 1 - n_digits, -1):
        above = rest // base
        digits = (rest - above * base).astype(np.uint8)
        digits += _ZERO
        if base > 10:
            digits[digits > _ZERO + 9] += 39  # from ":" to "a"
        if row < len(table) - 1:  # no leading zeros, but for the number 0 itself
            digits[rest == 0] = _SPACE if width else 0
        table[row] = digits
        rest = above
    return table


def exact_texts(values: FloatArray) -> np.ndarray:
    """Floats (n,) as the shortest text that gives the same float back, or one of 17 digits."""
    table = np.zeros((25, len(values)), dtype=np.uint8)
    greatness = np.abs(values)
    exponents = _exponents(greatness)
    table[0] = np.where(np.signbit(values), _MINUS, 0)
    missed = (greatness != 0) & ((exponents < _LEAST) | (exponents > _MOST))
    zeros = np.flatnonzero(greatness == 0)
    table[1:4, zeros] = np.array([[_ZERO], [_POINT], [_ZERO]])
    for exponent in range(_LEAST, _MOST + 1):
        rows = np.flatnonzero((exponents == exponent) & (greatness != 0))
        if len(rows):
            digits, reached = _shortest(greatness[rows], exponent)
            missed[rows[~reached]] = True
            _lay_out(table, rows, digits, exponent)
    _by_python(table, values, missed, repr)
    return table


def fitted_texts(values: FloatArray, width: int) -> np.ndarray:
    """Floats (n,) in exactly `width` characters, with as many decimals as fit, correctly rounded, and a point."""
    table = np.full((width, len(values)), _ZERO, dtype=np.uint8)
    greatness = np.abs(values)
    exponents = _exponents(greatness)
    table[0] = np.where(np.signbit(values), _MINUS, _SPACE)
    missed = np.zeros(len(values), dtype=bool)
    missed[(greatness != 0) & ((exponents < -3) | (exponents > width - 4))] = True
    for exponent in [None, *range(-3, min(width - 3, 20))]:
        is_here = greatness == 0 if exponent is None else (exponents == exponent) & (greatness != 0)
        rows = np.flatnonzero(is_here)
        if not len(rows):
            continue
        n_whole = max(1, 1 + (exponent or 0))
        n_decimals = width - 2 - n_whole
        rest = _rounded(greatness[rows], n_decimals)
        missed[rows[rest >= 10 ** (n_whole + n_decimals)]] = True
        digits = _digits(rest, n_whole + n_decimals)
        table[1 : 1 + n_whole, rows] = digits[:n_whole]
        table[1 + n_whole, rows] = _POINT
        table[2 + n_whole :, rows] = digits[n_whole:]
    _by_python(table, values, missed, lambda value: fitted_text(value, width))
    return table


def fitted_text(value: float, width: int) -> str:
    """One float in `width` characters, the closest text that fits, with a point."""
    found = repr(value).upper()
    digits = _DIGITS
    while len(found) > width or "." not in found:
        digits -= 1
        found = f"{value:.{digits}g}".upper()
        if "." not in found:
            mantissa, mark, exponent = found.partition("E")
            found = f"{mantissa}.0{mark}{exponent}"
    return found.rjust(width)


def bounded_texts(values: FloatArray, width: int) -> np.ndarray:
    """Floats as :func:`exact_texts` has them, but where that takes more than `width` characters as many as fit."""
    table = exact_texts(values)
    long = np.flatnonzero(np.count_nonzero(table, axis=0) > width)
    if len(long):
        fitted = fitted_texts(values[long], width)
        fitted[fitted == _SPACE] = 0
        table[:, long] = 0
        table[:width, long] = fitted
    return table


def scientific_texts(values: FloatArray, width: int) -> np.ndarray:
    """Floats as ``%<width>.16E`` has them."""
    table = np.full((width, len(values)), _SPACE, dtype=np.uint8)
    greatness = np.abs(values)
    exponents = np.where(greatness == 0, 0, _exponents(greatness))
    start = width - 22
    table[start - 1] = np.where(np.signbit(values), _MINUS, _SPACE)
    missed = (exponents < -5) | (exponents > _MOST)
    for exponent in range(-5, _MOST + 1):
        rows = np.flatnonzero(exponents == exponent)
        if not len(rows):
            continue
        mantissa = _rounded(greatness[rows], _DIGITS - 1 - exponent)
        missed[rows[(greatness[rows] != 0) & ((mantissa < 10**16) | (mantissa >= 10**17))]] = True
        digits = _digits(mantissa, _DIGITS)
        table[start, rows] = digits[0]
        table[start + 1, rows] = _POINT
        table[start + 2 : start + 18, rows] = digits[1:]
        tail = np.frombuffer(f"E{exponent:+03d}".encode(), dtype=np.uint8)
        table[start + 18 :, rows] = tail[:, None]
    _by_python(table, values, missed, lambda value: f"{value:{width}.16E}")
    return table


def _exponents(greatness: FloatArray) -> IntArray:
    """Exponents of ten; one less than the least, or the greatest, power in the table, beyond it."""
    return np.searchsorted(_POWERS, greatness, side="right") - 6


def _rounded(values: FloatArray, n_decimals: int) -> IntArray:
    """The integer nearest to each value (n,) times a power of ten from 1 to 1e22; the result is below 2**63."""
    power = 10.0**n_decimals
    product = values * power
    high = _SPLIT * values
    high = high - (high - values)
    low = values - high
    power_high = _SPLIT * power
    power_high = power_high - (power_high - power)
    power_low = power - power_high
    error = ((high * power_high - product) + high * power_low + low * power_high) + low * power_low
    whole = np.floor(product)
    return whole.astype(np.int64) + np.rint((product - whole) + error).astype(np.int64)


def _shortest(values: FloatArray, exponent: int) -> tuple[np.ndarray, np.ndarray]:
    """Characters (17, n) of the digits, 0 after the last that is needed; and whether they are right."""
    whole = _rounded(values, _DIGITS - 1 - exponent)
    fifteen = (whole + 50) // 100
    scale = 14 - exponent
    same = (fifteen / 10.0**scale if scale >= 0 else fifteen * 10.0**-scale) == values
    found = np.where(same, fifteen * 100, whole)
    rest = np.flatnonzero(~same)
    if len(rest):
        sixteen = (whole[rest] + 5) // 10 * 10
        # Half the way to the next float below, in units of the last digit; half a unit is lost to rounding.
        room = (values[rest] - np.nextafter(values[rest], 0)) * (0.5 * 10.0 ** (_DIGITS - 1 - exponent))
        close = np.abs(sixteen - whole[rest]) + 0.5 < room
        found[rest[close]] = sixteen[close]
    reached = (found >= 10**16) & (found < 10**17)
    digits = _digits(np.where(reached, found, 0), _DIGITS)
    needed = np.maximum.accumulate((digits != _ZERO)[::-1], axis=0)[::-1]
    digits[~needed] = 0
    return digits, reached


def _lay_out(table: np.ndarray, rows: IntArray, digits: np.ndarray, exponent: int) -> None:
    """Put digits (17, n) and a point into columns of a table, from its second row on."""
    n_whole = exponent + 1
    if n_whole > 0:
        table[1 : 1 + n_whole, rows] = np.maximum(digits[:n_whole], _ZERO)
        table[1 + n_whole, rows] = _POINT
        decimals = digits[n_whole:]
        decimals[0] = np.maximum(decimals[0], _ZERO)  # "3.0"
        table[2 + n_whole : 2 + n_whole + len(decimals), rows] = decimals
        return
    table[1, rows] = _ZERO
    table[2, rows] = _POINT
    table[3 : 3 - n_whole, rows] = _ZERO
    table[3 - n_whole : 3 - n_whole + _DIGITS, rows] = digits


def _digits(values: IntArray, n_digits: int) -> np.ndarray:
    """Characters (n_digits, n) of integers, leading zeros included."""
    table = np.empty((n_digits, len(values)), dtype=np.uint8)
    above = values // 10**9
    row = n_digits
    for part, count in ((values - above * 10**9, min(9, n_digits)), (above, max(0, n_digits - 9))):
        rest = part.astype(np.uint32)
        for _ in range(count):
            row -= 1
            quotient = rest // 10
            np.subtract(rest, quotient * 10, out=table[row], casting="unsafe")
            rest = quotient
    table += _ZERO
    return table


def _by_python(table: np.ndarray, values: FloatArray, missed: np.ndarray, text: Callable[[float], str]) -> None:
    """Write the numbers that were missed one by one, to the left of their columns."""
    for column in np.flatnonzero(missed).tolist():
        found = text(float(values[column])).encode()
        table[:, column] = 0
        table[: len(found), column] = np.frombuffer(found, dtype=np.uint8)
