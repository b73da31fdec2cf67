// SPDX-License-Identifier: BSD-3-Clause
// tools/methods/engine_options.h - the options that say what filters, OpenGL or the CPU engine, as
// verbs share them, and what comes of them where they leave it open.
#ifndef WEFT_TOOLS_METHODS_ENGINE_OPTIONS_H
#define WEFT_TOOLS_METHODS_ENGINE_OPTIONS_H

#include "tools/common/json.h"
#include "tools/options/options.h"
#include "weft.h"

// A verb's own enum has these side by side, from a `first` on.
enum engine_option {
    ENGINE_ENGINE,
    ENGINE_CONTEXT,
    ENGINE_THREADS,
    ENGINE_SUMS,
    ENGINE_OPTION_COUNT
};

extern const char *const engine_choices[]; // "auto", and then as weft_engine_names

// For the verbs' tables; automatic: what auto takes; sums: the help of --sums.
#define ENGINE_OPTIONS(first, automatic, sums_help)                                                \
    [first + ENGINE_ENGINE] = {.name = "engine",                                                   \
                               0,                                                                  \
                               OPTION_CHOICE,                                                      \
                               NULL,                                                               \
                               "what filters: OpenGL, or the CPU with its vectors and all cores "  \
                               "(default auto: " automatic ")",                                    \
                               engine_choices,                                                     \
                               .group = OPTION_METHOD},                                            \
             [first + ENGINE_CONTEXT] = ENGINE_SPEC_CONTEXT,                                       \
             [first + ENGINE_THREADS] = OPTIONS_THREADS,                                           \
             [first + ENGINE_SUMS] = {.name = "sums",                                              \
                                      0,                                                           \
                                      OPTION_CHOICE,                                               \
                                      NULL,                                                        \
                                      sums_help,                                                   \
                                      weft_sums_names,                                             \
                                      .group = OPTION_METHOD}
#define ENGINE_SPEC_CONTEXT                                                                        \
    {                                                                                              \
        .name = "context", 0, OPTION_TEXT, "auto|osmesa|egl",                                      \
        "where OpenGL runs (default auto: a GPU through EGL, else OSMesa, else EGL in software)",  \
        .group = OPTION_METHOD                                                                     \
    }
#define ENGINE_SUMS_HELP "what products are added up in (default float); double: by the CPU engine"
#define ENGINE_AUTOMATIC                                                                           \
    "the faster one by what weft calibrate measured here, OpenGL without that; the CPU where no "  \
    "OpenGL is to be had"

enum { ENGINE_TEXT = 192, ENGINE_ATTRIBUTES = 3 };

// What filters, as far as it is known. It stays where it is: its context has its log.
struct engine {
    bool automatic;          // it may still become the other one
    bool preferred;          // engine_prefer has decided
    enum weft_engine engine; // what it is, or would be
    enum weft_sums sums;
    enum weft_context_kind kind;
    struct weft_cpu cpu; // resolved
    bool loaded;         // the model, or there is none
    bool calibrated;     // the model is what weft calibrate measured, or else the default one
    struct weft_cost_model model;
    // Of the context, which borrows the log: what OpenGL says, while it is made and afterwards.
    weft_context_making *making; // NULL: none was begun
    struct weft_log log;
    bool holds_errors; // in `message`, as long as the CPU may do instead
    char message[512];
};

// Fills *out. gl_option: an option that was given and that only OpenGL has, "--source"; it decides
// as --context does. NULL: none was. Returns WEFT_ERR_ARGUMENT after an error line.
enum weft_result engine_options_read(const struct option_value *first, const char *gl_option,
                                     struct engine *out);

// Loads what was measured, once; context: where OpenGL is to run, or NULL as long as there is none.
// The defaults stay where nothing was, or on another renderer or processor.
void engine_load_costs(struct engine *engine, const weft_context *context);

// Where the engine is open, what was measured decides, by the first slice that is planned.
void engine_prefer(struct engine *engine, const weft_slice_plan *plan);

// Begins to make the context of OpenGL, where it is clear that one will be needed: files are read
// meanwhile. What goes wrong with it is told when it is needed.
enum weft_result engine_begin_context(struct engine *engine);
// Gives up what was begun and is not needed. Accepts an engine of which nothing was.
void engine_abandon_context(struct engine *engine);

// Makes the context of OpenGL unless there is one; nothing for the CPU engine. Where none can be
// had and the engine is open, it becomes the CPU, which a line tells. Returns WEFT_ERR_CONTEXT and
// others of weft_context_create after an error line.
enum weft_result engine_create_context(struct engine *engine, weft_context **context);

// Engines that methods are chosen from, bits of struct weft_choose_params. On a GPU nothing is
// known of the CPU engine until weft calibrate has measured both: OpenGL goes first. context: as
// above.
unsigned engine_candidates(const struct engine *engine, const weft_context *context);
// Whether to choose again, from these: where the first ones were not all, and none was within.
bool engine_has_more_candidates(const struct engine *engine, unsigned *engines);
// What the costs are of: the renderer and the instruction set, or "defaults".
const char *engine_model_name(const struct engine *engine, char text[ENGINE_TEXT]);

// Adds what filtered to a report in JSON: engine; of the CPU instructions, threads and sums.
void engine_set_json(json_t *root, const struct engine *engine, enum weft_engine taken,
                     enum weft_sums sums);
// "OpenGL", "CPU engine, avx2, 2 threads, double sums".
const char *engine_format(const struct engine *engine, enum weft_engine taken, enum weft_sums sums,
                          char text[ENGINE_TEXT]);
// Attributes of what the CPU engine computed: engine, instructions and sums. Threads, on which no
// pixel depends, are not told. Returns how many.
size_t engine_attributes(const struct engine *engine, enum weft_sums sums,
                         struct weft_metadata out[ENGINE_ATTRIBUTES]);

#endif
