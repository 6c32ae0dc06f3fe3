// Triangles as they were drawn, read from the pools through buffer textures, in the world relative to u_origin.
uniform vec3 u_origin;
uniform samplerBuffer u_positions;
uniform usamplerBuffer u_indices;

vec3 corner_ws(uvec4 info, uint slot, uint corner) {
    int v = int(texelFetch(u_indices, int(corner)).r) * 3;
    vec3 p = vec3(texelFetch(u_positions, v).r, texelFetch(u_positions, v + 1).r, texelFetch(u_positions, v + 2).r);
    return ((info.w & 1u) != 0u ? p : placed_ws(slot, p)) - u_origin;
}
