// Deferred shading: surface from the G-buffer, light from the shadow maps, error from the warp's Jacobian.
#include "common_octahedral.glsl"
#include "common_instance.glsl"
#include "common_plan.glsl"
#include "common_aliasing.glsl"
#include "common_depth_test.glsl"
#include "common_filter.glsl"
#include "common_light.glsl"
uniform sampler2D u_view_depth;
uniform sampler2D u_normal;
uniform usampler2D u_ids;
uniform samplerBuffer u_positions;
uniform usamplerBuffer u_indices;
uniform mat3 u_along_from_pixel;   // view ray per metre of view depth: M (x, y, 1), pixel coordinates from the bottom left
uniform mat3 u_start_from_pixel;   // world point at view depth 0
uniform vec4 u_background, u_clay;
layout(location = 0) out vec4 out_combined;
#if DATA
layout(location = 1) out vec4 out_errors;   // m, m_x, m_z; light 0...1
layout(location = 2) out vec4 out_normal;
layout(location = 3) out ivec2 out_ids;     // object or -1, map or -1
#endif

vec3 corner_ws(uvec4 info, uint slot, uint corner) {
    int v = int(texelFetch(u_indices, int(corner)).r) * 3;
    vec3 p = vec3(texelFetch(u_positions, v).r, texelFetch(u_positions, v + 1).r, texelFetch(u_positions, v + 2).r);
    return info.w != 0u ? p : placed_ws(slot, p);
}

// Normal of the triangle itself, turned to the viewer.
vec3 geometric_normal_ws(uvec4 info, uint slot, uint triangle, vec3 along) {
    vec3 a = corner_ws(info, slot, triangle * 3u), b = corner_ws(info, slot, triangle * 3u + 1u), c = corner_ws(info, slot, triangle * 3u + 2u);
    vec3 n = cross(b - a, c - a);
    n /= max(length(n), 1e-30);
    return dot(n, along) > 0.0 ? -n : n;
}

void background() {
    out_combined = u_background;
#if DATA
    out_errors = vec4(-1.0, -1.0, -1.0, 1.0);
    out_normal = vec4(0.0);
    out_ids = ivec2(-1);
#endif
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec2 ids = texelFetch(u_ids, pixel, 0).rg;
    if (ids.r == 0u) { background(); return; }
    uint slot = ids.r - 1u;
    uvec4 info = instance_info(slot);
    float view_depth = texelFetch(u_view_depth, pixel, 0).r;
    vec3 pixel_h = vec3(gl_FragCoord.xy, 1.0);
    vec3 along = u_along_from_pixel * pixel_h;
    vec3 x_ws = u_start_from_pixel * pixel_h + along * view_depth;
    vec3 geometric = geometric_normal_ws(info, slot, ids.g, along);
    vec3 smooth_normal = from_octahedral(texelFetch(u_normal, pixel, 0).rg);
    smooth_normal = dot(smooth_normal, geometric) < 0.0 ? -smooth_normal : smooth_normal;
    vec3 light_ws = towards_light(x_ws);
    bool faces = dot(geometric, light_ws) > 0.0;
    int map = map_index(x_ws, view_depth);
    float light = 0.0;
    vec3 errors = vec3(-1.0);
    if (map >= 0) {
        vec4 q = project(map, x_ws);
        if (faces) light = light_at(map, q, x_ws, geometric, light_ws);
#if DATA
        vec3 grad_s, grad_t;
        texel_gradients(map, q, grad_s, grad_t);
        vec3 move_x = u_along_from_pixel[0] * view_depth + u_start_from_pixel[0];
        vec3 move_y = u_along_from_pixel[1] * view_depth + u_start_from_pixel[1];
        vec3 towards_eye = -normalize(along);
        vec3 mid = light_ws + towards_eye;
        mid = dot(mid, mid) > 1e-6 ? normalize(mid) : geometric;
        errors = vec3(total_error(texel_jacobian(grad_s, grad_t, move_x, move_y, along, geometric)),
                      directional_errors(texel_jacobian(grad_s, grad_t, move_x, move_y, along, mid)));
#endif
    } else if (faces) {
        light = 1.0;
    }
    light *= light_falloff(x_ws);
    vec3 color = USE_OBJECT_COLORS != 0 ? base_color(slot).rgb : u_clay.rgb;
    out_combined = vec4(displayed(color, smooth_normal, light_ws, light, errors, map), 1.0);
#if DATA
    out_errors = vec4(errors, light);
    out_normal = vec4(smooth_normal, view_depth);
    out_ids = ivec2(int(info.x) - 1, map);
#endif
}
