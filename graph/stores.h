// SPDX-License-Identifier: MIT
// How a shader stores texels of an image that it puts out: into the image, or as words of its memory
// (PlanResource::row_bytes).
#pragma once

#include <string>

#include "penumbra/node_type.h"

namespace penumbra {

// A name as constants and macros have it, and what images and vectors of a format begin with.
std::string upper(std::string text);
const char* glsl_prefix(Format format);

// What the functions of declare_stores() call.
extern const char* const rounding_glsl;

// store_NAME() stores a texel, store4_NAME() of one narrow channel four in a row, from a multiple of four on:
// into the image at `binding` or, `in_rows`, to the same bits as words of the buffer behind that, whose rows
// are as long as the constant says. What lies outside is not stored.
std::string declare_stores(const Port& port, Format format, bool in_rows, uint32_t row_constant,
                           uint32_t binding);

}  // namespace penumbra
