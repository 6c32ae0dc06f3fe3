// One layer of panes, surfaces that let light through, as a light sees them: NDC depth and tint of the nearest that lies behind those already
// there (depth peeling, Everitt 2001). Depths are not clamped: before the map's near plane panes lie behind one another as well.
#include "common_instance.glsl"
#include "common_look.glsl"
uniform usampler2D u_peeled;   // the layer before
uniform int u_is_first;
layout(location = 0) out uvec2 out_pane;   // bits of the depth, red, green and blue of 10 bits each

void write_pane(float depth) {
    if (u_is_first == 0 && !(depth > uintBitsToFloat(texelFetch(u_peeled, ivec2(gl_FragCoord.xy), 0).r))) discard;
    gl_FragDepth = 2.0 / (3.0 - min(depth, 1.0));   // any depth before the far plane, in order
    uvec3 tint = uvec3(clamp(tint_of(instance_info(v_id)), 0.0, 1.0) * 1023.0 + 0.5);
    out_pane = uvec2(floatBitsToUint(depth), tint.r | (tint.g << 10) | (tint.b << 20));
}
