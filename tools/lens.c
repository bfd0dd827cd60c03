/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "lens.h"

#include <math.h>
#include <stdio.h>

#include "message.h"

static const double DEFAULT_FOCAL_LENGTH = 50, DEFAULT_SENSOR_WIDTH = 36, DEFAULT_UNIT = 1000; /* millimetres */

static const char *option_name(option_id id) {
    return option_table[id].name;
}

static int refuse_pair(const options *o, option_id first, option_id second) {
    if (!option_given(o, first) || !option_given(o, second)) return 0;
    return fail_usage("--%s: cannot be used together with --%s; give one of them", option_name(second),
                      option_name(first));
}

static int refuse_without(const options *o, option_id needing, option_id needed) {
    if (!option_given(o, needing) || option_given(o, needed)) return 0;
    return fail_usage("--%s: needs --%s too", option_name(needing), option_name(needed));
}

int lens_check_options(const options *o) {
    static const option_id with_depth_only[] = {OPT_ANIMATE,      OPT_AUTOFOCUS,    OPT_METADATA,    OPT_DEPTH,
                                                OPT_DEPTH_KIND,   OPT_NEAR,         OPT_FAR,         OPT_CAMERA,
                                                OPT_FOCAL_LENGTH, OPT_SENSOR_WIDTH, OPT_FSTOP,       OPT_UNIT,
                                                OPT_FOCUS,        OPT_FOCUS_AT,     OPT_FOCUS_RANGE, OPT_MAX_COC,
                                                OPT_MAX_COC_NEAR, OPT_MAX_COC_FAR};
    int status = 0;
    for (size_t i = 0; status == 0 && i < sizeof with_depth_only / sizeof *with_depth_only; i++)
        status = refuse_pair(o, OPT_COC, with_depth_only[i]);
    if (status == 0) status = refuse_pair(o, OPT_FOCUS, OPT_FOCUS_AT);
    if (status == 0) status = refuse_without(o, OPT_COC_SCALE, OPT_COC);
    if (status == 0) status = refuse_without(o, OPT_RENDER, OPT_CAMERA);
    return status;
}

static int depth_settings(ddof_depth *depth, const options *o, const camera *file) {
    depth->kind = file->has_depth_kind ? file->depth_kind : DDOF_DEPTH_PLANAR;
    if (option_given(o, OPT_DEPTH_KIND)) depth->kind = (ddof_depth_kind)option_number(o, OPT_DEPTH_KIND, 0);
    bool between = depth->kind == DDOF_DEPTH_NORMALIZED || depth->kind == DDOF_DEPTH_DEVICE;
    const option_id ends[2] = {OPT_NEAR, OPT_FAR};
    const bool said = file->has_depth_kind && file->depth_kind == depth->kind && file->z_at_0 > 0 && file->z_at_1 > 0;
    for (int i = 0; i < 2; i++) {
        if (between && !said && !option_given(o, ends[i]))
            return fail_usage("--%s: missing; --depth-kind normalized and device need --near (the distance of depth 0) "
                              "and --far (that of depth 1)",
                              option_name(ends[i]));
        if (!between && option_given(o, ends[i]))
            return fail_usage(
                "--%s: has no meaning for this depth; add --depth-kind normalized or device, or leave it out",
                option_name(ends[i]));
    }
    if (!between) return 0;
    depth->z_at_0 = option_number(o, OPT_NEAR, said ? file->z_at_0 : 0);
    depth->z_at_1 = option_number(o, OPT_FAR, said ? file->z_at_1 : 0);
    if (depth->z_at_0 == depth->z_at_1)
        return fail_usage("--near: the same as --far (%g); depth needs two different ends", depth->z_at_0);
    bool infinite = isinf(depth->z_at_0) || isinf(depth->z_at_1);
    if (infinite && depth->kind == DDOF_DEPTH_NORMALIZED)
        return fail_usage("--%s: inf needs --depth-kind device; normalized depth is linear and has finite ends",
                          isinf(depth->z_at_0) ? "near" : "far");
    return 0;
}

double extent_fraction(const option_value *extent, int picture_width) {
    return extent->percent ? extent->number / 100 : extent->number / picture_width;
}

