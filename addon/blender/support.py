"""What this engine makes of Blender's objects, lights, cameras, view layers, collections, worlds and materials: the one table of it.

Every property of those types stands here once: honoured; warned about where it is set, with the words of the warning; or of no effect,
because it belongs to the interface, to editing, to other engines or to light that bounces, which there is none of. No bpy: `snapshot/
complaints.py` asks the scene, `tools.docs_tables` makes `docs/blender_support.md` of it, a test compares it with Blender.
"""

from __future__ import annotations

from dataclasses import dataclass

HONOURED, WARNED, IDLE = "honoured", "warned", "no effect"


@dataclass(frozen=True, slots=True)
class Support:
    """Properties of one RNA type (a name ends in * where it stands for all that begin so), what becomes of them, and why or how.

    `question` names the test in `snapshot/complaints.py` that says whether a warned one is set.
    """

    owner: str
    names: str
    status: str
    text: str
    question: str = ""


SUPPORT: tuple[Support, ...] = (
    Support(
        "Object",
        "data type location rotation_* scale delta_* dimensions matrix_* parent* use_parent_final_indices track_axis up_axis "
        "use_camera_lock_parent",
        HONOURED,
        "placing, also animated, by constraints and parents",
    ),
    Support(
        "Object",
        "modifiers constraints vertex_groups shader_effects rigid_body* soft_body collision field particle_systems "
        "show_only_shape_key active_shape_key* use_shape_key_edit_mode add_rest_position_attribute pose use_simulation_cache "
        "use_mesh_mirror_* use_dynamic_topology_sculpting animation_data bound_box",
        HONOURED,
        "the evaluated geometry is drawn, with modifiers and simulations at the render's level",
    ),
    Support("Object", "material_slots active_material* color pass_index", HONOURED, "materials, object colour and index"),
    Support(
        "Object",
        "hide_render hide_viewport show_instancer_for_* instance_* is_instancer use_instance_* is_from_instancer is_from_set",
        HONOURED,
        "what a render or a viewport shows, instances of every kind",
    ),
    Support("Object", "visible_camera visible_shadow is_holdout is_shadow_catcher", HONOURED, "who sees it and what it casts"),
    Support("Object", "light_linking", HONOURED, "receivers and blockers of a light"),
    Support("Object", "display_type", HONOURED, "Wire and Bounds are not drawn"),
    Support(
        "Object",
        "visible_diffuse visible_glossy visible_transmission visible_volume_scatter visible_raycast",
        IDLE,
        "rays that bounce: there are none",
    ),
    Support("Object", "shadow_terminator_*", IDLE, "lights reach smooth surfaces by their true faces"),
    Support("Object", "lightgroup hide_probe_* use_grease_pencil_lights", IDLE, "passes and probes of other engines"),
    Support(
        "Object",
        "mode lock_* empty_* image_user show_empty_image_* use_empty_image_alpha hide_select hide_surface_pick display show_* "
        "display_bounds_type lineart animation_visualization motion_path selection_sets active_selection_set",
        IDLE,
        "interface and editing",
    ),
    Support("Object", "cycles", IDLE, "Cycles' own sampling, culling, caustics and motion steps"),
    Support(
        "Light",
        "type color temperature* use_temperature exposure energy use_shadow spot_size spot_blend spread animation_data",
        HONOURED,
        "as bright, coloured and wide as in Cycles",
    ),
    Support(
        "Light",
        "node_tree use_nodes",
        HONOURED,
        "an emission's colour and strength; a light whose nodes cannot be followed is named",
    ),
    Support("Light", "angle shadow_soft_size shape size size_y", HONOURED, "soft shadows, where Light Samples are above 0; else said"),
    Support("Light", "normalize", WARNED, "Normalize off is left out: the light is as strong as with it.", "not_normalized"),
    Support("Light", "use_square", IDLE, "the square of a spot is Blender Internal's; Cycles and EEVEE draw the cone"),
    Support(
        "Light",
        "specular_factor diffuse_factor transmission_factor volume_factor use_custom_distance cutoff_distance use_soft_falloff "
        "shadow_buffer_clip_start shadow_filter_radius shadow_maximum_resolution use_shadow_jitter shadow_jitter_overblur "
        "use_absolute_resolution shadow_cascade_* show_cone",
        IDLE,
        "EEVEE's own, and the interface",
    ),
    Support("Light", "cycles", IDLE, "Cycles' own sampling; portals give no light"),
    Support(
        "Camera",
        "type sensor_* angle* lens* ortho_scale shift_* clip_* animation_data",
        HONOURED,
        "perspective and orthographic cameras, to the pixel",
    ),
    Support(
        "Camera",
        "panorama_type fisheye_* latitude_* longitude_* central_cylindrical_* custom_* cycles_custom",
        HONOURED,
        "panoramic and custom cameras are refused in words",
    ),
    Support("Camera", "dof", WARNED, "Depth of field is left out: everything is sharp.", "depth_of_field"),
    Support("Camera", "stereo", HONOURED, "stereo pictures are refused in words"),
    Support("Camera", "passepartout_alpha display_size show_* composition_guide_color background_images", IDLE, "interface"),
    Support(
        "ViewLayer",
        "material_override world_override use layer_collection objects depsgraph",
        HONOURED,
        "layers, their collections and overrides",
    ),
    Support(
        "ViewLayer",
        "use_pass_combined use_pass_z use_pass_normal use_pass_shadow use_pass_position use_pass_mist use_pass_emit "
        "use_pass_object_index use_pass_material_index use_pass_cryptomatte_object use_pass_cryptomatte_material",
        HONOURED,
        "these passes come where they are on",
    ),
    Support(
        "ViewLayer",
        "use_pass_uv use_pass_vector use_pass_ambient_occlusion use_pass_environment use_pass_diffuse_* use_pass_glossy_* "
        "use_pass_transmission_* use_pass_subsurface_* use_pass_cryptomatte_asset use_pass_grease_pencil aovs active_aov* "
        "lightgroups active_lightgroup*",
        WARNED,
        "Passes that are on and not made here: {}.",
        "passes",
    ),
    Support("ViewLayer", "use_freestyle freestyle_settings", WARNED, "Freestyle draws no lines with this engine.", "freestyle"),
    Support(
        "ViewLayer",
        "pass_cryptomatte_depth use_pass_cryptomatte_accurate pass_alpha_threshold samples",
        IDLE,
        "mattes and data are those of the pixel's centre",
    ),
    Support(
        "ViewLayer",
        "use_solid use_sky use_ao use_strand use_volumes use_motion_blur use_grease_pencil",
        IDLE,
        "filters of other engines",
    ),
    Support("ViewLayer", "active_layer_collection has_export_collections eevee cycles", IDLE, "interface, and other engines' own"),
    Support("LayerCollection", "collection children exclude holdout indirect_only hide_viewport is_visible", HONOURED, "as in Cycles"),
    Support(
        "World",
        "color node_tree use_nodes mist_settings animation_data",
        HONOURED,
        "ambient light, background and the mist pass; of a picture all around the means of its halves",
    ),
    Support(
        "World",
        "light_settings lightgroup probe_resolution sun_* use_sun_* use_eevee_finite_volume cycles cycles_visibility",
        IDLE,
        "ambient occlusion of other engines, and their own",
    ),
    Support(
        "Material",
        "node_tree use_nodes diffuse_color metallic roughness pass_index use_transparent_shadow animation_data",
        HONOURED,
        "nodes are followed, transparency and glass (unbent) too; the viewport colour where they cannot be, with a warning",
    ),
    Support(
        "Material",
        "surface_render_method displacement_method blend_method alpha_threshold use_transparency_overlap show_transparent_back "
        "use_backface_culling* use_raytrace_refraction use_screen_refraction use_sss_translucency "
        "refraction_depth thickness_mode use_thickness_from_shadow volume_intersection_method max_vertex_displacement "
        "specular_* line_* grease_pencil is_grease_pencil lineart preview_render_type use_preview_world texture_paint_* paint_* "
        "cycles",
        IDLE,
        "EEVEE's and Cycles' own, and the interface",
    ),
    Support("RenderSettings", "use_motion_blur", WARNED, "Motion blur is left out: everything stands still.", "motion_blur"),
    Support("Geometry", "hair point_cloud volume", WARNED, "Not drawn here: {}.", "geometry"),
)


def row_of(owner: str, name: str) -> Support | None:
    """The row that a property of a type stands in; None where none does."""
    for row in SUPPORT:
        if row.owner == owner and any(name == one or (one.endswith("*") and name.startswith(one[:-1])) for one in row.names.split()):
            return row
    return None
