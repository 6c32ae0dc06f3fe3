"""Feature edges lie where geometry has them, are as wide as asked, and are drawn only where they are seen."""

from dataclasses import replace

import numpy as np
import pytest

from addon.pipeline.job import Job
from addon.scene.mesh_prep import shade_by_crease
from addon.scene.records import Mesh
from addon.settings.groups import Settings
from addon.studies.run import run
from addon.studies.staged import staged
from tests import bodies, scenes

SIZE = (320, 240)
CAMERA = scenes.look_at((5.0, -6.0, 5.0), (0.0, 0.0, 0.5), fov_y_deg=30.0, near=1.0, far=40.0)
SUN = scenes.sun(40.0)
WITHIN_PX = 0.3


def settings(width=1.5, samples=4, **groups):
    chosen = {"edges": {"width": width, "strength": 1.0}, "shading": {"samples": samples}, "fit": {"size": 64}}
    return Settings().replaced(**(chosen | groups))


def drawn(renderer, scene, chosen=None, passes=("combined", "edges", "depth"), camera=CAMERA):
    return run(staged(Job(scene, camera, SUN, chosen or settings(), SIZE, passes)), on=renderer).frame.passes


def in_picture(points, camera=CAMERA):
    """(N, 2) pixels and (N,) view depth of world points."""
    clip = np.column_stack([points, np.ones(len(points))]) @ camera.clip_from_world.T
    ndc = clip[:, :2] / clip[:, 3:]
    return np.stack([(ndc[:, 0] + 1) / 2 * SIZE[0], (1 - ndc[:, 1]) / 2 * SIZE[1]], axis=-1), clip[:, 3]


def bilinear(image, at):
    x, y = at[..., 0] - 0.5, at[..., 1] - 0.5
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    u, v = x - i, y - j
    return image[j, i] * (1 - u) * (1 - v) + image[j, i + 1] * u * (1 - v) + image[j + 1, i] * (1 - u) * v + image[j + 1, i + 1] * u * v


def offsets(passes, lines, apart_px=7.0, reach_px=3.0):
    """Of the seen places of `lines` (arrays of world points that follow one another): pixels by which what is drawn lies beside them, and
    its width. Places near the ends of lines and near other lines are left out."""
    flat = [in_picture(line) for line in lines]
    off, wide = [], []
    for i, (at, depth) in enumerate(flat):
        along = np.gradient(at, axis=0)
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        across = np.stack([-along[:, 1], along[:, 0]], axis=-1)
        others = np.concatenate([other for j, (other, _) in enumerate(flat) if j != i] or [np.full((1, 2), -1e3)])
        length = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(at, axis=0), axis=1)))
        steps = np.linspace(-reach_px, reach_px, 121)
        cusps = at[:-1][(along[1:] * along[:-1]).sum(axis=1) < 0.9]
        for k in range(len(at)):
            is_inside = (at[k] > 5).all() and (at[k] < np.array(SIZE) - 5).all()
            is_clear = np.linalg.norm(others - at[k], axis=1).min() > apart_px
            is_closed = np.linalg.norm(at[0] - at[-1]) < 1.0
            is_amid = is_closed or min(length[k], length[-1] - length[k]) > apart_px
            is_smooth = not len(cusps) or np.linalg.norm(cusps - at[k], axis=1).min() > 2 * apart_px
            if not (is_inside and is_clear and is_amid and is_smooth):
                continue
            x, y = at[k].astype(int)
            if depth[k] > passes["depth"][y - 1 : y + 2, x - 1 : x + 2].min() * 1.04:
                continue  # hidden
            cover = bilinear(passes["edges"], at[k] + steps[:, None] * across[k])
            wide.append(cover.sum() * (steps[1] - steps[0]))
            off.append((cover * steps).sum() / max(cover.sum(), 1e-9) if cover.sum() > 0.5 / (steps[1] - steps[0]) * 0.1 else 9.0)
    assert len(off) > 50
    return np.array(off), np.array(wide)


def segment(a, b, count=60):
    return np.array(a) + np.linspace(0, 1, count)[:, None] * (np.array(b) - np.array(a))


