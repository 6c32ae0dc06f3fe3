// How much of each pixel lines cover: the line nearest to its centre among those that it and its neighbours keep.
uniform sampler2D u_lines;        // edge_lines.frag
uniform sampler2D u_line_depth;
uniform sampler2D u_view_depth;
uniform float u_width;            // pixels
uniform float u_slack;            // share of a depth by which a line may lie behind what hides it not
layout(location = 0) out float out_coverage;

float nearest_line = 1e3, nearest_guess = 1e3;

void look_at(ivec2 pixel, ivec2 step, float view_depth) {
    ivec2 at = pixel + step;
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, textureSize(u_lines, 0)))) return;
    float depth = texelFetch(u_line_depth, at, 0).r;
    if (depth == 0.0) return;
    if (view_depth != 0.0 && step != ivec2(0) && view_depth < abs(depth) * (1.0 - u_slack)) return;   // something stands before it
    vec4 line = texelFetch(u_lines, at, 0) + vec4(step, step);
    vec2 along = line.zw - line.xy;
    float t = clamp(-dot(line.xy, along) / max(dot(along, along), 1e-12), 0.0, 1.0);
    float d = length(line.xy + t * along);
    if (depth > 0.0) nearest_line = min(nearest_line, d);
    else nearest_guess = min(nearest_guess, d);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float view_depth = texelFetch(u_view_depth, pixel, 0).r;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) look_at(pixel, ivec2(x, y), view_depth);
    for (int i = 2; i <= RADIUS; ++i) {
        look_at(pixel, ivec2(i, 0), view_depth);
        look_at(pixel, ivec2(-i, 0), view_depth);
        look_at(pixel, ivec2(0, i), view_depth);
        look_at(pixel, ivec2(0, -i), view_depth);
        look_at(pixel, ivec2(i, i), view_depth);
        look_at(pixel, ivec2(-i, i), view_depth);
        look_at(pixel, ivec2(i, -i), view_depth);
        look_at(pixel, ivec2(-i, -i), view_depth);
    }
    float d = nearest_line <= nearest_guess + 1.0 ? nearest_line : nearest_guess;
    out_coverage = min(u_width, 1.0) * clamp(0.5 * max(u_width, 1.0) + 0.5 - d, 0.0, 1.0);
}
