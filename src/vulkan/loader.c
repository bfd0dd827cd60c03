/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* Nothing is shared between sessions but the loader itself, which may be called from several threads. */
#include "loader.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_DEVICES = 16, MOST_FAMILIES = 32 };

#define INSTANCE_FUNCTIONS(X)                                                                                          \
    X(CreateDevice)                                                                                                    \
    X(DestroyInstance)                                                                                                 \
    X(EnumerateDeviceExtensionProperties)                                                                              \
    X(EnumeratePhysicalDevices)                                                                                        \
    X(GetDeviceProcAddr)                                                                                               \
    X(GetPhysicalDeviceFeatures2)                                                                                      \
    X(GetPhysicalDeviceMemoryProperties)                                                                               \
    X(GetPhysicalDeviceProperties)                                                                                     \
    X(GetPhysicalDeviceProperties2)                                                                                    \
    X(GetPhysicalDeviceQueueFamilyProperties)

/* An instance without a device. */
typedef struct instance {
    void *library;
    PFN_vkGetInstanceProcAddr get;
    VkInstance handle;
    uint32_t version; /* what may be used of it, at most 1.3 */
#define X(name) PFN_vk##name name;
    INSTANCE_FUNCTIONS(X)
#undef X
} instance;

typedef struct candidate {
    VkPhysicalDevice gpu;
    VkPhysicalDeviceType type;
    uint32_t version, family;
    bool synchronization2, subgroup_size, driver, portability;          /* extensions */
    VkBool32 write_without_format, geometry, synchronized, sized, full; /* features */
    ddof_device shown;
} candidate;

/* ---- the instance */

static bool load(instance *in, char *text, size_t size) {
    in->library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
    void *symbol = in->library ? dlsym(in->library, "vkGetInstanceProcAddr") : NULL;
    memcpy(&in->get, &symbol, sizeof symbol); /* ISO C has no such conversion; POSIX says that they look alike */
    if (symbol) return true;
    snprintf(text, size, "the Vulkan backend needs libvulkan.so.1, which is not installed (Debian: libvulkan1)");
    return false;
}

/* Drivers that implement most of Vulkan on top of another API are only shown to those who ask. */
static bool has_portability(const instance *in) {
    static const char name[] = VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME;
    PFN_vkEnumerateInstanceExtensionProperties enumerate =
        (PFN_vkEnumerateInstanceExtensionProperties)in->get(NULL, "vkEnumerateInstanceExtensionProperties");
    VkExtensionProperties have[64];
    uint32_t count = sizeof have / sizeof *have;
    if (!enumerate || enumerate(NULL, &count, have) < 0) return false;
    for (uint32_t i = 0; i < count; i++)
        if (!strcmp(have[i].extensionName, name)) return true;
    return false;
}

static void close_instance(instance *in) {
    if (in->handle && in->DestroyInstance) in->DestroyInstance(in->handle, NULL);
    in->handle = NULL;
}

static ddof_status create_instance(instance *in, char *text, size_t size) {
    static const char *const portability = VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME;
    PFN_vkEnumerateInstanceVersion version =
        (PFN_vkEnumerateInstanceVersion)in->get(NULL, "vkEnumerateInstanceVersion");
    PFN_vkCreateInstance create = (PFN_vkCreateInstance)in->get(NULL, "vkCreateInstance");
    if (!create || !version || version(&in->version) != VK_SUCCESS) {
        snprintf(text, size, "this libvulkan.so.1 is too old for the Vulkan backend: Vulkan 1.1 is needed");
        return DDOF_ERROR_UNSUPPORTED;
    }
    if (in->version > VK_API_VERSION_1_3) in->version = VK_API_VERSION_1_3;
    const bool ask = has_portability(in);
    const VkApplicationInfo application = {
        .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .pEngineName = "ddof", .apiVersion = in->version};
    const VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                       .flags = ask ? VK_INSTANCE_CREATE_ENUMERATE_PORTABILITY_BIT_KHR : 0,
                                       .pApplicationInfo = &application,
                                       .enabledExtensionCount = ask,
                                       .ppEnabledExtensionNames = &portability};
    const VkResult result = create(&info, NULL, &in->handle);
    if (result == VK_SUCCESS) return DDOF_OK;
    in->handle = NULL;
    if (result == VK_ERROR_INCOMPATIBLE_DRIVER)
        snprintf(text, size,
                 "there is no Vulkan driver on this machine (a software one, on Debian: mesa-vulkan-drivers)");
    else
        snprintf(text, size, "Vulkan cannot be started (VkResult %d)", (int)result);
    if (result == VK_ERROR_OUT_OF_HOST_MEMORY) return DDOF_ERROR_MEMORY;
    return result == VK_ERROR_OUT_OF_DEVICE_MEMORY ? DDOF_ERROR_DEVICE : DDOF_ERROR_UNSUPPORTED;
}

