"""The optional compilation of the hot modules; all metadata is in pyproject.toml.

With `LTLC_ACCELERATE=1` in the environment, a wheel built from here carries the modules below twice: as they are, and
compiled by mypyc into extension modules, which Python prefers. Without it nothing is compiled and mypy is not needed.
"""

from __future__ import annotations

import os
import shlex
import shutil
import sys
import sysconfig
from pathlib import Path

from setuptools import Extension, setup

# Where the time goes. Left out on purpose, besides what is not hot: budget.py, because every loop that can
# grow asks it, and only interpreted code notices Ctrl-C; automata/rabin.py, ltl/formula.py and ltl/rule.py, because
# mypyc does not support their cached properties, their object.__new__ and their subclass of list.
COMPILED = {
    "ltlc": ("graph",),
    "ltlc/ltl": (
        "implication",
        "normal",
        "rewrite",
        "rules_binary",
        "rules_boolean",
        "rules_unary",
        "syntax",
        "traversal",
    ),
    "ltlc/automata": (
        "acceptance",
        "canonical",
        "compare",
        "cycles",
        "emerson_lei",
        "emptiness",
        "languages",
        "marks",
        "partition",
        "rabin_pairs",
        "rabin_type",
        "simulation",
    ),
    "ltlc/minimize": (
        "collapse",
        "lower_bound",
        "merge_by_trial",
        "reduce",
        "residuals",
        "safe_classes",
        "state_based",
        "words",
    ),
    "ltlc/translate": (
        "closure",
        "components",
        "constructions",
        "decomposition",
        "letters",
        "limits",
        "mixtures",
        "nodes",
        "normal_form",
        "pipeline",
        "problem",
        "product",
        "round_robin",
        "safra",
        "tableau",
    ),
}
# The front door names every part for type checkers; what stands above the compiled modules need not be read.
MYPY = """\
[mypy]
follow_imports = silent
[mypy-ltlc.compiler,ltlc.envs.*,ltlc.many,ltlc.mdp.*,ltlc.task]
follow_imports = skip
"""
BUILD = Path("build", "mypyc")


def extensions() -> list[Extension]:
    """The compiled modules, as one shared library and a stub for each."""
    try:
        from mypyc.build import mypycify
    except ImportError as error:
        sys.exit(f"LTLC_ACCELERATE is set, but mypyc cannot be imported ({error}): pip install mypy, or unset it")
    if os.name == "posix":
        compiler = shlex.split(os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc")[0]
        if shutil.which(compiler) is None:
            sys.exit(f"LTLC_ACCELERATE is set, but there is no C compiler {compiler!r}: install one, or unset it")
        if not Path(sysconfig.get_path("include"), "Python.h").is_file():
            sys.exit("LTLC_ACCELERATE is set, but Python.h is missing: install python3-dev, or unset it")
    BUILD.mkdir(parents=True, exist_ok=True)
    config = BUILD / "mypy.ini"
    config.write_text(MYPY, encoding="utf-8")
    paths = [f"{folder}/{name}.py" for folder, names in COMPILED.items() for name in names]
    found: list[Extension] = mypycify(
        [f"--config-file={config}", f"--cache-dir={os.devnull}", *paths],
        opt_level="2",
        debug_level="0",
        target_dir=str(BUILD),
        group_name="ltlc._compiled",
    )
    return found


if os.environ.get("LTLC_ACCELERATE", "0") in ("", "0"):
    setup()
elif "editable_wheel" in sys.argv:
    sys.exit("LTLC_ACCELERATE is set, but an editable install stays pure Python: unset it, or install without -e")
else:  # the front end also asks for requirements, metadata and source archives; only a wheel is compiled
    setup(
        setup_requires=["mypy>=2.4", "numpy>=2.0"] if "egg_info" in sys.argv else [],
        ext_modules=extensions() if "bdist_wheel" in sys.argv else [],
    )
