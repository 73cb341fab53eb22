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
from .tabular.config import FuTopcuConfig, QLearningConfig, SadighConfig, WangConfig

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
        uses_rewards: whether it learns from the rewards of the task; others go by the automaton alone.
    """

    description: str
    citation: str
    defaults: AgentConfig
    agent: type[Any] | str
    trainer: Callable[..., Any] | str = "ltlc.agents.training.loop:train_in"
    uses_rewards: bool = True

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
    return AgentEntry(first or part.__name__, getattr(part, "citation", ""), config_type.from_dict({}), part)


AGENTS: Registry[AgentEntry] = Registry("agent", "ltlc.agents", _entry)
"""all agents by name; a class that was registered becomes an entry with its docstring and defaults."""

AGENTS.register(
    FITTED_Q,
    AgentEntry(
        "Of observations that can be numbered: a table of values, fitted to all steps, each for every automaton state.",
        "D. Ernst, P. Geurts, L. Wehenkel, JMLR 6, 2005, https://www.jmlr.org/papers/v6/ernst05a.html",
        FittedQConfig(),
        "ltlc.agents.fitted_q.agent:FittedQ",
    ),
)
AGENTS.register(
    DOUBLE_DQN,
    AgentEntry(
        "A network of values, from replayed steps that teach every automaton state.",
        "H. van Hasselt, A. Guez, D. Silver, AAAI 2016, doi 10.1609/aaai.v30i1.10295",
        DQNConfig(),
        "ltlc.agents.double_dqn.agent:DoubleDQN",
    ),
)
_TABLE = "ltlc.agents.tabular.policy:TablePolicy"
AGENTS.register(
    "q-learning",
    AgentEntry(
        "Values of the rewards of the task, taught to every automaton state at each step.",
        "C. Watkins, P. Dayan, Machine Learning 8, 1992, doi 10.1007/BF00992698",
        QLearningConfig(),
        _TABLE,
        "ltlc.agents.tabular.q_learning:train",
    ),
)
AGENTS.register(
    "double-q-learning",
    AgentEntry(
        "Q-learning with two tables, one to choose the next action and the other to value it.",
        "H. van Hasselt, Double Q-learning, NeurIPS 2010",
        QLearningConfig(double=True),
        _TABLE,
        "ltlc.agents.tabular.q_learning:train",
    ),
)
AGENTS.register(
    "fu-topcu",
    AgentEntry(
        "Transition probabilities with known states, and the way to accepting end components of the learned product.",
        "J. Fu, U. Topcu, RSS 2014, doi 10.15607/RSS.2014.X.039",
        FuTopcuConfig(),
        _TABLE,
        "ltlc.agents.tabular.fu_topcu:train",
        uses_rewards=False,
    ),
)
AGENTS.register(
    "sadigh",
    AgentEntry(
        "Rewards from the sets of a Rabin pair, and temporal differences on a learned model.",
        "D. Sadigh et al., CDC 2014, doi 10.1109/CDC.2014.7039527",
        SadighConfig(),
        _TABLE,
        "ltlc.agents.tabular.sadigh:train",
        uses_rewards=False,
    ),
)
AGENTS.register(
    "wang",
    AgentEntry(
        "A randomised policy towards accepting end components of the learned product, by actor and critic.",
        "J. Wang et al., IJRR 34(10), 2015, doi 10.1177/0278364915581505",
        WangConfig(),
        _TABLE,
        "ltlc.agents.tabular.wang:train",
        uses_rewards=False,
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
