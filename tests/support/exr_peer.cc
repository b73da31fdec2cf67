// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/exr_peer.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfThreading.h>
#include <OpenEXR/ImfTileDescription.h>
#include <OpenEXR/ImfTiledInputFile.h>
#include <OpenEXR/ImfTiledOutputPart.h>

#include "filter/check.h"
#include "filter/half.h"

namespace
{

using Words = std::vector<uint32_t>;

Imf::PixelType stored_type(const weft_image_channel &channel)
{
    return channel.type == WEFT_PIXEL_HALF   ? Imf::HALF
           : channel.type == WEFT_PIXEL_UINT ? Imf::UINT
                                             : Imf::FLOAT;
}

// A half's bits lie in the low half of its word.
uint32_t word(const weft_image_channel &channel, size_t i)
{
    uint32_t bits;
    if (channel.type == WEFT_PIXEL_UINT)
        return channel.integers[i];
    if (channel.type == WEFT_PIXEL_HALF)
        return weft_half_from_float(channel.plane[i]);
    memcpy(&bits, channel.plane + i, sizeof bits);
    return bits;
}

// Four bytes a pixel, whatever the type; addressed from pixel (0, 0).
Imf::Slice slice(Imf::PixelType type, Words *words, const Imath::Box2i &box)
{
    const int64_t width = int64_t(box.max.x) - box.min.x + 1;
    const auto base = reinterpret_cast<uintptr_t>(words->data()) -
                      static_cast<uintptr_t>(4 * (box.min.y * width + box.min.x));
    return Imf::Slice(type, reinterpret_cast<char *>(base), 4, size_t(width) * 4);
}

Words read_words(Imf::MultiPartInputFile &file, int part, const char *name, Imf::PixelType type)
{
    const Imath::Box2i box = file.header(part).dataWindow();
    Words words(size_t(box.max.x - box.min.x + 1) * size_t(box.max.y - box.min.y + 1));
    Imf::FrameBuffer frame;
    frame.insert(name, slice(type, &words, box));
    Imf::InputPart input(file, part);
    input.setFrameBuffer(frame);
    input.readPixels(box.min.y, box.max.y);
    return words;
}

std::string difference(const char *path, const weft_image &image)
{
    Imf::MultiPartInputFile file(path, 0);
    const Imf::Header &header = file.header(image.part);
    const Imath::Box2i &box = header.dataWindow();
    if (box.min.x != image.x || box.min.y != image.y || box.max.x != image.x + image.width - 1 ||
        box.max.y != image.y + image.height - 1)
        return "the data window is another";
    size_t channels = 0;
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c)
        channels++;
    if (channels != image.channel_count)
        return std::to_string(channels) + " channels";
    for (size_t c = 0; c < channels; c++) {
        const weft_image_channel &channel = image.channels[c];
        const Imf::Channel *found = header.channels().findChannel(channel.name);
        if (!found || found->type != stored_type(channel))
            return std::string("channel ") + channel.name + " is missing or of another type";
        const Words words = read_words(file, image.part, channel.name, found->type);
        for (size_t i = 0; i < words.size(); i++)
            if (words[i] != word(channel, i))
                return std::string("value ") + std::to_string(i) + " of channel " + channel.name;
    }
    return "";
}

const Imf::Compression compressions[] = {
    Imf::ZIP_COMPRESSION,  Imf::ZIPS_COMPRESSION,  Imf::RLE_COMPRESSION, Imf::NO_COMPRESSION,
    Imf::PIZ_COMPRESSION,  Imf::PXR24_COMPRESSION, Imf::B44_COMPRESSION, Imf::B44A_COMPRESSION,
    Imf::DWAA_COMPRESSION, Imf::DWAB_COMPRESSION,
};

Imf::Header make_header(const weft_image &image, int tile)
{
    const Imath::Box2i data({image.x, image.y},
                            {image.x + image.width - 1, image.y + image.height - 1});
    const Imath::Box2i display({image.display_min[0], image.display_min[1]},
                               {image.display_max[0], image.display_max[1]});
    Imf::Header header(display.max.x ? display : data, data);
    header.compression() = compressions[image.compression];
    header.setType(image.deep ? Imf::DEEPSCANLINE : tile ? Imf::TILEDIMAGE : Imf::SCANLINEIMAGE);
    if (image.deep)
        header.compression() = Imf::ZIPS_COMPRESSION;
    header.setVersion(1); // which OpenEXRCore wants in every part beside deep ones
    if (tile)
        header.setTileDescription(Imf::TileDescription(unsigned(tile), unsigned(tile)));
    if (*image.name)
        header.setName(image.name);
    for (size_t c = 0; c < image.channel_count; c++)
        header.channels().insert(image.channels[c].name,
                                 Imf::Channel(stored_type(image.channels[c])));
    return header;
}

void write_part(Imf::MultiPartOutputFile &file, int part, const weft_image &image, int tile)
{
    const Imath::Box2i box = file.header(part).dataWindow();
    std::vector<Words> words(image.channel_count);
    Imf::FrameBuffer frame;
    for (size_t c = 0; c < image.channel_count; c++) {
        for (size_t i = 0; i < size_t(image.width) * size_t(image.height); i++)
            words[c].push_back(word(image.channels[c], i));
        frame.insert(image.channels[c].name, slice(stored_type(image.channels[c]), &words[c], box));
    }
    if (tile) {
        Imf::TiledOutputPart output(file, part);
        output.setFrameBuffer(frame);
        output.writeTiles(0, output.numXTiles() - 1, 0, output.numYTiles() - 1);
    } else {
        Imf::OutputPart output(file, part);
        output.setFrameBuffer(frame);
        output.writePixels(image.height);
    }
}

