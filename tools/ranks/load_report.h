// SPDX-License-Identifier: BSD-3-Clause
// tools/ranks/load_report.h - what a verb tells of its ranks: how busy each was. Of works that were
// one after the other it is what weft_load_add makes of them. On rank 0.
#ifndef WEFT_TOOLS_RANKS_LOAD_REPORT_H
#define WEFT_TOOLS_RANKS_LOAD_REPORT_H

#include "tools/common/json.h"
#include "weft.h"

// The object "ranks" of a report in JSON: count, schedule, items, seconds, idle_share, imbalance,
// and "each" with rank, host, threads, busy, idle, taking, items, bytes of every one. With `items`
// also item_seconds and item_rank of each item of the last work. Seconds throughout; busy, idle and
// taking of a rank are `seconds` together, while idle_share counts taking as idle. NULL where
// nothing was divided (load.ranks 0), as alone without a rank option.
json_t *load_report_json(const struct weft_items_report *work, bool items);
// The same in a line where there are several ranks; with -v always, and a line for each.
void load_report_print(const struct weft_items_report *work);

// Before long work: that the chart could be drawn and written. Returns WEFT_ERR_ARGUMENT (its
// ending), WEFT_ERR_WRITE, or another result where gnuplot does not run, after an error line.
enum weft_result load_report_check_plot(const char *path);
// A bar for each rank: busy, taking, idle. Returns WEFT_ERR_WRITE, or another result where gnuplot
// fails, after an error line.
enum weft_result load_report_plot(const struct weft_items_report *work, const char *path);

#endif
