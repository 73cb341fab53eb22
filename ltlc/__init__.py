"""LTL to deterministic Rabin automata to rewards for reinforcement learning.

>>> import ltlc
>>> dra = ltlc.compile("G(request -> F grant)")
>>> dra.accepts(cycle=[{"request"}, {"grant"}])
True

The names below are imported on first use: `import ltlc` itself loads nothing but the standard library.
"""

import os.path as _path
from typing import TYPE_CHECKING

# The wheel carries agents/ and grammars/ inside this package; a checkout keeps them beside it.
if not _path.isdir(_path.join(__path__[0], "grammars")):
    __path__.append(_path.dirname(__path__[0]))

from ltlc.lazy import on_first_use as _on_first_use
from ltlc.version import __version__

if TYPE_CHECKING:
    from ltlc.automata import DFA, DRA
    from ltlc.compiler import compile, load
    from ltlc.envs import LTLVectorWrapper, LTLWrapper
    from ltlc.errors import LimitExceeded, LtlcError, LtlSyntaxError
    from ltlc.judging import judge
    from ltlc.ltl import Formula, LassoWord, parse, parse_word, satisfies
    from ltlc.many import compile_many
    from ltlc.mdp import Judge
    from ltlc.monitor import Monitor, Verdict
    from ltlc.task import Task

__all__ = [
    "DFA",
    "DRA",
    "Formula",
    "Judge",
    "LTLVectorWrapper",
    "LTLWrapper",
    "LassoWord",
    "LimitExceeded",
    "LtlSyntaxError",
    "LtlcError",
    "Monitor",
    "Task",
    "Verdict",
    "__version__",
    "compile",
    "compile_many",
    "judge",
    "load",
    "parse",
    "parse_word",
    "satisfies",
]

_HOME = {
    "DFA": "ltlc.automata",
    "DRA": "ltlc.automata",
    "Formula": "ltlc.ltl",
    "Judge": "ltlc.mdp",
    "LTLVectorWrapper": "ltlc.envs",
    "LTLWrapper": "ltlc.envs",
    "LassoWord": "ltlc.ltl",
    "LimitExceeded": "ltlc.errors",
    "LtlSyntaxError": "ltlc.errors",
    "LtlcError": "ltlc.errors",
    "Monitor": "ltlc.monitor",
    "Task": "ltlc.task",
    "Verdict": "ltlc.monitor",
    "compile": "ltlc.compiler",
    "compile_many": "ltlc.many",
    "judge": "ltlc.judging",
    "load": "ltlc.compiler",
    "parse": "ltlc.ltl",
    "parse_word": "ltlc.ltl",
    "satisfies": "ltlc.ltl",
}


if not TYPE_CHECKING:  # a type checker would take every name for an attribute
    __getattr__ = _on_first_use(__name__, _HOME)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
