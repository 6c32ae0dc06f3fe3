// The triangle that a view ray really meets, from one nearby on the same surface. A texel of an impostor names one triangle, but what is
// seen through it may lie on that triangle's neighbours, and on its own plane it would stand in their shadow or in them.
uniform usamplerBuffer u_normals;   // of the vertices, octahedral

// Edge functions of the ray through x along `along`, x being near: all of one sign where it passes through the triangle.
struct Facing { vec3 edges, lengths; };

Facing seen_along(uvec4 info, uint slot, uint triangle, vec3 x, vec3 along) {
    vec3 a = corner_ws(info, slot, triangle * 3u) - x;
    vec3 b = corner_ws(info, slot, triangle * 3u + 1u) - x;
    vec3 c = corner_ws(info, slot, triangle * 3u + 2u) - x;
    vec3 edges = vec3(dot(along, cross(a, b)), dot(along, cross(b, c)), dot(along, cross(c, a)));
    vec3 lengths = vec3(length(cross(along, b - a)), length(cross(along, c - b)), length(cross(along, a - c)));
    return Facing(edges.x + edges.y + edges.z < 0.0 ? -edges : edges, max(lengths, vec3(1e-30)));
}

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

// Over the edge that the ray is farthest beyond, again and again. False where the surface ends or folds back before the ray: then `triangle`
// is the last one that is seen from the ray's side, and `normal` what it was.
bool follow_to_ray(uvec4 info, uint slot, vec3 x, vec3 along, inout uint triangle, inout vec3 normal) {
    uint before = NOWHERE, at = triangle;
    for (int steps = 0; steps < MOST_FOLLOWED; ++steps) {
        Facing facing = seen_along(info, slot, at, x, along);
        if (all(greaterThanEqual(facing.edges, vec3(0.0)))) {
            triangle = at;
            normal = normal_met(info, slot, at, facing.edges, normal);
            return true;
        }
        vec3 beyond = facing.edges / facing.lengths;
        uint next = NOTHING;
        float farthest = 0.0;
        for (int k = 0; k < 3; ++k) {
            uint across = texelFetch(u_links, int(at) * 3 + k).r;
            if (across == before && facing.edges[k] < 0.0) return false;
            if (beyond[k] < farthest) {
                farthest = beyond[k];
                next = across;
            }
        }
        triangle = at;
        if (next == NOTHING || next == SEVERAL) return false;
        before = at;
        at = next;
    }
    return false;
}
