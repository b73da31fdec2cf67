// SPDX-License-Identifier: BSD-3-Clause
// passes/separable_job.h - what running and verifying separable filters share (not installed).
#ifndef WEFT_PASSES_SEPARABLE_JOB_H
#define WEFT_PASSES_SEPARABLE_JOB_H

#include "filter/check.h"
#include "passes/separable.h"

// The request with its defaults filled in. Returns WEFT_ERR_ARGUMENT or WEFT_ERR_UNSUPPORTED.
enum weft_result weft_separable_check(const struct weft_separable_params *params,
                                      struct weft_separable_params *out);

static inline bool weft_separable_go_on(const struct weft_progress *progress, double fraction)
{
    return !progress || !progress->report || progress->report(progress->priv, fraction);
}

#endif
