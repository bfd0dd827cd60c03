/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

/* quality_report markdown|html DIR: the tables of docs/quality, on standard output.
 *
 * DIR/cases.tsv: key, title, what is what. DIR/methods.tsv: key, title, what was run. DIR/CASE.METHOD.json: what
 * `ddof compare --coc --json` printed; a method that is not there for a case is left out. DIR/about: the first lines.
 * html: pictures are CASE.METHOD.jpg, their differences CASE.METHOD.d.jpg, the truth is CASE.truth.jpg. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_ROWS = 64, FIELD = 400 };

typedef struct row {
    char key[FIELD], title[FIELD], about[FIELD];
} row;

typedef struct table {
    row row[MAX_ROWS];
    int count;
} table;

static const char *folder;
static table cases, methods;

static void fail(const char *what, const char *which) {
    fprintf(stderr, "quality_report: %s: %s\n", which, what);
    exit(1);
}

static FILE *open_in(const char *name, const char *ending) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s%s", folder, name, ending);
    return fopen(path, "rb");
}

static void read_table(table *t, const char *name) {
    char line[3 * FIELD];
    FILE *file = open_in(name, ".tsv");
    if (!file) fail("cannot be read", name);
    while (t->count < MAX_ROWS && fgets(line, sizeof line, file)) {
        row *r = &t->row[t->count++];
        if (sscanf(line, "%399[^\t]\t%399[^\t]\t%399[^\n]", r->key, r->title, r->about) != 3) fail("bad line", line);
    }
    fclose(file);
}

static cJSON *read_result(const row *scene, const row *method) {
    char name[2 * FIELD + 2];
    snprintf(name, sizeof name, "%s.%s", scene->key, method->key);
    FILE *file = open_in(name, ".json");
    if (!file) return NULL;
    enum { MOST = 1 << 16 };
    static char text[MOST];
    text[fread(text, 1, MOST - 1, file)] = 0;
    fclose(file);
    cJSON *object = cJSON_Parse(text);
    if (!object) fail("is no JSON", name);
    return object;
}

/* NAN for null and for what is not there. */
static double number(const cJSON *object, const char *region, const char *key) {
    if (region) object = cJSON_GetObjectItemCaseSensitive(cJSON_GetObjectItemCaseSensitive(object, "regions"), region);
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
    return cJSON_IsNumber(item) ? item->valuedouble : NAN;
}

/* ------------------------------------------------------------------------- cells */

typedef struct column {
    const char *region, *key;
    int digits;
    bool larger_is_better;
} column;

static const column whole[] = {{NULL, "psnr", 2, true},
                               {NULL, "psnr_tonemapped", 2, true},
                               {NULL, "ssim_tonemapped", 4, true},
                               {NULL, "flip", 4, false},
                               {NULL, "flip_hdr", 4, false}};
static const column split[] = {{"in_focus", "psnr_tonemapped", 2, true},
                               {"in_focus", "ssim_tonemapped", 4, true},
                               {"in_focus", "flip", 4, false},
                               {"defocused", "psnr_tonemapped", 2, true},
                               {"defocused", "ssim_tonemapped", 4, true},
                               {"defocused", "flip", 4, false},
                               {"silhouette", "psnr_tonemapped", 2, true},
                               {"silhouette", "ssim_tonemapped", 4, true},
                               {"silhouette", "flip", 4, false}};
enum { WHOLE = sizeof whole / sizeof whole[0], SPLIT = sizeof split / sizeof split[0] };

/* As it is printed, so that equal figures are equally good. */
static double rounded(double value, int digits) {
    return round(value * pow(10, digits));
}

static double best_of(cJSON *const *result, const column *c) {
    double best = NAN;
    for (int m = 0; m < methods.count; m++) {
        const double v = result[m] ? number(result[m], c->region, c->key) : NAN;
        if (!isnan(v) && (isnan(best) || (c->larger_is_better ? v > best : v < best))) best = v;
    }
    return best;
}

static void print_cells(cJSON *const *result, int method, const column *columns, int count, bool html) {
    for (int i = 0; i < count; i++) {
        const column *c = &columns[i];
        const double v = number(result[method], c->region, c->key);
        const bool best = rounded(v, c->digits) == rounded(best_of(result, c), c->digits);
        const char *mark[2] = {best ? html ? "<b>" : "**" : "", best ? html ? "</b>" : "**" : ""};
        printf(html ? "<td>" : " ");
        if (isnan(v))
            printf("-");
        else
            printf("%s%.*f%s", mark[0], c->digits, v, mark[1]);
        printf(html ? "</td>" : " |");
    }
}

/* ------------------------------------------------------------------------- Markdown */

static void markdown_table(cJSON *const *result, const char *head, const column *columns, int count) {
    printf("| Method |%s\n|---|", head);
    for (int i = 0; i < count; i++)
        printf("---:|");
    printf("\n");
    for (int m = 0; m < methods.count; m++) {
        if (!result[m]) continue;
        printf("| %s |", methods.row[m].title);
        print_cells(result, m, columns, count, false);
        printf("\n");
    }
    printf("\n");
}

static double share(cJSON *const *result, const char *region) {
    for (int m = 0; m < methods.count; m++)
        if (result[m]) return 100 * number(result[m], region, "pixels") / number(result[m], NULL, "pixels");
    return NAN;
}

