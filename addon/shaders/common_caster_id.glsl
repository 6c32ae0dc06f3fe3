// Vertex stage of a caster pass that stores ids (IDS, see common_shadow_ids.glsl); after common_vertex.glsl or common_instance.glsl.
#ifndef IS_CUT
#define IS_CUT 0
#endif
#ifndef INSTANCED
#define INSTANCED 0
#endif
#if IDS
flat out uint v_id;
#if IS_CUT || !INSTANCED
in uint in_slot;
uint vertex_slot() { return in_slot; }
#endif
#if IS_CUT && IDS == 2
in uint in_triangle;
flat out int v_triangle;
#endif
#if IDS == 1
void pass_id() { v_id = id_of(instance_info(vertex_slot())); }
#elif IS_CUT && IDS == 2
void pass_id() {
    v_id = vertex_slot();
    v_triangle = int(in_triangle);
}
#elif defined(COARSE)
uniform usamplerBuffer u_coarse_places;   // by slot: the original's slot, and where its triangles begin in the index pool
flat out uint v_first;
void pass_id() {
    uvec2 place = texelFetch(u_coarse_places, int(vertex_slot())).rg;
    v_id = place.x;
    v_first = place.y;
}
#else
void pass_id() { v_id = vertex_slot(); }
#endif
#else
void pass_id() {}
#endif
