// SPDX-License-Identifier: BSD-3-Clause
// tools/ranks/load_report.h - what a verb tells of its ranks: how busy each was.
#ifndef WEFT_TOOLS_RANKS_LOAD_REPORT_H
#define WEFT_TOOLS_RANKS_LOAD_REPORT_H

#include "tools/common/json.h"
#include "weft.h"

// The object "ranks" of a report in JSON: count, schedule, items, seconds, idle_share, imbalance,
// and for each rank host, threads, busy, idle, taking, items, bytes. NULL alone, where no rank
// option was given.
json_t *load_report_json(const struct weft_items_report *work);
// The same in a line or two, at -v or where there are several ranks.
void load_report_print(const struct weft_items_report *work);
// A bar for each rank: busy, taking, idle. Returns WEFT_ERR_WRITE and what gnuplot returns.
enum weft_result load_report_plot(const struct weft_items_report *work, const char *path);

#endif
