// SPDX-License-Identifier: BSD-3-Clause
// weft-read-mesh: triangles of OBJ, PLY and glTF files for libweft, decoded by assimp.
#include <inttypes.h>
#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "tiles/process/server.h"
#include "tiles/readers/mesh/import.h"
#include "tiles/readers/mesh/soup.h"

static void put(char **to, const void *from, size_t bytes)
{
    memcpy(*to, from, bytes);
    *to += bytes;
}

static enum weft_result put_answer(struct weft_server *server, const struct weft_mesh_soup *soup,
                                   const char *warning)
{
    struct weft_wire_mesh wire = {.vertex_count = soup->vertex_count,
                                  .index_count = soup->index_count,
                                  .part_count = soup->part_count,
                                  .material_count = soup->material_count};
    const size_t vertices = soup->vertex_count * sizeof *soup->vertices,
                 indices = soup->index_count * sizeof *soup->indices,
                 parts = soup->part_count * sizeof *soup->parts,
                 materials = soup->material_count * sizeof *soup->materials;
    char *at = weft_server_map(server, sizeof wire + vertices + indices + parts + materials);
    if (!at)
        return (enum weft_result)server->answer.result;
    memcpy(wire.dropped, soup->dropped, sizeof wire.dropped);
    snprintf(wire.warning, sizeof wire.warning, "%s", warning);
    put(&at, &wire, sizeof wire);
    put(&at, soup->vertices, vertices);
    put(&at, soup->indices, indices);
    put(&at, soup->parts, parts);
    put(&at, soup->materials, materials);
    return WEFT_OK;
}

static enum weft_result check_file(struct weft_mesh_source *source)
{
    switch (source->kind) {
    case WEFT_MESH_OBJ:
        return weft_mesh_check_obj(source);
    case WEFT_MESH_PLY:
        return weft_mesh_check_ply(source);
    default:
        return weft_mesh_check_gltf(source);
    }
}

static enum weft_result make_soup(struct weft_mesh_source *source, struct weft_mesh_soup *soup)
{
    const struct aiScene *scene = NULL;
    enum weft_result res = check_file(source);
    if (res == WEFT_OK)
        res = weft_mesh_import(source, &scene);
    if (res == WEFT_OK)
        res = weft_mesh_soup_make(scene, source, soup);
    if (res == WEFT_OK && (!weft_mesh_soup_smooth(soup) || !weft_mesh_soup_join(soup)))
        res = weft_mesh_fail(source, WEFT_ERR_LIMIT, "%zu triangles do not fit in memory",
                             soup->index_count / 3);
    return res;
}

static enum weft_result answer_mesh(struct weft_server *server, struct weft_mesh_source *source,
                                    struct weft_mesh_soup *soup)
{
    if (!weft_mesh_files_begin(source->files, server->path, server->input_fd))
        return weft_server_fail(server, WEFT_ERR_LIMIT, "%s", source->files->refused);
    const enum weft_result res = make_soup(source, soup);
    if (res == WEFT_OK)
        return put_answer(server, soup, source->files->missing);
    if (res == WEFT_ERR_LIMIT)
        return weft_server_fail(server, res, "%s; the limit of memory is %" PRIu64 " bytes",
                                source->message, server->limits.memory_bytes);
    return weft_server_fail(server, res, "%s", source->message);
}

static enum weft_result handle(struct weft_server *server)
{
    struct weft_mesh_soup soup = {0};
    struct weft_mesh_files files;
    struct weft_mesh_source source = {.files = &files,
                                      .kind = (enum weft_mesh_kind)server->request->part};
    const struct weft_wire_request *request = server->request;
    if (request->op != WEFT_WIRE_MESH || request->part > WEFT_MESH_GLB)
        return weft_server_fail(server, WEFT_ERR_READER, "weft-read-mesh: unknown request %" PRIu32,
                                request->op);
    const enum weft_result res = answer_mesh(server, &source, &soup);
    free(source.text);
    weft_mesh_soup_clear(&soup);
    return res;
}

int main(int argc, char **argv)
{
    mallopt(M_ARENA_MAX, 1); // address space is limited
    return weft_server_run(argc, argv, handle, NULL);
}