def cube_lines():
    corners = scenes.BOX_CORNERS * 2.0 - [1.0, 1.0, 0.5]
    pairs = [(i, j) for i in range(8) for j in range(i + 1, 8) if bin(i ^ j).count("1") == 1]
    return [segment(corners[i], corners[j]) for i, j in pairs]


def ring(radius, z, count=400):
    return bodies.circle(radius, z, count)[np.append(np.arange(count), 0)]


def cylinder_lines(radius=1.0, low=-0.5, high=1.5):
    eye = CAMERA.eye_ws
    towards, half = np.arctan2(eye[1], eye[0]), np.arccos(radius / np.hypot(eye[0], eye[1]))
    sides = [radius * np.array([np.cos(towards + s * half), np.sin(towards + s * half)]) for s in (-1, 1)]
    return [ring(radius, low), ring(radius, high), *(segment((*side, low), (*side, high)) for side in sides)]


def torus_lines(major=1.2, minor=0.45):
    """n · (eye − p) = 0 on a torus: A cos v + B sin v = minor, for every u."""
    eye, u = CAMERA.eye_ws, np.linspace(0, 2 * np.pi, 600)
    a, b = eye[0] * np.cos(u) + eye[1] * np.sin(u) - major, np.full_like(u, eye[2])
    lines = []
    for sign in (-1, 1):
        v = np.arctan2(b, a) + sign * np.arccos(minor / np.hypot(a, b))
        r = major + minor * np.cos(v)
        lines.append(np.stack([r * np.cos(u), r * np.sin(u), minor * np.sin(v)], axis=-1))
    return lines


def sheet_lines(half=1.6, radius=0.8):
    square = np.array([(-half, -half), (half, -half), (half, half), (-half, half)])
    return [ring(radius, 0.0), *(segment((*square[i], 0.0), (*square[(i + 1) % 4], 0.0)) for i in range(4))]


def moved(part, z):
    return part[0] + [0.0, 0.0, z], part[1]


SHAPES = {
    "cube": (lambda: scenes.box((-1, -1, -0.5), (1, 1, 1.5)), cube_lines),
    "cylinder": (lambda: moved(bodies.cylinder(1.0, 2.0, 128), -0.5), cylinder_lines),
    "torus": (lambda: bodies.torus(1.2, 0.45, 256, 128), torus_lines),
    "coarse torus": (lambda: bodies.torus(1.2, 0.45, 96, 64), torus_lines),
    "sheet with a hole": (lambda: bodies.holed_sheet(1.6, 0.8, 128), sheet_lines),
}


def smooth(part):
    """A scene of one part, shaded as files without normals are."""
    shaded = shade_by_crease(part[0].astype(np.float32), part[1].astype(np.int32))
    scene = scenes.scene_of(part)
    return replace(scene, meshes=(Mesh(("smooth", hash(shaded.positions.tobytes())), shaded.positions, shaded.normals, shaded.triangles),))


@pytest.mark.parametrize("samples", [1, 4])
@pytest.mark.parametrize("shape", SHAPES)
def test_edges_lie_where_geometry_has_them(renderer, shape, samples):
    make, lines = SHAPES[shape]
    off, wide = offsets(drawn(renderer, smooth(make()), settings(samples=samples)), lines())
    print(shape, samples, np.percentile(np.abs(off), [50, 95, 100]), np.median(wide))
    assert np.percentile(np.abs(off), 95) < WITHIN_PX
    assert np.median(np.abs(off)) < 0.1
    assert np.median(wide) == pytest.approx(1.5, abs=0.25)


def soup(part):
    """Every triangle by itself, and cut in two at a point of its first edge: no two share that edge."""
    a, b, c = np.moveaxis(part[0][part[1]], 1, 0)
    middle = 0.4 * a + 0.6 * b
    corners = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
    return corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)


def test_triangles_that_meet_without_sharing_corners_have_no_line_between_them(renderer):
    whole, parted = (
        drawn(renderer, scenes.scene_of(part))["edges"] for part in (bodies.cylinder(1.0, 1.0), soup(bodies.cylinder(1.0, 1.0)))
    )
    assert np.abs(whole - parted).mean() < 0.002
    assert parted.sum() < 1.1 * whole.sum()


