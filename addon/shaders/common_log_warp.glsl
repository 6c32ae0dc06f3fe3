// t of a logarithmic map and its inverse: mirrors LogWarp of maths/shadow/projection.py.
// warp: scale, offset, 1 if s is divided by w, 1 if logarithmic at all; bend: base, slope of the divisor, (1, 0) for a plain logarithm.
float log_divisor(vec2 bend, float w) { return max(bend.x + bend.y * w, 1e-6); }

float log_t(vec4 warp, vec2 bend, float w) { return warp.x * log2(w / log_divisor(bend, w)) + warp.y; }

float log_w(vec4 warp, vec2 bend, float t) {
    float ratio = exp2((t - warp.y) / warp.x);
    return bend.x * ratio / (1.0 - bend.y * ratio);
}

// dt / dw
float log_rate(vec4 warp, vec2 bend, float w) { return warp.x * bend.x / (0.6931471805599453 * w * log_divisor(bend, w)); }
