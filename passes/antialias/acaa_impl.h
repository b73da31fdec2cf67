// SPDX-License-Identifier: BSD-3-Clause
// passes/antialias/acaa_impl.h - the parts of accumulative anti-aliasing (not installed).
#ifndef WEFT_PASSES_ANTIALIAS_ACAA_IMPL_H
#define WEFT_PASSES_ANTIALIAS_ACAA_IMPL_H

#include "passes/antialias/accumulative.h"
#include "passes/antialias/drawing/run.h"
#include "passes/antialias/supersample.h"

// ---- the plan: which form, samples, weights and layers of sums ----------------------------------

enum { WEFT_ACAA_MAX_LAYERS = 9 };

// Where a pixel's sums are: layers of an array of one word each.
struct weft_acaa_layers {
    int sum_words, weight_words; // of each of the three sums, from layer 0 on; of weights
    int weight, background;      // layers of the weights of surfaces, and of samples without any
    // Where both are the same layer, surfaces count above so many bits: no pixel has more samples
    // without a surface than samples.
    int weight_shift;
    int count;
};

struct weft_acaa_plan {
    enum weft_acaa_form form; // never auto
    const char *why;
    struct weft_pattern pattern;
    // Samples reach the pixels from -radius to radius + wrap of the target's own; the target has a
    // rim as wide.
    int radius, wrap, rim, side;
    bool box; // weights are 0 and 1
    int64_t total;
    double magnitude; // sum of |weights| / total
    double error;     // of the weights' rounding
    int entries;      // weights that are not 0
    struct weft_acaa_layers layers;
    // Rows by pass, y upwards and x: a mask of the device's samples that count there, and their
    // weights.
    int32_t *table; // owned; NULL for form jitter
    size_t table_size;
};

// Writes out->form and its reason; the rest of *out where `form` is not jitter. The context is not
// current. Errors as of weft_acaa_create; weft_acaa_plan_clear frees what is there in any case.
enum weft_result weft_acaa_plan_make(const struct weft_acaa_params *params,
                                     struct weft_acaa_plan *out);
void weft_acaa_plan_clear(struct weft_acaa_plan *plan);
// Ints from the beginning of a pass's rows to those of the next one.
size_t weft_acaa_pass_rows(const struct weft_acaa_plan *plan);

// ---- what GL holds ------------------------------------------------------------------------------

// Units and the binding that callbacks leave alone (drawing.h).
enum {
    WEFT_ACAA_CLAIMS_UNIT = 5,
    WEFT_ACAA_SUMS_UNIT = 6,
    WEFT_ACAA_TABLE_UNIT = 7,
    WEFT_ACAA_PASS_BINDING = 35,
};

struct weft_acaa_target {
    int32_t width, height; // with the rim
    struct weft_depth_buffer depth;
    GLuint framebuffer;
    GLuint sums, sums_framebuffer, layer_framebuffer; // of all layers; of one, to be read
    GLuint claims, claims_framebuffer;                // 0: surfaces do not claim samples
    struct weft_gl_buffer table;
    GLuint pass; // uniform buffer
    GLuint background;
    uint64_t bytes;
};

struct weft_acaa {
    struct weft_acaa_params params;
    struct weft_acaa_plan plan;
    struct weft_acaa_target target;
    weft_supersample *jitter; // form jitter: nothing else is there
    char *head;
    struct weft_rectangle part; // of the picture, that was drawn last
    uint32_t *words;            // of it: layer after layer
    double range;               // of a component
    double weight;              // as a share of the total, that sums have room for
    int scale_log2;             // integers for each unit of colour: 2^scale_log2
    double largest;             // component, of those beyond the range
    double reported;            // progress of this picture
    bool has_picture;
    struct weft_acaa_report report;
};

// These take a context that is current.
enum weft_result weft_acaa_target_create(struct weft_acaa *acaa);
void weft_acaa_target_destroy(struct weft_acaa *acaa);
// What of the target counts for the part.
struct weft_rectangle weft_acaa_target_part(const struct weft_acaa *acaa);
// Sums 0, nothing noted.
enum weft_result weft_acaa_target_clear(struct weft_acaa *acaa);
// Binds what the head reads, for a pass.
void weft_acaa_target_begin(struct weft_acaa *acaa, int pass);
void weft_acaa_target_end(struct weft_acaa *acaa);
// Reads the sums into acaa->words, and acaa->largest.
enum weft_result weft_acaa_target_read(struct weft_acaa *acaa);

// The fragment shaders' head; NULL: no memory.
char *weft_acaa_head_make(const struct weft_acaa_params *params, const struct weft_acaa_plan *plan);

// Draws a picture with the range and scale that are set. The context is current.
enum weft_result weft_acaa_draw(struct weft_acaa *acaa,
                                const struct weft_antialias_drawing *drawing,
                                const struct weft_progress *progress);

// ---- form jitter --------------------------------------------------------------------------------

// These take a context that is not current.
enum weft_result weft_acaa_jitter_create(struct weft_acaa *acaa);
enum weft_result weft_acaa_jitter_run(struct weft_acaa *acaa,
                                      const struct weft_antialias_drawing *drawing,
                                      const struct weft_progress *progress);
// Writes what it has; samples, form and callbacks stay as they are.
void weft_acaa_jitter_report(const struct weft_acaa *acaa, struct weft_acaa_report *out);

// ---- what was added up --------------------------------------------------------------------------

// Chooses range and scale: of the largest component and weight (as a share of the total, 1 or
// more) that sums have to hold. false: they cannot.
bool weft_acaa_set_range(struct weft_acaa *acaa, double range, double weight);
// Looks at all weights, for the report. Returns the largest, as a share of the total, that colours
// were counted with.
double weft_acaa_check(struct weft_acaa *acaa);
void weft_acaa_read_row(const struct weft_acaa *acaa, int channel, int32_t y, float *out);
float weft_acaa_weight(const struct weft_acaa *acaa, size_t pixel);

#endif
