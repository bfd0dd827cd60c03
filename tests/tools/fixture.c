/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Makes and inspects the small pictures that the tests of the command need.
 *
 * fixture make FILE WIDTH HEIGHT half|float BITS [window=X,Y,W,H] NAME=PATTERN[@X,Y=VALUE]...
 *     PATTERN: a number, ramp:A:B (along x), down:A:B (along y), noise
 *     window: the data window is WIDTH x HEIGHT at X,Y of a display window of W x H
 *
 * fixture value FILE CHANNEL X Y: one value
 *
 * fixture data FILE CHANNEL X Y: the same, of a file that holds no colour (integers are not decoded)
 *
 * fixture range FILE CHANNEL: smallest and largest value
 *
 * fixture same A B CHANNEL: succeeds when all values have the same bits
 *
 * fixture tile IN OUT NX NY: an EXR file of NX by NY times the picture IN, channels and types as there
 *
 * fixture header FILE WIDTH HEIGHT: the header of an EXR file without any pixels
 *
 * fixture attribute FILE NAME float|double|int|rational|string|TYPE VALUE: into the header of an EXR file with one part; rational:
 *     N/D, any other TYPE: hexadecimal bytes
 * fixture hex FILE NAME: the bytes of an attribute of such a file
 * fixture deep FILE WIDTH HEIGHT: the header of an EXR file of deep samples, without any
 * fixture rows FILE WIDTH HEIGHT half|float: an EXR of any size, not compressed: R G B noise that repeats, A 1, Z 1 to 20
 *
 * fixture json KEY... < TEXT: values of an object's members ("a.b" goes down), one a line; fails when one is not there
 */
#include <cjson/cJSON.h>
#include <picture.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int die(const char *what, const char *which) {
    fprintf(stderr, "fixture: %s: %s\n", what, which);
    exit(2);
}

static float pattern_value(const char *pattern, int x, int y, int width, int height) {
    float a, b;
    if (sscanf(pattern, "ramp:%f:%f", &a, &b) == 2) return a + (b - a) * (float)x / (float)(width > 1 ? width - 1 : 1);
    if (sscanf(pattern, "down:%f:%f", &a, &b) == 2)
        return a + (b - a) * (float)y / (float)(height > 1 ? height - 1 : 1);
    if (strncmp(pattern, "noise", 5) == 0) {
        unsigned n = (unsigned)x * 73856093u ^ (unsigned)y * 19349663u;
        n = (n ^ n >> 13) * 0x5bd1e995u;
        return (float)(n >> 8) * 0x1p-24f;
    }
    return strtof(pattern, NULL);
}

static void fill(io_channel *channel, char *pattern) {
    char *exception = strchr(pattern, '@');
    if (exception) *exception++ = 0;
    const int width = channel->width, height = channel->height;
    float *value = malloc((size_t)width * (size_t)height * sizeof *value);
    if (!value) die("out of memory", channel->name);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            value[(size_t)y * (size_t)width + (size_t)x] = pattern_value(pattern, x, y, width, height);
    int x, y;
    char text[32];
    if (exception && sscanf(exception, "%d,%d=%31s", &x, &y, text) == 3)
        value[(size_t)y * (size_t)width + (size_t)x] = strtof(text, NULL);
    io_channel_from_float(channel, value, 1, (size_t)width);
    free(value);
}

