// SPDX-License-Identifier: BSD-3-Clause
// Meshes of files, by weft-read-mesh.
#include "tiles/mesh/mesh.h"

#include <stdlib.h>

#include "filter/check.h"

enum weft_result weft_mesh_load(const struct weft_mesh_params *params, struct weft_mesh *out)
{
    *out = (struct weft_mesh){0};
    weft_error(params->log, "meshes cannot be read yet");
    return WEFT_ERR_UNSUPPORTED;
}

void weft_mesh_clear(struct weft_mesh *mesh)
{
    if (!mesh)
        return;
    free(mesh->memory);
    *mesh = (struct weft_mesh){0};
}
