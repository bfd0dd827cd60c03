/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "tiff_ifd.h"

enum {
    TAG_STRIP_OFFSETS = 273,
    TAG_STRIP_BYTES = 279,
    TAG_TILE_OFFSETS = 324,
    TAG_TILE_BYTES = 325,
    TAG_SUB_IFD = 330,
    TAG_OLD_JPEG = 513,
    TAG_EXIF = 34665,
    TAG_GPS = 34853,
    TAG_INTEROPERABILITY = 40965,
    TYPE_LONG = 4,
    TYPE_LONG8 = 16,
    MOST_PAGES = 10000,
    DEEPEST = 4
};

static const uint8_t type_size[] = {0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8};

/* ------------------------------------------------------------------------- numbers */

static uint64_t get(const io_ifd_file *file, const unsigned char *p, int size) {
    uint64_t value = 0;
    for (int i = 0; i < size; i++)
        value = value << 8 | p[file->big_endian ? i : size - 1 - i];
    return value;
}

static void put(const io_ifd_file *file, unsigned char *p, int size, uint64_t value) {
    for (int i = 0; i < size; i++)
        p[file->big_endian ? size - 1 - i : i] = (unsigned char)(value >> (8 * i));
}

static int read_at(io_ifd_file *file, uint64_t offset, void *out, size_t size) {
    if (offset > file->length || size > file->length - offset) return -1;
    return fseeko(file->file, (off_t)offset, SEEK_SET) == 0 && fread(out, 1, size, file->file) == size ? 0 : -1;
}

static int write_end(io_ifd_file *file, const void *bytes, size_t size) {
    if (size > 0 && fwrite(bytes, 1, size, file->file) != size) return -1;
    file->length += size;
    return 0;
}

/* Directories and values begin at even offsets. */
static int align(io_ifd_file *file) {
    return file->length % 2 == 0 ? 0 : write_end(file, "", 1);
}

static int pointer_size(const io_ifd_file *file) {
    return file->big_tiff ? 8 : 4;
}

/* An element of an entry that holds whole numbers. */
static bool element(const io_ifd_file *file, const io_ifd_entry *entry, uint64_t index, uint64_t *value) {
    const int size = type_size[entry->type];
    const bool whole = entry->type == 3 || entry->type == TYPE_LONG || entry->type == 13 || entry->type == TYPE_LONG8 ||
                       entry->type == 18;
    if (!whole || index >= entry->count) return false;
    *value = get(file, entry->value + index * (uint64_t)size, size);
    return true;
}

/* ------------------------------------------------------------------------- reading */

int io_ifd_header(io_ifd_file *file, uint64_t *first) {
    unsigned char head[16];
    if (read_at(file, 0, head, 8) < 0) return -1;
    if (memcmp(head, "II", 2) != 0 && memcmp(head, "MM", 2) != 0) return -1;
    file->big_endian = head[0] == 'M';
    const uint64_t version = get(file, head + 2, 2);
    if (version != 42 && version != 43) return -1;
    file->big_tiff = version == 43;
    if (file->big_tiff && (read_at(file, 0, head, 16) < 0 || get(file, head + 4, 2) != 8)) return -1;
    *first = file->big_tiff ? get(file, head + 8, 8) : get(file, head + 4, 4);
    return 0;
}

uint64_t io_ifd_first_field(const io_ifd_file *file) {
    return file->big_tiff ? 8 : 4;
}

/* Number of entries, and where they and the pointer to the next directory lie. */
static int read_frame(io_ifd_file *file, uint64_t offset, uint64_t *count, uint64_t *entries, uint64_t *next) {
    unsigned char number[8];
    const int count_size = file->big_tiff ? 8 : 2, entry_size = file->big_tiff ? 20 : 12;
    if (offset == 0 || read_at(file, offset, number, (size_t)count_size) < 0) return -1;
    *count = get(file, number, count_size);
    if (*count == 0 || *count > 65535) return -1;
    *entries = offset + (uint64_t)count_size;
    if (read_at(file, *entries + *count * (uint64_t)entry_size, number, (size_t)pointer_size(file)) < 0) return -1;
    *next = get(file, number, pointer_size(file));
    return 0;
}

int io_ifd_next(io_ifd_file *file, uint64_t offset, uint64_t *next) {
    uint64_t count, entries;
    return read_frame(file, offset, &count, &entries, next);
}

