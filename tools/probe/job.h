// SPDX-License-Identifier: BSD-3-Clause
// tools/probe/job.h - what weft probe does, and its stages.
#ifndef WEFT_TOOLS_PROBE_JOB_H
#define WEFT_TOOLS_PROBE_JOB_H

#include "tools/common/json.h"
#include "tools/options/options.h"
#include "tools/volumes/raw.h"

enum {
    PROBE_POINTS,
    PROBE_OUTPUT,
    PROBE_QUANTITY,
    PROBE_GRID,
    PROBE_RAW,
    PROBE_KERNEL,
    PROBE_NORMALISE,
    PROBE_SPACE,
    PROBE_SUMS,
    PROBE_THREADS,
    PROBE_MEMORY,
    PROBE_EXPLAIN,
    PROBE_VERIFY,
    PROBE_JSON,
    PROBE_NO_CLOBBER,
    PROBE_QUIET,
    PROBE_VERBOSE,
    PROBE_OPTION_COUNT
};

// ---- tables -------------------------------------------------------------------------------------

// A line of a table without its end.
struct probe_line {
    const char *text;
    uint32_t size;
};

// Points as text: a line each, of fields that commas, semicolons, tabs or spaces separate. Lines
// that are empty or begin with '#' are not there.
struct probe_table {
    const char *name; // for messages
    char *text;       // owned, `size` bytes
    size_t size;
    char separator;           // ' ': any number of spaces and tabs
    struct probe_line header; // text NULL: there is none
    int column[3];            // of x, y and z, from 0
    int columns;              // of the first line
    size_t count, capacity;
    struct probe_line *line;
    double (*position)[3];
};

// Reads a file, or standard input for "-", and the positions in it, with so many threads. A first
// line that is no number names the columns: x, y and z are found by their names, in either case, or
// are the first three. Returns WEFT_ERR_OPEN, WEFT_ERR_FORMAT (with the line's number),
// WEFT_ERR_LIMIT (a line of 1 MiB) or WEFT_ERR_MEMORY after an error line.
enum weft_result probe_table_read(const char *path, int threads, struct probe_table *out);
void probe_table_clear(struct probe_table *table); // {0} is fine

// ---- the job ------------------------------------------------------------------------------------

enum { PROBE_COMPONENTS = 3 };

struct probe_job {
    const char *input;
    struct weft_raw_layout layout;
    const struct weft_raw_layout *raw; // NULL: the input is what it is by its content
    const struct option_value *option;
    struct weft_kernel kernel;
    weft_kernel_file *kernel_file;
    struct weft_quantities quantities;
    struct weft_quantity_transform transform;
    int threads;
    struct probe_table table;
    weft_volume_opening *opening;
    // Components of a grid of vectors, or 1, one after another in `channel`.
    int components;
    int channel_count; // of all components
    char channel[PROBE_COMPONENTS * WEFT_QUANTITY_CHANNELS][64];
    float *channels;                  // channel c of point i is channels[c * count + i]
    struct weft_volume_info volume;   // of the first component; metadata is not kept
    struct weft_points_info info;     // likewise
    struct weft_points_report report; // of all: counts of points of the first one
    struct weft_verify_report error[WEFT_DERIVATIVES]; // with --verify, of all components
    double bound[WEFT_DERIVATIVES];                    // of the first component
    double read_seconds, sample_seconds, write_seconds, start;
};

// The points' values. Returns what the library returns, after an error line.
enum weft_result probe_sample(struct probe_job *job);

// Writes the table with its channels. Returns WEFT_ERR_MEMORY or WEFT_ERR_WRITE.
enum weft_result probe_write(const struct probe_job *job, const char *path);

void probe_explain(const struct probe_job *job);
void probe_report(const struct probe_job *job); // --verify, and warnings
// Whether -o names a file of JSON, which is the report then.
bool probe_writes_json(const struct probe_job *job);
enum weft_result probe_print_json(const struct probe_job *job);

// Calls part(priv, i) for every i below count, from `threads` threads.
void probe_parallel(int threads, size_t count, void (*part)(void *priv, size_t i), void *priv);

#endif
