"""The shadow test chosen in the settings as compile-time defines and uniforms of `shaders/common_filter.glsl` and its kin. No GL."""

from __future__ import annotations

import math

import numpy as np

from ...maths.shadow import cut
from ...maths.shadow.projection import ShadowPlan
from ...settings.groups import BIASES, FILTER_UNITS, ShadowTestChoice
from ...settings.shadowing import SHADOW_TESTS

# Numbers of the automatic bias and of the cells round a place, by measurement (docs/shadow_tests.md).
AUTO_TILT = 0.6
FOOT_TEXELS = 3.0
EDGE_SHARE, FOOT_SHARE = 0.5, 0.8
STEEPEST_TANGENT = 16.0
USUAL_BIAS = {"slope-scaled": 1.0, "normal-offset": 1.0, "receiver-plane": 2.0}
USUAL_CONSTANT_SHARE = 4e-3
SMOOTHING_TURNS = {1: 0, 5: 2, 9: 2, 13: 5}
"""By how many rows each column's place of the lattice lies above the last one's: the farthest apart that so many can be."""


def spread_neighbours(depths: int) -> np.ndarray:
    """(n − 1, 2) int cells (x, y) whose depths an n-SM with n ≥ 4 keeps beside its own: spread evenly round the centre (SMMVP §4.5.4)."""
    angles = np.pi / 2 + 2.0 * np.pi * np.arange(depths - 1) / (depths - 1)
    return np.rint(1.2 * np.stack([np.cos(angles), np.sin(angles)], axis=-1)).astype(np.int64)


def neighbour_define(depths: int) -> dict[str, str]:
    """The define `NEIGHBOURS` of common_neighbours.glsl."""
    return {"NEIGHBOURS": ", ".join(f"ivec2({x}, {y})" for x, y in spread_neighbours(depths).tolist())} if depths >= 4 else {}


def shadow_defines(test: ShadowTestChoice) -> dict[str, int | float | str]:
    """Everything the shading program is compiled with for this test: the others are not in it."""
    row, side = SHADOW_TESTS[test.kind], math.isqrt(test.pcf)
    width = float(side) if test.filter_width is None else test.filter_width
    names = {f"BIAS_{name.upper().replace('-', '_')}": i for i, name in enumerate(BIASES)}
    names |= {f"FILTER_{name.upper()}S": i for i, name in enumerate(FILTER_UNITS)}
    return {
        **names,
        **neighbour_define(test.depths),
        "SHADOW_TEST": row.glsl,
        "IDS": row.stored.numbers,
        "BIAS": BIASES.index(test.bias_strategy),
        "FILTER_UNIT": FILTER_UNITS.index(test.filter_unit),
        "PCF_SIDE": side,
        "TAP_SPACING": width / side,
        "IS_TEXEL_APART": int(test.filter_unit == "texel" and width == side),
        "DEPTHS": test.depths,
        "SMOOTHING": test.places,
        "SMOOTHING_TURN": SMOOTHING_TURNS[test.smoothing],
        "ID_PER_MATERIAL": int(test.id_per_material),
        "OUTLINES": int(test.has_outlines),
        "AUTO_TILT": AUTO_TILT,
        "FOOT_TEXELS": FOOT_TEXELS,
        "EDGE_SHARE": EDGE_SHARE,
        "FOOT_SHARE": FOOT_SHARE,
        "STEEPEST_TANGENT": STEEPEST_TANGENT,
        "CUT_BEYOND": min(cut.LARGE, 1e30),  # maps: twice the units of clip coordinates, a gradient being two rows' sum at most
        **row.defines,
    }


def shadow_uniforms(test: ShadowTestChoice, plan: ShadowPlan | None) -> dict[str, float]:
    """`u_bias` (metres or texels, as the strategy has it) and the epsilons (metres; −1 = automatic)."""
    return {
        "u_bias": _bias(test, plan),
        "u_epsilon": -1.0 if test.epsilon is None else test.epsilon,
        "u_epsilon_far": -1.0 if test.epsilon_far is None else test.epsilon_far,
    }


def _bias(test: ShadowTestChoice, plan: ShadowPlan | None) -> float:
    if test.bias is not None:
        return test.bias
    if test.bias_strategy == "constant":
        ranges = [p.light_depth_range for p in plan.projections if not p.is_empty] if plan is not None else []
        return USUAL_CONSTANT_SHARE * max((far - near for near, far in ranges), default=0.0)
    return USUAL_BIAS.get(test.bias_strategy, 0.0)
