// SPDX-License-Identifier: BSD-3-Clause
// In the place of weft-read-mesh: the letter that a file starts with says how it misbehaves.
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "tiles/mesh/mesh_wire.h"
#include "tiles/process/server.h"

// A triangle.
struct payload {
    struct weft_wire_mesh wire;
    struct weft_mesh_vertex vertices[3];
    uint32_t indices[3];
    struct weft_mesh_part part;
    struct weft_mesh_material material;
};

static void make_good(struct payload *p)
{
    memset(p, 0, sizeof *p);
    p->wire = (struct weft_wire_mesh){
        .vertex_count = 3, .index_count = 3, .part_count = 1, .material_count = 1};
    for (uint32_t i = 0; i < 3; i++) {
        p->vertices[i].position[i] = 1.0f;
        p->vertices[i].normal[2] = 1.0f;
        p->indices[i] = i;
    }
    p->part = (struct weft_mesh_part){.name = "a\33b", .index_count = 3};
}

static void lie(struct weft_server *server, char how, struct payload *p)
{
    switch (how) {
    case 'a':
        p->wire.vertex_count = UINT64_MAX;
        break;
    case 'b':
        p->wire.vertex_count = 2;
        break;
    case 'c':
        p->wire.index_count = UINT64_MAX / 3 * 3;
        break;
    case 'd':
        p->wire.part_count = 0;
        break;
    case 'e':
        p->wire.material_count = 2;
        break;
    case 'f':
        p->indices[1] = 3;
        break;
    case 'g':
        p->indices[2] = UINT32_MAX;
        break;
    case 'h':
        p->vertices[1].position[0] = NAN;
        break;
    case 'i':
        p->vertices[1].position[0] = 2e30f;
        break;
    case 'j':
        p->vertices[2].normal[0] = 1.0f;
        break;
    case 'k':
        p->vertices[0].colour[1] = -1.0f;
        break;
    case 'l':
        p->vertices[0].uv[1] = INFINITY;
        break;
    case 'm':
        p->part.first_index = 3;
        break;
    case 'n':
        p->part.index_count = UINT32_MAX;
        break;
    case 'o':
        p->part.material = 1;
        break;
    case 'p':
        memset(p->part.name, 'x', sizeof p->part.name);
        break;
    case 'q':
        memset(p->material.name, 'x', sizeof p->material.name);
        break;
    case 'r':
        p->material.reflectance[2] = NAN;
        break;
    case 's':
        p->material.emission[0] = -1.0f;
        break;
    case 't':
        memset(p->wire.dropped, 'x', sizeof p->wire.dropped);
        break;
    case 'u':
        memset(p->wire.warning, 'x', sizeof p->wire.warning);
        break;
    case 'v':
        memset(server->answer.message, 'x', sizeof server->answer.message);
        break;
    case 'w':
        _exit(9);
    case 'x':
        __builtin_trap();
    case 'y':
        pause();
        break;
    case 'z':
        *p->part.name = '\0';
        break;
    }
}

static enum weft_result handle(struct weft_server *server)
{
    char how = 0;
    struct payload payload;
    if (pread(server->input_fd, &how, 1, 0) != 1)
        return WEFT_ERR_FORMAT;
    make_good(&payload);
    lie(server, how, &payload);
    const size_t all = offsetof(struct payload, material) + sizeof payload.material,
                 size = how == '1'   ? all - 1
                        : how == '2' ? 10
                                     : all;
    weft_server_append(server, &payload, size);
    return WEFT_OK;
}

int main(int argc, char **argv)
{
    return weft_server_run(argc, argv, handle, NULL);
}
