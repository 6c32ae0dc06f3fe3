// For every pixel the line nearest to it at which its own surface ends or folds: the edge of its triangle itself, exactly projected, where
// the surface has a crease, a border or a silhouette there; else, where a neighbouring pixel shows another part or something far behind,
// a line between the two. What no pixel shows has no line: hidden lines are off.
#include "common_instance.glsl"
#include "common_triangles.glsl"
#include "common_links.glsl"
#include "common_octahedral.glsl"
uniform sampler2D u_view_depth;
uniform sampler2D u_normal;
uniform usampler2D u_ids;
uniform mat3 u_along_from_pixel;   // view ray per metre of view depth: M (x, y, 1), pixel coordinates from the bottom left
uniform mat3 u_start_from_pixel;   // place at view depth 0, relative to u_origin
uniform mat3x4 u_rows;             // clip x, clip y, metres behind the near plane, of a place relative to u_origin
uniform vec2 u_w_rule;             // clip w of a place t metres behind the near plane: x + y t
uniform float u_pixel_m;           // a pixel's side per metre of view depth, or (parallel) anywhere
uniform bool u_is_parallel;
uniform vec2 u_half_size;          // of the picture, pixels
uniform float u_crease_cos;        // faces that turn by more have a line between them
uniform float u_most_px;           // lines farther from the pixel's centre than this are not wanted
const float KEPT_PX = 16.0;        // how far a line is kept on either side of the pixel
const int MOST_STEPS = 4;          // over the mesh towards an outline
const float GAP = 1.5;             // pixels off each other's plane: what is more apart is not one surface
layout(location = 0) out vec4 out_line;    // its two ends, pixels from this pixel's centre
layout(location = 1) out float out_depth;  // view depth at its nearest place; negative: not an edge of the mesh; 0: no line

// What a pixel shows, but for the ground, which is not there.
uvec2 ids_at(ivec2 pixel) {
    uvec2 ids = texelFetch(u_ids, pixel, 0).rg & uvec2(~0u, ~FROM_TEXTURE);
    return ids.x != 0u && has_role(instance_info(ids.x - 1u), GROUND) ? uvec2(0u) : ids;
}

struct Seen {
    uint slot, triangle, object;
    bool is_cap;
    vec3 place, along;
    vec3 corners[3];
    vec3 normal;       // of the triangle, towards the eye
    float view_depth;
};

vec3 ray_along(vec2 at) { return u_along_from_pixel * vec3(at, 1.0); }

vec3 place_at(vec2 at, float view_depth) { return u_start_from_pixel * vec3(at, 1.0) + view_depth * ray_along(at); }

Seen seen_at(ivec2 pixel, uvec2 ids) {
    Seen s;
    s.slot = ids.x - 1u;
    s.triangle = ids.y;
    uvec4 info = instance_info(s.slot);
    s.object = info.x;
    s.is_cap = has_role(info, CAP);
    vec2 at = vec2(pixel) + 0.5;
    s.view_depth = texelFetch(u_view_depth, pixel, 0).r;
    s.along = ray_along(at);
    s.place = place_at(at, s.view_depth);
    for (int k = 0; k < 3; ++k) s.corners[k] = corner_ws(info, s.slot, s.triangle * 3u + uint(k));
    vec3 n = cross(s.corners[1] - s.corners[0], s.corners[2] - s.corners[0]);
    n /= max(length(n), 1e-30);
    s.normal = dot(n, s.along) > 0.0 ? -n : n;
    return s;
}

float footprint_at(float view_depth) { return u_is_parallel ? u_pixel_m : u_pixel_m * view_depth; }

// Is there a gap between what two pixels show? Each lies off the other's plane by more than a fold could explain.
bool is_apart(Seen s, ivec2 pixel, uvec2 ids, float view_depth) {
    float most = GAP * footprint_at(min(view_depth, s.view_depth));
    vec3 step = place_at(vec2(pixel) + 0.5, view_depth) - s.place;
    if (abs(dot(s.normal, step)) <= most) return false;
    return abs(dot(seen_at(pixel, ids).normal, step)) > most;
}

// The place of a corner in the picture, pixels from `centre`, and its clip w. False: the whole edge lies behind the near plane.
bool edge_in_picture(vec3 a, vec3 b, vec2 centre, out vec3 pa, out vec3 pb) {
    vec3 ca = vec4(a, 1.0) * u_rows, cb = vec4(b, 1.0) * u_rows;
    if (ca.z < 0.0 && cb.z < 0.0) return false;
    if (ca.z < 0.0) ca = mix(ca, cb, ca.z / (ca.z - cb.z));
    else if (cb.z < 0.0) cb = mix(cb, ca, cb.z / (cb.z - ca.z));
    float wa = u_w_rule.x + u_w_rule.y * ca.z, wb = u_w_rule.x + u_w_rule.y * cb.z;
    pa = vec3((ca.xy / wa + 1.0) * u_half_size - centre, wa);
    pb = vec3((cb.xy / wb + 1.0) * u_half_size - centre, wb);
    return true;
}

