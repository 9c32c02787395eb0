"""Compiled parsing of numbers gives what Python gives, to the bit."""

from __future__ import annotations

from decimal import Decimal

import numpy as np
import pytest

from cadsweep.io.parsing import floats, whole_numbers

rng = np.random.default_rng(7)
EXTREMES = [0.0, -0.0, 1e300, 1e-300, 5e-324, 1.7976931348623157e308, 123456789012345678.0, 2.0**53, 2.0**53 + 2]
SPREAD = np.concatenate([rng.random(4000), rng.normal(size=4000) * 10.0 ** rng.integers(-12, 15, 4000), EXTREMES])


@pytest.mark.parametrize("form", ["%r", "%.17g", "%25.16E", "%.15g", "%.10g", "%12.9f", "%.20f"])
def test_every_way_to_write_a_float_is_read_as_python_reads_it(form):
    words = [form % value for value in SPREAD.tolist()]
    expected = np.array([float(word) for word in words])
    assert floats(",\n".join(words).encode()).tobytes() == expected.tobytes()


def test_what_lies_halfway_between_two_floats_is_rounded_as_python_rounds():
    values = rng.random(3000) + 1
    halves = [str((Decimal(a) + Decimal(float(np.nextafter(a, 2)))) / 2) for a in values.tolist()]
    words = [half[:digits] for half in halves for digits in (18, 19, 20, 60)]
    # Odd integers above 2**53 lie exactly halfway, and have few enough digits to be scaled.
    words += [f"{(1 << 53) + 2 * k + 1}e{power}" for k in range(500) for power in (-3, 0, 2)]
    assert floats(" ".join(words).encode()).tobytes() == np.array([float(word) for word in words]).tobytes()


def test_whole_numbers_and_the_exponents_of_fortran():
    values = rng.integers(-(10**17), 10**17, 3000)
    assert (whole_numbers(b",\r\n".join(b"%d" % value for value in values.tolist())) == values).all()
    assert floats(b"1D3 2.5d-2 -1.e+2 .5 +7").tolist() == [1000.0, 0.025, -100.0, 0.5, 7.0]
    assert len(floats(b" \n")) == len(whole_numbers(b"")) == 0


@pytest.mark.parametrize("text", [b"1 2x 3", b"1.2.3", b"--1", b"1e", b"e5", b".", b"1_0", b"5S3", b"\xff"])
def test_what_is_no_number_is_refused(text):
    with pytest.raises(ValueError, match=r"convert|number"):
        floats(text)
    with pytest.raises(ValueError, match="number"):
        whole_numbers(text)
