// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/vdb_trees.h - OpenVDB, without making anew what its library has: it registers grids
// of these types, and so has them and their trees. Compiling takes a third of the time.
#ifndef WEFT_TILES_READERS_VDB_TREES_H
#define WEFT_TILES_READERS_VDB_TREES_H

#include <openvdb/openvdb.h>

// The library has what is virtual; the rest is inlined where anything is, by compilers that inline
// as much as the one that it was built with.
#if defined(__OPTIMIZE__) && defined(WEFT_VDB_TREES_OF_LIBRARY)
extern template class openvdb::tree::Tree<openvdb::FloatTree::RootNodeType>;
extern template class openvdb::tree::Tree<openvdb::DoubleTree::RootNodeType>;
extern template class openvdb::tree::Tree<openvdb::Int32Tree::RootNodeType>;
extern template class openvdb::tree::Tree<openvdb::Int64Tree::RootNodeType>;
extern template class openvdb::tree::Tree<openvdb::BoolTree::RootNodeType>;
extern template class openvdb::tree::Tree<openvdb::MaskTree::RootNodeType>;
extern template class openvdb::tree::Tree<openvdb::Vec3STree::RootNodeType>;
extern template class openvdb::tree::Tree<openvdb::Vec3DTree::RootNodeType>;
extern template class openvdb::tree::Tree<openvdb::Vec3ITree::RootNodeType>;
extern template class openvdb::Grid<openvdb::FloatTree>;
extern template class openvdb::Grid<openvdb::DoubleTree>;
extern template class openvdb::Grid<openvdb::Int32Tree>;
extern template class openvdb::Grid<openvdb::Int64Tree>;
extern template class openvdb::Grid<openvdb::BoolTree>;
extern template class openvdb::Grid<openvdb::Vec3STree>;
extern template class openvdb::Grid<openvdb::Vec3DTree>;
extern template class openvdb::Grid<openvdb::Vec3ITree>;
#endif

#endif
