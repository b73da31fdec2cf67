// SPDX-License-Identifier: BSD-3-Clause
// tools/methods/cost_file.h - what methods cost, as `weft calibrate` measured it, in a file for
// each value of --context, so that it is known before there is a context:
// $XDG_CACHE_HOME/weft/cost-auto.txt, or below ~/.cache. The file names the renderer and the set of
// instructions that it is of.
#ifndef WEFT_TOOLS_METHODS_COST_FILE_H
#define WEFT_TOOLS_METHODS_COST_FILE_H

#include "weft.h"

// To be freed; NULL where no folder is known (or no memory left).
char *cost_file_path(enum weft_context_kind kind);

// Returns true where there is a file that can be used. weft_cost_default and false where there is
// none, which a note tells, or none of this processor and of the renderer (NULL: not known yet, of
// any), which a warning tells.
bool cost_file_load(enum weft_context_kind kind, const char *renderer, struct weft_cost_model *out);

// Makes the folders that lead to a file. Returns WEFT_ERR_WRITE after an error line.
enum weft_result cost_file_make_folders(const char *path);
// Returns WEFT_ERR_WRITE or WEFT_ERR_MEMORY after an error line.
enum weft_result cost_file_save(const struct weft_cost_model *model, const char *path);

#endif
