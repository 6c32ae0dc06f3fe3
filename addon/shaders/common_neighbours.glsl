// Where the depths of a cell of an n-SM come from (SMMVP §4.5): n = 2 the largest of the 3x3, n = 3 the largest and the smallest,
// n >= 4 neighbours spread evenly round the centre (NEIGHBOURS, from pipeline/passes/nsm.py).
//
// n = 2 and 3 have a channel to spare, which says where the extremes lay: 9 * index of the largest + index of the smallest, row by row.
#if DEPTHS <= 3
ivec2 of_nine(int index) { return ivec2(index % 3 - 1, index / 3 - 1); }
ivec2 place_of(int i, vec4 cell) {
    if (i == 0) return ivec2(0);
    int code = int(cell[DEPTHS]);
    return of_nine(i == 1 ? code / 9 : code % 9);
}
#else
const ivec2 neighbours[DEPTHS - 1] = ivec2[DEPTHS - 1](NEIGHBOURS);
ivec2 place_of(int i, vec4 cell) { return i == 0 ? ivec2(0) : neighbours[i - 1]; }
#endif
