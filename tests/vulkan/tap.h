/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Between the library and Vulkan: counts what is made and destroyed, makes calls fail, hides functions, and lies about
 * the device. */
#ifndef TESTS_VULKAN_TAP_H
#define TESTS_VULKAN_TAP_H

#include "own.h"

typedef struct vulkan_tap {
    int live;           /* objects made and not destroyed, memory too */
    int calls;          /* of functions that make, allocate or bind */
    int dispatches;     /* recorded */
    int fail_at;        /* the one of `calls` that fails; 0: none */
    VkResult fail_with; /* so */
    int waits, wait_at; /* submissions and waits for them; the one that fails with fail_with, 0: none */
    const char *hidden; /* a function that is not there */
    char untapped[80];  /* a function of the kinds that are counted here, which the library asked for but is not */

    /* ---- lies */
    uint32_t api_version; /* of the device */
    uint32_t invocations; /* that a workgroup may have at most */
    uint32_t shared_bytes;
    bool no_compute, no_graphics;         /* in any queue family */
    bool no_shuffle, no_compute_subgroup; /* operations of subgroups; in compute shaders */
    bool no_required_size;                /* of a subgroup, in compute shaders */
    uint32_t subgroup; /* the one size it has: the shader with subgroups gets its shuffles through shared memory */
    VkFormat no_storage, no_sampling, no_blending; /* format without the feature */
    uint32_t max_side, buffer_range;
} vulkan_tap;
extern vulkan_tap tap;

/* All names that were asked for since tap_forget(). */
enum { TAP_NAMES = 160 };
extern const char *tap_names[TAP_NAMES];
extern int tap_name_count;
void tap_forget(void); /* zeroes the tap; objects that live stay counted */

PFN_vkVoidFunction VKAPI_PTR tap_get_instance_proc_addr(VkInstance instance, const char *name);

/* What stands for the function `real` called so: itself, where nothing is tapped. */
PFN_vkVoidFunction tap_function(const char *name, PFN_vkVoidFunction real);

/* Callbacks of Vulkan that count: allocations, and those that live. */
typedef struct host_memory {
    int allocations, live;
} host_memory;
VkAllocationCallbacks host_callbacks(host_memory *memory);

/* What ddof_vulkan_create() said when it failed. */
extern char said[600];

/* The device of own.h, with the tap in between and all features that were enabled. */
ddof_vulkan_config tap_config(void);
ddof_status try_create(ddof_vulkan **vk); /* with the tap as it is */
ddof_vulkan *create(void);                /* with the tap cleared; must succeed */
void destroy(ddof_vulkan **vk);           /* nothing that it made may live on */

#endif
