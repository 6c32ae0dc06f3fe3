// Depth, and what IDS asks for beside it.
#include "common_shadow_ids.glsl"
#if IDS == 3
in vec2 v_depth_w;
void main() { write_pane(v_depth_w.x / v_depth_w.y); }
#else
void main() { write_ids(); }
#endif