static ddof_status open_instance(instance *in, char *text, size_t size) {
    memset(in, 0, sizeof *in);
    if (!load(in, text, size)) return DDOF_ERROR_UNSUPPORTED;
    ddof_status status = create_instance(in, text, size);
    if (status != DDOF_OK) return status;
    const char *missing = NULL;
#define X(name)                                                                                                        \
    in->name = (PFN_vk##name)in->get(in->handle, "vk" #name);                                                          \
    if (!in->name) missing = "vk" #name;
    INSTANCE_FUNCTIONS(X)
#undef X
    if (!missing) return DDOF_OK;
    snprintf(text, size, "this libvulkan.so.1 has no %s: Vulkan 1.1 is needed", missing);
    close_instance(in);
    return DDOF_ERROR_UNSUPPORTED;
}

/* ---- what a device is */

static int at_most_int(uint64_t v) {
    return v > INT32_MAX ? INT32_MAX : (int)v;
}

static void look_for_extensions(const instance *in, candidate *c) {
    const struct {
        const char *name;
        bool *there;
    } wanted[] = {{VK_KHR_SYNCHRONIZATION_2_EXTENSION_NAME, &c->synchronization2},
                  {VK_EXT_SUBGROUP_SIZE_CONTROL_EXTENSION_NAME, &c->subgroup_size},
                  {VK_KHR_DRIVER_PROPERTIES_EXTENSION_NAME, &c->driver},
                  {"VK_KHR_portability_subset", &c->portability}}; /* its name is in a header of beta extensions */
    uint32_t count = 0;
    if (in->EnumerateDeviceExtensionProperties(c->gpu, NULL, &count, NULL) != VK_SUCCESS) return;
    VkExtensionProperties *have = malloc(count * sizeof *have); /* too many for a small stack; not a context's memory */
    if (!have || in->EnumerateDeviceExtensionProperties(c->gpu, NULL, &count, have) < 0) count = 0;
    for (uint32_t i = 0; i < count; i++)
        for (size_t k = 0; k < sizeof wanted / sizeof *wanted; k++)
            if (!strcmp(have[i].extensionName, wanted[k].name)) *wanted[k].there = true;
    free(have);
}

static bool find_family(const instance *in, candidate *c) {
    VkQueueFamilyProperties family[MOST_FAMILIES];
    uint32_t count = MOST_FAMILIES;
    int best = -1;
    in->GetPhysicalDeviceQueueFamilyProperties(c->gpu, &count, family);
    for (uint32_t i = 0; i < count; i++) {
        if (!(family[i].queueFlags & VK_QUEUE_COMPUTE_BIT) || !family[i].queueCount) continue;
        const int worth =
            2 * ((family[i].queueFlags & VK_QUEUE_GRAPHICS_BIT) != 0) + (family[i].timestampValidBits != 0);
        if (worth <= best) continue;
        c->family = i;
        best = worth;
    }
    return best >= 0;
}

static void look_at_features(const instance *in, candidate *c) {
    VkPhysicalDeviceSubgroupSizeControlFeatures sizes = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES};
    VkPhysicalDeviceSynchronization2Features sync = {.sType =
                                                         VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SYNCHRONIZATION_2_FEATURES};
    VkPhysicalDeviceFeatures2 all = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
    if (c->synchronization2) {
        sync.pNext = all.pNext;
        all.pNext = &sync;
    }
    if (c->subgroup_size) {
        sizes.pNext = all.pNext;
        all.pNext = &sizes;
    }
    in->GetPhysicalDeviceFeatures2(c->gpu, &all);
    c->write_without_format = all.features.shaderStorageImageWriteWithoutFormat;
    c->geometry = all.features.geometryShader;
    c->synchronized = sync.synchronization2;
    c->sized = sizes.subgroupSizeControl;
    c->full = sizes.computeFullSubgroups;
}

