// SPDX-License-Identifier: BSD-3-Clause
// Meshes of files, by weft-read-mesh. What it hands over is checked again here: a damaged file may
// have taken it over.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "filter/check.h"
#include "tiles/mesh/mesh_wire.h"
#include "tiles/process/client.h"

static const char program[] = "weft-read-mesh";

// ---- what the reader gave -----------------------------------------------------------------------

static bool take_text(char *text, size_t size)
{
    if (!memchr(text, '\0', size))
        return false;
    weft_text_clean(text, false);
    return true;
}

static bool within(const float *values, int count, float low, float high)
{
    for (int i = 0; i < count; i++)
        if (!(values[i] >= low && values[i] <= high))
            return false;
    return true;
}

static bool vertex_valid(const struct weft_mesh_vertex *v)
{
    const float *n = v->normal;
    const double length = sqrt((double)n[0] * n[0] + (double)n[1] * n[1] + (double)n[2] * n[2]);
    return within(v->position, 3, -WEFT_MESH_LARGEST, WEFT_MESH_LARGEST) &&
           within(v->uv, 2, -WEFT_MESH_LARGEST, WEFT_MESH_LARGEST) &&
           within(v->colour, 3, 0.0f, 1.0f) && within(n, 3, -2.0f, 2.0f) &&
           fabs(length - 1.0) < 1e-5;
}

// Parts follow each other, and are all there is.
static bool parts_valid(struct weft_mesh *mesh)
{
    uint64_t next = 0;
    for (size_t i = 0; i < mesh->part_count; i++) {
        struct weft_mesh_part *part = &mesh->parts[i];
        if (part->first_index != next || !part->index_count || part->index_count % 3 ||
            part->material >= mesh->material_count || !take_text(part->name, sizeof part->name) ||
            !*part->name)
            return false;
        next += part->index_count;
    }
    return next == mesh->index_count;
}

static bool materials_valid(struct weft_mesh *mesh)
{
    for (size_t i = 0; i < mesh->material_count; i++) {
        struct weft_mesh_material *m = &mesh->materials[i];
        if (!take_text(m->name, sizeof m->name) || !within(m->reflectance, 3, 0.0f, 1.0f) ||
            !within(m->emission, 3, 0.0f, WEFT_MESH_LARGEST))
            return false;
    }
    return true;
}

static bool mesh_valid(struct weft_mesh *mesh)
{
    for (size_t i = 0; i < mesh->vertex_count; i++)
        if (!vertex_valid(&mesh->vertices[i]))
            return false;
    for (size_t i = 0; i < mesh->index_count; i++)
        if (mesh->indices[i] >= mesh->vertex_count)
            return false;
    return parts_valid(mesh) && materials_valid(mesh) &&
           take_text(mesh->dropped, sizeof mesh->dropped);
}

static bool counts_valid(const struct weft_wire_mesh *wire)
{
    return wire->index_count > 0 && wire->index_count % 3 == 0 &&
           wire->index_count / 3 <= WEFT_MESH_MAX_TRIANGLES && wire->vertex_count > 0 &&
           wire->vertex_count <= wire->index_count && wire->part_count > 0 &&
           wire->part_count <= WEFT_MESH_MAX_PARTS && wire->material_count > 0 &&
           wire->material_count <= wire->part_count;
}

static void measure(struct weft_mesh *mesh)
{
    memcpy(mesh->low, mesh->vertices[mesh->indices[0]].position, sizeof mesh->low);
    memcpy(mesh->high, mesh->low, sizeof mesh->high);
    for (size_t i = 0; i < mesh->index_count; i++) {
        const float *p = mesh->vertices[mesh->indices[i]].position;
        for (int c = 0; c < 3; c++) {
            mesh->low[c] = p[c] < mesh->low[c] ? p[c] : mesh->low[c];
            mesh->high[c] = p[c] > mesh->high[c] ? p[c] : mesh->high[c];
        }
    }
}

static enum weft_result contradiction(const struct weft_mesh_params *params, const char *what)
{
    weft_error(params->log, "%s: %s contradicts itself: %s", params->path, program, what);
    return WEFT_ERR_READER;
}