// Where along a to b the origin is nearest, 0 ... 1.
float nearest_on(vec2 a, vec2 b) {
    vec2 along = b - a;
    return clamp(-dot(a, along) / max(dot(along, along), 1e-12), 0.0, 1.0);
}

// Direction from an edge into a triangle, across the edge and in its plane.
vec3 across_edge(vec3 edge, vec3 into) {
    vec3 across = into - edge * dot(into, edge);
    return across / max(length(across), 1e-30);
}

// Of the triangle's corners the one farthest from the line through `a` along `edge`, from `a`.
vec3 corner_off(uint slot, uint triangle, vec3 a, vec3 edge) {
    uvec4 info = instance_info(slot);
    vec3 best = vec3(0.0);
    float most = -1.0;
    for (int k = 0; k < 3; ++k) {
        vec3 from = corner_ws(info, slot, triangle * 3u + uint(k)) - a;
        float off = length(cross(edge, from));
        if (off > most) { most = off; best = from; }
    }
    return best;
}

// Does the surface go on at that pixel, beyond a border? It does where triangles meet without sharing corners.
bool goes_on(Seen s, ivec2 pixel) {
    ivec2 last = ivec2(2.0 * u_half_size) - 1;
    if (any(lessThan(pixel, ivec2(0))) || any(greaterThan(pixel, last))) return false;
    uvec2 ids = ids_at(pixel);
    if (ids.x == 0u) return false;
    Seen other = seen_at(pixel, ids);
    if (other.object != s.object || dot(other.normal, s.normal) < u_crease_cos) return false;
    return !is_apart(s, pixel, ids, other.view_depth);
}

// Is the edge from corner k one to be drawn? `nearest` its nearest place and `outwards` the way off the triangle, pixels.
bool is_feature(Seen s, int k, ivec2 pixel, vec2 nearest, vec2 outwards) {
    uint across = texelFetch(u_links, int(s.triangle) * 3 + k).r;
    if (across == SEVERAL) return true;
    if (across == NOTHING) return !goes_on(s, ivec2(floor(vec2(pixel) + 0.5 + nearest + 1.2 * outwards)));
    vec3 a = s.corners[k], edge = s.corners[(k + 1) % 3] - a;
    edge /= max(length(edge), 1e-30);
    vec3 own = across_edge(edge, s.corners[(k + 2) % 3] - a);
    vec3 other = across_edge(edge, corner_off(s.slot, across, a, edge));
    if (-dot(own, other) < u_crease_cos) return true;
    vec3 ray = u_is_parallel ? s.along : a - place_at(vec2(pixel) + 0.5, 0.0);
    return dot(cross(edge, own), ray) * dot(cross(other, edge), ray) < 0.0;   // it turns away there
}

vec2 kept(vec2 p, vec2 nearest) {
    vec2 off = p - nearest;
    return nearest + off * min(1.0, KEPT_PX / max(length(off), 1e-6));
}

// The nearest edge of the pixel's own triangle that is to be drawn; `best` its distance.
void edges_of_triangle(Seen s, ivec2 pixel, inout float best) {
    vec2 centre = vec2(pixel) + 0.5;
    for (int k = 0; k < 3; ++k) {
        vec3 a, b, c, d;
        if (!edge_in_picture(s.corners[k], s.corners[(k + 1) % 3], centre, a, b)) continue;
        float t = nearest_on(a.xy, b.xy);
        vec2 nearest = mix(a.xy, b.xy, t);
        float distance_px = length(nearest);
        if (distance_px >= best) continue;
        vec2 outwards = normalize(vec2(b.y - a.y, a.x - b.x) + vec2(1e-12, 0.0));
        if (edge_in_picture(s.corners[(k + 2) % 3], s.corners[k], centre, c, d) && dot(c.xy - a.xy, outwards) > 0.0) outwards = -outwards;
        if (!is_feature(s, k, pixel, nearest, outwards)) continue;
        best = distance_px;
        out_line = vec4(kept(a.xy, nearest), kept(b.xy, nearest));
        float depth = 1.0 / mix(1.0 / a.z, 1.0 / b.z, t);
        out_depth = u_is_parallel ? s.view_depth : depth;
    }
}

// Over the edges of the mesh towards the outline, as far as it may lie between this pixel and its neighbours: triangles there are seen so
// edge-on that no pixel shows them.
bool walked_to_outline(Seen s, ivec2 pixel, vec2 towards) {
    vec2 centre = vec2(pixel) + 0.5;
    float nearest = 1.6;
    for (int step = 0; step < MOST_STEPS; ++step) {
        int ahead = 0;
        float farthest = -1e9;
        for (int k = 0; k < 3; ++k) {
            vec3 a, b;
            if (!edge_in_picture(s.corners[k], s.corners[(k + 1) % 3], centre, a, b)) continue;
            float along = dot(a.xy + b.xy, towards);
            if (along > farthest) { farthest = along; ahead = k; }
        }
        uint across = texelFetch(u_links, int(s.triangle) * 3 + ahead).r;
        if (across >= SEVERAL) return false;
        s.triangle = across;
        for (int k = 0; k < 3; ++k) s.corners[k] = corner_ws(instance_info(s.slot), s.slot, across * 3u + uint(k));
        float before = nearest;
        edges_of_triangle(s, pixel, nearest);
        if (nearest < before) return true;
    }
    return false;
}

