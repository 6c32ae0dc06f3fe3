// The shadow maps of one light and view: mirrors maths/shadow/lookup.py, which is the oracle of these functions.
#include "common_log_warp.glsl"
#ifndef ANY_LOG
#define ANY_LOG 1   // 0: no map is logarithmic, and nothing is compiled for one
#endif
struct ShadowMap {
    mat4 clip_from_world;   // NDC after division: s, t, depth growing away from the light
    mat4 world_from_clip;
    vec4 bounds;            // view depth from, to; number of region planes; 1 = holds no receiver
    vec4 planes[4];         // inside where dot(plane, (X, 1)) >= 0
    vec4 log_warp;          // as common_log_warp.glsl has it
    vec4 log_linear;        // the projective part's own t = x + y / w; base and slope of common_log_warp.glsl
};
layout(std140) uniform ShadowPlan { ShadowMap maps[MAX_MAPS]; };
uniform int u_map_count;
uniform float u_map_size;
uniform vec4 u_light;  // sun: direction towards it, 0; spot, point: position, 1

vec3 towards_light(vec3 x_ws) { return u_light.w == 0.0 ? u_light.xyz : normalize(u_light.xyz - x_ws); }

// The first map whose view-depth bounds and region planes hold; -1 when none.
int map_index(vec3 x_ws, float view_depth) {
    for (int i = 0; i < u_map_count; ++i) {
        vec4 bounds = maps[i].bounds;
        if (bounds.w != 0.0 || !(view_depth >= bounds.x && view_depth < bounds.y)) continue;
        bool inside = true;
        for (int k = 0; k < int(bounds.z); ++k) inside = inside && dot(maps[i].planes[k], vec4(x_ws, 1.0)) >= 0.0;
        if (inside) return i;
    }
    return -1;
}

// (s, t, depth) in NDC and w.
vec4 project(int i, vec3 x_ws) {
    vec4 c = maps[i].clip_from_world * vec4(x_ws, 1.0);
    vec4 l = maps[i].log_warp;
    if (ANY_LOG == 0 || l.w == 0.0) return vec4(c.xyz / c.w, c.w);
    return vec4(l.z == 0.0 ? c.x : c.x / c.w, log_t(l, maps[i].log_linear.zw, c.w), c.z, c.w);
}

// World point at NDC (s, t, depth): the inverse of project.
vec3 unproject(int i, vec3 q) {
    vec4 l = maps[i].log_warp;
    vec4 c = vec4(q, 1.0);
    if (ANY_LOG != 0 && l.w != 0.0) {
        float w = log_w(l, maps[i].log_linear.zw, q.y);
        c = vec4(l.z == 0.0 ? q.x : q.x * w, maps[i].log_linear.x * w + maps[i].log_linear.y, q.z, w);
    }
    vec4 x = maps[i].world_from_clip * c;
    return x.xyz / x.w;
}

// Gradients over world space of the texel coordinates s and t, at a point that projects to q = project(i, x).
void texel_gradients(int i, vec4 q, out vec3 grad_s, out vec3 grad_t) {
    mat4 m = transpose(maps[i].clip_from_world);
    float half_size = 0.5 * u_map_size;
    vec4 l = maps[i].log_warp;
    if (ANY_LOG == 0 || l.w == 0.0) {
        grad_s = (m[0].xyz - q.x * m[3].xyz) * (half_size / q.w);
        grad_t = (m[1].xyz - q.y * m[3].xyz) * (half_size / q.w);
        return;
    }
    grad_s = l.z == 0.0 ? m[0].xyz * half_size : (m[0].xyz - q.x * m[3].xyz) * (half_size / q.w);
    grad_t = m[3].xyz * (half_size * log_rate(l, maps[i].log_linear.zw, q.w));
}
