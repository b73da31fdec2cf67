// SPDX-License-Identifier: BSD-3-Clause
// What the charts of `weft chart` have in common: axes, panels, captions, gnuplot's script.
#include <math.h>
#include <stdlib.h>

#include "tools/chart/chart.h"
#include "tools/draw/plot.h"

void chart_extend_range(struct chart_range *range, double value)
{
    if (!(value > 0.0) || !isfinite(value))
        return;
    range->low = fmin(range->low, value);
    range->high = fmax(range->high, value);
}

void chart_set_axis(FILE *s, const char *axis, struct chart_range range)
{
    fprintf(s, "set %srange [%.9g:%.9g]\n", axis, range.low, range.high);
    if (range.high / range.low > 1500.0) {
        fprintf(s, "set %stics auto\n", axis);
        return;
    }
    static const double steps[] = {1.0, 2.0, 5.0};
    const char *separator = "";
    fprintf(s, "set %stics (", axis);
    for (int e = (int)floor(log10(range.low)); e <= (int)floor(log10(range.high)); e++)
        for (int i = 0; i < 3; i++, separator = ", ")
            fprintf(s, "%s%.9g", separator, steps[i] * pow(10.0, e));
    fputs(")\n", s);
}

void chart_set_panel(FILE *s, int number)
{
    const int left = CHART_LEFT + number * (CHART_PANEL + CHART_PANEL_GAP);
    fprintf(s,
            "set lmargin at screen %.5f\nset rmargin at screen %.5f\nset bmargin at screen %.5f\n"
            "set tmargin at screen %.5f\n",
            (double)left / CHART_PANELS_WIDTH, (double)(left + CHART_PANEL) / CHART_PANELS_WIDTH,
            (double)CHART_BOTTOM / CHART_HEIGHT, (CHART_TOP - 20.0) / CHART_HEIGHT);
}

void chart_put_label(FILE *s, double x, double y, const char *style, const char *text)
{
    fputs("set label ", s);
    plot_quote(s, text);
    fprintf(s, " at screen %.5f,%.5f %s\n", x, y, style);
}

void chart_put_caption(FILE *s, const struct chart_job *job, int width, int height,
                       const char *first)
{
    char line[2 * CHART_REASON];
    snprintf(line, sizeof line, "%s; %s, weft %s%s", job->machine,
             job->context ? weft_context_get_info(job->context)->renderer
                          : weft_instruction_set_names[job->engine.cpu.instructions],
             weft_version(), job->interrupted ? "; INTERRUPTED: not all was measured" : "");
    chart_put_label(s, 20.0 / width, 40.0 / height, "left font 'sans,10' tc '#505050'", first);
    chart_put_label(s, 20.0 / width, 20.0 / height, "left font 'sans,10' tc '#505050'", line);
}

// ---- files --------------------------------------------------------------------------------------

static enum exit_code keep(struct plot *plot, const char *path)
{
    char *name = NULL;
    if (asprintf(&name, "%s.gp", path) < 0)
        return (enum exit_code)report_finish(WEFT_ERR_MEMORY);
    enum exit_code code = plot_save_script(plot, name);
    if (code == EXIT_CODE_DONE && !plot_can_draw()) {
        report_error("%s needs the program gnuplot (Debian package gnuplot-nox), which does not "
                     "run here; its script and data are in %s",
                     path, name);
        code = EXIT_CODE_FAILED;
    }
    free(name);
    return code;
}

enum exit_code
chart_draw_script(const struct chart_job *job, const char *path, int width, int height,
                  enum weft_result (*write)(FILE *script, const struct chart_job *job),
                  bool keep_script)
{
    struct plot plot;
    enum exit_code code = plot_begin(path, width, height, &plot);
    if (code != EXIT_CODE_DONE)
        return code;
    const enum weft_result res = write(plot.script, job);
    if (res != WEFT_OK)
        code = (enum exit_code)report_finish(res);
    if (code == EXIT_CODE_DONE && (keep_script || !plot_can_draw()))
        code = keep(&plot, path);
    if (code == EXIT_CODE_DONE)
        return plot_finish(&plot);
    plot_discard(&plot);
    return code;
}
