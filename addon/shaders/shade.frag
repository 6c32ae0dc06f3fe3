// Deferred shading of the pixels that have a surface: what is seen from the G-buffer, light from the shadow maps, error from the warp's
// Jacobian. The depth test leaves out the others (background.frag). All places are relative to
// u_origin, near what the camera sees, so that in a large world nothing large cancels.
#include "common_octahedral.glsl"
#include "common_instance.glsl"
#include "common_plan.glsl"
#include "common_aliasing.glsl"
#include "common_receiver.glsl"
#include "common_triangles.glsl"
#include "common_large.glsl"
#include "common_links.glsl"
#include "common_ray_walk.glsl"
#include "common_seen.glsl"
#include "common_filter.glsl"
#include "common_sky.glsl"
#include "common_light.glsl"
#if LOOKS
#include "common_look.glsl"
#endif
uniform vec4 u_background;
#include "common_ground.glsl"
uniform sampler2D u_normal;
uniform float u_side;              // pixels of the target to a side of the picture's pixel
uniform float u_footprint;         // of a camera sample, a side in the picture's pixels
uniform vec4 u_clay;
#if IMPOSTORS
#include "common_triangle_met.glsl"
#endif
#include "common_surface_seen.glsl"
#include "common_panes.glsl"
#if LAYER   // of what is see-through: what it adds to the picture, and what it leaves of what lies behind
layout(location = 0, index = 0) out vec4 out_combined;
layout(location = 0, index = 1) out vec4 out_through;
#else
layout(location = 0) out vec4 out_combined;
#endif
#if SUMS
#include "common_sums.glsl"
#endif
#if DATA
layout(location = 1) out vec4 out_errors;   // m, m_x, m_z; what the shadow lets through, 0...1
layout(location = 2) out vec4 out_normal;
layout(location = 3) out ivec4 out_ids;     // object, map or -1, instance row
#endif

#if LOOKS

float most(vec3 v) { return max(v.r, max(v.g, v.b)); }

// A surface with a look of its own; of a shadow catcher only how much darker it is than without what casts shadows on it.
vec4 looking(uvec4 info, vec3 color, vec3 normal, vec3 light_ws, vec3 eye_ws, vec3 light, float falloff) {
    if (has_flag(info, HOLDOUT)) return vec4(0.0);
    vec3 full = u_light_color.rgb * falloff, ambient = ambient_at(normal);
    if (has_flag(info, CATCHER)) {
        vec3 bright = ambient + full * max(dot(normal, light_ws), 0.0), now = ambient + full * light * max(dot(normal, light_ws), 0.0);
#if SUMS
        add_caught(dot(bright - now, vec3(1.0)), dot(bright, vec3(1.0)));
        return vec4(0.0);
#endif
        float darker = 1.0 - min(dot(now, vec3(1.0)) / max(dot(bright, vec3(1.0)), 1e-6), 1.0);
        return vec4(u_background.rgb * (1.0 - darker), mix(u_background.a, 1.0, darker));
    }
    Look look = look_of(info);
    if (USE_OBJECT_COLORS == 0) look = Look(vec3(0.0), 1.0 - most(look.through), 0.0, 1.0, 0.0, look.hole, look.through);
    vec3 lit = answered(look, color, normal, light_ws, eye_ws, full * light, ambient, ambient_at(reflect(-eye_ws, normal)));
    return vec4(lit, 1.0) * (1.0 - look.hole);
}
#endif

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec2 ids = texelFetch(u_ids, pixel, 0).rg;
    float view_depth = texelFetch(u_view_depth, pixel, 0).r;
    vec3 pixel_h = vec3(gl_FragCoord.xy, 1.0);
    vec3 along = u_along_from_pixel * pixel_h;
    vec3 start = u_start_from_pixel * pixel_h;
    vec3 smooth_normal = from_octahedral(texelFetch(u_normal, pixel, 0).rg);
    bool is_met = false, is_named = false;
#if IMPOSTORS
    int how = meet_ray(pixel, start, along, ids, view_depth, smooth_normal);
    is_met = how == MET;
    is_named = how == NAMED;
    if (ids.r == 0u) discard;   // the background stays
#endif
    uint slot = ids.r - 1u;
    uvec4 info = instance_info(slot);
    Surface seen = surface_seen(info, slot, ids.g, is_met, is_named, start, along, view_depth);
    vec3 x_ws = seen.position_ws, geometric = seen.normal_ws;
    smooth_normal = dot(smooth_normal, geometric) < 0.0 ? -smooth_normal : smooth_normal;
#if SKY
    sky_reach = reach_at(x_ws, geometric, view_depth);
