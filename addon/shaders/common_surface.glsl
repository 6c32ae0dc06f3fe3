// A fragment of geometry: which triangle it is of, how far behind the near plane it lies, and its depth where the rasteriser does not write it.
#define RASTERISER 0
#define FRAGMENT 1   // a driver without clip control: the rasteriser's depth would be moved to 0.5 ... 1 and lose its digits
in float v_behind_near;
uniform float u_near;
#if DEPTH_BY == FRAGMENT
#include "common_depth.glsl"
uniform float u_section;   // metres behind the near plane to the camera's far plane
#endif
#if IS_CUT
flat in uint v_triangle;
uint seen_triangle() { return v_triangle; }
#else
uniform int u_first_triangle;
uint seen_triangle() { return uint(u_first_triangle + gl_PrimitiveID); }
#endif

// Metres behind the near plane; writes the depth.
float seen_behind_near() {
#if DEPTH_BY == FRAGMENT
    if (v_behind_near > u_section) discard;
    gl_FragDepth = depth_behind(v_behind_near);
#endif
    return v_behind_near;
}
