// SPDX-License-Identifier: BSD-3-Clause
#include "tools/methods/candidates.h"

#include <math.h>

#include "tools/common/cells.h"
#include "tools/common/run_report.h"

json_t *candidate_json(const struct weft_candidate *c)
{
    const bool refused = c->state == WEFT_CANDIDATE_REFUSED;
    json_t *object = json_pack(
        "{s:s,s:s,s:b,s:o,s:o,s:o}", "name", c->name, "state", weft_candidate_state_names[c->state],
        "estimated", c->estimated, "seconds", run_report_total_seconds(refused ? NAN : c->seconds),
        "bytes", run_report_bytes("held", c->bytes), "bound", json_number(c->bound));
    if (object && c->method.algorithm == WEFT_ALGORITHM_MULTIPASS) {
        json_object_set_new(object, "technique",
                            json_text(weft_technique_names[c->method.technique]));
        json_object_set_new(object, "resolution", json_integer(c->method.samples));
        json_object_set_new(object, "bits", json_integer(c->method.bits));
    }
    return object;
}

static bool fill_row(struct cells *cells, int row, const struct weft_candidate *c)
{
    const char *least = c->estimated ? ">" : "";
    bool done = cells_set(cells, row, 0, "%s", c->name);
    if (c->state == WEFT_CANDIDATE_REFUSED) {
        for (int i = 1; i < 4; i++)
            done = done && cells_set(cells, row, i, "-");
    } else {
        done = done && cells_set(cells, row, 1, "%s%.2f", least, 1e3 * c->seconds) &&
               cells_set(cells, row, 2, "%s%.1f", least, 1e-6 * (double)c->bytes) &&
               cells_set(cells, row, 3, "%s%.3g", least, c->bound);
    }
    return done && cells_set(cells, row, 4, "%s", weft_candidate_state_names[c->state]);
}

void candidates_print(const struct weft_candidate *candidates, size_t count, const char *bound)
{
    const char *const heading[] = {"method", "ms", "MB", bound, ""};
    struct cells cells;
    bool done = cells_create(&cells, (int)count + 1, 5);
    for (int c = 0; done && c < 5; c++)
        done = cells_set(&cells, 0, c, "%s", heading[c]);
    cells.text_columns = 1;
    for (size_t i = 0; done && i < count; i++)
        done = fill_row(&cells, (int)i + 1, &candidates[i]);
    if (done)
        cells_print(&cells, CELLS_TEXT, stdout);
    cells_destroy(&cells);
}
