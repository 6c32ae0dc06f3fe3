// For the tests whose light_through and stays_on_surface stand before it.
//
// `through`: what a tap `step` texels from the receiver's place found, where it differs from what the place itself has, `own`. If nobody sees
// the tap on the receiver's surface, the place stands for it: the levels of the filter stay, and no rim lies along a foot or an edge.
float seen_light(Receiver r, vec2 step, float through, float own) {
    return through != own && stays_on_surface() && is_hidden(r, offset_on_plane(r, step)) ? own : through;
}
