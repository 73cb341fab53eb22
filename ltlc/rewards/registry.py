"""Reward schemes by name."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from ltlc.errors import UnknownNameError
from ltlc.rewards.accept import Accept
from ltlc.rewards.eventual import Eventual
from ltlc.rewards.frontier import Frontier
from ltlc.rewards.parity import Parity
from ltlc.rewards.sadigh import Sadigh
from ltlc.rewards.scheme import RewardScheme
from ltlc.rewards.shaping import Shaped
from ltlc.rewards.thesis import Thesis, ThesisCode
from ltlc.rewards.two_discount import TwoDiscount
from ltlc.rewards.zeta_discount import ZetaDiscount
from ltlc.rewards.zeta_reach import ZetaReach

_ALL = (Thesis, ThesisCode, Sadigh, Accept, ZetaReach, ZetaDiscount, TwoDiscount, Eventual, Frontier, Parity)
SCHEMES: Mapping[str, type[RewardScheme]] = MappingProxyType({scheme.name: scheme for scheme in _ALL})
"""every scheme, by the name that `get_scheme`, `Task` and the command line know."""

RECOMMENDED = TwoDiscount.name
"""the scheme that is taken where none is named: in the limit its optimum maximises the probability of satisfaction for
every formula, its values lie in [0, 1], and its discount prefers the shorter of two ways."""


def arguments_of(scheme: RewardScheme) -> tuple[str, dict[str, Any]]:
    """What `get_scheme` makes a scheme from: its name, and the parameters that are not those of its paper.

    Example:
        >>> arguments_of(get_scheme("zeta-reach", zeta=0.999, shaping=2.0))
        ('zeta-reach', {'zeta': 0.999, 'shaping': 2.0})
    """
    shaping = {}
    while isinstance(scheme, Shaped):
        shaping = {"shaping": scheme.weight}
        scheme = scheme.scheme
    defaults = {field.name: field.default for field in dataclasses.fields(scheme)}
    return scheme.name, {key: value for key, value in scheme.parameters.items() if value != defaults[key]} | shaping


def get_scheme(name: str, *, shaping: float = 0.0, **parameters: Any) -> RewardScheme:
    """A scheme by name, with some of its parameters set.

    Args:
        name: a key of `SCHEMES`.
        shaping: potential of an accepting cycle for shaping by distance to acceptance; 0 for none.
        parameters: fields of the scheme; the others keep the defaults of its paper.

    Raises:
        UnknownNameError: there is no such scheme, or it has no such parameter.
        InvalidArgumentError: a parameter is out of range.

    Example:
        >>> get_scheme("zeta-reach", zeta=0.999).parameters
        {'zeta': 0.999}
    """
    if name not in SCHEMES:
        raise UnknownNameError("reward scheme", name, SCHEMES)
    known = [field.name for field in dataclasses.fields(SCHEMES[name])]
    for parameter in parameters:
        if parameter not in known:
            raise UnknownNameError(f"parameter of reward scheme {name!r}:", parameter, [*known, "shaping"])
    scheme = SCHEMES[name](**parameters)
    return Shaped(scheme, shaping) if shaping else scheme