#endif
    vec3 light_ws = towards_light(x_ws);
    bool faces = dot(geometric, light_ws) > 0.0;
    int map = map_index(x_ws, view_depth);
    float light = 0.0, at_place = 0.0;   // over the sample's footprint, at its very place
    vec3 tint = vec3(1.0);   // of the light that gets through panes
    vec3 errors = vec3(-1.0);
    if (map >= 0) {
        vec4 q = project(map, x_ws);
        vec3 grad_s, grad_t;
        texel_gradients(map, q, grad_s, grad_t);
        vec3 move_x = (u_along_from_pixel[0] * view_depth + u_start_from_pixel[0]) * u_side;
        vec3 move_y = (u_along_from_pixel[1] * view_depth + u_start_from_pixel[1]) * u_side;
        if (faces) {
            bool needs_pixels = FILTER_UNIT == FILTER_PIXELS || SMOOTHING > 1;
            mat2 on_surface = needs_pixels ? texel_jacobian(grad_s, grad_t, move_x, move_y, along, geometric) : mat2(1.0);
            light = at_place = 1.0;
            if (all(lessThanEqual(abs(q.xy), vec2(1.0)))) {
                float blur = interpolation_blur(grad_s, grad_t, seen.edge_1, seen.edge_2);
                Receiver r = receiver_at(map, q, grad_s, grad_t, x_ws, geometric, light_ws, seen.noise_m, blur, ids, id_of(info));
#if SMOOTHING > 1
                light = smoothed_light(r, u_footprint * on_surface, at_place);
#else
                light = at_place = light_at(r, on_surface);
#endif
#if PANES
                if (light > 0.0) tint = tint_at(r);
#endif
            }
        }
        if (DATA != 0 || DISPLAY == 2) {
            vec3 towards_eye = -normalize(along);
            vec3 mid = light_ws + towards_eye;
            mid = dot(mid, mid) > 1e-6 ? normalize(mid) : geometric;
            errors = vec3(total_error(texel_jacobian(grad_s, grad_t, move_x, move_y, along, geometric)),
                          directional_errors(texel_jacobian(grad_s, grad_t, move_x, move_y, along, mid)));
        }
    } else if (faces) {
        light = at_place = 1.0;
    }
#if LOOKS
    if (has_flag(info, UNLIT)) light = at_place = 0.0;
#endif
    if (u_light.w != 0.0 && !in_cone(u_light.xyz - x_ws)) light = at_place = 0.0;
    vec3 passed = light * tint;
    float got_through = dot(tint, vec3(1.0 / 3.0));
    light *= got_through;
    at_place *= got_through;
    float falloff = light_falloff(x_ws), arriving = light * falloff;
#if SUMS
    float facing = falloff * max(dot(geometric, light_ws), 0.0);
    out_shares = vec4(0.0);
    add_arriving((DISPLAY == 1 ? light : at_place) * facing, facing);
#endif
#if GROUND
    if (has_role(info, GROUND)) {
        float fade = ground_fade(x_ws.xy), dark = fade * (1.0 - light), sun = falloff * max(dot(geometric, light_ws), 0.0);
#if SUMS
        if (DISPLAY != 0) discard;
        out_shares.xy = vec2(0.0);
        add_arriving((1.0 - dark) * sun, sun);
        vec2 taken = ground_taken(fade, dark, sun);
        add_caught(taken.x, taken.y);
        out_combined = summed(vec4(0.0));
        return;
#endif
        out_combined = DISPLAY == 0 ? shadow_caught(fade, dark, sun) : u_background;
#if DATA
        out_errors = vec4(-1.0, -1.0, -1.0, 1.0 - ground_fade(x_ws.xy) * (1.0 - at_place));   // as background.frag, but for the shadow
        out_normal = vec4(0.0);
        out_ids = ivec4(-1);
#endif
        return;
    }
#endif
    vec3 color = USE_OBJECT_COLORS != 0 ? base_color(slot).rgb : u_clay.rgb;
    out_combined = vec4(displayed(color, smooth_normal, light_ws, DISPLAY == 1 ? light : arriving, errors, map), 1.0);
#if LOOKS && DISPLAY == 0
    out_combined = looking(info, color, smooth_normal, light_ws, -normalize(along), passed, falloff);
#if LAYER
    vec3 through = clamp(look_of(info).through, 0.0, 1.0);
    float left = dot(through, vec3(1.0 / 3.0));
    out_combined.a = 1.0 - left;
    out_through = vec4(through, left);
#endif
#endif
#if SUMS
    out_combined = summed(out_combined);
#endif
#if DATA
    out_errors = vec4(errors, at_place);
    out_normal = vec4(smooth_normal, view_depth);
    out_ids = ivec4(int(info.x) - 1, map, int(info.z), 0);
#endif
}
