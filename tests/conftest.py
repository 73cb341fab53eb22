"""What `make test-fast` leaves out, besides the tests that are marked, and what several workers begin with."""

from __future__ import annotations

from collections import Counter

import pytest

FAST_CASES = 2
"""of each test with parameters; the others count as slow."""


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    cases: Counter[str] = Counter()
    for item in items:
        test = item.nodeid.partition("[")[0]
        cases[test] += 1
        if cases[test] > FAST_CASES:
            item.add_marker(pytest.mark.slow)
    if hasattr(config, "workerinput"):  # of pytest-xdist, which then builds only once, and ends with short tests
        items.sort(key=lambda item: item.get_closest_marker("build") is None)
