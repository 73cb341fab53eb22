"""LTL to deterministic Rabin automata to rewards for reinforcement learning.

>>> import ltlc
>>> dra = ltlc.compile("G(request -> F grant)")
>>> dra.accepts(cycle=[{"request"}, {"grant"}])
True

The names below are imported on first use: `import ltlc` itself loads nothing but the standard library.
"""

from importlib import import_module as _import_module
from pathlib import Path as _Path
from typing import TYPE_CHECKING

# The wheel carries agents/ and grammars/ inside this package; a checkout keeps them beside it.
if not _Path(__path__[0], "grammars").is_dir():
    __path__.append(str(_Path(__path__[0]).parent))

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

    def __getattr__(name: str) -> object:
        if name not in _HOME:
            raise AttributeError(f"module 'ltlc' has no attribute {name!r}")
        value = globals()[name] = getattr(_import_module(_HOME[name]), name)
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