static int make(int count, char **word) {
    if (count < 6) die("make", "too few arguments");
    io_error error = {0};
    io_format format;
    io_picture *picture = NULL;
    io_box window = {0};
    int first = 5, width = atoi(word[1]), height = atoi(word[2]);
    if (!io_format_of_name(word[0], &format)) die("unknown ending", word[0]);
    bool has_window = sscanf(word[5], "window=%d,%d,%d,%d", &window.x, &window.y, &window.width, &window.height) == 4;
    first += has_window;
    const char *names[64];
    char *patterns[64];
    int channels = 0;
    for (int i = first; i < count && channels < 64; i++, channels++) {
        char *equals = strchr(word[i], '=');
        if (!equals) die("no '='", word[i]);
        *equals = 0;
        names[channels] = word[i];
        patterns[channels] = equals + 1;
    }
    io_type type = strcmp(word[3], "half") == 0 ? IO_HALF : IO_FLOAT;
    if (io_create(&picture, format, width, height, names, channels, type, atoi(word[4]), IO_COLOR, &error))
        die("create", error.text);
    io_part *part = &picture->part[0];
    if (has_window) {
        part->data = (io_box){window.x, window.y, width, height};
        part->display = (io_box){0, 0, window.width, window.height};
    }
    for (int c = 0; c < part->channel_count; c++)
        for (int i = 0; i < channels; i++)
            if (strcmp(part->channel[c].name, names[i]) == 0) fill(&part->channel[c], patterns[i]);
    if (io_write(picture, word[0], NULL, NULL, &error)) die("write", error.text);
    io_close(&picture);
    return 0;
}

static io_channel *load(io_picture **picture, const char *path, const char *name, io_meaning meaning) {
    io_error error = {0};
    if (io_open(picture, path, meaning, NULL, &error) || io_read(*picture, &error)) die("read", error.text);
    for (int p = 0; p < (*picture)->part_count; p++)
        for (int c = 0; c < (*picture)->part[p].channel_count; c++)
            if (strcmp((*picture)->part[p].channel[c].name, name) == 0) return &(*picture)->part[p].channel[c];
    die("no such channel", name);
    return NULL;
}

static float *values(const io_channel *channel) {
    float *value = malloc((size_t)channel->width * (size_t)channel->height * sizeof *value);
    if (!value) die("out of memory", channel->name);
    io_channel_to_float(channel, value, 1, (size_t)channel->width);
    return value;
}

static int look(int count, char **word, bool range, io_meaning meaning) {
    if (count < (range ? 2 : 4)) die("value, range", "too few arguments");
    io_picture *picture = NULL;
    const io_channel *channel = load(&picture, word[0], word[1], meaning);
    float *value = values(channel);
    if (range) {
        float low = value[0], high = value[0];
        for (size_t i = 0; i < (size_t)channel->width * (size_t)channel->height; i++) {
            if (value[i] < low) low = value[i];
            if (value[i] > high) high = value[i];
        }
        printf("%.9g %.9g\n", (double)low, (double)high);
    } else {
        printf("%.9g\n", (double)value[(size_t)atoi(word[3]) * (size_t)channel->width + (size_t)atoi(word[2])]);
    }
    free(value);
    io_close(&picture);
    return 0;
}

static int same(int count, char **word) {
    if (count < 3) die("same", "too few arguments");
    io_picture *a = NULL, *b = NULL;
    const io_channel *p = load(&a, word[0], word[2], IO_COLOR), *q = load(&b, word[1], word[2], IO_COLOR);
    bool equal = p->width == q->width && p->height == q->height && p->type == q->type &&
                 memcmp(p->data, q->data, (size_t)p->width * (size_t)p->height * io_type_size(p->type)) == 0;
    io_close(&a);
    io_close(&b);
    return equal ? 0 : 1;
}

static void repeat(io_channel *to, const io_channel *from) {
    const size_t row = (size_t)from->width * io_type_size(from->type);
    const int across = to->width / from->width;
    for (int y = 0; y < to->height; y++)
        for (int x = 0; x < across; x++)
            memcpy((char *)to->data + ((size_t)y * (size_t)across + (size_t)x) * row,
                   (const char *)from->data + (size_t)(y % from->height) * row, row);
}

