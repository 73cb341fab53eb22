"""A page for each world, reward scheme, agent and construction, from one template and the registries alone."""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import gymnasium

import ltlc
import ltlc.envs
from ltlc.agents import AGENTS
from ltlc.automata import guard_text
from ltlc.registry import import_object
from ltlc.rewards import SCHEMES
from ltlc.translate import TRANSLATORS

SIZED = ("F a & F b", "GF a & GF b", "GF a -> GF b", "F G a | G F b", "G(a -> F b)", "a U (b U c)")
"""formulas for which the pages of constructions give sizes."""
REWARDED = "G(a -> F b) & G !c"
"""the formula for which the pages of reward schemes give the reward tables."""
WORDS = {"world": "worlds", "reward scheme": "rewards", "agent": "agents", "construction": "constructions"}
"""kinds of parts, and the folders of their pages."""


@dataclass(frozen=True)
class Part:
    """What the page of a part says.

    Attributes:
        kind: a key of `WORDS`.
        name: by which the registry knows it.
        summary: a sentence.
        facts: short ones, by what they are about.
        use: a command and a program that use it, by language.
        sections: further headings with their text.
    """

    kind: str
    name: str
    summary: str
    facts: Mapping[str, str]
    use: Sequence[tuple[str, str]]
    sections: Sequence[tuple[str, str]] = ()

    @property
    def path(self) -> str:
        """Of its page."""
        return f"{WORDS[self.kind]}/{self.name.replace('/', '-')}.md"

    @property
    def text(self) -> str:
        """Its page."""
        facts = "\n".join(f"| {key} | {_cell(value)} |" for key, value in self.facts.items() if value)
        use = "\n".join(f"```{language}\n{code.strip()}\n```\n" for language, code in self.use)
        parts = [f"# {self.name}\n\n{self.summary}\n\n| | |\n|---|---|\n{facts}\n", f"## Use\n\n{use}"]
        return "\n".join([*parts, *(f"## {heading}\n\n{body.strip()}\n" for heading, body in self.sections)])


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


def part_pages() -> Iterator[tuple[str, str]]:
    """The page of each part, and for each kind the page that lists them."""
    kinds: dict[str, tuple[str, str, Iterable[Part]]] = {
        "world": (
            "Each world",
            "They are registered with Gymnasium by `import ltlc.envs`, and label themselves.",
            worlds(),
        ),
        "reward scheme": (
            "Each reward scheme",
            "What each step pays, made from the automaton of a formula. "
            "[What each promises](../../explanation/rewards.md) is an explanation of its own.",
            rewards(),
        ),
        "agent": (
            "Each agent",
            "`--agent auto`, the default, takes `fitted-q` or `double-dqn`, whichever fits.",
            agents(),
        ),
        "construction": (
            "Each construction",
            "From a formula to a deterministic automaton. `auto`, the default, tries those that suit the formula and "
            "keeps the smallest result.",
            constructions(),
        ),
    }
    for kind, (title, text, found) in kinds.items():
        parts = list(found)
        rows = [f"| [{part.name}]({part.path.partition('/')[2]}) | {_cell(part.summary)} |" for part in parts]
        names = [part.path.partition("/")[2].removesuffix(".md") for part in parts]
        yield (
            f"{WORDS[kind]}/index.md",
            "\n".join(
                [
                    f"# {title}\n\n{text}\n",
                    f"| {kind} | |",
                    "|---|---|",
                    *rows,
                    "\n```{toctree}\n:hidden:",
                    *names,
                    "```\n",
                ]
            ),
        )
        yield from ((part.path, part.text) for part in parts)


