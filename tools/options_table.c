/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "options.h"

#include <math.h>

enum {
    R = 1 << COMMAND_RENDER,
    C = 1 << COMMAND_COC,
    I = 1 << COMMAND_INFO,
    M = 1 << COMMAND_COMPARE,
    B = 1 << COMMAND_BENCH,
    S = 1 << COMMAND_SOLVERS,
    D = 1 << COMMAND_DEVICES,
    WORK = R | C | I | M | B,
    ALL = WORK | S | D
};

/* One option, one or two lines; the order is that of --help. */
/* clang-format off */
const option_spec option_table[OPT_COUNT] = {
    [OPT_OUTPUT] = {"output", 'o', KIND_TEXT, "FILE", "out.exr",
        "the picture to write: .exr .png .tif .tiff .pfm; compare: of the difference, .png .exr", R | C | M, 0, 0, 0, NULL},
    [OPT_FRAMES] = {"frames", 0, KIND_TEXT, "A-B[xSTEP]", "1001-1240",
        "frames of a sequence: IN, --output and others have #### or %04d for the number (default: all that IN has)", R | C, 0, 0, 0, NULL},
    [OPT_RESUME] = {"resume", 0, KIND_FLAG, NULL, NULL,
        "leave out frames whose output is complete and was made of the same files with the same settings", R | C, 0, 0, 0, NULL},
    [OPT_KEEP_GOING] = {"keep-going", 'k', KIND_FLAG, NULL, NULL,
        "go on with other frames when one fails", R | C, 0, 0, 0, NULL},
    [OPT_IN_FLIGHT] = {"in-flight", 0, KIND_INTEGER, "N", "2",
        "frames of a sequence at work at a time, 1 to 64: more keep more threads busy and take more memory (default 3)", R | C, 1, 64, false, NULL},
    [OPT_LAYER] = {"layer", 0, KIND_TEXT, "NAME", "beauty",
        "colour layer or part (default: R G B A, then the first layer that has them)", R | C | I | M, 0, 0, 0, NULL},
    [OPT_RENDER_CHANNELS] = {"channels", 0, KIND_TEXT, "LIST", "'diffuse.*,specular.*,RGBA'",
        "what is blurred, by commas: channels or patterns of them (* ? []); RGBA: what is without this option", R, 0, 0, 0, NULL},
    [OPT_VIEWS] = {"views", 0, KIND_TEXT, "LIST", "left,right",
        "views of a stereo EXR that are blurred, each with its own depth, or all (default: the first)", R, 0, 0, 0, NULL},

    [OPT_DEPTH] = {"depth", 0, KIND_TEXT, "FILE[:CHANNEL]", "depth.exr:Z",
        "depth from another file, or :CHANNEL of IN (default: the depth channel of IN)", R | C | I, 0, 0, 0, NULL},
    [OPT_DEPTH_KIND] = {"depth-kind", 0, KIND_CHOICE, "KIND", "planar",
        "planar|ray|inverse|normalized|device: what depth values mean (default planar)", R | C, 0, 0, 0,
        "planar|ray|inverse|normalized|device"},
    [OPT_NEAR] = {"near", 0, KIND_NUMBER_OR_INF, "Z", "0.5",
        "distance meant by depth 0, for normalized and device (no default)", R | C, 0, INFINITY, true, NULL},
    [OPT_FAR] = {"far", 0, KIND_NUMBER_OR_INF, "Z", "50",
        "distance meant by depth 1; exchange the two when white is near (no default)", R | C, 0, INFINITY, true, NULL},
    [OPT_COC] = {"coc", 0, KIND_TEXT, "FILE[:CHANNEL]", "coc.exr",
        "signed CoC (diameter, pixels, negative is near) instead of depth and lens", R | C, 0, 0, 0, NULL},
    [OPT_COC_SCALE] = {"coc-scale", 0, KIND_NUMBER, "F", "2",
        "multiply the values of --coc, e.g. 2 for radii, -1 to change sides (default 1)", R | C, -1e6, 1e6, false, NULL},

    [OPT_CAMERA] = {"camera", 0, KIND_TEXT, "FILE.json", "scene.json",
        "camera, focus and depth convention from a scene.json; options given here win", R | C, 0, 0, 0, NULL},
    [OPT_RENDER] = {"render", 0, KIND_TEXT, "NAME", "dof_f2.exr",
        "the entry of --camera to take f-number and focus from (default: same frame, first with DoF)", R | C, 0, 0, 0, NULL},
    [OPT_FOCAL_LENGTH] = {"focal-length", 0, KIND_NUMBER, "MM", "85",
        "focal length of the lens (default 50 when --fstop is given)", R | C, 0, 1e6, true, NULL},
    [OPT_SENSOR_WIDTH] = {"sensor-width", 0, KIND_NUMBER, "MM", "36",
        "width of the sensor (default 36)", R | C, 0, 1e6, true, NULL},
    [OPT_FSTOP] = {"fstop", 0, KIND_NUMBER, "N", "2.8",
        "f-number of the lens (no default)", R | C, 0, 1e6, true, NULL},
    [OPT_UNIT] = {"unit", 0, KIND_NUMBER, "MM", "1000",
        "millimetres in one unit of depth and focus (default 1000: metres)", R | C, 0, 1e9, true, NULL},
    [OPT_FOCUS] = {"focus", 0, KIND_NUMBER_OR_INF, "DIST", "3.2",
        "focus distance in the depth's unit, or inf (no default)", R | C, 0, INFINITY, true, NULL},
    [OPT_FOCUS_AT] = {"focus-at", 0, KIND_POINT, "X,Y", "50%,50%",
        "focus on what is seen at this pixel, or P%,P% of the picture (no default)", R | C, 0, 1 << 20, false, NULL},
    [OPT_FOCUS_RANGE] = {"focus-range", 0, KIND_NUMBER, "DIST", "0.4",
        "depth kept sharp around the focus, in the depth's unit (default 0)", R | C, 0, 1e9, false, NULL},
    [OPT_AUTOFOCUS] = {"autofocus", 0, KIND_TEXT, "X,Y,WxH", "40%,40%,20%x20%",
        "focus on the median depth of this region, pixels or percent of the picture (no default)", R | C, 0, 0, 0, NULL},
    [OPT_FOCUS_SMOOTH] = {"focus-smooth", 0, KIND_INTEGER, "N", "4",
        "--autofocus: the mean of so many frames before and after, in dioptres, 0 to 1000 (default 0)", R | C, 0, 1000, false, NULL},
    [OPT_ANIMATE] = {"animate", 0, KIND_TEXT, "FILE.json", "pull.json",
        "keyframes of focus, focus-at, focus-range, fstop and focal-length by frame number", R | C, 0, 0, 0, NULL},
    [OPT_METADATA] = {"metadata", 0, KIND_TEXT, "auto|LIST", "focus=focus,fstop=aperture",
        "lens from attributes of IN's header: auto, or by commas focus=NAME, fstop=NAME, focal-length=NAME, sensor-width=NAME; "
        "options given here win",
        R | C | I, 0, 0, 0, NULL},
    [OPT_MAX_COC] = {"max-coc", 0, KIND_EXTENT, "PX", "40",
        "largest blur, pixels or P% of the width: a limit with --fstop (default none), else the blur itself", R | C, 0, 1e5,
        false, NULL},
    [OPT_MAX_COC_NEAR] = {"max-coc-near", 0, KIND_EXTENT, "PX", "20",
        "the same before the focus only (default --max-coc)", R | C, 0, 1e5, false, NULL},
    [OPT_MAX_COC_FAR] = {"max-coc-far", 0, KIND_EXTENT, "PX", "2%",
        "the same behind the focus only (default --max-coc)", R | C, 0, 1e5, false, NULL},

    [OPT_MASK] = {"mask", 0, KIND_TEXT, "FILE", "mask.png",
        "also measure inside (values of 0.5 and more) and outside of this mask", M, 0, 0, 0, NULL},
    [OPT_COMPARE_COC] = {"coc", 0, KIND_TEXT, "FILE[:CHANNEL]", "coc.exr",
        "signed CoC (of 'ddof coc'): also measure in focus, defocused, and at silhouettes", M, 0, 0, 0, NULL},
    [OPT_PPD] = {"ppd", 0, KIND_NUMBER, "N", "67",
        "FLIP: pixels in a degree of sight, 1 to 1000 (default 67: a 4K display 0.7 m wide, from 0.7 m)", M, 1, 1000, false, NULL},
    [OPT_AMPLIFY] = {"amplify", 0, KIND_NUMBER, "N", "255",
        "the picture of --output is |A - B| times N, no tone map or sRGB curve (default 255)", M, 0, 1e6, true, NULL},
    [OPT_INVERT] = {"invert", 0, KIND_FLAG, NULL, NULL,
        "the picture of --output is 1 - that: white where A and B agree", M, 0, 0, 0, NULL},

    [OPT_SIZE] = {"size", 0, KIND_SIZE, "WxH", "1920x1080",
        "picture size, pixels (default 1920x1080; solvers: 1600x1200; --table: the published ones)", B | S, 1, 1 << 20, false, NULL},
    [OPT_RUNS] = {"runs", 0, KIND_INTEGER, "N", "31",
        "timed repetitions (default 31; --table: 11)", B, 1, 100000, false, NULL},
    [OPT_TYPE] = {"type", 0, KIND_CHOICE, "TYPE", "float",
        "float|half: type of the picture's channels; --backend vulkan: of CoC or depth (default float)", B, 0, 0, 0, "float|half"},
    [OPT_LAYOUT] = {"layout", 0, KIND_CHOICE, "LAYOUT", "planar",
        "interleaved|planar: how the channels lie in memory (default interleaved)", B, 0, 0, 0, "interleaved|planar"},
    [OPT_CHANNELS] = {"channels", 0, KIND_INTEGER, "N", "4",
        "channels of the picture, 1 to 4 (default 4)", B, 1, 4, false, NULL},
    [OPT_IN_PLACE] = {"in-place", 0, KIND_FLAG, NULL, NULL,
        "write the result over the picture", B, 0, 0, 0, NULL},
    [OPT_BENCH_COC] = {"coc", 0, KIND_NUMBER, "PX", "48",
        "largest CoC of the made-up picture, pixels (default 48)", B, 0, 1e5, false, NULL},
    [OPT_BENCH_DEPTH] = {"depth", 0, KIND_FLAG, NULL, NULL,
        "give depth and a lens instead of a CoC image", B, 0, 0, 0, NULL},
    [OPT_TABLE] = {"table", 0, KIND_FLAG, NULL, NULL,
        "every solver of the backend at the sizes of the published table: time and memory", B, 0, 0, 0, NULL},
    [OPT_FORMAT] = {"format", 0, KIND_CHOICE, "FORMAT", "csv",
        "markdown|csv|json: how --table is printed (default markdown)", B, 0, 0, 0, "markdown|csv|json"},
    [OPT_REFERENCE] = {"reference", 0, KIND_FLAG, NULL, NULL,
        "--table: time the float64 reference too, which is slow", B, 0, 0, 0, NULL},

    [OPT_METHOD] = {"method", 0, KIND_CHOICE, "METHOD", "hexagon",
        "diffusion|gaussian|hexagon|scatter: how the picture is blurred, the last three for comparison; none: read and write only "
        "(default diffusion)",
        R | B, 0, 0, 0, "diffusion|gaussian|hexagon|scatter|none"},
    [OPT_KERNEL] = {"kernel", 0, KIND_CHOICE, "KERNEL", "disc",
        "heat|disc: what a point becomes, a bell or the even disc that a lens makes (default heat)", R | B, 0, 0, 0, "heat|disc"},
    [OPT_QUALITY] = {"quality", 0, KIND_CHOICE, "QUALITY", "best",
        "draft|good|best: --kernel disc: how close to a disc (default good)", R | B, 0, 0, 0, "draft|good|best"},
    [OPT_CONDUCTANCE] = {"conductance", 0, KIND_CHOICE, "LAW", "matched",
        "matched: as wide as the lens's disc; classic: beta = CoC squared, wider (default matched)", R | B, 0, 0, 0,
        "matched|classic"},
    [OPT_SUBSTEPS] = {"substeps", 0, KIND_INTEGER, "N", "2",
        "1 to 64: more make the blur rounder, at that many times the cost (default 1)", R | B, 1, 64, false, NULL},
    [OPT_LAYERS] = {"layers", 0, KIND_CHOICE, "LAYERS", "auto",
        "auto|off: blur what is near over what is sharp, and what lies behind it behind it (default off)", R, 0, 0, 0,
        "off|auto"},
    [OPT_BOKEH] = {"bokeh", 0, KIND_CHOICE, "BOKEH", "highlights",
        "off|highlights|full: what is drawn as pictures of the iris (default highlights with --kernel disc, else and in bench off)",
        R | B, 0, 0, 0, "off|highlights|full"},
    [OPT_IRIS] = {"iris", 0, KIND_TEXT, "LIST", "blades=6,rotation=10",
        "the iris that --bokeh draws: disc, or by commas blades=N or image=FILE[:CHANNEL], rotation=DEGREES, curvature=V, edge=V, "
        "cats-eye=V, squeeze=V, fringe=V (default disc)", R | B, 0, 0, 0, NULL},
    [OPT_BOKEH_THRESHOLD] = {"bokeh-threshold", 0, KIND_NUMBER, "V", "1.5",
        "--bokeh highlights: what is brighter, scene-linear, is drawn (default 1)", R | B, 0, 1e6, true, NULL},
    [OPT_BOKEH_LIMIT] = {"bokeh-limit", 0, KIND_EXTENT, "PX", "10%",
        "largest CoC that is drawn, pixels or P% of the width (default 25%)", R | B, 0, 4096, true, NULL},
    [OPT_MAX_SPRITES] = {"max-sprites", 0, KIND_INTEGER, "N", "10000",
        "--bokeh highlights: so many pixels are drawn at most, the brightest (default 65536)", R | B, 1, 1 << 20, false, NULL},
    [OPT_MAX_SPRITE_AREA] = {"max-sprite-area", 0, KIND_INTEGER, "N", "4",
        "--bokeh highlights: the squares around them add up to N times the picture at most (default 64)", R | B, 1, 1024, false, NULL},
    [OPT_BOKEH_RESOLUTION] = {"bokeh-resolution", 0, KIND_CHOICE, "SIZE", "half",
        "full|half: size of the picture that is drawn into (default full; --bokeh full: half)", R | B, 0, 0, 0, "full|half"},
    [OPT_APPEND] = {"append", 0, KIND_CHOICE, "HOW", "arguments",
        "counter|arguments: how --backend vulkan appends what it draws (default counter)", B, 0, 0, 0, "counter|arguments"},
    [OPT_QUADS] = {"quads", 0, KIND_CHOICE, "HOW", "geometry",
        "instanced|geometry: how --backend vulkan makes quads of it (default instanced)", B, 0, 0, 0, "instanced|geometry"},
    [OPT_HOLDOUT] = {"holdout", 0, KIND_TEXT, "FILE[:CHANNEL]", "subject.png",
        "mask of what neither blurs nor bleeds: 1 there, 0 elsewhere (no default)", R, 0, 0, 0, NULL},
    [OPT_PREVIEW] = {"preview", 0, KIND_TEXT, "FILE.png", "preview.png",
        "also write before and after side by side, as sRGB", R, 0, 0, 0, NULL},
    [OPT_EXPOSURE] = {"exposure", 0, KIND_NUMBER, "STOPS", "1.5",
        "brighten --preview and false colour, -30 to 30 stops (default 0)", R | C, -30, 30, false, NULL},

    [OPT_MAX_MEMORY] = {"max-memory", 0, KIND_BYTES, "SIZE", "512M",
        "most memory to use, with K, M, G or T: larger pictures are worked on from files in --scratch (default: no limit)", R | C,
        1, 0x1p60, false, NULL},
    [OPT_SCRATCH] = {"scratch", 0, KIND_TEXT, "FOLDER", "/var/tmp",
        "where --max-memory puts its files, which never have a name (default: the folder of --output)", R | C, 0, 0, 0, NULL},

    [OPT_THREADS] = {"threads", 0, KIND_INTEGER, "N", "4",
        "threads, 0 to 256; results do not depend on it (default 0: all there are)", WORK, 0, 256, false, NULL},
    [OPT_BACKEND] = {"backend", 0, KIND_CHOICE, "NAME", "cpu",
        "auto|cpu|gl|vulkan|reference: what does the work; auto is cpu (default auto)", R | C | B, 0, 0, 0,
        "auto|cpu|gl|vulkan|reference"},
    [OPT_DEVICE] = {"device", 0, KIND_INTEGER, "N", "1",
        "--backend vulkan: which of 'ddof devices', the best first (default 0)", R | C | B, 0, 1023, false, NULL},
    [OPT_SOLVER] = {"solver", 0, KIND_CHOICE, "NAME", "cr4+pack",
        "how a GPU solves. gl: cr-vanilla|cr|cr+pack|cr4|cr4+pack|cr+pcr (default cr4+pack); "
        "vulkan: line|pcr|pcr3+sweep|cr4+pack (default line)", R | B, 0, 0, 0,
        "cr-vanilla|cr|cr+pack|cr4|cr4+pack|cr+pcr|line|pcr|pcr3+sweep"},
    [OPT_SURFACE] = {"surface", 0, KIND_CHOICE, "FORMAT", "rgba32f",
        "rgba16f|rgba32f: colour under way on a GPU (default rgba16f)", R | B, 0, 0, 0, "rgba16f|rgba32f"},
    [OPT_SHARED_CHAIN] = {"shared-chain", 0, KIND_FLAG, NULL, NULL,
        "--backend gl: columns are solved in the surfaces of the rows, for less memory", R | B, 0, 0, 0, NULL},
    [OPT_CPU] = {"cpu", 0, KIND_CPUS, "LIST", "baseline,avx2",
        "allowed instruction sets of all|baseline|avx2|avx512|neon, by commas (default all)", R | C | B, 0, 0, 0,
        "baseline|avx2|avx512|neon|all"},
    [OPT_QUIET] = {"quiet", 'q', KIND_FLAG, NULL, NULL,
        "only errors; --json still prints its object", ALL, 0, 0, 0, NULL},
    [OPT_JSON] = {"json", 0, KIND_FLAG, NULL, NULL,
        "print one JSON object on standard output", ALL, 0, 0, 0, NULL},
    [OPT_HELP] = {"help", 'h', KIND_FLAG, NULL, NULL,
        "this text", ALL, 0, 0, 0, NULL},
};
/* clang-format on */

