// Depth, and what IDS asks for beside it.
#include "common_shadow_ids.glsl"
void main() { write_ids(); }
