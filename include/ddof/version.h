/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */
#ifndef DDOF_VERSION_H
#define DDOF_VERSION_H

/* The one place of the version: meson.build, the man page and `ddof --version` read it here. */
#define DDOF_VERSION_MAJOR 0
#define DDOF_VERSION_MINOR 1
#define DDOF_VERSION_PATCH 0
#define DDOF_VERSION_STRING "0.1.0"

#endif
