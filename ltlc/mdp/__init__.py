"""The judge: labelled MDPs, their products with automata and reward tables, and exact answers about them.

Examples: docs/examples.md.
"""

from ltlc.mdp.chain import MarkovChain, induced_chain
from ltlc.mdp.end_components import EndComponents, accepting_end_components, maximal_end_components
from ltlc.mdp.estimate import Estimate
from ltlc.mdp.explicit import ExplicitMDP
from ltlc.mdp.max_reachability import Reachability, max_reachability
from ltlc.mdp.measures import (
    FirstAcceptance,
    acceptances_per_1000_steps,
    expected_count,
    expected_return,
    expected_return_within,
    expected_steps,
    expected_violations,
    first_acceptance,
    long_run_average,
    optimal_return,
    state_return,
    violations_per_step,
)
from ltlc.mdp.model import LabelledMDP
from ltlc.mdp.policy_evaluation import policy_evaluation
from ltlc.mdp.policy_iteration import optimal_total_reward, policy_iteration
from ltlc.mdp.product import Product
from ltlc.mdp.reward_product import EpisodeChain, RewardColumns, RewardProduct
from ltlc.mdp.satisfaction import (
    MaxSatisfaction,
    PolicySatisfaction,
    max_satisfaction_probability,
    satisfaction_probability,
)
from ltlc.mdp.value_iteration import Solution, value_iteration
from ltlc.mdp.verdict import Judge, PolicyVerdict

__all__ = [
    "EndComponents",
    "EpisodeChain",
    "Estimate",
    "ExplicitMDP",
    "FirstAcceptance",
    "Judge",
    "LabelledMDP",
    "MarkovChain",
    "MaxSatisfaction",
    "PolicySatisfaction",
    "PolicyVerdict",
    "Product",
    "Reachability",
    "RewardColumns",
    "RewardProduct",
    "Solution",
    "acceptances_per_1000_steps",
    "accepting_end_components",
    "expected_count",
    "expected_return",
    "expected_return_within",
    "expected_steps",
    "expected_violations",
    "first_acceptance",
    "induced_chain",
    "long_run_average",
    "max_reachability",
    "max_satisfaction_probability",
    "maximal_end_components",
    "optimal_return",
    "optimal_total_reward",
    "policy_evaluation",
    "policy_iteration",
    "satisfaction_probability",
    "state_return",
    "value_iteration",
    "violations_per_step",
]