int io_ifd_count_next(io_ifd_file *file, uint64_t first, bool *all) {
    uint64_t *seen = malloc(sizeof *seen * MOST_PAGES), count, entries, next;
    file->no_memory |= seen == NULL;
    uint64_t offset = first;
    int pages = 0;
    for (; seen != NULL && offset != 0 && pages < MOST_PAGES; offset = next) {
        bool again = false;
        for (int i = 0; i < pages && !again; i++)
            again = seen[i] == offset;
        if (again || read_frame(file, offset, &count, &entries, &next) < 0) break;
        seen[pages++] = offset;
    }
    *all = offset == 0;
    free(seen);
    return pages > 0 ? pages - 1 : 0;
}

static void free_entry(io_ifd_entry *entry) {
    free(entry->value);
    if (entry->child != NULL) io_ifd_free(entry->child);
    free(entry->child);
}

void io_ifd_free(io_ifd *ifd) {
    for (int i = 0; i < ifd->count; i++)
        free_entry(&ifd->entry[i]);
    free(ifd->entry);
    *ifd = (io_ifd){0};
}

io_ifd_entry *io_ifd_find(const io_ifd *ifd, uint16_t tag) {
    for (int i = 0; i < ifd->count; i++)
        if (ifd->entry[i].tag == tag) return &ifd->entry[i];
    return NULL;
}

static int by_tag(const void *a, const void *b) {
    return (int)((const io_ifd_entry *)a)->tag - (int)((const io_ifd_entry *)b)->tag;
}

static void sort_and_drop_doubles(io_ifd *ifd) {
    int kept = 0;
    qsort(ifd->entry, (size_t)ifd->count, sizeof *ifd->entry, by_tag);
    for (int i = 0; i < ifd->count; i++) {
        if (kept > 0 && ifd->entry[i].tag == ifd->entry[kept - 1].tag)
            free_entry(&ifd->entry[i]);
        else
            ifd->entry[kept++] = ifd->entry[i];
    }
    ifd->count = kept;
}

static int read_directory(io_ifd_file *file, uint64_t offset, bool (*wanted)(uint16_t tag), io_ifd *ifd, int depth,
                          uint64_t *budget);

/* One entry; 1: it cannot be kept. */
static int read_entry(io_ifd_file *file, const unsigned char *raw, io_ifd_entry *entry, int depth, uint64_t *budget) {
    const int pointer = pointer_size(file);
    const unsigned char *field = raw + 4 + pointer;
    *entry = (io_ifd_entry){.tag = (uint16_t)get(file, raw, 2), .type = (uint16_t)get(file, raw + 2, 2)};
    entry->count = get(file, raw + 4, pointer);
    const uint64_t size = entry->type < sizeof type_size ? type_size[entry->type] : 0;
    /* Entries may point to the same bytes; all of them together cannot be more than an honest file holds. */
    if (size == 0 || entry->count == 0 || entry->count > *budget / size) return 1;
    entry->size = (size_t)(entry->count * size);
    entry->value = malloc(entry->size);
    if (entry->value == NULL) {
        file->no_memory = true;
        return 1;
    }
    if (entry->size <= (size_t)pointer)
        memcpy(entry->value, field, entry->size);
    else if (read_at(file, get(file, field, pointer), entry->value, entry->size) < 0)
        goto lost;
    *budget -= entry->size;
    if (entry->tag == TAG_EXIF || entry->tag == TAG_GPS || entry->tag == TAG_INTEROPERABILITY) {
        uint64_t child;
        entry->child = calloc(1, sizeof *entry->child);
        file->no_memory |= entry->child == NULL;
        if (entry->child == NULL || depth >= DEEPEST || !element(file, entry, 0, &child) ||
            read_directory(file, child, NULL, entry->child, depth + 1, budget) < 0)
            goto lost;
    }
    return 0;
lost:
    free(entry->child);
    free(entry->value);
    return 1;
}

