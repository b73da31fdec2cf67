// SPDX-License-Identifier: BSD-3-Clause
// tools/chart/chart.h - one `weft chart`: speed charted against accuracy.
// A chart is a list of points, each a method of computing one slice, measured. The first chart has
// the error that a method makes of its kernel; the second one the error that method, kernel and
// sampling make of a signal that is known. The chart of --accumulate has methods of averaging
// frames instead, over the number of frames; that of --antialias ways of anti-aliasing a scene.
#ifndef WEFT_TOOLS_CHART_CHART_H
#define WEFT_TOOLS_CHART_CHART_H

#include <stdio.h>

#include "tools/antialias/drawer.h"
#include "tools/common/cells.h"
#include "tools/common/run_report.h"
#include "tools/options/options.h"
#include "tools/common/report.h"
#include "tools/methods/engine_options.h"
#include "tools/volumes/raw.h"

enum chart_option {
    CHART_OUTPUT,
    CHART_PNG,
    CHART_CSV,
    CHART_JSON,
    CHART_SCRIPT,
    CHART_TRUTH,
    CHART_ACCUMULATE,
    CHART_FRAMES,
    CHART_ANTIALIAS,
    CHART_SCENE,
    CHART_GRID,
    CHART_RAW,
    CHART_PLANE,
    CHART_KERNEL,
    CHART_SIZE,
    CHART_POINTS,
    CHART_QUICK,
    CHART_ENGINE, // the first of enum engine_option
    CHART_QUIET = CHART_ENGINE + ENGINE_OPTION_COUNT,
    CHART_VERBOSE,
    CHART_OPTION_COUNT
};

// What has a colour of its own.
enum chart_family {
    CHART_FUSED, // by source format
    CHART_SEPARABLE = CHART_FUSED + WEFT_SOURCE_FORMATS,
    CHART_HARDWARE,
    CHART_CPU, // by sums: fused and separable on the CPU engine
    CHART_PASSES = CHART_CPU + WEFT_SUMS_DOUBLE + 1, // by technique
    CHART_PEER = CHART_PASSES + WEFT_TECHNIQUE_LOG + 1,
    CHART_FAMILIES
};

enum { CHART_MAX_KERNELS = 16, CHART_TEXT = 128, CHART_REASON = 256, CHART_RUNS = 50 };

struct chart_kernel {
    char *text; // as given
    struct weft_kernel kernel;
    weft_kernel_file *file;
};

struct chart_point {
    enum chart_family family;
    char technique[CHART_TEXT]; // "fused 32f", "passes dot4"; of a peer as its file says
    char label[CHART_TEXT];     // weft_method_format; of a peer as its file says
    int kernel;                 // of the chart's; -1: a peer, taken to have the first one
    int voxels;                 // along each axis of a sampled signal; 0: a volume's
    struct weft_method method;  // not of a peer
    double seconds;             // median, from voxels in memory to pixels in memory
    double read_seconds;        // median, of reading the voxels, which is not in `seconds`
    double pass_seconds;        // median, of the rendering passes, which is
    int runs;                   // that the medians are of
    struct chart_run {
        double seconds, read_seconds, pass_seconds;
    } run[CHART_RUNS];
    uint64_t bytes; // peak of voxels, layouts, tiles and GL
    double max_error, rms_error;
    double bound;                   // of max_error where that is against the kernel; NAN: none
    uint64_t pixels_checked;        // 0: unknown
    uint64_t not_finite_mismatches; // pixels that are finite on one side only
    bool front;                     // no other point is both as fast and as accurate
    char reason[CHART_REASON];      // why it was not measured; empty: it was
};

struct chart {
    struct chart_kernel kernel[CHART_MAX_KERNELS];
    int kernel_count;
    struct chart_point *point; // measured ones
    size_t count;
    struct chart_point *skipped;
    size_t skipped_count;
};

// ---- averages of frames -------------------------------------------------------------------------

// What has a colour of its own.
enum chart_frames_family {
    CHART_EXACT,
    CHART_FLOAT,
    CHART_BUFFER,
    CHART_BLEND,
    CHART_TREE_8, // trees by their bits
    CHART_TREE_16,
    CHART_TREE_32,
    CHART_FRAMES_FAMILIES
};

