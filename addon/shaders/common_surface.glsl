// A fragment of geometry: how far behind the near plane it lies, and its depth where the rasteriser does not write it (DEPTH_BY).
#define RASTERISER 0
#define FRAGMENT 1   // a driver without clip control: the rasteriser's depth would be moved to 0.5 ... 1 and lose its digits
in float v_behind_near;
uniform float u_near;
#if DEPTH_BY == FRAGMENT
#include "common_depth.glsl"
uniform float u_section;   // metres behind the near plane to the camera's far plane
#endif

// Metres behind the near plane; writes the depth.
float seen_behind_near() {
#if DEPTH_BY == FRAGMENT
    if (v_behind_near > u_section) discard;
    gl_FragDepth = depth_behind(v_behind_near);
#endif
    return v_behind_near;
}
