// SPDX-License-Identifier: MIT
// How far a visibility mask is from the truth, one question per file.
#pragma once

#include "host/metrics/bias_map.h"
#include "host/metrics/contact.h"
#include "host/metrics/decisions.h"
#include "host/metrics/flicker.h"
#include "host/metrics/flip.h"
#include "host/metrics/front.h"
#include "host/metrics/lag.h"
#include "host/metrics/mask_error.h"
#include "host/metrics/shaded.h"
#include "host/metrics/ssim.h"