static int tile(int count, char **word) {
    if (count < 4) die("tile", "too few arguments");
    io_error error = {0};
    io_picture *in = NULL, *out = NULL;
    if (io_open(&in, word[0], IO_COLOR, NULL, &error) || io_read(in, &error)) die("read", error.text);
    const io_part *part = &in->part[0];
    const char *names[32];
    if (part->channel_count > 32) die("too many channels", word[0]);
    for (int c = 0; c < part->channel_count; c++)
        names[c] = part->channel[c].name;
    if (io_create(&out, IO_EXR, part->data.width * atoi(word[2]), part->data.height * atoi(word[3]), names,
                  part->channel_count, IO_HALF, 16, IO_COLOR, &error))
        die("create", error.text);
    for (int c = 0; c < part->channel_count; c++) {
        io_channel *to = &out->part[0].channel[c];
        if (to->type != part->channel[c].type && io_channel_retype(to, part->channel[c].type, &error))
            die("out of memory", word[1]);
        repeat(to, &part->channel[c]);
        io_channel_modified(to);
    }
    if (io_write(out, word[1], NULL, NULL, &error)) die("write", error.text);
    io_close(&out);
    io_close(&in);
    return 0;
}

/* ------------------------------------------------------------------------- an EXR header by hand */

static void put_int(FILE *file, int value) {
    for (int i = 0; i < 4; i++)
        fputc(value >> 8 * i & 255, file);
}

static void put_attribute(FILE *file, const char *name, const char *type, int size) {
    fwrite(name, strlen(name) + 1, 1, file);
    fwrite(type, strlen(type) + 1, 1, file);
    put_int(file, size);
}

/* Of a file of deep samples: what its header has more. */
static void put_deep(FILE *file, int height) {
    put_attribute(file, "type", "string", 12);
    fwrite("deepscanline", 12, 1, file);
    put_attribute(file, "name", "string", 4);
    fwrite("deep", 4, 1, file);
    put_attribute(file, "version", "int", 4);
    put_int(file, 1);
    put_attribute(file, "chunkCount", "int", 4);
    put_int(file, height);
    put_attribute(file, "maxSamplesPerPixel", "int", 4);
    put_int(file, 2);
}

static void put_header(FILE *file, const char *names, bool half, bool deep, const char *width, const char *height) {
    const int channels = (int)strlen(names);
    put_int(file, 20000630);
    put_int(file, deep ? 2 | 0x800 : 2);
    if (deep) put_deep(file, atoi(height));
    put_attribute(file, "channels", "chlist", channels * 18 + 1);
    for (int i = 0; i < channels; i++) {
        fputc(names[i], file);
        fputc(0, file);
        put_int(file, half ? 1 : 2);
        put_int(file, 0);
        put_int(file, 1);
        put_int(file, 1);
    }
    fputc(0, file);
    put_attribute(file, "compression", "compression", 1);
    fputc(0, file);
    for (int i = 0; i < 2; i++) {
        put_attribute(file, i ? "displayWindow" : "dataWindow", "box2i", 16);
        put_int(file, 0);
        put_int(file, 0);
        put_int(file, atoi(width) - 1);
        put_int(file, atoi(height) - 1);
    }
    put_attribute(file, "lineOrder", "lineOrder", 1);
    fputc(0, file);
    put_attribute(file, "pixelAspectRatio", "float", 4);
    put_int(file, 0x3f800000);
    put_attribute(file, "screenWindowCenter", "v2f", 8);
    put_int(file, 0);
    put_int(file, 0);
    put_attribute(file, "screenWindowWidth", "float", 4);
    put_int(file, 0x3f800000);
    fputc(0, file);
}

static FILE *create_file(const char *path) {
    FILE *file = fopen(path, "wb");
    if (!file) die("cannot write", path);
    return file;
}

static int header(int count, char **word, bool deep) {
    if (count < 3) die("header", "too few arguments");
    FILE *file = create_file(word[0]);
    put_header(file, "BGRZ", true, deep, word[1], word[2]);
    for (int i = 0; deep && i < 8 * atoi(word[2]); i++) fputc(0, file); /* where the rows begin */
    return fclose(file);
}

/* ------------------------------------------------------------------------- one more attribute */

enum { LARGEST_EXR = 1 << 24 };

