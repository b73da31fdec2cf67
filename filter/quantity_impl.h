// SPDX-License-Identifier: BSD-3-Clause
// filter/quantity_impl.h - what quantities and their bounds share (not installed).
#ifndef WEFT_FILTER_QUANTITY_IMPL_H
#define WEFT_FILTER_QUANTITY_IMPL_H

#include "filter/quantity.h"

// World derivatives are sums of those in index space, all of an order that a list has.
struct weft_quantity_terms {
    int first[3];   // in the list: where each order begins; -1: it is not there
    double g[3][3]; // world gradient by index gradient: A^-T
    double h[6][6]; // world Hessian by index Hessian, both XX, XY, XZ, YY, YZ, ZZ: A^-T H A^-1
};
struct weft_quantity_terms weft_quantity_terms_of(const struct weft_quantities *list,
                                                  const struct weft_quantity_transform *transform);

// Channels of a quantity, 1 to 6.
int weft_quantity_channels(enum weft_quantity quantity);

#endif
