// A triangle whose edges are curves in a logarithmic map, cut at fixed rows of the map, so close together that a straight edge from row to
// row is its curve within BEND_TEXELS of pipeline/passes/log_map.py. The rows are the same for all triangles and a cut point depends on its
// edge alone: neighbours share every point, no crack opens between them. What lies before the first or behind the last row is cut off.
layout(triangles) in;
layout(triangle_strip, max_vertices = MOST_VERTICES) out;
#include "common_log_warp.glsl"
uniform vec4 u_log_warp;    // as common_log_warp.glsl has them
uniform vec2 u_log_bend;
uniform int u_rows;         // row j of u_rows lies at t = 2 j / u_rows - 1
uniform int u_first_slab;   // of the triangle's own slabs, this draw emits MOST_SLABS from here on
uniform float u_shift;      // how far before its curve a cut point lies, see emit_cut
#if IDS
flat in uint v_id[];
flat out uint g_id;
#endif
#ifndef IS_CUT
#define IS_CUT 0
#endif
#if IS_CUT && IDS == 2
flat in int v_triangle[];
#define TRIANGLE v_triangle[0]
#else
#define TRIANGLE gl_PrimitiveIDIn
#endif
// A plane's depth is affine in (X, w); divided by the divisor of s (w, or 1) it is affine along a row, and straight from row to row as the
// edges are; so is the divisor's inverse. Taken from the triangle's lowest corner, so that a level triangle stays level to the last bit.
flat out float g_level;
noperspective out vec2 g_rise;   // (depth - level) / divisor, 1 / divisor

float level;

float t_of_row(int j) { return float(j) * (2.0 / float(u_rows)) - 1.0; }
float w_of_row(int j) { return log_w(u_log_warp, u_log_bend, t_of_row(j)); }
float t_of(float w) { return log_t(u_log_warp, u_log_bend, w); }
int row_below(float w) { return int(floor((t_of(w) + 1.0) * 0.5 * float(u_rows))); }

void emit(float s, float t, float rise, float inverse_divisor) {
    gl_Position = vec4(s, t, 0.0, 1.0);
    g_level = level;
    g_rise = vec2(rise, inverse_divisor);
#if IDS
    g_id = v_id[0];
#endif
#if IDS == 2
    gl_PrimitiveID = TRIANGLE;
#endif
    EmitVertex();
}

void emit_corner(vec4 c) {
    float divisor = u_log_warp.z == 0.0 ? 1.0 : c.w;
    emit(c.x / divisor, t_of(c.w), (c.z - level) / divisor, 1.0 / divisor);
}

// Where the edge from a to b (a.w < w < b.w) crosses a row. Along it s, rise and 1 / w are constant + share * exp(-t or t), and chords lie
// beyond such a curve; a cut point lies u_shift of the share before it, so that the chord misses the curve as much on either side.
void emit_cut(vec4 a, vec4 b, float t, float w) {
    vec4 side = b - a;
    vec2 slope = side.xz / side.w, at = vec2(a.x, a.z - level) + slope * (w - a.w);
    if (u_log_warp.z == 0.0) {
        at -= u_shift * w * slope;
        emit(at.x, t, at.y, 1.0);
    } else {
        float shift = u_shift * (1.0 + w * u_log_bend.y / u_log_bend.x);
        at = (at - shift * (at - w * slope)) / w;
        emit(at.x, t, at.y, (1.0 - shift) / w);
    }
}

void main() {
    // corners by w: the long edge runs from low to high, the two short ones meet in middle
    vec4 low = gl_in[0].gl_Position, middle = gl_in[1].gl_Position, high = gl_in[2].gl_Position, kept;
    if (middle.w < low.w) { kept = low; low = middle; middle = kept; }
    if (high.w < middle.w) { kept = middle; middle = high; high = kept; }
    if (middle.w < low.w) { kept = low; low = middle; middle = kept; }
    float w_first = w_of_row(0), w_last = w_of_row(u_rows);
    if (high.w <= w_first || low.w >= w_last) return;

    // the rows between the corners; rounding of the logarithm must not put one beyond a corner
    bool from_low = low.w > w_first, to_high = high.w < w_last;
    int first = from_low ? row_below(low.w) + 1 : 0, last = to_high ? row_below(high.w) : u_rows;
    if (from_low && w_of_row(first) <= low.w) ++first;
    if (to_high && w_of_row(last) >= high.w) --last;
    first += u_first_slab;
    if (u_first_slab > 0) {
        if (first >= last) return;
        from_low = false;
    }
    if (last > first + MOST_SLABS) {
        last = first + MOST_SLABS;
        to_high = false;
    }

    level = low.z;
    if (from_low) emit_corner(low);
    bool is_above = !from_low && middle.w < w_of_row(first);   // then rows cut the upper short edge from the start
    for (int j = first; j <= last; ++j) {
        float t = t_of_row(j), w = w_of_row(j);
        if (!is_above && middle.w < w) {
            emit_corner(middle);
            is_above = true;
        }
        // short edge then long edge below the middle corner, long then short above it: so the strip never folds
        emit_cut(low, is_above ? high : middle, t, w);
        emit_cut(is_above ? middle : low, high, t, w);
    }
    if (to_high) {
        if (!is_above) emit_corner(middle);
        emit_corner(high);
    }
    EndPrimitive();
}
