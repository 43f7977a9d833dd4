"""The bits of every built-in scene by every method are those of `golden.json`; at every width: `make golden`."""

from __future__ import annotations

import json

import pytest
from golden import FILE, cases, differences

KNOWN = json.loads(FILE.read_text(encoding="utf-8"))
RUNS = dict(cases())


def test_the_file_holds_every_case() -> None:
    assert KNOWN.keys() == RUNS.keys()


@pytest.mark.parametrize("name", RUNS)
def test_a_motion_has_the_bits_that_are_known(name: str) -> None:
    assert differences({name: RUNS[name]("avx512")}, {name: KNOWN[name]}) == []
