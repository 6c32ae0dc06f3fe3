"""Small Blender scenes for the tests of the snapshot, and its reading."""

import bpy

from addon.blender.snapshot import SceneReader

SIZE = (640, 360)


def depsgraph():
    bpy.context.view_layer.update()
    return bpy.context.evaluated_depsgraph_get()


def read(reader=None, **options):
    return (reader or SceneReader()).read(depsgraph(), size=SIZE, **options)


def add(data, location=(0, 0, 0), name=None):
    ob = bpy.data.objects.new(name or data.name, data)
    ob.location = location
    bpy.context.scene.collection.objects.link(ob)
    return ob


def mesh(points, faces, name="mesh"):
    data = bpy.data.meshes.new(name)
    data.from_pydata(points, [], faces)
    return data


def triangle(name="triangle"):
    return mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)], name)