// One method of averaging so many frames, measured.
struct chart_frames_point {
    enum chart_frames_family family;
    struct weft_accumulator_params method; // as far as it is the method's
    int64_t frames;
    char label[CHART_TEXT]; // "tree 4, 8 bits, unbiased"
    double seconds;         // median of an average, from frames in memory to floats in memory
    int runs;               // that the median is of
    double run[CHART_RUNS]; // seconds
    uint64_t bytes, passes; // of textures and memory; drawn
    double max_error, rms_error, mean_error; // of values from 0 to 1; the mean has a sign
    double bound, bias;                      // of max_error; of mean_error, as trees expect it
    bool front;                // with as many frames nothing is both as fast and as accurate
    char reason[CHART_REASON]; // why it was not measured; empty: it was
};

enum { CHART_MAX_COUNTS = 12 };

struct chart_frames {
    int width, height;
    int64_t count[CHART_MAX_COUNTS]; // of frames, ascending
    int counts;
    struct chart_frames_point *point;
    size_t points, measured; // with those that were skipped; without
};

// ---- anti-aliasing ------------------------------------------------------------------------------

// One way of drawing a picture with smooth edges, measured against the scene's exact coverage by
// the same filter of a pixel.
struct chart_edges_point {
    struct antialias_params way; // as far as it is the way's
    int filter;                  // of chart_edges_filters; 0: a box
    char label[CHART_TEXT];      // "ACAA 16, mitchell"
    double seconds;         // median of a picture, from triangles on OpenGL to floats in memory
    int runs;               // that the median is of
    double run[CHART_RUNS]; // seconds
    uint64_t bytes, formula_bytes; // of all that is held for it; by the way's formula
    double marked;                 // share of pixels with edges, of adaptive; else NAN
    double max_error, rms_error;   // of R, G and B
    bool front;                    // by this filter nothing is both as fast and as accurate (RMS)
    char reason[CHART_REASON];     // why it was not measured; empty: it was
};

enum { CHART_EDGES_FILTERS = 4, CHART_EDGES_POINTS = 40 };
extern const char *const chart_edges_filters[CHART_EDGES_FILTERS]; // the first is the box

struct chart_edges {
    char scene[CHART_TEXT]; // as it was asked for
    int width, height;
    double exact_error; // of the exact pictures, estimated: the largest of them
    struct chart_edges_point point[CHART_EDGES_POINTS];
    size_t points, measured; // with those that were skipped; without
};

struct chart_job {
    const struct option_value *option;     // [CHART_OPTION_COUNT]
    const struct weft_signal_info *signal; // NULL: a volume
    const char *path;                      // of the volume
    struct weft_raw_layout layout;
    const struct weft_raw_layout *raw; // of the volume; NULL: it is what it is by its content
    bool has_methods, has_truth, has_frames, has_edges; // which charts are made
    struct chart methods, truth;
    struct chart_frames frames;
    struct chart_edges edges;
    struct weft_slice_geometry geometry;     // of the first chart, in index space
    char plane[32];                          // "oblique slice", "slice across z"
    struct weft_slice_statistics statistics; // of the voxels in reach of the first chart's slice
    struct engine engine;
    weft_context *context;    // NULL: methods on the CPU engine alone
    bool has_cpu;             // methods on the CPU engine too
    char machine[CHART_TEXT]; // processor and cores
    bool interrupted;
};

// ---- chart_scene.c: what is sliced --------------------------------------------------------------

struct chart_scene {
    weft_volume *volume;
    struct weft_slice_geometry geometry; // in index space
    int voxels;                          // of a sampled signal along each axis, else 0
    const struct weft_signal_info *signal;
};

// Samples the signal at n^3 voxels.
enum weft_result chart_sample(const struct weft_signal_info *signal, int voxels, weft_volume **out);

// The scene of the first chart, with the plane that was asked for.
enum weft_result chart_scene_create(struct chart_job *job, struct chart_scene *out);

// The scene of the second chart: one plane of the signal, whatever the number of voxels, that lies
// `margin` or more of the cube's half away from its faces.
enum weft_result chart_truth_scene_create(const struct chart_job *job, int voxels, double margin,
                                          struct chart_scene *out);

void chart_scene_destroy(struct chart_scene *scene);

// The signal's value at pixel (x, y).
double chart_scene_truth(const struct chart_scene *scene, int x, int y);

// Checks --plane. Returns WEFT_ERR_ARGUMENT after an error line.
enum weft_result chart_plane_check(const struct option_value *plane);

// ---- chart_measure.c ----------------------------------------------------------------------------

// Both fill in points and what was skipped; what there is stays on failure and interruption.
enum weft_result chart_measure_methods(struct chart_job *job);
enum weft_result chart_measure_truth(struct chart_job *job);

// Sets `front` of all points by seconds and error: the largest where `by_max`, else the RMS, where
// less than a thousandth makes no difference. Points
// of kernels but the first are left out where `first_only`.
void chart_find_front(struct chart *chart, bool by_max, bool first_only);