static unsigned long long get_bytes(const unsigned char *at, int size) {
    unsigned long long value = 0;
    for (int i = size; i-- > 0;)
        value = value << 8 | at[i];
    return value;
}

static void put_bytes(unsigned char *at, int size, unsigned long long value) {
    for (int i = 0; i < size; i++)
        at[i] = (unsigned char)(value >> 8 * i);
}

/* The bytes of a value; returns how many. */
static int encode(const char *type, const char *text, unsigned char *out) {
    const float single = strtof(text, NULL);
    const double number = strtod(text, NULL);
    const char *slash = strchr(text, '/');
    if (strcmp(type, "string") == 0) {
        memcpy(out, text, strlen(text));
        return (int)strlen(text);
    }
    if (strcmp(type, "double") == 0) {
        memcpy(out, &number, 8);
        return 8;
    }
    if (strcmp(type, "float") != 0 && strcmp(type, "int") != 0 && strcmp(type, "rational") != 0) {
        const int length = (int)strlen(text) / 2;
        for (int i = 0; i < length; i++) {
            const char digits[3] = {text[2 * i], text[2 * i + 1], 0};
            out[i] = (unsigned char)strtoul(digits, NULL, 16);
        }
        return length;
    }
    if (strcmp(type, "float") == 0)
        memcpy(out, &single, 4);
    else
        put_bytes(out, 4, (unsigned long long)atoll(text));
    if (strcmp(type, "rational") == 0) put_bytes(out + 4, 4, (unsigned long long)atoll(slash ? slash + 1 : "1"));
    return strcmp(type, "rational") == 0 ? 8 : 4;
}

/* Where the header's last byte, a 0, is; or, where there is one of this name, the size of an attribute, before its value. */
static size_t header_end(const unsigned char *file, const char *name) {
    size_t at = 8;
    while (file[at]) {
        const bool found = name && strcmp((const char *)file + at, name) == 0;
        at += strlen((const char *)file + at) + 1;
        at += strlen((const char *)file + at) + 1;
        if (found) return at;
        at += 4 + (size_t)get_bytes(file + at, 4);
    }
    return at;
}

static size_t read_file(const char *path, unsigned char *file) {
    FILE *in = fopen(path, "rb");
    if (!in) die("cannot read", path);
    const size_t size = fread(file, 1, LARGEST_EXR - 4096, in);
    fclose(in);
    return size;
}

static int hex(int count, char **word) {
    static unsigned char file[LARGEST_EXR];
    if (count < 2) die("hex", "too few arguments");
    read_file(word[0], file);
    const size_t at = header_end(file, word[1]);
    if (!file[at] && at == header_end(file, NULL)) die("no attribute", word[1]);
    for (size_t i = 0, size = (size_t)get_bytes(file + at, 4); i < size; i++) printf("%02x", file[at + 4 + i]);
    printf("\n");
    return 0;
}

static int attribute(int count, char **word) {
    static unsigned char file[LARGEST_EXR], made[LARGEST_EXR];
    if (count < 4) die("attribute", "too few arguments");
    const size_t size = read_file(word[0], file), end = header_end(file, NULL);
    unsigned char *out = made + end;
    memcpy(made, file, end);
    out += strlen(strcpy((char *)out, word[1])) + 1;
    out += strlen(strcpy((char *)out, word[2])) + 1;
    const int length = encode(word[2], word[3], out + 4);
    put_bytes(out, 4, (unsigned long long)length);
    out += 4 + length;
    const size_t more = (size_t)(out - made) - end;
    memcpy(out, file + end, size - end);
    /* the table of chunks, up to the first of them, says where each lies in the file */
    const size_t first = (size_t)get_bytes(file + end + 1, 8);
    for (size_t at = end + 1; at < first; at += 8)
        put_bytes(made + at + more, 8, get_bytes(file + at, 8) + more);
    FILE *written = fopen(word[0], "wb");
    if (!written || fwrite(made, 1, size + more, written) != size + more) die("cannot write", word[0]);
    return fclose(written);
}

