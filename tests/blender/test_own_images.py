"""What bears a name of ours but is the user's stays as it is."""

import numpy as np
import pytest

from tests.blender.impostor_rig import SIZE

TITLE = "CAD Shadow Preview"


@pytest.fixture
def users_image(blend):
    """Makes an image as a user does, painted red."""

    def make(name):
        image = blend.data.images.new(name, 8, 8)
        image.pixels.foreach_set(np.tile(np.float32([1, 0, 0, 1]), 64))
        return image

    return make


def is_red(image):
    return np.array_equal(np.array(image.pixels[:]).reshape(-1, 4)[:, :3].min(axis=0), (1, 0, 0)) and tuple(image.size) == (8, 8)


def picture(size, value=0.5):
    return np.full((*size, 4), value, np.float32)


def test_an_image_of_the_users_that_bears_the_pictures_name_stays(room, blend, users_image):
    mine, editor = users_image(TITLE), room("blender.image_editor")
    for size in ((4, 6), (4, 6), (8, 8), (5, 5)):
        ours = editor.to_image(picture(size))
        assert ours != mine and tuple(ours.size) == size[::-1]
    assert is_red(mine) and mine.name == TITLE and len(blend.data.images) == 2


def test_a_picture_renamed_or_copied_to_be_kept_is_kept(room, blend):
    editor = room("blender.image_editor")
    first = editor.to_image(picture((4, 6), 0.25))
    copy = first.copy()
    first.name = "Before the change"
    second = editor.to_image(picture((4, 6), 0.75))
    assert second not in (first, copy) and second.name == TITLE
    assert [round(image.pixels[0], 2) for image in (first, copy, second)] == [0.25, 0.25, 0.75]
    assert editor.to_image(picture((4, 6))) == second


def test_a_picture_of_another_size_takes_the_place_of_the_one_before_everywhere(room, blend):
    editor = room("blender.image_editor")
    material = blend.data.materials.new("Screen")
    if blend.app.version < (5, 0, 0):
        material.use_nodes = True
    node = material.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = editor.to_image(picture((4, 6)))
    node.image.use_fake_user = True
    other = editor.to_image(picture((5, 5)))
    assert node.image == other and other.name == TITLE and len(blend.data.images) == 1


def test_an_image_from_a_library_is_not_ours(room, blend, tmp_path):
    editor, path = room("blender.image_editor"), str(tmp_path / "library.blend")
    blend.data.libraries.write(path, {editor.to_image(picture((4, 6)))})
    blend.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    with blend.data.libraries.load(path, link=True) as (there, here):
        here.images = there.images
    (linked,) = here.images
    assert editor.to_image(picture((4, 6))) != linked and linked.library is not None


def test_a_packed_impostor_replaces_its_own_images_and_no_others(ball, api, blend, users_image):
    mine = users_image(f"Impostor {ball.name} color")
    ball.cad_shadow_impostor = True
    for _ in range(2):
        assert blend.ops.cad_shadow.impostor_export(to="PACKED") == {"FINISHED"}
    assert is_red(mine) and mine.name == f"Impostor {ball.name} color"
    assert len(blend.data.images) == 5


def test_a_plane_is_no_impostor_and_says_whose_it_is(ball, api, blend):
    ball.cad_shadow_impostor = True
    (captured,) = api.impostors([ball.name], size=SIZE, samples=1, map_size=128)
    plane = captured.to_plane()
    assert plane.cad_shadow_impostor is False and plane["cad_shadow_impostor_of"] == ball.name
    assert [row.name for row in blend.context.window_manager.cad_shadow_impostors] == [ball.name]