// Planes of a channel's own type, and where the library finds them.
struct Planes {
    Imf::FrameBuffer frame;
    std::vector<std::vector<char>> data;

    char *add(const char *name, Imf::PixelType type, const Imath::Box2i &box)
    {
        const size_t size = type == Imf::HALF ? 2 : 4;
        const size_t width = size_t(box.max.x - box.min.x + 1);
        data.emplace_back(size * width * size_t(box.max.y - box.min.y + 1));
        const auto first = int64_t(box.min.y) * int64_t(width) + box.min.x;
        const auto base = reinterpret_cast<uintptr_t>(data.back().data()) -
                          static_cast<uintptr_t>(int64_t(size) * first);
        frame.insert(name, Imf::Slice(type, reinterpret_cast<char *>(base), size, size * width));
        return data.back().data();
    }
};

} // namespace

bool exr_peer_agrees(const char *path, const struct weft_image *image, char *why, size_t size)
{
    std::string text;
    try {
        text = difference(path, *image);
    } catch (const std::exception &error) {
        text = error.what();
    }
    snprintf(why, size, "%s", text.c_str());
    return text.empty();
}

bool exr_peer_write(const char *path, const struct weft_image *parts, size_t count, int tile,
                    char *why, size_t size)
{
    try {
        std::vector<Imf::Header> headers;
        for (size_t p = 0; p < count; p++)
            headers.push_back(make_header(parts[p], tile));
        Imf::MultiPartOutputFile file(path, headers.data(), int(count), false, 0);
        for (size_t p = 0; p < count; p++)
            if (!parts[p].deep)
                write_part(file, int(p), parts[p], tile);
        return true;
    } catch (const std::exception &error) {
        snprintf(why, size, "%s", error.what());
        return false;
    }
}

float *exr_peer_values(const char *path, const char *channel, char *why, size_t size)
{
    try {
        Imf::MultiPartInputFile file(path, 0);
        const Words words = read_words(file, 0, channel, Imf::FLOAT);
        float *out = static_cast<float *>(malloc(words.size() * sizeof *out));
        if (out)
            memcpy(out, words.data(), words.size() * sizeof *out);
        return out;
    } catch (const std::exception &error) {
        snprintf(why, size, "%s", error.what());
        return NULL;
    }
}

float *exr_peer_level(const char *path, const char *channel, int level, int size[2], int *levels,
                      char *why, size_t why_size)
{
    try {
        Imf::TiledInputFile file(path, 0);
        *levels = file.numLevels();
        const int width = file.levelWidth(level), height = file.levelHeight(level);
        const Imath::Box2i box = file.dataWindowForLevel(level);
        float *out = static_cast<float *>(malloc(size_t(width) * size_t(height) * sizeof *out));
        char *base = reinterpret_cast<char *>(out - (ptrdiff_t(box.min.y) * width + box.min.x));
        Imf::FrameBuffer frame;
        frame.insert(channel,
                     Imf::Slice(Imf::FLOAT, base, sizeof *out, sizeof *out * size_t(width)));
        file.setFrameBuffer(frame);
        file.readTiles(0, file.numXTiles(level) - 1, 0, file.numYTiles(level) - 1, level);
        size[0] = width;
        size[1] = height;
        return out;
    } catch (const std::exception &error) {
        snprintf(why, why_size, "%s", error.what());
        return NULL;
    }
}

double exr_peer_write_seconds(const char *path, const struct weft_image *image, int threads,
                              char *why, size_t size)
{
    try {
        const Imf::Header header = make_header(*image, 0);
        Planes planes;
        for (size_t c = 0; c < image->channel_count; c++) {
            const weft_image_channel &channel = image->channels[c];
            char *data = planes.add(channel.name, stored_type(channel), header.dataWindow());
            const size_t bytes = channel.type == WEFT_PIXEL_HALF ? 2 : 4;
            for (size_t i = 0; i < size_t(image->width) * size_t(image->height); i++) {
                const uint32_t value = word(channel, i);
                memcpy(data + bytes * i, &value, bytes);
            }
        }
        Imf::setGlobalThreadCount(threads);
        const double start = weft_now_seconds();
        {
            Imf::OutputFile output(path, header, threads);
            output.setFrameBuffer(planes.frame);
            output.writePixels(image->height);
        }
        return weft_now_seconds() - start;
    } catch (const std::exception &error) {
        snprintf(why, size, "%s", error.what());
        return -1.0;
    }
}

double exr_peer_read_seconds(const char *path, int threads, char *why, size_t size)
{
    try {
        Imf::setGlobalThreadCount(threads);
        const double start = weft_now_seconds();
        Imf::InputFile input(path, threads);
        const Imath::Box2i &box = input.header().dataWindow();
        const Imf::ChannelList &channels = input.header().channels();
        Planes planes;
        for (auto c = channels.begin(); c != channels.end(); ++c)
            planes.add(c.name(), c.channel().type == Imf::UINT ? Imf::UINT : Imf::FLOAT, box);
        input.setFrameBuffer(planes.frame);
        input.readPixels(box.min.y, box.max.y);
        return weft_now_seconds() - start;
    } catch (const std::exception &error) {
        snprintf(why, size, "%s", error.what());
        return -1.0;
    }
}
