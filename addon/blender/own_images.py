"""Images in the open file that this extension has made and may fill anew: known by a mark that they carry, never by their name alone."""

from __future__ import annotations

import bpy

MARK = "cad_shadow_made"


def find(title: str) -> bpy.types.Image | None:
    """The image made under this title. One that the user has renamed or copied is the user's; so is one that only bears the name."""
    return next((image for image in bpy.data.images if image.library is None and _is_ours(image, title)), None)


def title_of(image: bpy.types.Image) -> str | None:
    """The title that this extension has made the image under; None for another's image."""
    mark = image.get(MARK)
    return None if mark is None else mark["title"]


def make(title: str, width: int, height: int, **options: bool) -> bpy.types.Image:
    """A new image of that title, marked; it takes the name, and in all editors and materials the place, of the one made before."""
    image, old = bpy.data.images.new(title, width, height, **options), find(title)
    if old is not None:
        name = old.name
        old.user_remap(image)
        bpy.data.images.remove(old)
        image.name = name
    image[MARK] = {"title": title, "name": image.name}
    return image


def _is_ours(image: bpy.types.Image, title: str) -> bool:
    mark = image.get(MARK)
    return mark is not None and mark.to_dict() == {"title": title, "name": image.name}
