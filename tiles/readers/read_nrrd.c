// SPDX-License-Identifier: BSD-3-Clause
// weft-read-nrrd: bricks of NRRD files, by Teem, and of raw files whose layout is given.
#include "tiles/readers/dense/nrrd.h"

static enum weft_result handle(struct weft_server *server)
{
    return weft_dense_handle(server, server->priv, weft_nrrd_read_header);
}

int main(int argc, char **argv)
{
    static struct weft_dense dense;
    return weft_server_run(argc, argv, handle, &dense);
}
