/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* --max-memory: what grows with the picture lies in files instead of in memory. Such a block is a file without a name, in
 * the folder of --scratch, mapped shared: the system brings in the rows that are worked on, and a thread of ours gives back
 * what the process holds of all blocks whenever it comes near the limit. What was given back is in the system's file cache
 * or on the disk, so nothing but time depends on it. The work goes through all of them in the order of rows, down or up,
 * which is what makes it bearable (docs/memory.md).
 *
 * One limit for the process, as there is one of memory. Thread-safety: open and close from the main thread, while no other
 * works; the rest from any. */
#ifndef TOOLS_SCRATCH_H
#define TOOLS_SCRATCH_H

#include <picture.h>

#include "options.h"

/* Reads --max-memory and --scratch; nothing is in files yet. `frames`: pictures worked on at a time. Returns 0 or an exit
 * code. */
int scratch_open(const options *o, int frames);
/* After all blocks were released. */
void scratch_close(void);

/* From here on large blocks are files, of which `bytes` in all are expected. May be said again. Returns 0 or an exit code. */
int scratch_stream(uint64_t bytes);
bool scratch_streams(void);

/* Of --max-memory, and no more than most of what the machine has; 0: none was given. */
uint64_t scratch_limit(void);
/* How much of the limit the process may hold before blocks are given back; the rest is for what happens meanwhile. */
uint64_t scratch_threshold(uint64_t limit);
/* What the process held at scratch_open(), before any picture. */
uint64_t scratch_base(void);
int scratch_frames(void);

/* Zeroed, aligned to 64 bytes; NULL: scratch_error() says why. Without --max-memory it is plain memory. */
void *scratch_allocate(size_t bytes);
void scratch_release(void *block);
/* One line about the last allocation that failed in this thread; "". */
const char *scratch_error(void);

/* The same for io/; NULL without --max-memory. */
const io_memory *scratch_memory(void);

/* Gives blocks back if that is due. Cheap: may be called for every few rows. */
void scratch_pace(void);

#endif
