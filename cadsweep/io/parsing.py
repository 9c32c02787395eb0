"""Numbers of a text, many at once: compiled, and correctly rounded.

Place in the flow: for :func:`cadsweep.io.text.parse_numbers`.

A number of up to 18 digits is an integer times a power of ten. Integer and power, up to 1e22, are exact as one float or
the sum of two, and so is what a first quotient or product leaves: with it the result is known to more than a hundred
bits, so that its rounding is known but where these lie halfway between two floats, as near as that. Such numbers, and
those of more digits or greater powers, are left to Python, one by one.

References
----------
W. D. Clinger, "How to read floating point numbers accurately", 1990. T. J. Dekker, "A floating-point technique for
extending the available precision", 1971.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, IntArray
from ..compiled import compiled

_POWERS = 10.0 ** np.arange(23)
_SPLIT = 134217729.0  # 2**27 + 1
_BLANK, _COMMA, _PLUS, _MINUS, _POINT, _ZERO, _NINE = 32, 44, 43, 45, 46, 48, 57
_MOST_DIGITS = 18
_NEAR_HALF = 1e-9
"""How near to half a unit in the last place, in such units, the rest of a quotient may be: it is known to 1e-15."""


@compiled(cache=True, nogil=True)
def parse_whole(text, numbers):  # type: ignore[no-untyped-def]
    """Write the whole numbers of a text into (n,); returns how many, or minus one less than the place of a fault."""
    n, k, count = len(text), 0, 0
    while True:
        while k < n and (text[k] <= _BLANK or text[k] == _COMMA):
            k += 1
        if k == n:
            return count
        negative = text[k] == _MINUS
        if negative or text[k] == _PLUS:
            k += 1
        first, value = k, 0
        while k < n and _ZERO <= text[k] <= _NINE:
            value = 10 * value + (text[k] - _ZERO)
            k += 1
        if k == first or k - first > _MOST_DIGITS or (k < n and text[k] > _BLANK and text[k] != _COMMA):
            return -1 - k
        numbers[count] = -value if negative else value
        count += 1


@compiled(cache=True, nogil=True)
def parse_floats(text, numbers, left):  # type: ignore[no-untyped-def]
    """Write floats into (n,); returns how many, and how many are left to Python: which and where, in `left` (n, 3)."""
    n, k, count, n_left = len(text), 0, 0, 0
    while True:
        while k < n and (text[k] <= _BLANK or text[k] == _COMMA):
            k += 1
        if k == n:
            return count, n_left
        begin = k
        negative = text[k] == _MINUS
        if negative or text[k] == _PLUS:
            k += 1
        value, digits, power, any_digit = 0, 0, 0, False
        seen_point = False
        while k < n and (_ZERO <= text[k] <= _NINE or (text[k] == _POINT and not seen_point)):
            if text[k] == _POINT:
                seen_point = True
            else:
                any_digit = True
                digits += 1 if digits > 0 or text[k] != _ZERO else 0
                value = 10 * value + (text[k] - _ZERO) if digits <= _MOST_DIGITS else value
                power -= 1 if seen_point else 0
            k += 1
        if any_digit and k + 1 < n and text[k] in (68, 69, 100, 101):  # D, E, d, e
            k += 1
            down = text[k] == _MINUS
            k += 1 if down or text[k] == _PLUS else 0
            first, exponent = k, 0
            while k < n and _ZERO <= text[k] <= _NINE and k - first < 5:
                exponent = 10 * exponent + (text[k] - _ZERO)
                k += 1
            any_digit = k > first
            power += -exponent if down else exponent
        is_whole = any_digit and (k == n or text[k] <= _BLANK or text[k] == _COMMA)
        while k < n and text[k] > _BLANK and text[k] != _COMMA:
            k += 1
        found, sure = 0.0, is_whole and digits <= _MOST_DIGITS and -23 < power < 23
        if sure and value != 0:
            found, sure = _scaled(value, power)
        if not sure:
            left[n_left, 0], left[n_left, 1], left[n_left, 2] = count, begin, k
            n_left += 1
        numbers[count] = -found if negative else found
        count += 1


@compiled(cache=True, nogil=True)
def _scaled(value, power):  # type: ignore[no-untyped-def]
    """An integer below 1e18 times a power of ten from 1e-22 to 1e22; and whether it is sure to be rounded rightly."""
    high = float(value)
    low = float(value - np.int64(high))
    scale = _POWERS[abs(power)]
    if power == 0 or (low == 0.0 and abs(high) <= 9007199254740992.0):
        return (high / scale if power < 0 else high * scale), True
    first = high / scale if power < 0 else high * scale
    # The exact product of two floats, as the sum of two.
    one, other = (first, scale) if power < 0 else (high, scale)
    a = _SPLIT * one
    a = a - (a - one)
    b = _SPLIT * other
    b = b - (b - other)
    product = one * other
    error = ((a * b - product) + a * (other - b) + (one - a) * b) + (one - a) * (other - b)
    rest = ((high - product) - error + low) / scale if power < 0 else error + low * scale
    found = first + rest
    gap = rest - (found - first)
    unit = np.abs(np.nextafter(found, np.inf) - found)
    below = np.abs(found - np.nextafter(found, -np.inf))
    half = 0.5 * min(unit, below)
    return found, np.abs(np.abs(gap) - half) > _NEAR_HALF * unit and np.abs(gap) < half


def _letters(text: bytes | np.ndarray) -> np.ndarray:
    """Characters that may be written to: one type for the compiled loops."""
    return text if isinstance(text, np.ndarray) else np.frombuffer(text, dtype=np.uint8).copy()


def floats(text: bytes | np.ndarray) -> FloatArray:
    """Floats (n,) of a text, between blanks, commas and line ends.

    Raises
    ------
    ValueError
        A word is no number.
    """
    letters = _letters(text)
    numbers = np.empty(len(letters) // 2 + 1)
    left = np.empty((len(numbers), 3), dtype=np.int64)
    count, n_left = parse_floats(letters, numbers, left)
    for place, begin, end in left[:n_left].tolist():
        numbers[place] = float(letters[begin:end].tobytes().replace(b"D", b"E").replace(b"d", b"e").replace(b"_", b"?"))
    return numbers[:count].copy()


def whole_numbers(text: bytes | np.ndarray) -> IntArray:
    """Whole numbers (n,) of a text, alike."""
    letters = _letters(text)
    numbers = np.empty(len(letters) // 2 + 1, dtype=np.int64)
    count = parse_whole(letters, numbers)
    if count < 0:
        raise ValueError(f"no whole number at {letters[max(0, -count - 20) : 20 - count].tobytes()!r}")
    return numbers[:count].copy()
