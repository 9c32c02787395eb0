"""References of a STEP file that go in circles."""

import numpy as np
import pytest

from cadsweep.cad.read.step_text import numbers_of, on_circle


def circle_of(pairs, n):
    rows, columns = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    return on_circle(rows, columns, n)


@pytest.mark.parametrize("pairs", [[], [(0, 1), (1, 2), (0, 2)], [(j, j + 1) for j in range(999)]])
def test_tree_has_none(pairs):
    assert circle_of(pairs, 1000) is None


@pytest.mark.parametrize("length", [1, 2, 5, 500])
@pytest.mark.parametrize("tail", [0, 3, 300])
def test_entity_on_the_circle_is_named_not_one_that_leads_to_it(length, tail):
    lead = [(j, j + 1) for j in range(tail)]
    ring = [(tail + j, tail + (j + 1) % length) for j in range(length)]
    leaves = [(tail, tail + length)]
    found = circle_of(lead + ring + leaves, tail + length + 1)
    assert tail <= found < tail + length


@pytest.mark.parametrize(
    ("text", "numbers", "begins"),
    [
        (b"#1=A(#2,\n#30);#2 \r\n= B(#1)", [1, 2, 30, 2, 1], [True, False, False, True, False]),
        (b"#7='#8 it''s #9'(#10)", [7, 10], [True, False]),  # strings, with a quote in them
        (b"#1=(#,#x,'#2'/* '#3 */#4)/* #5", [1, 4, 5], [True, False, False]),  # a comment, and one that never ends
        (b"#1='a'(#2)'#3", [1, 2, 3], [True, False, False]),  # a string that never ends is none
        (b"", [], []),
        (b"#12", [12], [False]),
    ],
)
def test_numbers_of_entities_are_those_outside_of_strings_and_comments(text, numbers, begins):
    found, is_begin = numbers_of(text)
    assert found.tolist() == numbers
    assert is_begin.tolist() == begins