static void markdown_case(const row *scene, cJSON *const *result) {
    printf("## %s\n\n%s\n\n", scene->title, scene->about);
    markdown_table(result, " PSNR, scene-linear | PSNR, tone-mapped | SSIM | FLIP | HDR-FLIP |", whole, WHOLE);
    printf("In focus %.1f %%, defocused %.1f %%, silhouette %.1f %% of the pixels (f, d, s):\n\n",
           share(result, "in_focus"), share(result, "defocused"), share(result, "silhouette"));
    markdown_table(result, " f: PSNR | SSIM | FLIP | d: PSNR | SSIM | FLIP | s: PSNR | SSIM | FLIP |", split, SPLIT);
}

static void markdown_overview(cJSON *(*all)[MAX_ROWS], const char *title, const column *c) {
    printf("%s:\n\n| Method |", title);
    for (int s = 0; s < cases.count; s++)
        printf(" %s |", cases.row[s].title);
    printf("\n|---|");
    for (int s = 0; s < cases.count; s++)
        printf("---:|");
    printf("\n");
    for (int m = 0; m < methods.count; m++) {
        bool any = false;
        for (int s = 0; s < cases.count; s++)
            any = any || all[s][m];
        if (!any) continue;
        printf("| %s |", methods.row[m].title);
        for (int s = 0; s < cases.count; s++)
            print_cells(all[s], m, c, 1, false);
        printf("\n");
    }
    printf("\n");
}

static void copy_about(void) {
    char line[4096];
    FILE *file = open_in("about", "");
    if (!file) fail("cannot be read", "about");
    while (fgets(line, sizeof line, file))
        fputs(line, stdout);
    fclose(file);
}

static void markdown(cJSON *(*all)[MAX_ROWS]) {
    printf("# Against a real lens\n\n");
    copy_about();
    printf("\n| Method | What was run |\n|---|---|\n");
    for (int m = 0; m < methods.count; m++)
        printf("| %s | %s |\n", methods.row[m].title, methods.row[m].about);
    printf("\n## Overview\n\n");
    markdown_overview(all, "PSNR of the tone-mapped pictures, dB, more is better", &whole[1]);
    markdown_overview(all, "FLIP, less is better", &whole[3]);
    for (int s = 0; s < cases.count; s++)
        markdown_case(&cases.row[s], all[s]);
}

/* ------------------------------------------------------------------------- HTML */

static void html_case(const row *scene, cJSON *const *result) {
    printf("<h2 id=\"%s\">%s</h2>\n<p>%s</p>\n", scene->key, scene->title, scene->about);
    for (int m = 0; m < methods.count; m++) {
        if (!result[m]) continue;
        const char *key = methods.row[m].key, *title = methods.row[m].title;
        printf("<figure><figcaption><b>%s</b>: PSNR %.2f dB, SSIM %.4f, FLIP %.4f</figcaption>\n", title,
               number(result[m], NULL, "psnr_tonemapped"), number(result[m], NULL, "ssim_tonemapped"),
               number(result[m], NULL, "flip"));
        printf("<img loading=\"lazy\" src=\"%s.%s.jpg\" alt=\"%s\">\n", scene->key, key, title);
        printf("<img loading=\"lazy\" src=\"%s.truth.jpg\" alt=\"the lens\">\n", scene->key);
        printf("<img loading=\"lazy\" src=\"%s.%s.d.jpg\" alt=\"difference\">\n</figure>\n", scene->key, key);
    }
}

static void html(cJSON *(*all)[MAX_ROWS]) {
    printf("<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>ddof against a real lens</title>\n");
    printf("<style>\nbody { font: 15px sans-serif; margin: 2em; background: #fff; color: #222 }\n"
           "figure { margin: 0 0 14px }\nimg { width: 32.8%%; max-width: 640px }\n</style>\n");
    printf("<h1>Against a real lens</h1>\n<p>From left to right: the method's picture, the lens's picture (the truth), "
           "and "
           "four times the difference of the two, all tone-mapped. The figures of all regions: "
           "<a href=\"results.md\">results.md</a>.</p>\n<p>");
    for (int s = 0; s < cases.count; s++)
        printf("<a href=\"#%s\">%s</a> ", cases.row[s].key, cases.row[s].title);
    printf("</p>\n");
    for (int s = 0; s < cases.count; s++)
        html_case(&cases.row[s], all[s]);
    printf("</html>\n");
}

int main(int count, char **word) {
    static cJSON *all[MAX_ROWS][MAX_ROWS];
    const bool wants_html = count == 3 && strcmp(word[1], "html") == 0;
    if (count != 3 || (!wants_html && strcmp(word[1], "markdown") != 0)) fail("markdown|html DIR", "usage");
    folder = word[2];
    read_table(&cases, "cases");
    read_table(&methods, "methods");
    for (int s = 0; s < cases.count; s++)
        for (int m = 0; m < methods.count; m++)
            all[s][m] = read_result(&cases.row[s], &methods.row[m]);
    (wants_html ? html : markdown)(all);
    for (int s = 0; s < cases.count; s++)
        for (int m = 0; m < methods.count; m++)
            cJSON_Delete(all[s][m]);
    if (fflush(stdout)) fail("could not be printed", "standard output");
    return 0;
}