def constructions() -> Iterator[Part]:
    """Those of `TRANSLATORS`."""
    for name, construction in TRANSLATORS.items():
        rows = []
        for formula in SIZED:
            try:
                dra = ltlc.compile(formula, translator=name, acceptance="transition", effort="fast")
                rows.append(f"| `{_cell(formula)}` | {dra.n_states} | {dra.n_pairs} |")
            except ltlc.LtlcError:
                rows.append(f"| `{_cell(formula)}` | does not apply | |")
        tried = ", ".join(f"{kind} ({place + 1})" for kind, place in construction.portfolio.items())
        yield Part(
            "construction",
            name,
            construction.description,
            {"source": construction.citation, "tried by `auto` for": tried or "none; it is used by name"},
            (
                ("sh", f'ltlc compile "F a & G !b" --translator {name}'),
                ("python", f'import ltlc\n\nltlc.compile("F a & G !b", translator="{name}")'),
            ),
            (
                (
                    "Sizes",
                    'With marks on transitions and `effort="fast"`, computed when this page was built.\n\n'
                    "| formula | states | pairs |\n|---|---|---|\n" + "\n".join(rows),
                ),
                (
                    "See also",
                    "[How the parts fit together](../../architecture.md#from-formula-to-automaton); "
                    "[write one of your own](../../howto/construction.md).",
                ),
            ),
        )


def rewards() -> Iterator[Part]:
    """Those of `SCHEMES`."""
    for name, scheme in SCHEMES.items():
        fields = described_fields(scheme)
        defaults = scheme().parameters
        parameters = [f"| `{key}` | `{value!r}` | {_cell(fields.get(key, ''))} |" for key, value in defaults.items()]
        body, references = _split(scheme)
        yield Part(
            "reward scheme",
            name,
            body.partition("\n\n")[0].replace("\n", " "),
            {
                "guarantee": scheme.guarantee,
                "requires": scheme.requires,
                "after a violation": f"`{scheme.on_deadlock}`",
                "source": scheme.citation,
            },
            (
                ("sh", f'ltlc solve "!C U A" --env ltlc/Thesis5x5-v0 --reward {name}'),
                ("python", f'import ltlc\n\ntask = ltlc.Task("F goal & G !hole", reward="{name}")'),
            ),
            (
                *((("Details", body.partition("\n\n")[2]),) if "\n\n" in body else ()),
                ("Parameters", "| name | default | meaning |\n|---|---|---|\n" + "\n".join(parameters)),
                ("What it pays", _payments(name)),
                *((("References", references),) if references else ()),
                (
                    "See also",
                    "[What rewards promise](../../explanation/rewards.md); "
                    "[write one of your own](../../howto/reward.md).",
                ),
            ),
        )


def _payments(name: str) -> str:
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        task = ltlc.Task(REWARDED, reward=name)
    tables, dra = task.tables, task.automaton
    rows = []
    for q in range(tables.n_states):
        for c in range(tables.next_state.shape[1]):
            letters = guard_text(dra, [c])
            end = " (the episode ends)" if tables.stop[q, c] == 1 else ""
            rows.append(
                f"| {q} | `{_cell(letters)}` | {tables.next_state[q, c]}{end} | {tables.reward[q, c]:.6g} "
                f"| {tables.discount[q, c]:.6g} |"
            )
    return (
        f"For `{REWARDED}`, computed when this page was built:\n\n"
        "| state | letters | next | reward | discount |\n|---|---|---|---|---|\n" + "\n".join(rows)
    )


def agents() -> Iterator[Part]:
    """Those of `AGENTS`."""
    for name, entry in AGENTS.items():
        fields = described_fields(type(entry.defaults))
        rows = [f"| `{k}` | `{v!r}` | {_cell(fields.get(k, ''))} |" for k, v in entry.defaults.to_dict().items()]
        body, references = _split(type(entry.defaults))
        kind = type(entry.defaults).__name__
        yield Part(
            "agent",
            name,
            entry.description,
            {
                "learns from": "rewards" if entry.uses_rewards else "the automaton alone",
                "source": entry.citation,
                "configuration": f"`{type(entry.defaults).__module__}.{kind}`",
            },
            (
                ("sh", f'ltlc train "F(A & F B)" --env ltlc/Thesis5x5-v0 --agent {name} --steps 40000'),
                (
                    "python",
                    "from ltlc.agents.registry import hyperparameters\n\n"
                    f'config = hyperparameters("{name}", {{"total_steps": 40_000}})',
                ),
            ),
            (
                ("Details", body),
                (
                    "Hyperparameters",
                    "Each is set by `--hyper NAME=VALUE`.\n\n| name | default | meaning |\n|---|---|---|\n"
                    + "\n".join(rows),
                ),
                *((("References", references),) if references else ()),
                ("See also", "[Training runs](../../runs.md#agents); [write one of your own](../../howto/agent.md)."),
            ),
        )