static void blur_settings(ddof_lens *lens, const options *o, int picture_width) {
    const option_value *both = &o->value[OPT_MAX_COC];
    const option_value *near_side = option_given(o, OPT_MAX_COC_NEAR) ? &o->value[OPT_MAX_COC_NEAR] : both;
    const option_value *far_side = option_given(o, OPT_MAX_COC_FAR) ? &o->value[OPT_MAX_COC_FAR] : both;
    const double near_width = near_side->given ? extent_fraction(near_side, picture_width) : 0;
    const double far_width = far_side->given ? extent_fraction(far_side, picture_width) : 0;
    if (lens->kind == DDOF_LENS_ARTIST) {
        lens->max_coc_near = near_width;
        lens->max_coc_far = far_width;
        return;
    }
    /* The library's 0 means "no limit"; who writes --max-coc-near 0 wants that side sharp. */
    if (near_side->given) lens->limit_near = fmax(near_width, 1e-12);
    if (far_side->given) lens->limit_far = fmax(far_width, 1e-12);
}

static int choose_kind(ddof_settings *settings, const options *o, const camera *file) {
    ddof_lens *lens = &settings->lens;
    bool blur_given =
        option_given(o, OPT_MAX_COC) || option_given(o, OPT_MAX_COC_NEAR) || option_given(o, OPT_MAX_COC_FAR);
    bool ray = settings->depth.kind == DDOF_DEPTH_RAY;
    lens->kind = option_given(o, OPT_FSTOP) || file->f_number > 0 ? DDOF_LENS_THIN : DDOF_LENS_ARTIST;
    if (lens->kind == DDOF_LENS_THIN) return 0;
    if (!blur_given && !option_given(o, OPT_FOCAL_LENGTH))
        return fail_usage(
            "--fstop: missing; describe a lens with --fstop N --focal-length MM --focus DIST, or the blur "
            "itself with --focus DIST --max-coc PX, or give --camera or --coc");
    if (!blur_given || (option_given(o, OPT_FOCAL_LENGTH) && !ray))
        return fail_usage("--fstop: missing; --focal-length describes a lens, which needs its f-number as well");
    if (ray && !option_given(o, OPT_FOCAL_LENGTH) && !(file->focal_length > 0))
        return fail_usage("--focal-length: missing; ray depth needs it to know the angle of each pixel");
    return 0;
}

static int focus_settings(ddof_lens *lens, const options *o, const camera *file) {
    const bool is_found = option_given(o, OPT_AUTOFOCUS), known = option_given(o, OPT_FOCUS);
    const char *name = option_name(is_found ? OPT_AUTOFOCUS : OPT_FOCUS);
    if (option_given(o, OPT_FOCUS_AT) || (is_found && !known)) { /* or it is being found, see autofocus.c */
        lens->focus = DDOF_FOCUS_PIXEL;
        return 0;
    }
    lens->focus_distance = option_number(o, OPT_FOCUS, file->focus_distance / lens->unit);
    if (!(lens->focus_distance > 0))
        return fail_usage("--focus: missing; give the focus distance (--focus 3.2) or a pixel to focus on "
                          "(--focus-at 50%%,50%%)");
    if (lens->kind == DDOF_LENS_ARTIST && isinf(lens->focus_distance))
        return fail_usage("--%s: inf needs a lens; give --fstop and --focal-length, or a finite distance", name);
    if (lens->kind == DDOF_LENS_THIN && lens->focus_distance * lens->unit <= lens->focal_length)
        return fail_usage("--%s: %g (%g mm) lies inside the focal length of %g mm; focus farther away, or correct "
                          "--unit",
                          name, lens->focus_distance, lens->focus_distance * lens->unit, lens->focal_length);
    return 0;
}

double lens_unit(const options *o, const camera *file) {
    return option_number(o, OPT_UNIT, file->unit > 0 ? file->unit : DEFAULT_UNIT);
}

int lens_settings(ddof_settings *settings, const options *o, const camera *file, int picture_width) {
    ddof_lens *lens = &settings->lens;
    int status = depth_settings(&settings->depth, o, file);
    if (status == 0) status = choose_kind(settings, o, file);
    if (status) return status;
    double focal_default = lens->kind == DDOF_LENS_THIN ? DEFAULT_FOCAL_LENGTH : 0;
    lens->focal_length =
        option_number(o, OPT_FOCAL_LENGTH, file->focal_length > 0 ? file->focal_length : focal_default);
    lens->sensor_width =
        option_number(o, OPT_SENSOR_WIDTH, file->sensor_width > 0 ? file->sensor_width : DEFAULT_SENSOR_WIDTH);
    lens->f_number = option_number(o, OPT_FSTOP, file->f_number);
    lens->unit = lens_unit(o, file);
    lens->in_focus_range = option_number(o, OPT_FOCUS_RANGE, 0);
    blur_settings(lens, o, picture_width);
    return focus_settings(lens, o, file);
}

