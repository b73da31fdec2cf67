// SPDX-License-Identifier: BSD-3-Clause
// weft.h - reconstruction filtering of 2D textures and 3D volumes on OpenGL: every public header.
#ifndef WEFT_H
#define WEFT_H

#include "filter/analysis.h"
#include "filter/base.h"
#include "filter/error.h"
#include "filter/fixed.h"
#include "filter/kernel.h"
#include "filter/kernel_nd.h"
#include "filter/kernel_table.h"
#include "filter/prefilter.h"
#include "filter/reference.h"
#include "filter/signal.h"
#include "passes/accumulate/tree.h"
#include "passes/choose.h"
#include "passes/context.h"
#include "passes/convolve.h"
#include "passes/cost.h"
#include "passes/pass.h"
#include "passes/plan.h"
#include "passes/profile.h"
#include "passes/range.h"
#include "passes/separable.h"
#include "passes/slice.h"
#include "passes/slice_passes.h"
#include "passes/stability.h"
#include "passes/tile_error.h"
#include "passes/way.h"
#include "tiles/image.h"
#include "tiles/kernel_file.h"
#include "tiles/kernel_tiles.h"
#include "tiles/layout.h"
#include "tiles/limits.h"
#include "tiles/output.h"
#include "tiles/volume.h"

#endif
