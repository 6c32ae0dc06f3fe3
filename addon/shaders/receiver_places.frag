// The places that the camera sees as receivers for many lights: what shade.frag finds out of the G-buffer first.
#include "common_instance.glsl"
#include "common_triangles.glsl"
#include "common_large.glsl"
#include "common_octahedral.glsl"
#include "common_surface_seen.glsl"
uniform sampler2D u_view_depth;
uniform usampler2D u_ids;
uniform sampler2D u_normal;
uniform mat3 u_along_from_pixel, u_start_from_pixel;
layout(location = 0) out vec4 out_place;   // relative to u_origin; float32's noise, metres
layout(location = 1) out vec4 out_plane;   // unit normal on the viewer's side; 1 = there is a surface

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec2 ids = texelFetch(u_ids, pixel, 0).rg;
    if (ids.r == 0u) discard;
    vec3 pixel_h = vec3(gl_FragCoord.xy, 1.0);
    if ((ids.g & FROM_TEXTURE) != 0u) {   // an impostor: its triangles lie near, not in it
        vec3 along = u_along_from_pixel * pixel_h, normal = from_octahedral(texelFetch(u_normal, pixel, 0).rg);
        float view_depth = texelFetch(u_view_depth, pixel, 0).r;
        out_place = vec4(u_start_from_pixel * pixel_h + along * view_depth, 2e-3 * abs(view_depth));
        out_plane = vec4(dot(normal, along) > 0.0 ? -normal : normal, 1.0);
        return;
    }
    uint slot = ids.r - 1u;
    Surface seen = surface_seen(instance_info(slot), slot, ids.g, false, false, u_start_from_pixel * pixel_h,
                                u_along_from_pixel * pixel_h, texelFetch(u_view_depth, pixel, 0).r);
    out_place = vec4(seen.position_ws, seen.noise_m);
    out_plane = vec4(seen.normal_ws, 1.0);
}
