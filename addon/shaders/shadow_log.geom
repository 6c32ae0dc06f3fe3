// A triangle whose edges are curves in a logarithmic map becomes a few boxes that hold it; the fragment stage decides exactly.
// s = X/w is extremal at corners (a projective map with w > 0) and t is monotonic in w, so the box of the corners is the box of the part
// between two rows. A slanting rod would fill little of one box: it is cut into slabs of rows.
layout(triangles) in;
layout(triangle_strip, max_vertices = 48) out;
uniform vec4 u_log_warp;   // as ShadowMap.log_warp
uniform float u_map_size;
in vec4 v_clip[];
#if IDS
flat in uint v_id[];
flat out uint g_id;
#endif
flat out vec2 g_origin, g_side1, g_side2;   // the triangle in (X, w), where its edges are straight and its depth is affine
flat out vec3 g_depth;                      // depth at the origin and its change along the sides

float s_of(float x, float w) { return u_log_warp.z == 0.0 ? x : x / w; }
float t_of(float w) { return u_log_warp.x * log2(w) + u_log_warp.y; }

float w_of(float t) { return exp2((t - u_log_warp.y) / u_log_warp.x); }

const int MOST_SLABS = 12;
const float SMALL_CELLS = 64.0;  // a box of so many cells is not worth cutting

// Least and largest s of the triangle's part with w in [from, to]; empty: x > y.
vec2 s_range(float from, float to) {
    vec2 range = vec2(1e30, -1e30);
    for (int i = 0; i < 3; ++i) {
        vec2 a = v_clip[i].xw, b = v_clip[(i + 1) % 3].xw;
        if (a.y >= from && a.y <= to) {
            float s = s_of(a.x, a.y);
            range = vec2(min(range.x, s), max(range.y, s));
        }
        for (int end = 0; end < 2; ++end) {
            float w = end == 0 ? from : to;
            if ((a.y < w) != (b.y < w)) {
                float s = s_of(mix(a.x, b.x, (w - a.y) / (b.y - a.y)), w);
                range = vec2(min(range.x, s), max(range.y, s));
            }
        }
    }
    return range;
}

void emit_box(vec2 low, vec2 high) {
    vec2 corners[4] = vec2[4](low, vec2(high.x, low.y), vec2(low.x, high.y), high);
    for (int i = 0; i < 4; ++i) {
        gl_Position = vec4(corners[i], 0.0, 1.0);
        gl_PrimitiveID = gl_PrimitiveIDIn;
        g_origin = v_clip[0].xw;
        g_side1 = v_clip[1].xw - g_origin;
        g_side2 = v_clip[2].xw - g_origin;
        g_depth = vec3(v_clip[0].z, v_clip[1].z - v_clip[0].z, v_clip[2].z - v_clip[0].z);
#if IDS
        g_id = v_id[0];
#endif
        EmitVertex();
    }
    EndPrimitive();
}

void main() {
    vec2 side1 = v_clip[1].xw - v_clip[0].xw, side2 = v_clip[2].xw - v_clip[0].xw;
    if (side1.x * side2.y == side1.y * side2.x) return;
    // what lies before the map's first row is cut off there, so that w stays positive
    vec3 w = vec3(v_clip[0].w, v_clip[1].w, v_clip[2].w);
    float from = max(min(w.x, min(w.y, w.z)), w_of(-1.0) * 0.999), to = min(max(w.x, max(w.y, w.z)), w_of(1.0) * 1.001);
    if (from > to) return;
    float spare = 0.05 / u_map_size, bottom = t_of(from) - spare, top = t_of(to) + spare;
    vec2 whole = s_range(from, to);
    if (whole.x > 1.0 || whole.y < -1.0 || whole.x > whole.y) return;
    whole = clamp(whole, -1.0, 1.0);
    vec2 cells = 0.5 * u_map_size * vec2(whole.y - whole.x, top - bottom);
    int slabs = cells.x * cells.y > SMALL_CELLS ? clamp(int(0.5 * min(cells.x, cells.y)), 1, MOST_SLABS) : 1;
    for (int k = 0; k < slabs; ++k) {
        vec2 rows = bottom + (top - bottom) * vec2(float(k), float(k + 1)) / float(slabs) + vec2(-spare, spare);
        vec2 range = s_range(max(w_of(rows.x), from), min(w_of(rows.y), to));
        if (range.x <= range.y) emit_box(clamp(vec2(range.x - spare, rows.x), -1.0, 1.0), clamp(vec2(range.y + spare, rows.y), -1.0, 1.0));
    }
}
