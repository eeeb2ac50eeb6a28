// SPDX-License-Identifier: MIT
// What a shared library of penumbra shows: everything in the namespace as these headers open it. The build
// hides all else.
#pragma once

#define PENUMBRA_API __attribute__((visibility("default")))
