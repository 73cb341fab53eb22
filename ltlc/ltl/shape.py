"""What the shape of a formula shows: the bits of `Formula.flags`."""

from __future__ import annotations

EVENTUAL, UNIVERSAL = 1, 2
"""A pure eventuality; a pure universality (see `ltlc.ltl.hierarchy`)."""
SUSPENDABLE = EVENTUAL | UNIVERSAL
NORMAL, LITERAL = 4, 8
"""In negation normal form; a proposition or the negation of one."""
NO_PAST, NO_FUTURE = 16, 32
"""Without operators of the past; without those of the future."""
PRESENT = NO_PAST | NO_FUTURE
"""Without any temporal operator."""
