// A layer of what is see-through, from the sums of common_sums.glsl: what it adds to the picture, and what it leaves of what lies behind.
#include "common_instance.glsl"
#include "common_look.glsl"
uniform sampler2D u_sampled;
uniform usampler2D u_ids;
uniform float u_share;   // of one picture among those added up
layout(location = 0, index = 0) out vec4 out_combined;
layout(location = 0, index = 1) out vec4 out_through;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec4 info = instance_info(texelFetch(u_ids, pixel, 0).r - 1u);
    vec3 through = clamp(look_of(info).through, 0.0, 1.0);
    float left = dot(through, vec3(1.0 / 3.0));
    out_combined = vec4(texelFetch(u_sampled, pixel, 0).rgb * u_share, 1.0 - left);
    out_through = vec4(through, left);
}