// ---- chart_points.c -----------------------------------------------------------------------------

// Appends the points of a file: technique,label,seconds,bytes,max_error,rms_error. Returns
// WEFT_ERR_OPEN or WEFT_ERR_FORMAT after an error line that names the line.
enum weft_result chart_points_load(const char *path, struct chart *chart);

enum weft_result chart_append(struct chart_point **list, size_t *count,
                              const struct chart_point *point);

// ---- frames_measure.c, frames_report.c, frames_plot.c -------------------------------------------

// Reads --frames and --size. Returns WEFT_ERR_ARGUMENT after an error line.
enum weft_result chart_frames_read(struct chart_job *job);
// As chart_measure_methods.
enum weft_result chart_frames_measure(struct chart_job *job);
bool chart_frames_fill_csv(const struct chart_job *job, struct cells *cells);
json_t *chart_frames_json(const struct chart_job *job);
enum weft_result chart_frames_print(const struct chart_job *job);
enum exit_code chart_frames_draw(const struct chart_job *job, const char *path, bool keep_script);

// ---- edges_measure.c, edges_report.c, edges_plot.c ----------------------------------------------

// Reads --scene and --size.
void chart_edges_read(struct chart_job *job);
// As chart_measure_methods. Returns WEFT_ERR_CONTEXT without OpenGL, WEFT_ERR_UNSUPPORTED of scenes
// whose triangles are not of one colour each, scene_make's and GL's errors, after an error line.
enum weft_result chart_edges_measure(struct chart_job *job);
bool chart_edges_fill_csv(const struct chart_job *job, struct cells *cells);
json_t *chart_edges_json(const struct chart_job *job);
enum weft_result chart_edges_print(const struct chart_job *job);
enum exit_code chart_edges_draw(const struct chart_job *job, const char *path, bool keep_script);

// ---- chart_drawing.c: what charts are drawn with ------------------------------------------------

// Pixels. Two panels stand side by side, with the key on their right.
enum {
    CHART_HEIGHT = 840,
    CHART_LEFT = 95,
    CHART_BOTTOM = 135,
    CHART_TOP = 765,
    CHART_PANELS_WIDTH = 1500,
    CHART_PANEL = 480,
    CHART_PANEL_GAP = 85
};

// An axis' values, > 0. {DBL_MAX, DBL_MIN} has none yet; what is not finite is left out.
struct chart_range {
    double low, high;
};
void chart_extend_range(struct chart_range *range, double value);
// Axes have 1, 2 and 5 of each decade named where they have up to three.
void chart_set_axis(FILE *script, const char *axis, struct chart_range range);
void chart_set_panel(FILE *script, int number);
// At a place in the image, from 0 to 1.
void chart_put_label(FILE *script, double x, double y, const char *style, const char *text);
// `first` and the machine, below the plots of an image of that size.
void chart_put_caption(FILE *script, const struct chart_job *job, int width, int height,
                       const char *first);

// Draws what `write` writes to an .svg or .png; keep_script: keeps gnuplot's script beside it
// (otherwise only where gnuplot does not run).
enum exit_code
chart_draw_script(const struct chart_job *job, const char *path, int width, int height,
                  enum weft_result (*write)(FILE *script, const struct chart_job *job),
                  bool keep_script);

// ---- chart_plot.c -------------------------------------------------------------------------------

enum exit_code chart_draw(const struct chart_job *job, const struct chart *chart, const char *path,
                          bool keep_script);

// ---- chart_labels.c: texts that do not overlap --------------------------------------------------

struct chart_label {
    double x, y; // what it belongs to, pixels from the plot's lower left
    char text[CHART_TEXT];
    double at_x, at_y; // out: the text's middle at its near end
    int side;          // out: 1: the text starts there, -1: it ends there, 0: it is centred there
};

// Places labels beside their points, clear of each other and, as far as that goes, of the points.
void chart_labels_place(struct chart_label *label, int count, const double (*points)[2],
                        size_t point_count, double width, double height);

// ---- chart_report.c -----------------------------------------------------------------------------

enum weft_result chart_save_csv(const struct chart_job *job, const char *path);
enum weft_result chart_print_json(const struct chart_job *job);
// The points on the front, on stdout.
enum weft_result chart_print(const struct chart_job *job);

const char *chart_name(const struct chart_job *job,
                       const struct chart *chart); // "methods", "truth"
const char *chart_kernel_text(const struct chart *chart, const struct chart_point *point);
const char *chart_source_name(const struct chart_job *job); // of the volume or signal

#endif
