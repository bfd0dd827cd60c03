/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Inside io/tiff*.c only: the directories (IFD) of a TIFF as bytes. libtiff knows the meaning of some tags, rounds
 * fractions to floats and drops what it does not know; a picture's metadata should come back as it was. So libtiff does
 * the pixels, and all tags that are not about how pixels lie in the file are carried over as they are. */
#ifndef IO_TIFF_IFD_H
#define IO_TIFF_IFD_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

typedef struct io_ifd_file {
    FILE *file;
    uint64_t length;
    bool big_endian, big_tiff;
    bool no_memory; /* something could not be kept for want of it */
} io_ifd_file;

typedef struct io_ifd_entry {
    uint16_t tag, type;
    uint64_t count;
    size_t size;          /* of the value in bytes */
    unsigned char *value; /* in the byte order of the file */
    struct io_ifd *child; /* EXIF, GPS, interoperability: the directory that the value points to; else NULL */
} io_ifd_entry;

typedef struct io_ifd {
    int count;
    io_ifd_entry *entry;
    uint64_t next; /* offset of the next page's directory, 0: none */
    bool lost;     /* something in it could not be read and is left out */
} io_ifd;

/* Byte order, variant and the offset of the first directory. -1: no TIFF. */
int io_ifd_header(io_ifd_file *file, uint64_t *first);

/* Reads a directory; `wanted` (NULL: all) says which tags. -1: damaged or out of memory. */
int io_ifd_read(io_ifd_file *file, uint64_t offset, bool (*wanted)(uint16_t tag), io_ifd *ifd);
void io_ifd_free(io_ifd *ifd);
io_ifd_entry *io_ifd_find(const io_ifd *ifd, uint16_t tag);

/* How many directories follow the one at `first`. all: false when there is more, but damaged, a ring, or too many. */
int io_ifd_count_next(io_ifd_file *file, uint64_t first, bool *all);

/* The directory after the one at `offset`, 0: none. -1: damaged. */
int io_ifd_next(io_ifd_file *file, uint64_t offset, uint64_t *next);

/* Appends a directory with its children; *next_field is where its pointer to the next page lies. -1: cannot be written.
 */
int io_ifd_append(io_ifd_file *file, const io_ifd *ifd, uint64_t *offset, uint64_t *next_field);
/* Writes a pointer to a directory. */
int io_ifd_link(io_ifd_file *file, uint64_t field, uint64_t offset);
/* Where the header points to the first directory. */
uint64_t io_ifd_first_field(const io_ifd_file *file);

/* Copies a page with its pixels, as they are, from a file of the same byte order; gives what io_ifd_append gives.
 * 1: the page is damaged and was not copied; -1: cannot be written. */
int io_ifd_copy_page(io_ifd_file *from, uint64_t page, io_ifd_file *to, uint64_t *offset, uint64_t *next_field);

#endif
