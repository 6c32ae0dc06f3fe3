// The instance table: four RGBA32F texels a slot (three rows of world_from_object, base colour), and integers beside it.
uniform samplerBuffer u_table;
uniform usamplerBuffer u_info;

vec3 placed_ws(uint slot, vec3 position_os) {
    int row = int(slot) * 4;
    vec4 p = vec4(position_os, 1.0);
    return vec3(dot(texelFetch(u_table, row), p), dot(texelFetch(u_table, row + 1), p), dot(texelFetch(u_table, row + 2), p));
}

// The same relative to `anchor`: nothing large cancels where the instance stands near it.
vec3 placed_from(uint slot, vec3 position_os, vec3 anchor) {
    int row = int(slot) * 4;
    vec4 a = texelFetch(u_table, row), b = texelFetch(u_table, row + 1), c = texelFetch(u_table, row + 2);
    return (vec3(a.w, b.w, c.w) - anchor) + vec3(dot(a.xyz, position_os), dot(b.xyz, position_os), dot(c.xyz, position_os));
}

// Direction of a normal under an affine map: the cofactor matrix, right for mirrored and unevenly scaled objects.
vec3 turned_normal_ws(uint slot, vec3 normal_os) {
    int row = int(slot) * 4;
    vec3 a = texelFetch(u_table, row).xyz, b = texelFetch(u_table, row + 1).xyz, c = texelFetch(u_table, row + 2).xyz;
    vec3 n = vec3(dot(cross(b, c), normal_os), dot(cross(c, a), normal_os), dot(cross(a, b), normal_os));
    return n * sign(dot(a, cross(b, c)));
}

vec4 base_color(uint slot) { return texelFetch(u_table, int(slot) * 4 + 3); }

uvec4 instance_info(uint slot) { return texelFetch(u_info, int(slot)); }

// Whether an instance has one of the flags of scene/looks.py.
bool has_role(uvec4 info, int flag) { return (info.w & uint(flag << 1)) != 0u; }

#ifdef ID_PER_MATERIAL
// The ID test's number of a slot's object: one per object, or one per object and material slot.
uint id_of(uvec4 info) { return ID_PER_MATERIAL != 0 ? info.z + 1u : info.x; }
#endif
