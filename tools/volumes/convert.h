// SPDX-License-Identifier: BSD-3-Clause
// tools/volumes/convert.h - the work of weft convert: grids of a file, as a VDB or an NRRD file.
#ifndef WEFT_TOOLS_VOLUMES_CONVERT_H
#define WEFT_TOOLS_VOLUMES_CONVERT_H

#include "tools/options/options.h"

enum convert_option {
    CONVERT_OUTPUT,
    CONVERT_GRID,
    CONVERT_RAW,
    CONVERT_TYPE,
    CONVERT_BACKGROUND,
    CONVERT_PRUNE,
    CONVERT_THREADS,
    CONVERT_JSON,
    CONVERT_NO_CLOBBER,
    CONVERT_QUIET,
    CONVERT_VERBOSE,
    CONVERT_OPTION_COUNT
};

// A grid that is converted, and its open components.
struct convert_grid {
    struct weft_volume_info *info; // of the list
    weft_volume *volume[3];
    weft_volume *rest[3]; // NULL where floats hold all
};

struct convert_job {
    const char *input, *output;
    const struct option_value *option;
    struct weft_raw_layout layout;
    const struct weft_raw_layout *raw; // NULL: the file is what it is by its content
    bool whole; // what floats do not hold is written, too, or told by who writes
    struct weft_volume_list list;
    struct convert_grid *grid; // those that are chosen
    size_t grid_count;
};

// Lists the file's grids and opens those that --grid names: the first one that can be read, all
// that can, or those of a list, which is divided by commas.
enum weft_result convert_open(struct convert_job *job);
void convert_clear(struct convert_job *job);

// Opens what floats lack of a grid's values, where they lack anything.
enum weft_result convert_open_rest(const struct convert_job *job, struct convert_grid *grid);

// Writes the output. Of NRRD files there is one grid.
enum weft_result convert_write_vdb(struct convert_job *job);
enum weft_result convert_write_nrrd(struct convert_job *job);

#endif
