/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Camera files: the scene.json that a renderer's script leaves beside its pictures. Format: docs/cli.md. */
#ifndef TOOLS_CAMERA_H
#define TOOLS_CAMERA_H

#include <ddof/ddof.h>
#include <stdbool.h>

/* What the file says; 0 and "" for what it does not say. */
typedef struct camera {
    double focal_length; /* millimetres */
    double sensor_width; /* millimetres */
    double f_number;
    double focus_distance; /* millimetres */
    double unit;           /* millimetres in one scene unit */
    bool has_depth_kind;
    ddof_depth_kind depth_kind;
    double z_at_0, z_at_1; /* of that kind, in the depth's unit; a picture may say it, a camera file does not */
    char depth_channel[256];
    char entry[256]; /* the name of the entry of "renders" that f-number and focus came from */
} camera;

/* `input`: the picture to be rendered, whose name and number choose the entry; `entry`: its name, or NULL.
 * Returns 0 or an exit code. */
int camera_read(camera *result, const char *path, const char *entry, const char *input);

#endif
