// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/vdb_guard.h - OpenVDB's decompressors, with their input checked.
#ifndef WEFT_TILES_READERS_VDB_GUARD_H
#define WEFT_TILES_READERS_VDB_GUARD_H

namespace weft
{

// false if libopenvdb has no such functions to pass calls on to: nothing may be read then.
bool guard_is_complete();

} // namespace weft

#endif
