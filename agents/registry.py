"""Every agent by the name that the command line knows: what there is to say of it, and where its class is.

What is known of the agents is at hand without PyTorch; it is loaded where one learns or acts.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ltlc.errors import InvalidArgumentError
from ltlc.registry import Registry, import_object

from .config import AgentConfig
from .double_dqn.config import DQNConfig
from .fitted_q.config import FittedQConfig
from .tabular.registry import LEARNERS

DOUBLE_DQN, FITTED_Q = "double-dqn", "fitted-q"
AUTO = "auto"
"""for `choose_agent`: the agent that fits the environment."""


@dataclass(frozen=True)
class AgentEntry:
    """What there is to say of an agent.

    Attributes:
        description: one sentence.
        citation: where it is from.
        defaults: default hyperparameters; their class is that of the agent's configuration.
        agent: the class, or `module:class`; see `ltlc.agents.Agent`.
        trainer: a function, or `module:function`, called as `ltlc.agents.training.loop.train_in` is.
        quick_steps: environment steps where nobody says how many; None: `total_steps` of the defaults.
        uses_rewards: whether it learns from the rewards of the task; others go by the automaton alone.
        keeps_checkpoints: whether training that was cut short can go on where it was; else it begins anew.
    """

    description: str
    citation: str
    defaults: AgentConfig
    agent: type[Any] | str
    trainer: Callable[..., Any] | str = "ltlc.agents.training.loop:train_in"
    quick_steps: int | None = None
    uses_rewards: bool = True
    keeps_checkpoints: bool = True

    @property
    def agent_class(self) -> Any:
        """The class of the agent."""
        return import_object(self.agent, "agent") if isinstance(self.agent, str) else self.agent

    @property
    def train(self) -> Callable[..., Any]:
        """What trains it."""
        return import_object(self.trainer, "trainer") if isinstance(self.trainer, str) else self.trainer


def _entry(name: str, part: Any) -> AgentEntry:
    if isinstance(part, AgentEntry):
        return part
    config_type = getattr(part, "config_type", None)
    named = isinstance(part, type) and isinstance(getattr(part, "name", None), str)
    if not named or not isinstance(config_type, type) or not issubclass(config_type, AgentConfig):
        raise InvalidArgumentError(
            f"{name!r} is no agent, but {part!r}; an agent is a subclass of ltlc.agents.ValueAgent with a "
            "name and a config_type, or an AgentEntry"
        )
    first = (part.__doc__ or "").strip().partition("\n")[0]
    return AgentEntry(first or part.__name__, getattr(part, "citation", ""), config_type(), part)


AGENTS: Registry[AgentEntry] = Registry("agent", "ltlc.agents", _entry)
"""all agents by name; a class that was registered becomes an entry with its docstring and defaults."""

AGENTS.register(
    FITTED_Q,
    AgentEntry(
        "Of observations that can be numbered: a table of values, fitted to all steps, each for every automaton state.",
        "D. Ernst, P. Geurts, L. Wehenkel, JMLR 6, 2005, https://www.jmlr.org/papers/v6/ernst05a.html",
        FittedQConfig(),
        "ltlc.agents.fitted_q.agent:FittedQ",
        quick_steps=300_000,
    ),
)
AGENTS.register(
    DOUBLE_DQN,
    AgentEntry(
        "A network of values, from replayed steps that teach every automaton state.",
        "H. van Hasselt, A. Guez, D. Silver, AAAI 2016, doi 10.1609/aaai.v30i1.10295",
        DQNConfig(),
        "ltlc.agents.double_dqn.agent:DoubleDQN",
        quick_steps=300_000,
    ),
)
for _name, _learner in LEARNERS.items():
    AGENTS.register(
        _name,
        AgentEntry(
            _learner.description,
            _learner.citation,
            _learner.config,
            "ltlc.agents.tabular.policy:TablePolicy",
            "ltlc.agents.tabular.run:train_learner",
            uses_rewards=_learner.uses_rewards,
            keeps_checkpoints=False,
        ),
    )


def register_agent(name: str, agent: Any = None) -> Any:
    """Register an agent under a name: a subclass of `ltlc.agents.ValueAgent`, an `AgentEntry`, or `module:attribute`.

    Without an agent, a decorator of the class. From then on `train`, the command line and all listings know it.

    Raises:
        InvalidArgumentError: the name is taken, or what is registered is no agent.

    Example:
        >>> from ltlc.agents import FittedQ
        >>> class Patient(FittedQ):
        ...     "Fitted Q iteration with much patience."
        >>> entry = register_agent("patient", Patient)
        >>> AGENTS["patient"].description
        'Fitted Q iteration with much patience.'
        >>> AGENTS.remove("patient")
    """
    return AGENTS.register(name) if agent is None else AGENTS.register(name, agent)


def hyperparameters(agent: str, values: Mapping[str, Any]) -> AgentConfig:
    """Make the hyperparameters of an agent; those not given have their default.

    Raises:
        UnknownNameError: there is no such agent or hyperparameter.
        InvalidArgumentError: a value is out of range.
    """
    defaults = AGENTS[agent].defaults
    return type(defaults).from_dict(defaults.to_dict() | dict(values))


def agent_of(config: AgentConfig) -> str:
    """Find the agent whose configuration this is, the first that was registered.

    Raises:
        InvalidArgumentError: there is none.
    """
    for name in AGENTS:
        if type(AGENTS[name].defaults) is type(config):
            return name
    raise InvalidArgumentError(f"{type(config).__name__} is of no registered agent; name the agent")
