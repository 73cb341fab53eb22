"""Sets of small integers as Python integers."""


def bits(mask: int) -> list[int]:
    """The members of a set given as a bitmask, in increasing order."""
    found: list[int] = []
    while mask:
        low = mask & -mask
        found.append(low.bit_length() - 1)
        mask ^= low
    return found