// Towards its outline a round surface turns away as a circle does: the square of the cosine between normal and view falls evenly with the
// pixels left to the outline. Two pixels tell where it is 0.
bool found_by_turning(Seen s, ivec2 pixel, vec2 towards) {
    if ((texelFetch(u_ids, pixel, 0).g & FROM_TEXTURE) != 0u) return false;   // an impostor's pixels keep no normal
    vec3 right = normalize(u_is_parallel ? u_start_from_pixel[0] : u_along_from_pixel[0]);
    vec3 up = normalize(u_is_parallel ? u_start_from_pixel[1] : u_along_from_pixel[1]);
    vec3 n = from_octahedral(texelFetch(u_normal, pixel, 0).rg);
    n = dot(n, s.normal) < 0.0 ? -n : n;
    vec2 side = vec2(dot(n, right), dot(n, up));
    if (dot(side, towards) < 0.7 * length(side) || length(side) < 0.5) return false;
    side = normalize(side);
    vec2 step = sign(side) * vec2(greaterThan(abs(side), vec2(0.38)));
    ivec2 inner = pixel - ivec2(step);
    uvec2 ids = ids_at(inner);
    if (ids.x != s.slot + 1u) return false;
    vec3 m = from_octahedral(texelFetch(u_normal, inner, 0).rg);
    float here = dot(n, normalize(s.along)), there = dot(m, normalize(ray_along(vec2(inner) + 0.5)));
    float left = here * here * dot(step, side) / max(there * there - here * here, 1e-6);
    if (left > 1.6) return false;
    vec2 middle = left * side, across = 0.7 * vec2(-side.y, side.x);
    out_line = vec4(middle - across, middle + across);
    out_depth = -s.view_depth;
    return true;
}

// Where neighbours show something else: the line midway between them and the neighbours that are of this surface.
void line_between(Seen s, ivec2 pixel) {
    ivec2 last = ivec2(2.0 * u_half_size) - 1;
    bool is_out[9];
    vec2 towards = vec2(0.0);
    for (int i = 0; i < 9; ++i) {
        is_out[i] = false;
        ivec2 step = ivec2(i % 3, i / 3) - 1, other = pixel + step;
        if (i == 4 || any(lessThan(other, ivec2(0))) || any(greaterThan(other, last))) continue;
        uvec2 ids = ids_at(other);
        if (ids == uvec2(s.slot + 1u, s.triangle)) continue;
        float view_depth = ids.x == 0u ? 0.0 : texelFetch(u_view_depth, other, 0).r;
        uvec4 info = instance_info(max(ids.x, 1u) - 1u);
        bool is_part = ids.x != 0u && info.x == s.object && has_role(info, CAP) == s.is_cap;
        bool has_gap = ids.x != 0u && is_apart(s, other, ids, view_depth);
        is_out[i] = ids.x == 0u || (has_gap ? view_depth > s.view_depth : !is_part);
        if (is_out[i]) towards += vec2(step) / length(vec2(step));
    }
    if (dot(towards, towards) < 0.25) return;
    towards = normalize(towards);
    if (walked_to_outline(s, pixel, towards) || found_by_turning(s, pixel, towards)) return;
    float inner = 0.0, outer = 1e3;
    for (int i = 0; i < 9; ++i) {
        float along = dot(vec2(i % 3 - 1, i / 3 - 1), towards);
        if (is_out[i]) outer = min(outer, along);
    }
    for (int i = 0; i < 9; ++i) {
        float along = dot(vec2(i % 3 - 1, i / 3 - 1), towards);
        if (!is_out[i] && along < outer) inner = max(inner, along);
    }
    vec2 middle = towards * 0.5 * (inner + outer), side = 0.7 * vec2(-towards.y, towards.x);
    out_line = vec4(middle - side, middle + side);
    out_depth = -s.view_depth;
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec2 ids = ids_at(pixel);
    out_line = vec4(0.0);
    out_depth = 0.0;
    if (ids.x == 0u) return;
    Seen s = seen_at(pixel, ids);
    float best = u_most_px;
    if (!s.is_cap) edges_of_triangle(s, pixel, best);   // a cap's triangles are pieces: its outline is the cut body's
    if (best > 1.0) {
        vec4 line = out_line;
        float depth = out_depth;
        out_depth = 0.0;
        line_between(s, pixel);
        if (out_depth == 0.0) { out_line = line; out_depth = depth; }
    }
}
