/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* EXR files that only the C++ library writes (DWA, levels, deep tiles), and its view of any file. Built where io/ reads
 * DWA. */
#include <cmath>
#include <cstdint>
#include <cstring>
#include <exception>
#include <string>
#include <vector>

#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineOutputFile.h>
#include <ImfDeepTiledOutputFile.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfPartType.h>
#include <ImfTiledOutputFile.h>

namespace {

struct Sample {
    std::string name;
    Imf::PixelType type;
    std::vector<char> data;
};

double value_at(size_t channel, int x, int y) {
    return 1 + std::sin(x * 0.3 + y * 0.2 + double(channel)) + ((x * 7 + y * 13) % 5) * 0.01;
}

void fill(Sample &sample, size_t channel, int width, int height) {
    size_t size = sample.type == Imf::HALF ? 2 : 4;
    sample.data.resize(size * size_t(width) * size_t(height));
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            char *at = &sample.data[size * (size_t(y) * size_t(width) + size_t(x))];
            double value = value_at(channel, x, y);
            half h = half(float(value));
            float f = float(10 * value);
            uint32_t u = uint32_t(1000 * value);
            std::memcpy(at,
                        sample.type == Imf::HALF    ? (void *)&h
                        : sample.type == Imf::FLOAT ? (void *)&f
                                                    : (void *)&u,
                        size);
        }
}

Imf::Compression compression_of(const std::string &kind) {
    static const char *const names[] = {"none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"};
    for (int i = 0; i < 10; i++)
        if (kind.compare(0, kind.find(' '), names[i]) == 0) return Imf::Compression(i);
    return Imf::NO_COMPRESSION;
}

bool has(const std::string &kind, const char *word) {
    return kind.find(word) != std::string::npos;
}

void add_channels(Imf::Header &header, bool subsampled) {
    Imf::ChannelList &list = header.channels();
    list.insert("R", Imf::Channel(Imf::HALF));
    list.insert("G", Imf::Channel(Imf::HALF, 1, 1, true));
    list.insert("Z", Imf::Channel(Imf::FLOAT));
    list.insert("id", Imf::Channel(Imf::UINT));
    if (subsampled) { /* also by numbers that do not divide the lines of a chunk */
        list.insert("RY", Imf::Channel(Imf::HALF, 3, 3));
        list.insert("BY", Imf::Channel(Imf::HALF, 2, 2, true));
        list.insert("far", Imf::Channel(Imf::FLOAT, 6, 4));
    }
}

void write_flat(const std::string &kind, const char *path, Imf::Header &header, int width, int height) {
    std::vector<Sample> samples;
    Imf::FrameBuffer frame;
    Imath::Box2i window = header.dataWindow();
    samples.reserve(16);
    for (auto i = header.channels().begin(); i != header.channels().end(); ++i) {
        int xs = i.channel().xSampling, ys = i.channel().ySampling;
        samples.push_back({i.name(), i.channel().type, {}});
        Sample &s = samples.back();
        fill(s, samples.size(), width / xs, height / ys);
        size_t size = s.type == Imf::HALF ? 2 : 4;
        frame.insert(s.name, Imf::Slice::Make(s.type, s.data.data(), window, size, size * size_t(width / xs), xs, ys));
    }
    if (!header.hasTileDescription()) {
        Imf::OutputFile file(path, header);
        file.setFrameBuffer(frame);
        file.writePixels(height);
        return;
    }
    Imf::TiledOutputFile file(path, header);
    file.setFrameBuffer(frame);
    for (int y = 0; y < file.numYLevels(); y++)
        for (int x = 0; x < file.numXLevels(); x++)
            if (has(kind, "ripmap") || x == y)
                file.writeTiles(0, file.numXTiles(x) - 1, 0, file.numYTiles(y) - 1, x, y);
}

