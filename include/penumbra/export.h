// SPDX-License-Identifier: MIT
// What a shared library of penumbra shows: everything in the namespace as these headers open it. The build
// hides all else. Of compilers, GCC and Clang know how to say that of a namespace.
#pragma once

#ifndef __GNUC__
#error "penumbra is built and used with GCC or Clang"
#endif
#define PENUMBRA_API __attribute__((visibility("default")))