static int read_directory(io_ifd_file *file, uint64_t offset, bool (*wanted)(uint16_t tag), io_ifd *ifd, int depth,
                          uint64_t *budget) {
    const int entry_size = file->big_tiff ? 20 : 12;
    uint64_t count, entries;
    *ifd = (io_ifd){0};
    if (read_frame(file, offset, &count, &entries, &ifd->next) < 0) return -1;
    unsigned char *raw = malloc((size_t)count * (size_t)entry_size);
    ifd->entry = malloc(sizeof *ifd->entry * (size_t)count);
    file->no_memory |= raw == NULL || ifd->entry == NULL;
    if (raw == NULL || ifd->entry == NULL || read_at(file, entries, raw, (size_t)count * (size_t)entry_size) < 0) {
        free(raw);
        io_ifd_free(ifd);
        return -1;
    }
    for (uint64_t i = 0; i < count; i++) {
        const unsigned char *p = raw + i * (uint64_t)entry_size;
        const uint16_t tag = (uint16_t)get(file, p, 2);
        if (wanted != NULL && !wanted(tag)) continue;
        if (read_entry(file, p, &ifd->entry[ifd->count], depth, budget) == 0) {
            ifd->lost |= ifd->entry[ifd->count].child != NULL && ifd->entry[ifd->count].child->lost;
            ifd->count++;
        } else {
            ifd->lost = true;
        }
    }
    free(raw);
    sort_and_drop_doubles(ifd);
    return 0;
}

int io_ifd_read(io_ifd_file *file, uint64_t offset, bool (*wanted)(uint16_t tag), io_ifd *ifd) {
    uint64_t budget = file->length;
    return read_directory(file, offset, wanted, ifd, 0, &budget);
}

/* ------------------------------------------------------------------------- writing */

int io_ifd_link(io_ifd_file *file, uint64_t field, uint64_t offset) {
    unsigned char bytes[8];
    const int size = pointer_size(file);
    if (!file->big_tiff && offset > UINT32_MAX) return -1;
    put(file, bytes, size, offset);
    return fseeko(file->file, (off_t)field, SEEK_SET) == 0 && fwrite(bytes, 1, (size_t)size, file->file) == (size_t)size
               ? 0
               : -1;
}

/* The value's bytes go to the end of the file when they do not fit into the entry. */
static int append_value(io_ifd_file *file, const io_ifd_entry *entry, unsigned char *out) {
    const int pointer = pointer_size(file);
    uint64_t offset, unused;
    put(file, out, 2, entry->tag);
    put(file, out + 2, 2, entry->child != NULL ? (file->big_tiff ? 18 : TYPE_LONG) : entry->type);
    put(file, out + 4, pointer, entry->count);
    if (entry->child != NULL) {
        if (io_ifd_append(file, entry->child, &offset, &unused) < 0) return -1;
        put(file, out + 4, pointer, 1);
    } else if (entry->size <= (size_t)pointer) {
        memcpy(out + 4 + pointer, entry->value, entry->size);
        return 0;
    } else {
        if (align(file) < 0) return -1;
        offset = file->length;
        if (write_end(file, entry->value, entry->size) < 0) return -1;
    }
    put(file, out + 4 + pointer, pointer, offset);
    return 0;
}

int io_ifd_append(io_ifd_file *file, const io_ifd *ifd, uint64_t *offset, uint64_t *next_field) {
    const int count_size = file->big_tiff ? 8 : 2, entry_size = file->big_tiff ? 20 : 12;
    const size_t size = (size_t)count_size + (size_t)ifd->count * (size_t)entry_size + (size_t)pointer_size(file);
    unsigned char *table = calloc(1, size);
    int status = table == NULL || fseeko(file->file, (off_t)file->length, SEEK_SET) != 0 ? -1 : 0;
    if (status == 0) put(file, table, count_size, (uint64_t)ifd->count);
    for (int i = 0; i < ifd->count && status == 0; i++)
        status = append_value(file, &ifd->entry[i], table + count_size + i * entry_size);
    if (status == 0) status = align(file);
    *offset = file->length;
    *next_field = file->length + size - (size_t)pointer_size(file);
    if (status == 0) status = write_end(file, table, size);
    free(table);
    if (status == 0 && !file->big_tiff && file->length > UINT32_MAX) {
        errno = EFBIG;
        status = -1;
    }
    return status;
}

/* ------------------------------------------------------------------------- pages */