void write_deep(const std::string &kind, const char *path, Imf::Header &header, int width, int height) {
    size_t pixels = size_t(width) * size_t(height), row = size_t(width);
    std::vector<unsigned> counts(pixels);
    std::vector<std::vector<float>> values(pixels);
    std::vector<float *> pointers(pixels);
    for (size_t i = 0; i < pixels; i++) {
        counts[i] = unsigned(i % 4);
        values[i].assign(counts[i] + 1, float(i));
        pointers[i] = values[i].data();
    }
    Imath::Box2i window = header.dataWindow();
    size_t shift = size_t(window.min.x) + size_t(window.min.y) * row; /* wraps around, and back */
    Imf::DeepFrameBuffer frame;
    frame.insertSampleCountSlice(
        Imf::Slice(Imf::UINT, (char *)(counts.data() - shift), sizeof(unsigned), sizeof(unsigned) * row));
    frame.insert("Z", Imf::DeepSlice(Imf::FLOAT, (char *)(pointers.data() - shift), sizeof(float *),
                                     sizeof(float *) * row, sizeof(float)));
    if (has(kind, "tiled")) {
        header.setType(Imf::DEEPTILE);
        header.setTileDescription(Imf::TileDescription(16, 16, Imf::ONE_LEVEL));
        Imf::DeepTiledOutputFile file(path, header);
        file.setFrameBuffer(frame);
        file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
    } else {
        header.setType(Imf::DEEPSCANLINE);
        Imf::DeepScanLineOutputFile file(path, header);
        file.setFrameBuffer(frame);
        file.writePixels(height);
    }
}

} // namespace

extern "C" int make_fixture(const char *kind_text, const char *path);
extern "C" bool read_reference(const char *path, const char *channel, int type, void *data, int width, int height);

/* "<compression> scanline|tiled|mipmap|ripmap|subsampled|deep scanline|deep tiled" */
int make_fixture(const char *kind_text, const char *path) {
    try {
        std::string kind = kind_text;
        int width = has(kind, "subsampled") ? 36 : 37, height = has(kind, "subsampled") ? 72 : 45;
        Imath::Box2i window({-6, -12}, {-6 + width - 1, -12 + height - 1});
        Imf::Header header(Imath::Box2i({0, 0}, {63, 31}), window, 1, {0, 0}, 1,
                           has(kind, "tiled") ? Imf::DECREASING_Y : Imf::INCREASING_Y, compression_of(kind));
        if (has(kind, "deep")) {
            header.channels().insert("Z", Imf::Channel(Imf::FLOAT));
            header.lineOrder() = Imf::INCREASING_Y;
            write_deep(kind, path, header, width, height);
            return 1;
        }
        add_channels(header, has(kind, "subsampled"));
        if (has(kind, "tiled")) header.setTileDescription(Imf::TileDescription(16, 13, Imf::ONE_LEVEL));
        if (has(kind, "mipmap"))
            header.setTileDescription(Imf::TileDescription(16, 13, Imf::MIPMAP_LEVELS, Imf::ROUND_UP));
        if (has(kind, "ripmap"))
            header.setTileDescription(Imf::TileDescription(16, 13, Imf::RIPMAP_LEVELS, Imf::ROUND_DOWN));
        write_flat(kind, path, header, width, height);
        return 1;
    } catch (const std::exception &) {
        return -1;
    }
}

bool read_reference(const char *path, const char *channel, int type, void *data, int width, int height) {
    try {
        Imf::InputFile file(path);
        const Imf::Channel &found = file.header().channels()[channel];
        Imath::Box2i window = file.header().dataWindow();
        size_t size = type == 1 ? 2 : 4;
        if (found.type != Imf::PixelType(type) || (window.max.x - window.min.x + 1) / found.xSampling != width ||
            (window.max.y - window.min.y + 1) / found.ySampling != height)
            return false;
        Imf::FrameBuffer frame;
        frame.insert(channel, Imf::Slice::Make(found.type, data, window, size, size * size_t(width), found.xSampling,
                                               found.ySampling));
        file.setFrameBuffer(frame);
        file.readPixels(window.min.y, window.max.y);
        return true;
    } catch (const std::exception &) {
        return false;
    }
}
