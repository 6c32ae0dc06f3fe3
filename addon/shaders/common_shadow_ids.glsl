// What a shadow map stores beside the depth: IDS 0 nothing, 1 the object's number (the ID test), 2 slot + 1 and triangle in the index pool
// (the triangle-exact test; same numbers as the G-buffer's), 3 nothing of the kind: panes, what is see-through and tints light (pane.glsl).
// Pieces of large triangles (IS_CUT) bring their triangle's number along, triangles of coarser casters (COARSE) that of the original at them.
#ifndef IS_CUT
#define IS_CUT 0
#endif
#ifdef MOST_SLABS
#define v_id g_id  // from the geometry stage of a logarithmic map
#endif
#if IDS == 1
flat in uint v_id;
layout(location = 0) out uint out_id;
void write_ids() { out_id = v_id; }
#elif IDS == 2
flat in uint v_id;
layout(location = 0) out uvec2 out_id;
#if IS_CUT && !defined(MOST_SLABS)
flat in int v_triangle;
void write_ids() { out_id = uvec2(v_id + 1u, uint(v_triangle)); }
#elif IS_CUT
void write_ids() { out_id = uvec2(v_id + 1u, uint(gl_PrimitiveID)); }
#elif defined(COARSE)
uniform int u_first_triangle;
uniform usamplerBuffer u_coarse_sources;  // by triangle: the original's triangle that lies there, counted from its first
flat in uint v_first;
void write_ids() { out_id = uvec2(v_id + 1u, v_first + texelFetch(u_coarse_sources, u_first_triangle + gl_PrimitiveID).r); }
#else
uniform int u_first_triangle;
void write_ids() { out_id = uvec2(v_id + 1u, uint(u_first_triangle + gl_PrimitiveID)); }
#endif
#elif IDS == 3
flat in uint v_id;   // slot
#include "pane.glsl"
#else
void write_ids() {}
#endif