const command_spec command_table[COMMAND_COUNT] = {
    [COMMAND_RENDER] =
        {"render", 1, true, "IN -o OUT", "give a picture the depth of field of a lens",
         "  ddof render shot.exr -o out.exr --fstop 2.8 --focal-length 85 --focus 3.2\n"
         "  ddof render shot.exr -o out.exr --fstop 1.4 --focus-at 960,540 --preview before_after.png\n"
         "  ddof render photo.png -o out.png --depth depth.png --depth-kind device --near 50 --far 0.4 \\\n"
         "       --focus 2 --max-coc 2%\n"
         "  ddof render pinhole.exr -o out.exr --camera scene.json --render dof_f2.exr --json\n"
         "  ddof render shot.exr -o out.exr --coc radius.exr:blur --coc-scale 2\n"
         "  ddof render shot.exr -o out.exr --fstop 2 --focus 4 --kernel disc --quality best\n"
         "  ddof render shot.exr -o out.exr --fstop 2 --focus 4 --kernel disc --iris blades=6,rotation=10\n"
         "  ddof render shot.exr -o out.exr --fstop 2 --focus 4 --bokeh full --iris image=heart.png\n"
         "  ddof render shot.exr -o out.exr --fstop 2 --focus 4 --backend gl --solver cr4+pack\n"
         "  ddof render shot.exr -o out.exr --fstop 2 --focus 4 --backend vulkan --device 1\n"},
    [COMMAND_COC] = {"coc", 1, true, "IN -o OUT",
                     "write the signed circle of confusion (EXR, PFM, TIFF), or show it in false colour (PNG)",
                     "  ddof coc shot.exr -o coc.exr --fstop 2.8 --focal-length 85 --focus 3.2\n"
                     "  ddof coc shot.exr -o coc.png --camera scene.json\n"
                     "  ddof coc shot.exr -o coc.pfm --focus-at 50%,50% --max-coc-near 10 --max-coc-far 30\n"},
    [COMMAND_INFO] = {"info", 1, false, "IN", "what is in a picture, and what would be used as colour and depth",
                      "  ddof info shot.exr\n"
                      "  ddof info shot.exr --layer beauty --depth aovs.exr:depth.Z\n"
                      "  ddof info shot.exr --json\n"},
    [COMMAND_COMPARE] = {"compare", 2, false, "A B", "how far two pictures are apart: PSNR, SSIM, FLIP, largest error",
                         "  ddof compare out.exr truth.exr\n"
                         "  ddof compare out.exr truth.exr --coc coc.exr\n"
                         "  ddof compare out.exr truth.exr --mask subject.png --json\n"
                         "  ddof compare packed.exr unpacked.exr --amplify 255 --invert -o difference.png\n"},
    [COMMAND_BENCH] = {"bench", 0, false, "", "time the solve on a made-up picture, next to a copy of it in memory",
                       "  ddof bench --size 3840x2160 --threads 1\n"
                       "  ddof bench --type half --layout planar --in-place\n"
                       "  ddof bench --coc 1000 --cpu avx2 --json\n"
                       "  ddof bench --kernel disc --bokeh highlights --coc 64\n"
                       "  ddof bench --table --backend gl --format csv\n"
                       "  ddof bench --backend gl --solver cr --surface rgba32f --size 1600x1200\n"
                       "  ddof bench --backend vulkan --size 3840x2160 --json\n"},
    [COMMAND_SOLVERS] = {"solvers", 0, false, "",
                         "the tridiagonal solvers of the literature: steps, operations, memory",
                         "  ddof solvers\n"
                         "  ddof solvers --size 2560x1600 --json\n"},
    [COMMAND_DEVICES] = {"devices", 0, false, "", "what can do the work here: instruction sets, GL, Vulkan devices",
                         "  ddof devices\n"
                         "  ddof devices --json\n"},
};
