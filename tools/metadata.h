/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* The lens as a picture's header says it (--metadata). Names that are known: docs/cli.md. */
#ifndef TOOLS_METADATA_H
#define TOOLS_METADATA_H

#include <picture.h>

#include "camera.h"
#include "options.h"

enum { METADATA_ITEMS = 4 };

/* What was found of one option. */
typedef struct metadata_item {
    option_id id;   /* whose place it takes */
    char name[256]; /* of the attribute; "": there is none */
    double number;  /* as in the header */
    bool metres;    /* a focus in metres, else in the depth's unit */
} metadata_item;

typedef struct metadata {
    metadata_item item[METADATA_ITEMS];
} metadata;

/* What `text` (of --metadata; NULL: auto) finds, first in this part, then in all; options that are given are not looked for.
 * `needed`: that nothing is found is an error. Returns 0 or an exit code. */
int metadata_find(metadata *m, const io_picture *picture, int part, const options *o, const char *text, bool needed);

/* Lets it win over what the camera file says. */
void metadata_apply(camera *file, const metadata *m, const options *o);

#endif
