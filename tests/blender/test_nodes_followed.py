"""Node trees of constants: each as the glow of a plate of its own, all in one picture, with Cycles as the judge."""

import numpy as np
import pytest

from tests.blender import judge

pytestmark = pytest.mark.usefixtures("blend")
A, B = (0.7, 0.35, 0.1, 1.0), (0.2, 0.5, 0.8, 1.0)


def node(tree, kind, *linked, settings=None, **inputs):
    """A node with its properties and inputs set, and sockets linked to its first inputs; numbers in names stand for places."""
    made = tree.nodes.new(kind)
    for name, value in (settings or {}).items():
        setattr(made, name, value)
    for name, value in inputs.items():
        made.inputs[int(name[1:]) if name[1:].isdigit() else name].default_value = value
    for i, socket in enumerate(linked):
        tree.links.new(socket, made.inputs[i])
    return made


def rgb(tree, color):
    made = tree.nodes.new("ShaderNodeRGB")
    made.outputs[0].default_value = color
    return made.outputs[0]


def mixing(kind):
    def tree_of(tree):
        made = node(tree, "ShaderNodeMix", settings={"data_type": "RGBA", "blend_type": kind}, _0=0.6, _6=A, _7=B)
        return made.outputs[2]

    return tree_of


def maths(kind, *operands):
    def tree_of(tree):
        made = node(tree, "ShaderNodeMath", settings={"operation": kind}, **{f"_{i}": value for i, value in enumerate(operands)})
        return made.outputs[0]

    return tree_of


def vectors(kind, *operands, out=0):
    def tree_of(tree):
        made = node(tree, "ShaderNodeVectorMath", settings={"operation": kind}, **{f"_{i}": value for i, value in enumerate(operands)})
        return made.outputs[out]

    return tree_of


def parted(mode):
    """A colour taken apart and put together in another order."""

    def tree_of(tree):
        apart = node(tree, "ShaderNodeSeparateColor", rgb(tree, A), settings={"mode": mode})
        order = (1, 0, 2) if mode == "RGB" else (0, 1, 2)
        return node(tree, "ShaderNodeCombineColor", *(apart.outputs[i] for i in order), settings={"mode": mode}).outputs[0]

    return tree_of


def turned(mode):
    """A colour put together from hue, saturation and value or lightness."""
    return lambda tree: node(tree, "ShaderNodeCombineColor", settings={"mode": mode}, _0=0.83, _1=0.6, _2=0.4).outputs[0]


def ranged(kind, **more):
    def tree_of(tree):
        settings = {"interpolation_type": kind, **more}
        return node(
            tree,
            "ShaderNodeMapRange",
            settings=settings,
            _0=0.3,
            _1=0.1,
            _2=0.9,
            _3=0.2,
            _4=1.4,
            **({"_5": 3.0} if kind == "STEPPED" else {}),
        ).outputs[0]

    return tree_of


def bent(tree):
    made = node(tree, "ShaderNodeRGBCurve", _0=0.8, _1=A)
    made.mapping.curves[0].points.new(0.5, 0.8)
    made.mapping.curves[3].points.new(0.4, 0.2)
    made.mapping.update()
    return made.outputs[0]


def ramp(tree):
    made = node(tree, "ShaderNodeValToRGB", _0=0.37)
    made.color_ramp.elements[0].color, made.color_ramp.elements[1].color = A, B
    return made.outputs[0]


def nested(tree):
    """A group in a group, their inputs handed through."""
    import bpy

    def group(name, inner):
        made = bpy.data.node_groups.new(name, "ShaderNodeTree")
        made.interface.new_socket("In", in_out="INPUT", socket_type="NodeSocketColor")
        made.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketColor")
        made.links.new(inner(made, made.nodes.new("NodeGroupInput").outputs[0]), made.nodes.new("NodeGroupOutput").inputs[0])
        return made

    inner = group("inner", lambda own, socket: node(own, "ShaderNodeGamma", socket, _1=2.0).outputs[0])
    outer = group("outer", lambda own, socket: node(own, "ShaderNodeGroup", socket, settings={"node_tree": inner}).outputs[0])
    return node(tree, "ShaderNodeGroup", settings={"node_tree": outer}, _0=A).outputs[0]