static int copy_bytes(io_ifd_file *from, uint64_t offset, uint64_t size, io_ifd_file *to) {
    static const size_t most = 1 << 16;
    unsigned char *buffer = malloc(most);
    int status = buffer == NULL || fseeko(to->file, (off_t)to->length, SEEK_SET) != 0 ? -1 : align(to);
    while (size > 0 && status == 0) {
        const size_t piece = size < most ? (size_t)size : most;
        status = read_at(from, offset, buffer, piece) < 0 ? 1 : write_end(to, buffer, piece);
        offset += piece;
        size -= piece;
    }
    free(buffer);
    return status;
}

/* Gives an entry new values: offsets in the other file. */
static int replace(const io_ifd_file *to, io_ifd_entry *entry, const uint64_t *values) {
    const int size = pointer_size(to);
    unsigned char *bytes = malloc((size_t)entry->count * (size_t)size);
    if (bytes == NULL) return -1;
    for (uint64_t i = 0; i < entry->count; i++)
        put(to, bytes + i * (uint64_t)size, size, values[i]);
    free(entry->value);
    entry->value = bytes;
    entry->size = (size_t)entry->count * (size_t)size;
    entry->type = to->big_tiff ? TYPE_LONG8 : TYPE_LONG;
    return 0;
}

static int copy_directory(io_ifd_file *from, uint64_t at, io_ifd_file *to, uint64_t *offset, uint64_t *next_field,
                          int depth, uint64_t *budget);

/* The strips or tiles that `entry` points to (`sizes` their bytes), or sub-directories (sizes NULL). */
static int copy_targets(io_ifd_file *from, io_ifd_file *to, io_ifd_entry *entry, const io_ifd_entry *sizes, int depth,
                        uint64_t *budget) {
    uint64_t *moved = calloc((size_t)entry->count, sizeof *moved), unused;
    int status = moved == NULL ? -1 : 0;
    for (uint64_t i = 0; i < entry->count && status == 0; i++) {
        uint64_t offset, size;
        if (!element(from, entry, i, &offset) || (sizes != NULL && !element(from, sizes, i, &size))) {
            status = 1;
        } else if (sizes == NULL) {
            status = depth >= DEEPEST ? 1 : copy_directory(from, offset, to, &moved[i], &unused, depth + 1, budget);
        } else if (size > *budget) {
            status = 1;
        } else if (size > 0) { /* 0: a strip that was never written stays so */
            *budget -= size;
            moved[i] = to->length + to->length % 2;
            status = copy_bytes(from, offset, size, to);
        }
    }
    if (status == 0) status = replace(to, entry, moved);
    free(moved);
    return status;
}

static int copy_directory(io_ifd_file *from, uint64_t at, io_ifd_file *to, uint64_t *offset, uint64_t *next_field,
                          int depth, uint64_t *budget) {
    io_ifd ifd;
    if (read_directory(from, at, NULL, &ifd, depth, budget) < 0) return 1;
    io_ifd_entry *strips = io_ifd_find(&ifd, TAG_STRIP_OFFSETS), *tiles = io_ifd_find(&ifd, TAG_TILE_OFFSETS);
    const io_ifd_entry *strip_bytes = io_ifd_find(&ifd, TAG_STRIP_BYTES),
                       *tile_bytes = io_ifd_find(&ifd, TAG_TILE_BYTES);
    io_ifd_entry *sub = io_ifd_find(&ifd, TAG_SUB_IFD);
    /* Old-style JPEG keeps offsets in more tags than these. */
    int status = ifd.lost || io_ifd_find(&ifd, TAG_OLD_JPEG) != NULL || (strips != NULL && strip_bytes == NULL) ||
                         (tiles != NULL && tile_bytes == NULL)
                     ? 1
                     : 0;
    if (strips != NULL && status == 0) status = copy_targets(from, to, strips, strip_bytes, depth, budget);
    if (tiles != NULL && status == 0) status = copy_targets(from, to, tiles, tile_bytes, depth, budget);
    if (sub != NULL && status == 0) status = copy_targets(from, to, sub, NULL, depth, budget);
    if (status == 0) status = io_ifd_append(to, &ifd, offset, next_field);
    io_ifd_free(&ifd);
    return status;
}

int io_ifd_copy_page(io_ifd_file *from, uint64_t page, io_ifd_file *to, uint64_t *offset, uint64_t *next_field) {
    /* Twice its length: an honest page's tags and pixels together are less than the file. */
    uint64_t budget = 2 * from->length;
    return copy_directory(from, page, to, offset, next_field, 0, &budget);
}
