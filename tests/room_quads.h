/* SPDX-License-Identifier: MIT */
/* The unit room and the box on its floor, for tests and benches. */
#ifndef LCOR_TEST_ROOM_QUADS_H
#define LCOR_TEST_ROOM_QUADS_H

enum { ROOM_FACES = 6, ROOM_AND_BOX_FACES = 11 };

static const char *const room_names[ROOM_FACES] = {"floor", "ceiling", "x0", "x1", "y0", "y1"};

/* Where it says 1, patch (i, j) of the references is patch (j, i) of the quad. */
static const int room_swapped[ROOM_FACES] = {0, 1, 0, 1, 1, 0};

/* Corner and edges: the room's in the order of room_names, facing inward; then the box without its
 * bottom, facing outward. */
static const double room_quads[ROOM_AND_BOX_FACES][9] = {{0, 0, 0, 1, 0, 0, 0, 1, 0},
                                                         {0, 0, 1, 0, 1, 0, 1, 0, 0},
                                                         {0, 0, 0, 0, 1, 0, 0, 0, 1},
                                                         {1, 0, 0, 0, 0, 1, 0, 1, 0},
                                                         {0, 0, 0, 0, 0, 1, 1, 0, 0},
                                                         {0, 1, 0, 1, 0, 0, 0, 0, 1},
                                                         {0.45, 0.2, 0.4, 0.3, 0, 0, 0, 0.3, 0},
                                                         {0.45, 0.2, 0, 0, 0, 0.4, 0, 0.3, 0},
                                                         {0.75, 0.2, 0, 0, 0.3, 0, 0, 0, 0.4},
                                                         {0.45, 0.2, 0, 0.3, 0, 0, 0, 0, 0.4},
                                                         {0.45, 0.5, 0, 0, 0, 0.4, 0.3, 0, 0}};

#endif
