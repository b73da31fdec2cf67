// SPDX-License-Identifier: BSD-3-Clause
// tests/command/scenes/refused.h - what verbs of scenes refuse, and how tests look at it.
#ifndef WEFT_TESTS_COMMAND_SCENES_REFUSED_H
#define WEFT_TESTS_COMMAND_SCENES_REFUSED_H

#include <stddef.h>

#include "tests/support/command.h"

// A verb's operand, up to four arguments after -o p.exr (of which the first may be another -o), and
// what the error line has.
struct refused_value {
    const char *operand, *option[4], *message;
};

// Each ends with 2.
static inline void refuse_values(const char *verb, const struct refused_value *cases, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const char *const *o = cases[i].option;
        const char *argv[10] = {"weft", verb, cases[i].operand, "--output=p.exr"};
        const bool named = o[0][0] == '-' && o[0][1] == 'o';
        int length = named ? 3 : 4;
        for (int k = 0; k < 4 && o[k]; k++)
            argv[length++] = o[k];
        argv[length] = NULL;
        command_fails_list(__FILE__, __LINE__, 2, cases[i].message, argv);
    }
}

// Mesh files that cannot be drawn.
static const struct {
    const char *path, *text;
} bad_meshes[] = {
    {"empty.obj", ""},
    {"points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"},
    {"beyond.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"},
    {"nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
    {"large.obj", "v 1e38 0 0\nv 1 0 0\nv 0 1e38 0\nf 1 2 3\n"},
    {"text.ply", "hello\n"},
    {"cut.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                "end_header\n0 0 0\n"},
    {"text.gltf", "{"},
    {"text.glb", "glTF"},
    {"outside.gltf",
     "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"uri\":\"../../../etc/passwd\","
     "\"byteLength\":36}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":[{"
     "\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],\"meshes\":[{"
     "\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"nodes\":[{\"mesh\":0}],\"scenes\":"
     "[{\"nodes\":[0]}],\"scene\":0}"},
};

#endif
