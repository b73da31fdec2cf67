// SPDX-License-Identifier: BSD-3-Clause
// Preloaded: makes the k-th allocation of jansson fail, k = $WEFT_FAIL_JSON; 0: none does. At the
// end it writes how many there were to the file $WEFT_COUNT_JSON.
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include <jansson.h>

static unsigned long count, failing;

static void *allocate(size_t size)
{
    return ++count == failing ? NULL : malloc(size);
}

__attribute__((constructor)) static void begin(void)
{
    const char *text = getenv("WEFT_FAIL_JSON");
    failing = text ? strtoul(text, NULL, 10) : 0;
    json_set_alloc_funcs(allocate, free);
}

__attribute__((destructor)) static void end(void)
{
    const char *path = getenv("WEFT_COUNT_JSON");
    int fd = path ? open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600) : -1;
    if (fd < 0)
        return;
    dprintf(fd, "%lu", count);
    close(fd);
}