def worlds() -> Iterator[Part]:
    """Those that `ltlc.envs` registers with Gymnasium."""
    for name, spec in gymnasium.registry.items():
        if not name.startswith("ltlc/"):
            continue
        env: Any = gymnasium.make(name).unwrapped
        propositions = tuple(getattr(env, "propositions", ())) or _labels_of(env)
        exact = hasattr(env, "labelled_mdp")
        summary, _, body = _split(type(env))[0].partition("\n\n")
        many = import_object(spec.vector_entry_point, name) if isinstance(spec.vector_entry_point, str) else None
        if "; see `Vector" in summary and isinstance(many, type):  # one of many, which say what there is to say
            summary = summary.partition(";")[0] + "."
            body = "\n\n".join(filter(None, [body, _split(many)[0]]))
        formula = f"F {propositions[0]}"
        sections = [("Details", body)] if body else []
        if exact:
            model = env.labelled_mdp()
            judge = ltlc.Judge(model, ltlc.Task(formula))
            sections.append(
                (
                    "Exactly",
                    f"The model has {model.n_states} states. `{formula}` can be satisfied with "
                    f"probability {judge.maximum.probability:.6g}.",
                )
            )
        picture = f"![{name}: the world]({name.replace('/', '-')}.png)"
        yield Part(
            "world",
            name,
            " ".join(summary.split()),
            {
                "propositions": ", ".join(f"`{p}`" for p in propositions),
                "actions": f"`{env.action_space}`",
                "observation": f"`{_short(env.observation_space)}`",
                "steps": str(spec.max_episode_steps or "no limit"),
                "exact model": "yes" if exact else "no: judging samples episodes",
                "made by": f"`{spec.entry_point}`" + (f" with `{spec.kwargs}`" if spec.kwargs else ""),
            },
            (
                ("sh", f'ltlc {"solve" if exact else "train"} "{formula}" --env {name}'),
                (
                    "python",
                    f"import gymnasium\nimport ltlc\nimport ltlc.envs\n\n"
                    f'env = ltlc.LTLWrapper(gymnasium.make("{name}"), "{formula}")',
                ),
            ),
            (("Picture", picture), *sections),
        )


def _labels_of(env: Any) -> tuple[str, ...]:
    return tuple(env.labelled_mdp().aps)


def _short(space: Any) -> str:
    if isinstance(space, gymnasium.spaces.Box):
        return f"Box{space.shape}, {space.dtype}"
    return str(space)


def world_pictures() -> Iterator[tuple[str, Any]]:
    """For each world, the path of its picture and the pixels, shape (height, width, 3), uint8."""
    for name in [name for name in gymnasium.registry if name.startswith("ltlc/")]:
        env = gymnasium.make(name, render_mode="rgb_array")
        env.reset(seed=1)
        yield f"worlds/{name.replace('/', '-')}.png", env.render()
        env.close()


def _split(part: type) -> tuple[str, str]:
    """A docstring without its sections, and its references, a list."""
    text = inspect.getdoc(part) or ""
    body = re.split(r"(?m)^(?:Args|Attributes|Raises|Example|Examples|References|Warns):$", text)[0].strip()
    found = re.search(r"(?ms)^References:\n(.*?)(?=^\S|\Z)", text)
    return body, "" if found is None else " ".join(found[1].split())


def described_fields(part: type) -> dict[str, str]:
    """What the docstrings of a class and its bases say of its attributes."""
    found: dict[str, str] = {}
    for base in reversed(part.__mro__):
        text = inspect.cleandoc(base.__dict__.get("__doc__") or "")
        section = re.search(r"(?ms)^Attributes:\n(.*?)(?=^\S|\Z)", text)
        for names, meaning in re.findall(
            r"(?ms)^    (\w+(?:, \w+)*): (.*?)(?=^    \w|\Z)", section[1] if section else ""
        ):
            found |= dict.fromkeys(names.split(", "), " ".join(meaning.split()))
    return {name: found[name] for name in found if name in {field.name for field in dataclasses.fields(part)}}
