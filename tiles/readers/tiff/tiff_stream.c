// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/tiff/tiff_stream.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { MOST_ALLOCATION = 1 << 30 }; // of libtiff at once

static int keep_message(TIFF *tiff, void *priv, const char *module, const char *format,
                        va_list args)
{
    struct weft_tiff_stream *s = priv;
    (void)tiff;
    (void)module;
    if (!s->message[0])
        vsnprintf(s->message, sizeof s->message, format, args);
    return 1;
}

static int be_silent(TIFF *tiff, void *priv, const char *module, const char *format, va_list args)
{
    (void)tiff;
    (void)priv;
    (void)module;
    (void)format;
    (void)args;
    return 1;
}

static tmsize_t read_bytes(thandle_t priv, void *out, tmsize_t size)
{
    struct weft_tiff_stream *s = priv;
    tmsize_t done = 0;
    while (done < size) {
        const ssize_t n = pread(s->fd, (char *)out + done, (size_t)(size - done),
                                (off_t)(s->at + (uint64_t)done));
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            break;
        done += n;
    }
    s->at += (uint64_t)done;
    return done;
}

static tmsize_t write_bytes(thandle_t priv, void *data, tmsize_t size)
{
    struct weft_tiff_stream *s = priv;
    tmsize_t done = 0;
    while (s->writes && done < size) {
        const ssize_t n = pwrite(s->fd, (const char *)data + done, (size_t)(size - done),
                                 (off_t)(s->at + (uint64_t)done));
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0) {
            if (!s->message[0])
                snprintf(s->message, sizeof s->message, "%s", strerror(errno));
            return -1;
        }
        done += n;
    }
    s->at += (uint64_t)done;
    s->end = s->at > s->end ? s->at : s->end;
    return s->writes ? done : -1;
}

static toff_t seek(thandle_t priv, toff_t offset, int from)
{
    struct weft_tiff_stream *s = priv;
    const uint64_t base = from == SEEK_CUR ? s->at : from == SEEK_END ? s->end : 0;
    if (base + offset > INT64_MAX)
        return (toff_t)-1;
    return s->at = base + offset;
}

static int close_nothing(thandle_t priv)
{
    (void)priv;
    return 0;
}

static toff_t size_of(thandle_t priv)
{
    return ((struct weft_tiff_stream *)priv)->end;
}

TIFF *weft_tiff_stream_open(struct weft_tiff_stream *stream, const char *path, const char *mode)
{
    TIFFOpenOptions *options = TIFFOpenOptionsAlloc();
    TIFF *tiff = NULL;
    if (!options)
        return NULL;
    stream->writes = mode[0] == 'w';
    if (!stream->writes)
        TIFFOpenOptionsSetMaxSingleMemAlloc(options, MOST_ALLOCATION);
    TIFFOpenOptionsSetErrorHandlerExtR(options, keep_message, stream);
    TIFFOpenOptionsSetWarningHandlerExtR(options, be_silent, stream);
    tiff = TIFFClientOpenExt(path, mode, stream, read_bytes, write_bytes, seek, close_nothing,
                             size_of, NULL, NULL, options);
    TIFFOpenOptionsFree(options);
    return tiff;
}
