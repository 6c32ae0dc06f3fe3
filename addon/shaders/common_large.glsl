// Planes of triangles that are huge beside what is seen of them, made in float64 (pipeline/passes/large_receivers.py): unit normal by the
// winding, and the height of u_origin over it. Two texels a row, sorted by slot and triangle.
#if LARGE
uniform usamplerBuffer u_large;
uniform int u_large_count;

bool large_plane(uint slot, uint triangle, out vec4 plane) {
    int low = 0, high = u_large_count;   // the first row not before the key
    while (low < high) {
        int middle = (low + high) / 2;
        uvec2 key = texelFetch(u_large, 2 * middle).xy;
        if (key.x < slot || (key.x == slot && key.y < triangle)) low = middle + 1;
        else high = middle;
    }
    if (low == u_large_count || texelFetch(u_large, 2 * low).xy != uvec2(slot, triangle)) return false;
    plane = uintBitsToFloat(texelFetch(u_large, 2 * low + 1));
    return true;
}
#endif
