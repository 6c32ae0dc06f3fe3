// Where a vertex stands: baked parts carry world positions and their slot, instanced ones look both up.
in vec3 in_position;
#ifndef IDS
#define IDS 0
#endif
#if INSTANCED || IDS == 1
#include "common_instance.glsl"
#endif
#if INSTANCED
uniform usamplerBuffer u_visible;
uniform int u_first_instance;
uint vertex_slot() { return texelFetch(u_visible, u_first_instance + gl_InstanceID).r; }
vec3 vertex_ws() { return placed_ws(vertex_slot(), in_position); }
vec3 vertex_from(vec3 anchor) { return placed_from(vertex_slot(), in_position, anchor); }
#else
vec3 vertex_ws() { return in_position; }
vec3 vertex_from(vec3 anchor) { return in_position - anchor; }
#endif
