// The part of an impostor's plane under which its object can be seen. The depth is the fragment's business, so nothing is clipped by it.
uniform vec4 u_extent;              // smallest u, v, largest u, v
uniform mat4 u_clip_from_texel;     // from (u, v, |relief|, 1)
out vec2 v_uv;

void main() {
    v_uv = vec2((gl_VertexID & 1) == 0 ? u_extent.x : u_extent.z, (gl_VertexID & 2) == 0 ? u_extent.y : u_extent.w);
    vec4 clip = u_clip_from_texel * vec4(v_uv, 0.0, 1.0);
    gl_Position = vec4(clip.xy, 0.0, clip.w);
}
