// The triangle that a view ray really meets, from one nearby on the same surface. A texel of an impostor names one triangle, but what is
// seen through it may lie on that triangle's neighbours, and on its own plane it would stand in their shadow or in them.
uniform usamplerBuffer u_normals;   // of the vertices, octahedral
uniform vec2 u_section;             // view depths between which the camera shows something

vec3 corner_normal_ws(uvec4 info, uint slot, uint corner) {
    vec3 normal = unpacked_octahedral(texelFetch(u_normals, int(texelFetch(u_indices, int(corner)).r)).r);
    return info.w != 0u ? normal : normalize(turned_normal_ws(slot, normal));
}

// The shading normal where the ray of these edge functions passes through the triangle; where its corners' normals cancel: `other`.
vec3 normal_met(uvec4 info, uint slot, uint triangle, vec3 edges, vec3 other) {
    vec3 sum = (edges.y * corner_normal_ws(info, slot, triangle * 3u) + edges.z * corner_normal_ws(info, slot, triangle * 3u + 1u)
        + edges.x * corner_normal_ws(info, slot, triangle * 3u + 2u)) / max(edges.x + edges.y + edges.z, 1e-30);
    return dot(sum, sum) > 1e-6 ? normalize(sum) : other;
}

// As walk_to_ray, with the shading normal where the ray passes through; where none does, that of the place next to the ray.
bool follow_to_ray(uvec4 info, uint slot, vec3 x, vec3 along, inout uint triangle, inout vec3 normal) {
    vec3 last;
    bool is_met = walk_to_ray(info, slot, x, along, triangle, last);
    normal = normal_met(info, slot, triangle, max(last, vec3(0.0)), normal);
    return is_met;
}

const int AS_DRAWN = 0, MET = 1, NAMED = 2;

// Whether the pixel beside, at depth `there` (0: nothing), may show a surface that this pixel, at depth `here` of a smooth surface, should show:
// one that is nearer by more than the surface's slope, `beyond` being the depth on the other side.
bool stands_before(float there, float here, float beyond) {
    return there > 0.0 && here - there > 2.0 * abs(beyond - here) + 1e-4 * here;
}

float depth_of(ivec2 pixel, ivec2 last) { return texelFetch(u_view_depth, clamp(pixel, ivec2(0), last), 0).r; }

// Whether any of the four pixels round one may show what stands before it.
bool is_beside_nearer(ivec2 pixel, ivec2 last, float here) {
    vec2 across = vec2(depth_of(pixel - ivec2(1, 0), last), depth_of(pixel + ivec2(1, 0), last));
    vec2 along = vec2(depth_of(pixel - ivec2(0, 1), last), depth_of(pixel + ivec2(0, 1), last));
    return stands_before(across.x, here, across.y) || stands_before(across.y, here, across.x)
        || stands_before(along.x, here, along.y) || stands_before(along.y, here, along.x);
}

// What the view ray of a pixel meets: the surface that the pixel names, or a nearer one of those that impostors name round it, as their outlines
// are resampled. `ids` of what is met, its view depth and normal. What an impostor names and no ray meets is nothing where a pixel beside it
// shows nothing (ids 0), else it stays as it is: NAMED.
int meet_ray(ivec2 pixel, vec3 start, vec3 along, inout uvec2 ids, inout float view_depth, inout vec3 normal) {
    bool is_impostor = (ids.g & FROM_TEXTURE) != 0u, is_open = false;
    ids.g &= ~FROM_TEXTURE;
    uvec2 own = ids, tried = ids;
    float here = view_depth, nearest = is_impostor || own.r == 0u ? 1e30 : here;
    int how = is_impostor ? NAMED : AS_DRAWN;
    if (is_impostor) {
        uvec4 info = instance_info(own.r - 1u);
        vec3 x = start + along * here;
        if (follow_to_ray(info, own.r - 1u, x, along, ids.g, normal)) {
            nearest = here + depth_to_plane(info, own.r - 1u, ids.g, x, along);
            how = MET;
        }
    }
    bool is_certain = nearest < 1e30;
    ivec2 last = textureSize(u_ids, 0) - 1;
    if (is_certain && !is_beside_nearer(pixel, last, here)) {
        view_depth = nearest;
        return how;
    }
    for (int k = 0; k < 9; ++k) {
        ivec2 offset = ivec2(k % 3, k / 3) - 1;
        uvec2 other = texelFetch(u_ids, clamp(pixel + offset, ivec2(0), last), 0).rg;
        is_open = is_open || other.r == 0u;
        if ((other.g & FROM_TEXTURE) == 0u) continue;
        other.g &= ~FROM_TEXTURE;
        if (other == own || other == tried) continue;
        float there = depth_of(pixel + offset, last);
        if (is_certain && !stands_before(there, here, depth_of(pixel - offset, last))) continue;
        tried = other;
        uvec4 info = instance_info(other.r - 1u);
        vec3 x = start + along * there, turned = normal;
        if (!follow_to_ray(info, other.r - 1u, x, along, other.g, turned)) continue;
        float depth = there + depth_to_plane(info, other.r - 1u, other.g, x, along);
        if (depth >= nearest || depth < u_section.x || depth > u_section.y) continue;
        nearest = depth;
        ids = other;
        normal = turned;
        how = MET;
    }
    if (how == MET) view_depth = nearest;
    if (how == NAMED && is_open) ids = uvec2(0u);
    return how;
}
