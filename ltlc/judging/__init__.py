"""Judging policies of any kind, wherever they were learned.

Examples: docs/examples.md.
"""

from ltlc.judging.judgement import Judgement, judge
from ltlc.judging.policies import Actor, actor_of
from ltlc.judging.sampled import Sample

__all__ = ["Actor", "Judgement", "Sample", "actor_of", "judge"]
