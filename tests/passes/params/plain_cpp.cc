// SPDX-License-Identifier: BSD-3-Clause
// weft from C++17, which has no compound literals: params are variables that init functions fill.
#include <cmath>
#include <vector>

#include "weft.h"

extern "C" int slice_in_cpp(float *pixels, int side)
{
    std::vector<float> voxels;
    for (int i = 0; i < side * side * side; i++)
        voxels.push_back(float(i % side + 10 * (i / side % side) + 100 * (i / (side * side))));
    weft_volume_params block;
    weft_volume_params_init(&block);
    if (!std::isnan(block.background)) // the edge goes on
        return __LINE__;
    block.size[0] = block.size[1] = block.size[2] = side;
    block.data = voxels.data();
    weft_volume *volume = nullptr;
    if (weft_volume_create(&block, &volume) != WEFT_OK)
        return __LINE__;

    weft_slice_params slice;
    weft_slice_params_init(&slice);
    slice.engine = WEFT_ENGINE_CPU;
    weft_slice_plan *plan = nullptr;
    weft_slice_run_params run;
    weft_slice_run_params_init(&run);
    run.pixels = pixels;
    weft_slice_compile_params where;
    weft_slice_compile_params_init(&where);
    weft_result res = weft_slice_axis_geometry(nullptr, volume, WEFT_SPACE_WORLD, 2, 3.0, side,
                                               side, &slice.geometry);
    if (res == WEFT_OK)
        res = weft_slice_plan_create(volume, &slice, &plan);
    if (res == WEFT_OK)
        res = weft_slice_run_once(plan, &where, &run, nullptr);
    weft_slice_plan_destroy(&plan);
    weft_volume_destroy(&volume);
    return res == WEFT_OK ? 0 : __LINE__;
}