def test_what_stands_in_front_hides_the_lines_behind_it(renderer):
    box, screen = scenes.box((-0.3, -0.3, 0.2), (0.3, 0.3, 0.8)), scenes.sheet((1, -3, -1), (3, -1, -1), (3, -1, 3), (1, -3, 3))
    alone, behind = (drawn(renderer, scenes.scene_of(*parts), passes=("edges", "object")) for parts in ((screen,), (screen, box)))
    assert not (behind["object"] == 1).any()
    assert np.array_equal(alone["edges"], behind["edges"])


def test_parts_that_meet_without_a_fold_have_a_line_between_them(renderer):
    left, right = scenes.sheet((-1, -1, 0), (0, -1, 0), (0, 1, 0), (-1, 1, 0)), scenes.sheet((0, -1, 0), (1, -1, 0), (1, 1, 0), (0, 1, 0))
    apart, one = (drawn(renderer, scenes.scene_of(*parts))["edges"] for parts in ((left, right), (scenes.joined(left, right),)))
    (x, y), _ = in_picture(np.zeros((1, 3)))[0][0], None
    assert apart[int(y) - 1 : int(y) + 2, int(x) - 1 : int(x) + 2].max() > 0.9
    assert one[int(y) - 1 : int(y) + 2, int(x) - 1 : int(x) + 2].max() == 0.0


@pytest.mark.parametrize("width", [0.5, 1.0, 3.0, 6.0])
def test_lines_are_as_wide_as_asked(renderer, width):
    _, wide = offsets(drawn(renderer, scenes.scene_of(scenes.box((-1, -1, -0.5), (1, 1, 1.5))), settings(width)), cube_lines(), 20.0, 4.9)
    assert np.median(wide) == pytest.approx(width, rel=0.05)


def test_the_angle_decides_which_folds_have_lines(renderer):
    prism = scenes.rod((0, 0, -0.5), (0, 0, 1.5), 1.0, 12)  # faces meet at 30 degrees
    few, many = (drawn(renderer, scenes.scene_of(prism), settings(edges={"crease_deg": angle}))["edges"].sum() for angle in (31.0, 29.0))
    assert many > 1.2 * few


def test_lines_cover_what_is_below_by_their_strength_and_the_background_stays_see_through(renderer):
    shading = {"samples": 1, "background": (0.0, 0.0, 0.0, 0.0)}
    plain = settings(width=0.0, shading=shading)
    lined = settings(shading=shading, edges={"width": 2.0, "strength": 0.5, "color": (1.0, 0.0, 0.0)})
    scene = scenes.scene_of(scenes.box((-1, -1, -0.5), (1, 1, 1.5)))
    bare, passes = drawn(renderer, scene, plain, ("combined",))["combined"], drawn(renderer, scene, lined)
    a = 0.5 * passes["edges"][..., None]
    assert np.allclose(passes["combined"], bare * (1.0 - a) + a * [1.0, 0.0, 0.0, 1.0], atol=1e-5)
    assert (passes["combined"][..., 3] == 0.0).any()


def test_pictures_of_data_have_no_lines(renderer):
    scene = scenes.closed_box()
    for display in ("shadow", "aliasing", "partitions"):
        shading = {"samples": 1, "display": display}
        with_lines, without = (drawn(renderer, scene, settings(width, shading=shading), ("combined",)) for width in (2.0, 0.0))
        assert np.array_equal(with_lines["combined"], without["combined"])


def test_the_outline_of_a_cap_is_whole(renderer):
    chosen = settings(section={"planes": (0, 0, 0, 0, -1.0, 0)}, edges={"width": 1.5, "crease_deg": 60.0})
    corners = [(-1.0, 0.0, -0.5), (1.0, 0.0, -0.5), (1.0, 0.0, 1.5), (-1.0, 0.0, 1.5)]
    lines = [segment(corners[i], corners[(i + 1) % 4]) for i in range(4)]
    off, wide = offsets(drawn(renderer, scenes.scene_of(scenes.box((-1, -1, -0.5), (1, 1, 1.5))), chosen), lines)
    assert np.abs(off).max() < WITHIN_PX
    assert wide.min() > 1.0
