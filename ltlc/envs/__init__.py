"""Environments that a formula can be taught in: wrappers, labels, worlds.

Importing this package registers the worlds with Gymnasium: `gymnasium.make("ltlc/Thesis10x10-v0")`.

Examples: docs/examples.md.
"""

from ltlc.envs.comparisons import Comparison, comparisons
from ltlc.envs.discretised import DiscretisedActions, DiscretisedVectorActions, action_grid
from ltlc.envs.flat_world import FlatWorld, VectorFlatWorld
from ltlc.envs.grid import GridWorld, VectorGridWorld
from ltlc.envs.grid_map import HOLD, GridMap, grid_map
from ltlc.envs.held_actions import HeldActions
from ltlc.envs.labels import LABELLERS, LabelFunction, register_labeller
from ltlc.envs.letter_world import LetterWorld, VectorLetterWorld
from ltlc.envs.protocol import DrawnEnv, MappedEnv, ModelledEnv
from ltlc.envs.recorded import RECORDED, recorded_automaton
from ltlc.envs.registration import register_envs
from ltlc.envs.robust_wrappers import RobustLTLVectorWrapper, RobustLTLWrapper
from ltlc.envs.tabular import board_of, labelled_mdp
from ltlc.envs.thesis import thesis_map, thesis_vector_world, thesis_world
from ltlc.envs.vector_wrapper import LTLVectorWrapper
from ltlc.envs.watched import MonitorWrapper
from ltlc.envs.wrapper import LTLWrapper
from ltlc.envs.zone_world import VectorZoneWorld, ZoneWorld

__all__ = [
    "HOLD",
    "LABELLERS",
    "RECORDED",
    "Comparison",
    "DiscretisedActions",
    "DiscretisedVectorActions",
    "DrawnEnv",
    "FlatWorld",
    "GridMap",
    "GridWorld",
    "HeldActions",
    "LTLVectorWrapper",
    "LTLWrapper",
    "LabelFunction",
    "LetterWorld",
    "MappedEnv",
    "ModelledEnv",
    "MonitorWrapper",
    "RobustLTLVectorWrapper",
    "RobustLTLWrapper",
    "VectorFlatWorld",
    "VectorGridWorld",
    "VectorLetterWorld",
    "VectorZoneWorld",
    "ZoneWorld",
    "action_grid",
    "board_of",
    "comparisons",
    "grid_map",
    "labelled_mdp",
    "recorded_automaton",
    "register_envs",
    "register_labeller",
    "thesis_map",
    "thesis_vector_world",
    "thesis_world",
]

register_envs()
