// A share of the mean colour of the SIDE x SIDE samples of every pixel; shares are added up.
uniform sampler2D u_sampled;
uniform float u_share;   // of one sample
layout(location = 0) out vec4 out_color;

void main() {
    ivec2 corner = ivec2(gl_FragCoord.xy) * SIDE;
    vec4 sum = vec4(0.0);
    for (int y = 0; y < SIDE; ++y)
        for (int x = 0; x < SIDE; ++x) sum += texelFetch(u_sampled, corner + ivec2(x, y), 0);
    out_color = sum * u_share;
}
