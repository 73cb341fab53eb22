"""Reward schemes by name."""

from __future__ import annotations

import dataclasses
from typing import Any

from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.registry import Registry
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


def _check(name: str, part: Any) -> type[RewardScheme]:
    """A reward scheme that can be made with its defaults."""
    if not (isinstance(part, type) and issubclass(part, RewardScheme) and dataclasses.is_dataclass(part)):
        raise InvalidArgumentError(
            f"reward scheme {name!r}: {part!r} is no dataclass that derives from ltlc.rewards.RewardScheme"
        )
    missing = [attribute for attribute in ("name", "citation", "guarantee", "requires") if not hasattr(part, attribute)]
    if missing:
        raise InvalidArgumentError(f"reward scheme {name!r} does not say its {', '.join(missing)}")
    return part


SCHEMES: Registry[type[RewardScheme]] = Registry("reward scheme", "ltlc.rewards", _check)
"""every scheme, by the name that `get_scheme`, `Task` and the command line know; `module:Class` is a name, too."""


def register_scheme(scheme: type[RewardScheme]) -> type[RewardScheme]:
    """Make a scheme known by its name; a class decorator, or a plain call.

    Installed packages offer theirs in the group of entry points "ltlc.rewards".

    Raises:
        InvalidArgumentError: it is no scheme, or another one has its name.

    Example:
        >>> from dataclasses import dataclass
        >>> from ltlc.rewards import register_scheme
        >>> @register_scheme
        ... @dataclass(frozen=True)
        ... class Generous(Accept):
        ...     name = "generous"
        >>> get_scheme("generous", gamma=0.9).parameters
        {'gamma': 0.9}
        >>> SCHEMES.remove("generous")
    """
    SCHEMES.register(getattr(scheme, "name", ""), scheme)
    return scheme


for _scheme in (Thesis, ThesisCode, Accept, Sadigh, Frontier, ZetaReach, ZetaDiscount, TwoDiscount, Eventual, Parity):
    register_scheme(_scheme)

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
    kind = type(scheme)
    known = scheme.name in SCHEMES and SCHEMES[scheme.name] is kind
    name = scheme.name if known else f"{kind.__module__}:{kind.__qualname__}"
    return name, {key: value for key, value in scheme.parameters.items() if value != defaults[key]} | shaping


def get_scheme(name: str, *, shaping: float = 0.0, **parameters: Any) -> RewardScheme:
    """A scheme by name, with some of its parameters set.

    Args:
        name: a key of `SCHEMES`, or `module:Class`.
        shaping: potential of an accepting cycle for shaping by distance to acceptance; 0 for none.
        parameters: fields of the scheme; the others keep the defaults of its paper.

    Raises:
        UnknownNameError: there is no such scheme, or it has no such parameter.
        InvalidArgumentError: a parameter is out of range.

    Example:
        >>> get_scheme("zeta-reach", zeta=0.999).parameters
        {'zeta': 0.999}
    """
    kind = SCHEMES[name]
    known = [field.name for field in dataclasses.fields(kind)]
    for parameter in parameters:
        if parameter not in known:
            raise UnknownNameError(f"parameter of reward scheme {name!r}:", parameter, [*known, "shaping"])
    scheme = kind(**parameters)
    return Shaped(scheme, shaping) if shaping else scheme