/* For people to read, and for the choice of a solver. */
static void show(const instance *in, candidate *c) {
    VkPhysicalDeviceSubgroupSizeControlProperties sizes = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_PROPERTIES};
    VkPhysicalDeviceDriverProperties driver = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
    VkPhysicalDeviceSubgroupProperties subgroup = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
    VkPhysicalDeviceProperties2 all = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &subgroup};
    VkPhysicalDeviceMemoryProperties memory;
    if (c->driver) {
        driver.pNext = all.pNext;
        all.pNext = &driver;
    }
    if (c->subgroup_size) {
        sizes.pNext = all.pNext;
        all.pNext = &sizes;
    }
    in->GetPhysicalDeviceProperties2(c->gpu, &all);
    in->GetPhysicalDeviceMemoryProperties(c->gpu, &memory);
    const VkPhysicalDeviceLimits *limits = &all.properties.limits;
    ddof_device *d = &c->shown;
    snprintf(d->driver, sizeof d->driver, "%.120s%s%.120s", driver.driverName, driver.driverInfo[0] ? " " : "",
             driver.driverInfo);
    d->subgroup_least = at_most_int(c->sized ? sizes.minSubgroupSize : subgroup.subgroupSize);
    d->subgroup_most = at_most_int(c->sized ? sizes.maxSubgroupSize : subgroup.subgroupSize);
    d->max_side = at_most_int(limits->maxImageDimension2D);
    d->max_workgroup = at_most_int(limits->maxComputeWorkGroupInvocations);
    d->shared_bytes = at_most_int(limits->maxComputeSharedMemorySize);
    for (uint32_t i = 0; i < memory.memoryHeapCount; i++)
        if (memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT &&
            memory.memoryHeaps[i].size > d->memory_bytes)
            d->memory_bytes = memory.memoryHeaps[i].size;
}

static candidate look_at(const instance *in, VkPhysicalDevice gpu) {
    candidate c = {.gpu = gpu};
    VkPhysicalDeviceProperties p;
    ddof_device *d = &c.shown;
    in->GetPhysicalDeviceProperties(gpu, &p);
    c.type = p.deviceType;
    c.version = p.apiVersion < in->version ? p.apiVersion : in->version;
    snprintf(d->name, sizeof d->name, "%s", p.deviceName);
    d->is_software = c.type == VK_PHYSICAL_DEVICE_TYPE_CPU;
    if (c.version < VK_API_VERSION_1_1) {
        snprintf(d->refused, sizeof d->refused, "its driver has Vulkan 1.0, but 1.1 is needed");
        return c;
    }
    look_for_extensions(in, &c);
    if (c.version >= VK_API_VERSION_1_2) c.driver = true;
    if (c.version >= VK_API_VERSION_1_3) c.synchronization2 = c.subgroup_size = true;
    look_at_features(in, &c);
    show(in, &c);
    if (!c.synchronized)
        snprintf(d->refused, sizeof d->refused, "its driver lacks synchronization2 (Vulkan 1.3 or %s)",
                 VK_KHR_SYNCHRONIZATION_2_EXTENSION_NAME);
    else if (!c.write_without_format)
        snprintf(d->refused, sizeof d->refused, "it lacks the feature shaderStorageImageWriteWithoutFormat");
    else if (!find_family(in, &c))
        snprintf(d->refused, sizeof d->refused, "it has no queue for compute");
    return c;
}

/* ---- the list */

static int rank(const candidate *c) {
    const int unusable = c->shown.refused[0] ? 10 : 0;
    switch (c->type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
        return unusable;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
        return unusable + 1;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
        return unusable + 2;
    default:
        return unusable + 3;
    }
}

/* The best first; equal ones stay in the order of the loader. Returns how many there are. */
static int candidates(const instance *in, candidate *list) {
    VkPhysicalDevice gpu[MOST_DEVICES];
    uint32_t count = MOST_DEVICES;
    if (in->EnumeratePhysicalDevices(in->handle, &count, gpu) < 0) return 0;
    for (uint32_t i = 0; i < count; i++) {
        const candidate c = look_at(in, gpu[i]);
        uint32_t at = i;
        for (; at > 0 && rank(&c) < rank(&list[at - 1]); at--)
            list[at] = list[at - 1];
        list[at] = c;
    }
    return (int)count;
}

int vulkan_list(ddof_device *devices, int capacity) {
    candidate list[MOST_DEVICES];
    instance in;
    char text[256];
    if (open_instance(&in, text, sizeof text) != DDOF_OK) return 0;
    const int count = candidates(&in, list);
    for (int i = 0; i < count && i < capacity; i++)
        devices[i] = list[i].shown;
    close_instance(&in);
    return count;
}

/* ---- a session */

static void choose_features(vulkan_session *s, const candidate *c) {
    s->subgroup_size = (VkPhysicalDeviceSubgroupSizeControlFeatures){
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES,
        .subgroupSizeControl = c->sized,
        .computeFullSubgroups = c->full};
    s->synchronization2 = (VkPhysicalDeviceSynchronization2Features){
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SYNCHRONIZATION_2_FEATURES,
        .pNext = c->subgroup_size ? &s->subgroup_size : NULL,
        .synchronization2 = VK_TRUE};
    s->features = (VkPhysicalDeviceFeatures2){
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
        .pNext = &s->synchronization2,
        .features = {.geometryShader = c->geometry, .shaderStorageImageWriteWithoutFormat = VK_TRUE}};
}

