// SPDX-License-Identifier: MIT
// How far away the things are that a tile's shadow rays hit: per 8x4 tile the number of hits, the sum and the sum of
// squares of log2(distance in metres). Logarithms, because one fixed point then serves centimetres and kilometres, and
// their deviation is the relative spread that the reader wants. Fixed point, because integer sums are the same in every
// order. 64 steps per octave over 2^-32 .. 2^32 m: 32 squares of at most 4095 stay below 2^32.
//
// Of a light that is near it is not the distance but the way to the blocker over the way from there on to the light: what makes the
// penumbra as wide as it is, as the distance does from a sun.
//
// Includer declares: buffer uint blockers[]; who writes them has rounded.glsl.
const float BLOCKER_STEPS = 64.0;   // per octave
const float BLOCKER_OCTAVES = 32.0; // below and above 1 m

#ifdef READS_BLOCKERS
// Hits, sum and sum of squares of log2(metres), all as floats, so that tiles can be mixed.
vec3 blockers_of(uint tile) {
    const float n = float(blockers[3u * tile]);
    const float sum = float(blockers[3u * tile + 1u]) / BLOCKER_STEPS;
    const float squares = float(blockers[3u * tile + 2u]) / (BLOCKER_STEPS * BLOCKER_STEPS);
    const float shift = BLOCKER_OCTAVES;
    return vec3(n, sum - shift * n, squares - shift * (2.0 * sum - shift * n));
}
#else
struct BlockerSums {
    uint n, sum, squares;
};

float way_to_blocker(float t, float t_light) { return t / max(t_light - t, 1e-5 * t); }

void add_blocker(inout BlockerSums sums, float distance_m) {
    const float octaves = log2(clamp(distance_m, exp2(-31.0), exp2(31.0))) + BLOCKER_OCTAVES;
    const uint steps = rounded(octaves * BLOCKER_STEPS);
    ++sums.n;
    sums.sum += steps;
    sums.squares += steps * steps;
}

// Called by every invocation that is alive; three atomics per subgroup that hits something.
void store_blockers(uint tile, BlockerSums sums) {
    const uint n = subgroupAdd(sums.n), sum = subgroupAdd(sums.sum), squares = subgroupAdd(sums.squares);
    if (subgroupElect() && n != 0u) {
        atomicAdd(blockers[3u * tile], n);
        atomicAdd(blockers[3u * tile + 1u], sum);
        atomicAdd(blockers[3u * tile + 2u], squares);
    }
}
#endif
