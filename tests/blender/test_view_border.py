"""The live view shows only what the viewport's border, or the scene's in camera view, lets be seen."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from addon.blender.view_border import shown_part
from tests.blender import judge

pytestmark = pytest.mark.usefixtures("blend")
SIZE = (200, 120)


def viewport(border=None, **more):
    low, high = border or ((0.0, 0.0), (1.0, 1.0))
    ends = {"render_border_min_x": low[0], "render_border_min_y": low[1], "render_border_max_x": high[0], "render_border_max_y": high[1]}
    return SimpleNamespace(use_render_border=border is not None, **ends, **more)


def test_without_a_border_all_is_shown():
    assert shown_part(viewport(), SimpleNamespace(view_perspective="PERSP"), bpy.context.scene, SIZE) is None


def test_the_viewports_own_border_counts_from_the_region():
    space = viewport(((0.25, 0.5), (0.75, 1.0)))
    assert shown_part(space, SimpleNamespace(view_perspective="PERSP"), bpy.context.scene, SIZE) == (50, 60, 100, 60)


def test_a_border_in_camera_view_counts_from_the_cameras_frame():
    scene = judge.empty_scene(100, 100)
    camera = judge.camera((0.0, 0.0, 9.0))
    scene.render.use_border = True
    scene.render.border_min_x, scene.render.border_min_y, scene.render.border_max_x, scene.render.border_max_y = 0.5, 0.0, 1.0, 0.5
    bpy.context.view_layer.update()
    window = camera.calc_matrix_camera(bpy.context.evaluated_depsgraph_get(), x=100, y=100)
    zoomed = Matrix.Diagonal((0.3, 0.5, 1.0, 1.0)) @ window  # the frame takes 60 of the region's 200 pixels, and 60 of its 120
    region = SimpleNamespace(view_perspective="CAMERA", perspective_matrix=zoomed @ camera.matrix_world.inverted())
    left, low, width, height = shown_part(viewport(camera=camera), region, scene, SIZE)
    assert np.allclose((left, low, width, height), (100, 30, 30, 30), atol=1)
    scene.render.use_border = False
    assert shown_part(viewport(camera=camera), region, scene, SIZE) is None


def test_a_border_beyond_the_region_leaves_what_is_in_it():
    space = viewport(((-0.5, 0.9), (0.1, 1.4)))
    assert shown_part(space, SimpleNamespace(view_perspective="PERSP"), bpy.context.scene, SIZE) == (0, 108, 20, 12)
