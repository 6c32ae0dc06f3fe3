// The depth of a place so many metres behind the near plane, as maths/depth_projection.py keeps it.
// Never quite 0 or 1: what lies a little beyond the far plane is drawn all the same.
uniform vec4 u_depth_rule;
float depth_behind(float metres) {
    return clamp((u_depth_rule.x + u_depth_rule.y * metres) / (u_depth_rule.z + u_depth_rule.w * metres), 1e-30, 0.99999994);
}
