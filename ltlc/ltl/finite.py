"""What formulas about finite traces have besides those about infinite words.

References:
    Giuseppe De Giacomo and Moshe Y. Vardi, Linear temporal logic and linear dynamic logic on finite traces, IJCAI 2013.
"""

from __future__ import annotations

from ltlc.ltl.formula import FALSE, Unary
from ltlc.ltl.shape import NO_PAST


class WeakNext(Unary):
    """WX f: f holds at the next position, if there is one; on infinite words the same as X f."""

    __slots__ = ()
    symbol = "WX"
    _tense = NO_PAST


LAST = WeakNext(FALSE)
"""There is no next position: `last` of a finite trace."""
