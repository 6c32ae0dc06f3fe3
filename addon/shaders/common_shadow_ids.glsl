// What a shadow map stores beside the depth: IDS 0 nothing, 1 the object's number (the ID test), 2 slot + 1 and triangle in the index pool
// (the triangle-exact test; same numbers as the G-buffer's).
#ifdef MOST_SLABS
#define v_id g_id  // from the geometry stage of a logarithmic map
#endif
#if IDS == 1
flat in uint v_id;
layout(location = 0) out uint out_id;
void write_ids() { out_id = v_id; }
#elif IDS == 2
flat in uint v_id;
uniform int u_first_triangle;
layout(location = 0) out uvec2 out_id;
void write_ids() { out_id = uvec2(v_id + 1u, uint(u_first_triangle + gl_PrimitiveID)); }
#else
void write_ids() {}
#endif