bool method_none(const options *o) {
    return option_number(o, OPT_METHOD, DDOF_METHOD_DIFFUSION) > DDOF_METHOD_SCATTER; /* the last word */
}

ddof_method method_of_options(const options *o) {
    return method_none(o) ? DDOF_METHOD_DIFFUSION : (ddof_method)option_number(o, OPT_METHOD, DDOF_METHOD_DIFFUSION);
}

/* Only diffusion has a kernel, and a system to solve. */
static int check_other_method(const options *o, ddof_method method) {
    static const option_id diffusion_only[] = {OPT_KERNEL,   OPT_QUALITY, OPT_CONDUCTANCE,
                                               OPT_SUBSTEPS, OPT_SOLVER,  OPT_SHARED_CHAIN};
    for (size_t i = 0; i < sizeof diffusion_only / sizeof *diffusion_only; i++)
        if (option_given(o, diffusion_only[i]))
            return fail_usage("--%s: cannot be used together with --method %s; it belongs to --method diffusion",
                              option_name(diffusion_only[i]), method_name(method));
    return 0;
}

int method_check_options(const options *o) {
    static const option_id heat_only[] = {OPT_SUBSTEPS, OPT_CONDUCTANCE};
    const ddof_method method = method_of_options(o);
    if (method != DDOF_METHOD_DIFFUSION) return check_other_method(o, method);
    const bool disc = option_number(o, OPT_KERNEL, DDOF_KERNEL_HEAT) == DDOF_KERNEL_DISC;
    for (size_t i = 0; disc && i < sizeof heat_only / sizeof *heat_only; i++)
        if (option_given(o, heat_only[i]))
            return fail_usage(
                "--%s: cannot be used together with --kernel disc; --quality says how close to a disc it is",
                option_name(heat_only[i]));
    if (!disc && option_given(o, OPT_QUALITY)) return fail_usage("--quality: needs --kernel disc too");
    return 0;
}

void method_settings(ddof_settings *settings, const options *o) {
    settings->method = method_of_options(o);
    settings->kernel = (ddof_kernel)option_number(o, OPT_KERNEL, DDOF_KERNEL_HEAT);
    settings->layers = (ddof_layers)option_number(o, OPT_LAYERS, DDOF_LAYERS_OFF);
    settings->conductance = (ddof_conductance)option_number(o, OPT_CONDUCTANCE, DDOF_CONDUCTANCE_MATCHED);
    const bool heat = settings->method == DDOF_METHOD_DIFFUSION && settings->kernel == DDOF_KERNEL_HEAT;
    settings->substeps = (int)option_number(o, OPT_SUBSTEPS, heat ? 1 : 0);
    /* the words stand in the order of the library's names, the first of which is 1 */
    settings->quality = (ddof_quality)(option_number(o, OPT_QUALITY, DDOF_QUALITY_DEFAULT - 1) + 1);
    settings->solver = (ddof_solver)(option_number(o, OPT_SOLVER, DDOF_SOLVER_DEFAULT - 1) + 1);
    settings->surface = (ddof_surface)(option_number(o, OPT_SURFACE, DDOF_SURFACE_RGBA16F - 1) + 1);
    settings->shared_chain = option_given(o, OPT_SHARED_CHAIN);
}

const char *method_name(ddof_method method) {
    static const char *const names[] = {[DDOF_METHOD_DIFFUSION] = "diffusion",
                                        [DDOF_METHOD_GAUSSIAN] = "gaussian",
                                        [DDOF_METHOD_HEXAGON] = "hexagon",
                                        [DDOF_METHOD_SCATTER] = "scatter"};
    return names[method];
}

const char *kernel_name(ddof_kernel kernel) {
    return kernel == DDOF_KERNEL_DISC ? "disc" : "heat";
}

const char *quality_name(ddof_quality quality) {
    static const char *const names[] = {[DDOF_QUALITY_DEFAULT] = "good",
                                        [DDOF_QUALITY_DRAFT] = "draft",
                                        [DDOF_QUALITY_GOOD] = "good",
                                        [DDOF_QUALITY_BEST] = "best"};
    return names[quality];
}

void lens_describe(char *text, size_t size, const ddof_settings *settings, double focus, int picture_width) {
    const ddof_lens *lens = &settings->lens;
    if (lens->kind == DDOF_LENS_THIN)
        snprintf(text, size, "%g mm f/%g, focus %.4g", lens->focal_length, lens->f_number, focus);
    else
        snprintf(text, size, "focus %.4g, CoC up to %.4g px near and %.4g px far", focus,
                 lens->max_coc_near * picture_width, lens->max_coc_far * picture_width);
}
