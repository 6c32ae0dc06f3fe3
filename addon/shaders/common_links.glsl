// Beside the indices: the triangle across the edge from corner k to k + 1, or one of these.
uniform usamplerBuffer u_links;
const uint NOTHING = 0xFFFFFFFFu, SEVERAL = 0xFFFFFFFEu, NOWHERE = 0xFFFFFFFDu;
