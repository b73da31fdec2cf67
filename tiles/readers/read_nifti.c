// SPDX-License-Identifier: BSD-3-Clause
// weft-read-nifti: bricks of NIfTI files, by libnifti2.
#include "tiles/readers/dense/nifti.h"

static enum weft_result handle(struct weft_server *server)
{
    return weft_dense_handle(server, server->priv, weft_nifti_read_header);
}

int main(int argc, char **argv)
{
    static struct weft_dense dense;
    return weft_server_run(argc, argv, handle, &dense);
}
