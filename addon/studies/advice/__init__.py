"""Advice: which warp, partition, fit and map size suit a scene, its cameras and a budget of texels; or the least budget for a wanted error.

The theory prunes the combinations, measurement decides: the exact error m of every visible point under each of them, and in the end a real
picture of the proposal. No bpy; `cli/commands/advise.py` and `operators/advise.py` bring the frames.
"""

from .goal import Goal
from .report import advice_report, advice_table
from .sampled_frame import SampledFrame
from .search import Advice, Row, Step, advise

__all__ = ["Advice", "Goal", "Row", "SampledFrame", "Step", "advice_report", "advice_table", "advise"]
