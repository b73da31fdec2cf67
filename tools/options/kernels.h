// SPDX-License-Identifier: BSD-3-Clause
// tools/options/kernels.h - kernels as the command's users name them: NAME[:p,q][+unit] or
// table:FILE.
#ifndef WEFT_TOOLS_OPTIONS_KERNELS_H
#define WEFT_TOOLS_OPTIONS_KERNELS_H

#include "tools/common/json.h"
#include "tools/options/options.h"

enum { KERNELS_TEXT = 4400 }; // for weft_kernel_format: a path may be in it

// weft_kernel_load, and sees to it that a kernel to be normalised can be: its weights must add up
// to something at every position.
enum weft_result kernels_load(const char *text, struct weft_kernel *out, weft_kernel_file **file);

// The same for filtering along `axes` axes at once (2 or 3): a product of derivatives, which nobody
// means, is refused.
enum weft_result kernels_load_filter(const char *text, int axes, struct weft_kernel *out,
                                     weft_kernel_file **file);

// The filter of a pixel, --kernel and --kernel-width in pixels, where they are given; otherwise
// what the pointers lead to stays. Returns WEFT_ERR_ARGUMENT after an error line, and as above.
enum weft_result kernels_read_filter(const struct option_value *filter,
                                     const struct option_value *width, struct weft_kernel *kernel,
                                     weft_kernel_file **file, double *pixels);

// `--normalise on|off`, where samples are reconstructed.
extern const char *const kernels_normalise_choices[];
#define KERNELS_NORMALISE_OPTION                                                                   \
    {                                                                                              \
        .name = "normalise", 0, OPTION_CHOICE, NULL,                                               \
        "divide the kernel's weights by their sum, so that white stays white (default: on, but "   \
        "for table:FILE, which is taken as it is; kernels whose weights add up to 1 stay as "      \
        "they are)",                                                                               \
        kernels_normalise_choices, .group = OPTION_FILTER                                          \
    }

// Does what the option says to a kernel in so many dimensions, which kernels_load_filter gave with
// `file`. Where the default cannot, as the weights add up to 0 somewhere, a warning says so.
// Returns WEFT_ERR_ARGUMENT (on, and that cannot be) after an error line.
enum weft_result kernels_normalise(const struct option_value *option, int dims,
                                   const weft_kernel_file *file, struct weft_kernel *kernel);

// The length of the name at the start of a list: up to the next semicolon where those separate,
// else to the next comma that no number follows ("cubic:0,0.5,linear" are two).
size_t kernels_list_length(const char *text, bool semicolons);

// The catalogue: a line for each with parameters, taps, orders and flags.
void kernels_print(void);
json_t *kernels_json(void);

#endif
