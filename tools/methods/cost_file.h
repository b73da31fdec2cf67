// SPDX-License-Identifier: BSD-3-Clause
// tools/methods/cost_file.h - what methods cost, as `weft calibrate` measured it, in a file for
// each renderer: $XDG_CACHE_HOME/weft/cost-RENDERER.txt, or below ~/.cache.
#ifndef WEFT_TOOLS_METHODS_COST_FILE_H
#define WEFT_TOOLS_METHODS_COST_FILE_H

#include "weft.h"

// To be freed; NULL where no folder is known (or no memory left).
char *cost_file_path(const char *renderer);

// weft_cost_default where there is no file, which a note tells, or none that can be used, which a
// warning tells. *path (may be NULL) is the file that was used, to be freed, or NULL.
void cost_file_load(const char *renderer, struct weft_cost_model *out, char **path);

// Makes the folders that lead to a file. Returns WEFT_ERR_WRITE after an error line.
enum weft_result cost_file_make_folders(const char *path);
// Returns WEFT_ERR_WRITE or WEFT_ERR_MEMORY after an error line.
enum weft_result cost_file_save(const struct weft_cost_model *model, const char *path);

#endif
