// SPDX-License-Identifier: MIT
// How invocations share out an image: every kernel of one pixel defines for_pixel() and calls for_each_pixel().
// An invocation owns PER_THREAD_X x PER_THREAD_Y neighbouring pixels, so that a software device can run long thin
// footprints (64x1 lanes, several rows each) and a GPU 8x8 lanes with one pixel, from the same file.

bool inside_frame(ivec2 p) {
    return all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, ivec2(frame.size)));
}

void for_pixel(ivec2 p);

void for_each_pixel() {
    const ivec2 first = ivec2(gl_GlobalInvocationID.xy * uvec2(PER_THREAD_X, PER_THREAD_Y));
    for (int y = 0; y < int(PER_THREAD_Y); ++y)
        for (int x = 0; x < int(PER_THREAD_X); ++x) {
            const ivec2 p = first + ivec2(x, y);
            if (inside_frame(p)) for_pixel(p);
        }
}