static VkResult create_device(const instance *in, const candidate *c, const VkPhysicalDeviceFeatures2 *features,
                              VkDevice *device) {
    static const float priority = 1;
    const VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                           .queueFamilyIndex = c->family,
                                           .queueCount = 1,
                                           .pQueuePriorities = &priority};
    const char *extensions[3];
    uint32_t count = 0;
    if (c->version < VK_API_VERSION_1_3) {
        extensions[count++] = VK_KHR_SYNCHRONIZATION_2_EXTENSION_NAME;
        if (c->subgroup_size) extensions[count++] = VK_EXT_SUBGROUP_SIZE_CONTROL_EXTENSION_NAME;
    }
    if (c->portability) extensions[count++] = "VK_KHR_portability_subset";
    const VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                     .pNext = features,
                                     .queueCreateInfoCount = 1,
                                     .pQueueCreateInfos = &queue,
                                     .enabledExtensionCount = count,
                                     .ppEnabledExtensionNames = extensions};
    return in->CreateDevice(c->gpu, &info, NULL, device);
}

static ddof_status open_device(vulkan_session *s, const instance *in, const candidate *c, char *text, size_t size) {
    if (c->shown.refused[0]) {
        snprintf(text, size, "the Vulkan device %s cannot be used: %s", c->shown.name, c->shown.refused);
        return DDOF_ERROR_UNSUPPORTED;
    }
    choose_features(s, c);
    const VkResult result = create_device(in, c, &s->features, &s->device);
    if (result != VK_SUCCESS) {
        s->device = VK_NULL_HANDLE;
        snprintf(text, size, "the Vulkan device %s cannot be opened (VkResult %d)", c->shown.name, (int)result);
        return result == VK_ERROR_OUT_OF_HOST_MEMORY ? DDOF_ERROR_MEMORY : DDOF_ERROR_DEVICE;
    }
    s->physical_device = c->gpu;
    s->family = c->family;
    in->GetPhysicalDeviceMemoryProperties(c->gpu, &s->memory);
    in->GetPhysicalDeviceProperties(c->gpu, &s->properties);
    ((PFN_vkGetDeviceQueue)vulkan_function(s, "vkGetDeviceQueue"))(s->device, s->family, 0, &s->queue);
    return DDOF_OK;
}

bool vulkan_open(vulkan_session *s, int index, ddof_status *status, char *text, size_t size) {
    candidate list[MOST_DEVICES];
    instance in;
    memset(s, 0, sizeof *s);
    if ((*status = open_instance(&in, text, size)) != DDOF_OK) return false;
    s->library = in.library;
    s->get_instance_proc_addr = in.get;
    s->get_device_proc_addr = in.GetDeviceProcAddr;
    s->instance = in.handle;
    const int count = candidates(&in, list);
    if (count == 0) {
        snprintf(text, size,
                 "there is no Vulkan device on this machine (a software one, on Debian: mesa-vulkan-drivers)");
        *status = DDOF_ERROR_UNSUPPORTED;
    } else if (index < 0 || index >= count) {
        snprintf(text, size,
                 "config.device is %d, but the Vulkan devices of this machine are 0 to %d: see ddof_devices()", index,
                 count - 1);
        *status = DDOF_ERROR_INVALID;
    } else {
        *status = open_device(s, &in, &list[index], text, size);
    }
    if (*status != DDOF_OK) vulkan_close(s);
    return *status == DDOF_OK;
}

void vulkan_close(vulkan_session *s) {
    if (s->device) ((PFN_vkDestroyDevice)vulkan_function(s, "vkDestroyDevice"))(s->device, NULL);
    if (s->instance)
        ((PFN_vkDestroyInstance)s->get_instance_proc_addr(s->instance, "vkDestroyInstance"))(s->instance, NULL);
    memset(s, 0, sizeof *s);
}

PFN_vkVoidFunction vulkan_function(const vulkan_session *s, const char *name) {
    PFN_vkVoidFunction found = s->device ? s->get_device_proc_addr(s->device, name) : NULL;
    return found ? found : s->get_instance_proc_addr(s->instance, name);
}

uint32_t vulkan_memory_type(const VkPhysicalDeviceMemoryProperties *memory, uint32_t bits, VkMemoryPropertyFlags wanted,
                            VkMemoryPropertyFlags liked) {
    uint32_t found = UINT32_MAX;
    for (uint32_t i = memory->memoryTypeCount; i-- > 0;) {
        const VkMemoryPropertyFlags have = memory->memoryTypes[i].propertyFlags;
        if (!(bits >> i & 1) || (have & wanted) != wanted) continue;
        const bool better = (have & liked) == liked;
        if (found == UINT32_MAX || better || (memory->memoryTypes[found].propertyFlags & liked) != liked) found = i;
    }
    return found;
}
