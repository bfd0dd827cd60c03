/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Machines without libvulkan, with an old one, with one that finds no driver or no device: this program's dlopen() and
 * dlsym() are the ones the library gets. */
#include "../gpu/support.h"

#include <ddof/vulkan.h>

#include <string.h>

static struct {
    bool library, version, incompatible, instance_fails;
    const char *hidden; /* a function */
    int instances;
} here;

void *dlopen(const char *file, int mode);
void *dlsym(void *handle, const char *name);

void *dlopen(const char *file, int mode) {
    (void)mode;
    return here.library && strstr(file, "vulkan") ? &here : NULL;
}

static VKAPI_ATTR VkResult VKAPI_CALL instance_version(uint32_t *version) {
    *version = VK_API_VERSION_1_3;
    return VK_SUCCESS;
}

static VKAPI_ATTR VkResult VKAPI_CALL no_extensions(const char *layer, uint32_t *count, VkExtensionProperties *all) {
    (void)layer, (void)all;
    *count = 0;
    return VK_SUCCESS;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_instance(const VkInstanceCreateInfo *info,
                                                      const VkAllocationCallbacks *allocator, VkInstance *made) {
    (void)info, (void)allocator;
    if (here.instance_fails) return VK_ERROR_OUT_OF_HOST_MEMORY;
    if (here.incompatible) return VK_ERROR_INCOMPATIBLE_DRIVER;
    *made = (VkInstance)(void *)&here;
    here.instances++;
    return VK_SUCCESS;
}

static VKAPI_ATTR void VKAPI_CALL destroy_instance(VkInstance made, const VkAllocationCallbacks *allocator) {
    (void)allocator;
    assert_ptr_equal(made, &here);
    here.instances--;
}

static VKAPI_ATTR VkResult VKAPI_CALL no_devices(VkInstance instance, uint32_t *count, VkPhysicalDevice *all) {
    (void)instance, (void)all;
    *count = 0;
    return VK_SUCCESS;
}

/* Of the functions of devices, which there are none of. */
static VKAPI_ATTR void VKAPI_CALL never(void) {
    fail_msg("a function of a device was called");
}

static PFN_vkVoidFunction VKAPI_PTR find(VkInstance instance, const char *name) {
    (void)instance;
    if (here.hidden && !strcmp(name, here.hidden)) return NULL;
    if (!strcmp(name, "vkEnumerateInstanceVersion")) return here.version ? (PFN_vkVoidFunction)instance_version : NULL;
    if (!strcmp(name, "vkEnumerateInstanceExtensionProperties")) return (PFN_vkVoidFunction)no_extensions;
    if (!strcmp(name, "vkCreateInstance")) return (PFN_vkVoidFunction)create_instance;
    if (!strcmp(name, "vkDestroyInstance")) return (PFN_vkVoidFunction)destroy_instance;
    if (!strcmp(name, "vkEnumeratePhysicalDevices")) return (PFN_vkVoidFunction)no_devices;
    return (PFN_vkVoidFunction)never;
}

void *dlsym(void *handle, const char *name) {
    PFN_vkGetInstanceProcAddr function = find;
    void *symbol;
    if (handle != &here || strcmp(name, "vkGetInstanceProcAddr")) return NULL;
    memcpy(&symbol, &function, sizeof symbol);
    return symbol;
}

static char said[300];
static int times;

static void keep(void *user, ddof_log_level level, const char *text) {
    (void)user;
    assert_int_equal(level, DDOF_LOG_ERROR);
    strncpy(said, text, sizeof said - 1);
    times++;
}

static void says(ddof_status status, const char *part) {
    const ddof_config config = {.backend = DDOF_BACKEND_VULKAN, .log = keep};
    ddof_context *ctx = (ddof_context *)said;
    ddof_device device;
    times = 0;
    assert_int_equal(ddof_create(&ctx, &config), status);
    assert_null(ctx);
    assert_int_equal(times, 1);
    if (!strstr(said, part)) fail_msg("\"%s\" says nothing of \"%s\"", said, part);
    assert_int_equal(ddof_devices(DDOF_BACKEND_VULKAN, &device, 1), 0);
    assert_int_equal(here.instances, 0);
}

static void no_library(void **state) {
    (void)state;
    memset(&here, 0, sizeof here);
    says(DDOF_ERROR_UNSUPPORTED, "libvulkan.so.1");
}

static void old_library(void **state) {
    (void)state;
    memset(&here, 0, sizeof here);
    here.library = true;
    says(DDOF_ERROR_UNSUPPORTED, "1.1");
}

static void no_driver(void **state) {
    (void)state;
    memset(&here, 0, sizeof here);
    here.library = here.version = here.incompatible = true;
    says(DDOF_ERROR_UNSUPPORTED, "driver");
}

static void no_memory(void **state) {
    (void)state;
    memset(&here, 0, sizeof here);
    here.library = here.version = here.instance_fails = true;
    says(DDOF_ERROR_MEMORY, "");
}

static void no_device(void **state) {
    (void)state;
    memset(&here, 0, sizeof here);
    here.library = here.version = true;
    says(DDOF_ERROR_UNSUPPORTED, "device");
}

static void no_function(void **state) {
    (void)state;
    memset(&here, 0, sizeof here);
    here.library = here.version = true;
    here.hidden = "vkGetPhysicalDeviceFeatures2";
    says(DDOF_ERROR_UNSUPPORTED, "vkGetPhysicalDeviceFeatures2");
}

/* The other backends do not need it. */
static void others_work(void **state) {
    (void)state;
    ddof_context *ctx = NULL;
    memset(&here, 0, sizeof here);
    assert_int_equal(ddof_create(&ctx, NULL), DDOF_OK);
    DESTROY(ctx);
}

int main(void) {
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_library),  cmocka_unit_test(old_library), cmocka_unit_test(no_driver),
        cmocka_unit_test(no_memory),   cmocka_unit_test(no_device),   cmocka_unit_test(no_function),
        cmocka_unit_test(others_work),
    };
    return run_gpu_tests("vulkan absent", tests, COUNT(tests), NULL);
}
