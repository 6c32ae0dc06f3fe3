// Vertex stage of a caster pass that stores ids (IDS, see common_shadow_ids.glsl); after common_vertex.glsl.
#if IDS
flat out uint v_id;
#if !INSTANCED
in uint in_slot;
uint vertex_slot() { return in_slot; }
#endif
#if IDS == 1
void pass_id() { v_id = id_of(instance_info(vertex_slot())); }
#else
void pass_id() { v_id = vertex_slot(); }
#endif
#else
void pass_id() {}
#endif
