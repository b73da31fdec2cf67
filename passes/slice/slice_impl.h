// SPDX-License-Identifier: BSD-3-Clause
// passes/slice/slice_impl.h - the engines of compiled slices (not installed). Params have pixels
// and stride; reports are {0} before.
#ifndef WEFT_PASSES_SLICE_SLICE_IMPL_H
#define WEFT_PASSES_SLICE_SLICE_IMPL_H

#include "filter/statistics.h"
#include "passes/fused/plan.h"
#include "passes/slice/slice.h"

// A slice one axis after the other, by a plan that is separable.
typedef struct weft_slice_separable weft_slice_separable;
// `cpu` has its defaults filled in; on GL its threads sum voxels.
enum weft_result weft_slice_separable_compile(weft_context *context, const struct weft_cpu *cpu,
                                              const struct weft_slice_plan *plan,
                                              weft_slice_separable **out);
void weft_slice_separable_destroy(weft_slice_separable **separable); // accepts &NULL
// Adds all pixels to the statistics, or none where some were painted over.
enum weft_result weft_slice_separable_run(weft_slice_separable *separable,
                                          const struct weft_slice_run_params *params,
                                          struct weft_slice_report *report,
                                          struct weft_statistics *pixels);

// A slice by a plan of passes, whose voxels the threads of `cpu` lay out.
typedef struct weft_slice_multipass weft_slice_multipass;
enum weft_result weft_slice_multipass_compile(weft_context *context, const struct weft_cpu *cpu,
                                              const struct weft_slice_plan *plan,
                                              const struct weft_slice_passes *passes,
                                              weft_slice_multipass **out);
void weft_slice_multipass_destroy(weft_slice_multipass **multipass); // accepts &NULL
enum weft_result weft_slice_multipass_run(weft_slice_multipass *multipass,
                                          const struct weft_slice_run_params *params,
                                          struct weft_slice_report *report);

#endif
