// SPDX-License-Identifier: MIT
// What a texel of the history knows besides its colour, in its alpha: for how many frames the colour stands, less some 32nds
// of a frame, which say the rest. All in units of MAX_FRAMES, where a half holds it exactly.

const float THIN_LONGEST = 7.0;  // pairs of frames: nearly the 16 of the jitter, after which it has looked everywhere

struct Memory {
    float frames;
    float thin;         // pairs of frames for which the texel goes on showing what is thinner than a pixel though nobody sees it
    bool moves_itself;  // what is in front there, not by the cameras alone
};

Memory memory_of(float alpha) {
    const float n = alpha * float(MAX_FRAMES), frames = floor(n + 0.5), rest = floor(32.0 * (frames - n) + 0.5);
    const float thin = floor(0.5 * rest);
    return Memory(frames, thin, rest > 2.0 * thin);
}

float alpha_of(Memory m) { return (m.frames - (2.0 * m.thin + float(m.moves_itself)) / 32.0) / float(MAX_FRAMES); }

float a_frame_later(float thin) { return max(thin - float(frame.frame_index & 1u), 0.0); }
