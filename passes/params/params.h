// SPDX-License-Identifier: BSD-3-Clause
// passes/params/params.h - the default values of every params struct, for programs in C++ and for
// bindings, which have no compound literals: weft_volume_params_init(&params) writes what
// weft_volume_params() is in C. Then set the members that are required, or that differ:
//
//     weft_volume_params params;             params = weft.weft_volume_params()  # ctypes.Structure
//     weft_volume_params_init(&params);      lib.weft_volume_params_init(byref(params))
//     params.size[0] = 64; ...               params.size[0] = 64; ...
//
// Each function takes a pointer to the struct that it is named after, which it overwrites whole,
// padding too. For nearly all structs that is zero; the list has all of them, so that nobody needs
// to know for which. Where zero is a value and the default is another, it is not:
//
//     weft_volume_params         background NAN (outside, the edge goes on)
//     weft_pixels_verify_params  bound_relative and bound_absolute NAN (no bound is held against)
//     weft_nrrd_save_params      type WEFT_SAMPLE_FLOAT
//     weft_division_params       keep 0.5
//     weft_camera                along -z from the origin, y up, 45 degrees, 1 to 100
//
// A struct that another one contains (weft_slice_params in weft_choose_params) has its own defaults
// there. Pure and thread-safe.
#ifndef WEFT_PASSES_PARAMS_PARAMS_H
#define WEFT_PASSES_PARAMS_PARAMS_H

#include "../../filter/analysis/error.h"
#include "../../filter/kernels/kernel_table.h"
#include "../accumulate/accumulate.h"
#include "../accumulate/buffer.h"
#include "../accumulate/tree/tree.h"
#include "../antialias/accumulative.h"
#include "../antialias/marks/marks.h"
#include "../antialias/multisample.h"
#include "../antialias/pattern/pattern.h"
#include "../antialias/supersample.h"
#include "../choose/choose.h"
#include "../choose/method.h"
#include "../distribute/division.h"
#include "../distribute/ranks.h"
#include "../distribute/schedule/schedule.h"
#include "../fused/fused.h"
#include "../fused/resident.h"
#include "../gl/context.h"
#include "../hardware/hardware.h"
#include "../jitter/camera.h"
#include "../jitter/discrepancy.h"
#include "../jitter/jitter.h"
#include "../jitter/weights.h"
#include "../lattice/lattice.h"
#include "../multipass/multipass.h"
#include "../plan/plan.h"
#include "../points/points.h"
#include "../positions/footprint.h"
#include "../resample/choose.h"
#include "../resample/resample.h"
#include "../separable/separable.h"
#include "../simple/simple.h"
#include "../slice/slab.h"
#include "../slice/slice.h"
#include "../stability/stability.h"
#include "../verify/verify.h"
#include "../warp/warp.h"
#include "../../tiles/image/image.h"
#include "../../tiles/image/sequence.h"
#include "../../tiles/kernel/kernel_tiles.h"
#include "../../tiles/mesh/mesh.h"
#include "../../tiles/volume/volume.h"
#include "../../tiles/volume/volume_nrrd.h"
#include "../../tiles/volume/volume_writer.h"

WEFT_BEGIN_DECLS

// Calls X(tag) for each struct of weft.h that has a macro of its name which fills it: all those
// whose names end in _params, and a few that are members or arguments of others.
// clang-format off
#define WEFT_PARAMS_LIST(X)                                                                        \
    X(weft_error_kernel_params) X(weft_kernel_table_params) X(weft_accumulator_params)             \
    X(weft_accum_buffer_params) X(weft_tree_params) X(weft_acaa_params) X(weft_marker_params)      \
    X(weft_msaa_params) X(weft_pattern_params) X(weft_spread_params) X(weft_supersample_params)    \
    X(weft_choose_params) X(weft_method_params) X(weft_method_run_params) X(weft_division_params)  \
    X(weft_distribute_params) X(weft_regions_params) X(weft_slice_params) X(weft_resident_params)  \
    X(weft_context_params) X(weft_hardware_params) X(weft_camera) X(weft_camera_frame)             \
    X(weft_discrepancy_params) X(weft_jitter_params) X(weft_weights_kernel_params)                 \
    X(weft_lattice_params) X(weft_lattice_run_params) X(weft_multipass_params)                     \
    X(weft_multipass_run_params) X(weft_pass_plan_params) X(weft_points_params)                    \
    X(weft_points_run_params) X(weft_footprint_params) X(weft_resample_choose_params)              \
    X(weft_resample_engine_params) X(weft_resample_params) X(weft_resample_compile_params)         \
    X(weft_resample_source_params) X(weft_resample_run_params) X(weft_resample_verify_params)      \
    X(weft_separable_params) X(weft_separable_compile_params) X(weft_separable_run_params)         \
    X(weft_slice_file_params) X(weft_sample_params) X(weft_slab_params)                            \
    X(weft_slice_compile_params) X(weft_slice_run_params) X(weft_stability_params)                 \
    X(weft_verify_params) X(weft_slice_verify_params) X(weft_multipass_verify_params)              \
    X(weft_pixels_verify_params) X(weft_warp_params) X(weft_warp_run_params)                       \
    X(weft_image_load_params) X(weft_image_save_params) X(weft_preview_params)                     \
    X(weft_colour_preview_params) X(weft_image_sequence_params) X(weft_kernel_tiles_params)        \
    X(weft_mesh_params) X(weft_raw_layout) X(weft_volume_params) X(weft_volume_bricks_params)      \
    X(weft_volume_open_params) X(weft_volume_save_params) X(weft_volume_writer_params)             \
    X(weft_nrrd_save_params)
// clang-format on

// Declares void TAG_init(struct TAG *params) for each of them.
#define WEFT_PARAMS_DECLARE(tag) void tag##_init(struct tag *params) WEFT_API;
WEFT_PARAMS_LIST(WEFT_PARAMS_DECLARE)
#undef WEFT_PARAMS_DECLARE

WEFT_END_DECLS
#endif
