// The picture that the sums of common_sums.glsl stand for.
uniform sampler2D u_sampled, u_shares;
uniform float u_share;   // of one picture among those added up
uniform vec4 u_background;
layout(location = 0) out vec4 out_color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 sum = texelFetch(u_sampled, pixel, 0) * u_share, shares = texelFetch(u_shares, pixel, 0);
    out_color = u_background;
    if (sum.a < 0.5) return;
    if (shares.w > 0.0) {
        float taken = clamp(shares.z / shares.w, 0.0, 1.0);
        out_color = vec4(u_background.rgb * (1.0 - taken), mix(u_background.a, 1.0, taken));
        return;
    }
    float alpha = clamp(round((sum.a - 1.0) * 65536.0) / 65536.0, 0.0, 1.0);   // 1 exactly, whatever the parts add up to
    out_color = DISPLAY == 1 ? vec4(vec3(shares.y > 0.0 ? shares.x / shares.y : 0.0), 1.0) : vec4(sum.rgb, alpha);
}