// One block holds all arrays; the reader's memory, which another process can no longer change, goes
// back.
static enum weft_result take_answer(const struct weft_mesh_params *params,
                                    const struct weft_payload *payload, struct weft_mesh *out)
{
    struct weft_wire_mesh wire;
    if (payload->size < sizeof wire)
        return contradiction(params, "the answer is too short");
    memcpy(&wire, payload->data, sizeof wire);
    if (!counts_valid(&wire))
        return contradiction(params, "the counts");
    const size_t vertices = wire.vertex_count * sizeof *out->vertices,
                 indices = wire.index_count * sizeof *out->indices,
                 parts = wire.part_count * sizeof *out->parts,
                 materials = wire.material_count * sizeof *out->materials,
                 bytes = vertices + indices + parts + materials;
    if (payload->size - sizeof wire != bytes)
        return contradiction(params, "the size of the answer");
    char *at = out->memory = malloc(bytes);
    if (!at) {
        weft_error(params->log, "%s: out of memory for %zu bytes", params->path, bytes);
        return WEFT_ERR_MEMORY;
    }
    memcpy(at, (const char *)payload->data + sizeof wire, bytes);
    out->vertices = (struct weft_mesh_vertex *)(void *)at;
    out->indices = (uint32_t *)(void *)(at + vertices);
    out->parts = (struct weft_mesh_part *)(void *)(at + vertices + indices);
    out->materials = (struct weft_mesh_material *)(void *)(at + vertices + indices + parts);
    out->vertex_count = wire.vertex_count;
    out->index_count = wire.index_count;
    out->part_count = wire.part_count;
    out->material_count = wire.material_count;
    memcpy(out->dropped, wire.dropped, sizeof out->dropped);
    if (!mesh_valid(out) || !memchr(wire.warning, '\0', sizeof wire.warning))
        return contradiction(params, "the triangles");
    measure(out);
    if (*wire.warning)
        weft_warn(params->log, "%s: %s", params->path, wire.warning);
    return WEFT_OK;
}

// ---- loading ------------------------------------------------------------------------------------

static bool kind_of(const char *path, uint32_t *out)
{
    const char *dot = strrchr(path, '.');
    for (uint32_t kind = 0; dot && weft_mesh_endings[kind]; kind++)
        if (!strcasecmp(dot, weft_mesh_endings[kind])) {
            *out = kind;
            return true;
        }
    return false;
}

enum weft_result weft_mesh_load(const struct weft_mesh_params *params, struct weft_mesh *out)
{
    *out = (struct weft_mesh){0};
    weft_reader *reader = NULL;
    struct weft_wire_request request = {.op = WEFT_WIRE_MESH};
    struct weft_wire_answer answer;
    struct weft_payload payload = {0};
    struct weft_limits limits;
    struct stat st;
    int fd = -1;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(params->log, params->path != NULL);
    if (!kind_of(params->path, &request.part)) {
        weft_error(params->log, "%s: a mesh ends in .obj, .ply, .gltf or .glb", params->path);
        goto fail;
    }
    res = weft_reader_open(params->log, params->path, &fd);
    if (res == WEFT_OK) {
        // What a glTF file says lies in other files, of any size.
        limits = request.part == WEFT_MESH_GLTF || fstat(fd, &st)
                     ? params->limits
                     : weft_reader_limits(&params->limits, (uint64_t)st.st_size);
        res = weft_reader_start(params->log, program, params->path, fd, &limits, &reader);
    }
    if (res == WEFT_OK)
        res = weft_reader_call(reader, &request, NULL, &answer, &payload);
    if (res == WEFT_OK)
        res = take_answer(params, &payload, out);
fail:
    weft_payload_release(&payload);
    weft_reader_stop(&reader);
    if (fd >= 0)
        close(fd);
    if (res != WEFT_OK)
        weft_mesh_clear(out);
    return res;
}

void weft_mesh_clear(struct weft_mesh *mesh)
{
    if (!mesh)
        return;
    free(mesh->memory);
    *mesh = (struct weft_mesh){0};
}