/* ------------------------------------------------------------------------- large pictures */

/* A row at a time, so that the picture may be larger than memory. */
static int rows(int count, char **word) {
    static const char names[] = "ABGRZ";
    static const char *const patterns[] = {"1", "noise", "noise", "noise", "ramp:1:20"};
    enum { CHANNELS = 5, REPEAT = 61 };
    if (count < 4) die("rows", "too few arguments");
    const io_type type = strcmp(word[3], "half") == 0 ? IO_HALF : IO_FLOAT;
    const int width = atoi(word[1]), height = atoi(word[2]);
    const size_t size = (size_t)width * io_type_size(type), row = size * CHANNELS;
    io_picture *made;
    io_error error = {0};
    static const char *const columns[] = {"A", "B", "G", "R", "Z"};
    if (io_create(&made, IO_EXR, width, REPEAT, columns, CHANNELS, type, 0, IO_DATA, &error)) die("create", error.text);
    for (int c = 0; c < CHANNELS; c++) {
        char pattern[16];
        snprintf(pattern, sizeof pattern, "%s", patterns[c]);
        fill(&made->part[0].channel[c], pattern);
    }
    FILE *file = create_file(word[0]);
    put_header(file, names, type == IO_HALF, false, word[1], word[2]);
    const uint64_t first = (uint64_t)ftell(file) + 8 * (uint64_t)height;
    for (uint64_t y = 0, at = first; y < (uint64_t)height; y++, at += row + 8) {
        put_int(file, (int)(uint32_t)at);
        put_int(file, (int)(uint32_t)(at >> 32));
    }
    for (int y = 0; y < height; y++) {
        put_int(file, y);
        put_int(file, (int)row);
        for (int c = 0; c < CHANNELS; c++)
            fwrite((char *)made->part[0].channel[c].data + (size_t)(y % REPEAT) * size, 1, size, file);
    }
    io_close(&made);
    return ferror(file) | fclose(file);
}

/* ------------------------------------------------------------------------- JSON */

static int json(int count, char **key) {
    static char text[1 << 20];
    size_t size = fread(text, 1, sizeof text - 1, stdin);
    cJSON *root = cJSON_ParseWithLengthOpts(text, size + 1, NULL, true);
    if (!cJSON_IsObject(root)) die("not one JSON object", text);
    for (int i = 0; i < count; i++) {
        const cJSON *item = root;
        for (char *step = strtok(key[i], "."); step && item; step = strtok(NULL, "."))
            item = cJSON_IsArray(item) ? cJSON_GetArrayItem(item, atoi(step))
                                       : cJSON_GetObjectItemCaseSensitive(item, step);
        if (!item) die("no member", key[i]);
        char *shown = cJSON_PrintUnformatted(item);
        puts(cJSON_IsString(item) ? item->valuestring : shown);
        cJSON_free(shown);
    }
    cJSON_Delete(root);
    return 0;
}

int main(int count, char **word) {
    if (count < 2) return 2;
    const char *what = word[1];
    count -= 2;
    word += 2;
    if (strcmp(what, "make") == 0) return make(count, word);
    if (strcmp(what, "value") == 0) return look(count, word, false, IO_COLOR);
    if (strcmp(what, "data") == 0) return look(count, word, false, IO_DATA);
    if (strcmp(what, "range") == 0) return look(count, word, true, IO_COLOR);
    if (strcmp(what, "same") == 0) return same(count, word);
    if (strcmp(what, "tile") == 0) return tile(count, word);
    if (strcmp(what, "header") == 0) return header(count, word, false);
    if (strcmp(what, "deep") == 0) return header(count, word, true);
    if (strcmp(what, "hex") == 0) return hex(count, word);
    if (strcmp(what, "attribute") == 0) return attribute(count, word);
    if (strcmp(what, "rows") == 0) return rows(count, word);
    if (strcmp(what, "json") == 0) return json(count, word);
    return die("unknown", what);
}
