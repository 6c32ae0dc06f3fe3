// The cut faces of sections over the picture: one color, or hatched, every other part the other way round.
#include "common_instance.glsl"
uniform usampler2D u_ids;
uniform vec3 u_cap_color;
uniform vec3 u_hatch;   // distance between lines and their width, pixels; how much darker they are; 0: none
out vec4 out_color;

void main() {
    uvec2 ids = texelFetch(u_ids, ivec2(gl_FragCoord.xy), 0).rg;
    if (ids.x == 0u) discard;
    uvec4 info = instance_info(ids.x - 1u);
    if (!has_role(info, CAP)) discard;
    vec2 at = gl_FragCoord.xy;
    float across = (at.x + ((info.x & 1u) == 0u ? at.y : -at.y)) * 0.70710678;
    float off = abs(mod(across, u_hatch.x) - 0.5 * u_hatch.x);
    float line = clamp(0.5 * u_hatch.y + 0.5 - off, 0.0, 1.0) * u_hatch.z;
    out_color = vec4(u_cap_color * (1.0 - line), 1.0);
}
