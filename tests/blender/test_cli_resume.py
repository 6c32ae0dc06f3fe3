"""What the command line did before: `--resume` sees whatever would make it different now."""

import json
import os

from tests.blender.user_folder import BOX, SMALL


def times(folder):
    return {p.name: p.stat().st_mtime_ns for p in folder.glob("*.png")}


def test_resume_sees_a_changed_preset_and_a_changed_material_file_of_any_name(main, room, box, tmp_path, user_resources):
    (box.parent / "any.mtl").write_text("newmtl red\nKd 1 0 0\n")
    box.write_text("mtllib any.mtl\n" + BOX)
    preset = user_resources / "scripts" / "presets" / room("blender.presets").SUBDIR / "Mine.py"
    preset.parent.mkdir(parents=True, exist_ok=True)
    head = "import bpy\nsettings = bpy.context.scene.cad_shadow\n"
    preset.write_text(head + "settings.warp = 'psm'\n")
    out = tmp_path / "out"
    try:

        def again():
            assert main(["preview", str(box), "-o", str(out), "--resume", "--preset", "mine", *SMALL]) == 0
            return times(out)

        first = again()
        assert again() == first
        preset.write_text(head + "settings.warp = 'tsm'\n")
        second = again()
        assert second != first
        assert json.loads((out / "box_report.json").read_text())["settings"]["warp"]["kind"] == "tsm"
        (box.parent / "any.mtl").write_text("newmtl red\nKd 0 0 1\n")
        third = again()
        assert third != second
        assert again() == third
    finally:
        preset.unlink()


def test_resume_sees_a_changed_library(main, cube_scene, blend, tmp_path):
    out, library, file = tmp_path / "out", tmp_path / "library.blend", tmp_path / "linked.blend"
    blend.data.libraries.write(str(library), {blend.data.objects["Cube"].data})
    with blend.data.libraries.load(str(library), link=True) as (there, here):
        here.meshes = there.meshes
    blend.data.objects["Cube"].data = blend.data.libraries[0].users_id[0]
    blend.ops.wm.save_as_mainfile(filepath=str(file))
    blend.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)

    def again():
        assert main(["preview", str(file), "-o", str(out), "--resume", *SMALL]) == 0
        return times(out)

    first = again()
    assert again() == first
    data = library.read_bytes()
    library.write_bytes(data + b"\0")
    os.utime(library, (1, 1))
    assert again() != first