BLENDS = "HUE", "SATURATION", "VALUE", "COLOR", "DODGE", "BURN", "OVERLAY", "SOFT_LIGHT", "EXCLUSION"
TREES = {
    **{f"mix {kind.lower()}": mixing(kind) for kind in BLENDS},
    "wrap": maths("WRAP", 1.7, 0.9, 0.2),
    "snap": maths("SNAP", 0.77, 0.25),
    "ping-pong": maths("PINGPONG", 1.3, 0.8),
    "compare": maths("COMPARE", 0.5, 0.55, 0.1),
    "smooth minimum": maths("SMOOTH_MIN", 0.5, 0.6, 0.4),
    "smooth maximum": maths("SMOOTH_MAX", 0.5, 0.6, 0.4),
    "logarithm": maths("LOGARITHM", 3.0, 8.0),
    "arctan2": maths("ARCTAN2", 0.4, 0.9),
    "floored modulo": maths("FLOORED_MODULO", -0.3, 0.8),
    "sign": maths("SIGN", 0.3),
    "cross product": vectors("CROSS_PRODUCT", (1.0, -1.0, 0.0), (0.2, 0.1, -0.4)),
    "dot product": vectors("DOT_PRODUCT", (0.1, 0.9, 0.2), (0.3, 0.1, 0.7), out=1),
    "vector length": vectors("LENGTH", (0.1, 0.9, 0.2), out=1),
    "normalised": vectors("NORMALIZE", (0.1, 0.9, 0.2)),
    "parted RGB": parted("RGB"),
    "parted HSV": parted("HSV"),
    "parted HSL": parted("HSL"),
    "HSV": turned("HSV"),
    "HSL": turned("HSL"),
    "range": ranged("LINEAR"),
    "stepped range": ranged("STEPPED"),
    "smooth range": ranged("SMOOTHSTEP"),
    "smoother range": ranged("SMOOTHERSTEP"),
    "curves": bent,
    "ramp": ramp,
    "black body": lambda tree: node(tree, "ShaderNodeBlackbody", _0=3200.0).outputs[0],
    "cold black body": lambda tree: node(tree, "ShaderNodeBlackbody", _0=1200.0).outputs[0],
    "hue and saturation": lambda tree: node(tree, "ShaderNodeHueSaturation", Hue=0.6, Saturation=0.7, Value=1.3, Color=A).outputs[0],
    "inverted": lambda tree: node(tree, "ShaderNodeInvert", _0=0.7, _1=A).outputs[0],
    "gamma": lambda tree: node(tree, "ShaderNodeGamma", _0=A, _1=1.8).outputs[0],
    "bright and contrast": lambda tree: node(tree, "ShaderNodeBrightContrast", _0=A, _1=0.1, _2=0.2).outputs[0],
    "nested groups": nested,
}  # fmt: skip


def test_trees_of_constants_are_as_in_cycles(tmp_path):
    side = 7
    scene = judge.empty_scene(side * 4, side * 4)
    for i, make in enumerate(TREES.values()):
        paint = judge.material(f"tree {i}")
        glow = judge.to_output(paint, paint.node_tree.nodes.new("ShaderNodeEmission"))
        paint.node_tree.links.new(make(paint.node_tree), glow.inputs["Color"])
        plate = judge.plate(0.9, 0.0, paint, f"plate {i}")
        plate.location.x, plate.location.y = i % side - (side - 1) / 2.0, (side - 1) / 2.0 - i // side
    judge.sun()
    judge.camera((0.0, 0.0, 9.0), type="ORTHO", ortho_scale=float(side)).rotation_euler = (0.0, 0.0, 0.0)
    mine, warnings = judge.ours(scene)
    theirs = judge.cycles(scene, tmp_path)
    middles = [(4 * (i // side) + 2, 4 * (i % side) + 2) for i in range(len(TREES))]
    off = {name: (mine[at][:3], theirs[at][:3]) for name, at in zip(TREES, middles, strict=True)}
    assert {name: pair for name, pair in off.items() if not np.allclose(*pair, atol=2e-3, rtol=5e-3)} == {}
    assert not [line for line in warnings if "viewport colour" in line]
